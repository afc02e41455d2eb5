"""Selects the toolkit for windows: that of the user's backend, else the first that works."""

import importlib
import os
import sys
import time
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from irsim_gym.base.errors import NoWindowError

MODULES = {"tk": "tkagg", "qt": "qtagg", "gtk4": "gtk4agg", "gtk3": "gtk3agg", "wx": "wxagg", "macosx": "macosx"}
BACKENDS = {name: f"matplotlib.backends.backend_{module}" for name, module in MODULES.items()}
INSTEAD = "Pictures need no window: render_mode='rgb_array', save_figure and films work without a display."
VIRTUAL = "Without a screen, a virtual one will do: `xvfb-run -a python script.py`."
DRIVERS = {
    "SDL_VIDEODRIVER": "chooses where SDL and pygame show windows; these are matplotlib's",
    "MPLBACKEND": "chooses how matplotlib draws; without a display it opens no window either",
    "QT_QPA_PLATFORM": "chooses where Qt shows windows; a display is asked for first",
}
"""Environment variables for running other environments without a display, and their effect here."""


def new_manager(figure: Figure) -> Any:
    """Return the manager of a new window with a figure, independent of pyplot.

    Raises:
        NoWindowError: If there is no display or no working toolkit.
    """
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        set_ones = [f"{name}={os.environ[name]} {does}. " for name, does in DRIVERS.items() if os.environ.get(name)]
        raise NoWindowError(
            "no window can be opened: there is no display (DISPLAY and WAYLAND_DISPLAY are not set). "
            f"{''.join(set_ones)}{INSTEAD} {VIRTUAL}"
        )
    reasons = []
    for toolkit in _order():
        try:
            module = importlib.import_module(BACKENDS[toolkit])
            with matplotlib.rc_context({"toolbar": "None"}):
                return module.FigureCanvas.new_manager(figure, 0)
        except Exception as error:  # toolkits raise exceptions of any type
            reasons.append(f"{toolkit}: {(str(error).strip() or repr(error)).splitlines()[0]}")
    missing = (
        "no GUI toolkit of matplotlib works here. Install one, e.g. Tk (python3-tk of the system) or "
        "`pip install pyside6`."
    )
    shown = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if shown and any("display" in reason for reason in reasons):
        missing = f"the display '{shown}' does not answer: is it running, and is it the right one? {VIRTUAL}"
    told = "\n".join(f"  {reason}" for reason in reasons)
    raise NoWindowError(f"no window can be opened: {missing} {INSTEAD}\n{told}")


def event_time(event: object) -> float:
    """Return the time of a toolkit's event by the toolkit's clock [s]; the present time if it has none."""
    for name in ("time", "timestamp", "GetTimestamp"):
        told = getattr(event, name, None)
        told = told() if callable(told) else told
        if isinstance(told, int | float) and told > 0:
            return 0.001 * told
    return time.perf_counter()


def _order() -> list[str]:
    """Return the toolkits in the order of trial: the user's own first."""
    chosen = str(dict.__getitem__(matplotlib.rcParams, "backend")).lower()
    preferred = [toolkit for toolkit in BACKENDS if chosen.startswith(toolkit)]
    return preferred + [toolkit for toolkit in BACKENDS if toolkit not in preferred]
