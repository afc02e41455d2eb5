"""Reads those arguments of ``load``, ``render`` and ``end`` that come from IR-SIM."""

import logging
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args

from irsim_gym.base.errors import NoEffectWarning, suggestion, warn_caller
from irsim_gym.live.session import hints
from irsim_gym.scenario.reading.plot_overrides import BODY_KEYS, FIGURE_KEYS

StepMode = Literal["internal", "external"]
MODES = ("dynamic", "static", "all")
NO_EFFECT_ON_FILMS = ("last_frame_duration", "rm_fig_path")
FILM_KEYS = ("ani_name", "suffix")


class LoadArguments(NamedTuple):
    """The arguments of ``load`` in one record.

    Attributes:
        render_mode: None, ``rgb_array`` or ``human``.
        file: The file under IR-SIM's keyword; None if it was not used.
        step_mode: Step mode; None for that of the file.
        log_level: Level of the world's logger; None to leave it unchanged.
        film: Defaults of ``end``.
        parameters: All other arguments: parameters of the scenario.
    """

    render_mode: str | None
    file: str | Path | None
    step_mode: StepMode | None
    log_level: int | str | None
    film: Mapping[str, object]
    parameters: dict[str, object]


def read_arguments(render_mode: str | None, others: Mapping[str, Any]) -> LoadArguments:
    """Read IR-SIM's arguments of ``make`` from those of ``load``.

    Raises:
        TypeError: An argument asks for something unsupported; the message says what to do.
        ValueError: Another render mode or step mode, or an unknown level of logging.
    """
    if render_mode not in (None, "rgb_array", "human"):
        raise ValueError(f"render_mode must be None, 'rgb_array' or 'human', got {render_mode!r}")
    mode = _render_mode(render_mode, others)
    for name, value in others.items():
        harmless, advice = hints.LOAD.get(name, ((), ""))
        if advice and not any(value is word or (isinstance(word, str) and value == word) for word in harmless):
            raise TypeError(f"load() takes no {name}={value!r}: {advice}")
    if others.get("full") and mode == "human":
        raise TypeError(f"load() takes no full=True: {hints.LARGE}")
    step_mode = others.get("step_mode")
    if step_mode not in (None, *get_args(StepMode)):
        raise ValueError(f"step_mode must be 'internal' or 'external', got {step_mode!r}")
    rest = {name: value for name, value in others.items() if name not in hints.LOAD and name not in hints.TAKEN}
    film = film_options(others.get("ani_kwargs") or {})
    return LoadArguments(mode, others.get("world_name"), step_mode, _level(others.get("log_level")), film, rest)


def _render_mode(render_mode: str | None, others: Mapping[str, object]) -> str | None:
    """Return the render mode.

    Raises:
        TypeError: A window is both wanted and not wanted.
    """
    hidden = next((name for name, no in (("display", False), ("headless", True)) if others.get(name) is no), None)
    shown = others.get("display") is True and not others.get("disable_all_plot")  # the latter wins, as in IR-SIM
    with_window = render_mode == "human" or shown
    if with_window and hidden is not None:
        raise TypeError(f"load() takes no {hidden}={others[hidden]!r} where a window is asked for as well")
    return "human" if with_window else render_mode


def _level(level: object) -> int | str | None:
    if level is None or isinstance(level, int):
        return level
    levels = logging.getLevelNamesMapping()
    name = {"SUCCESS": "INFO", "TRACE": "DEBUG"}.get(str(level).upper(), str(level).upper())
    if name in levels:
        return name
    raise ValueError(f"log_level must be one of {', '.join(levels)}, got {level!r}{suggestion(name, levels)}")


def drawing_options(
    figure_kwargs: Mapping[str, object] | None, mode: str, others: Mapping[str, object]
) -> dict[str, object]:
    """Return how bodies are drawn in one picture, by keys of their section ``plot``.

    Raises:
        ValueError: Another mode.
    """
    if mode not in MODES:
        raise ValueError(f"mode must be 'dynamic', 'static' or 'all', got {mode!r}; all bodies are drawn in each")
    if figure_kwargs:
        warn_caller(
            "render() draws frames of one size, figure_kwargs change nothing: plot: {figure_pixels: [800, 600]}",
            NoEffectWarning,
        )
    _warn_of_unknown("render()", others, BODY_KEYS)
    return {name: value for name, value in others.items() if name in BODY_KEYS}


def figure_options(others: Mapping[str, object]) -> dict[str, object]:
    """Return how a figure is saved, by keys of ``plot.saved_figure``."""
    _warn_of_unknown("save_figure()", others, FIGURE_KEYS)
    return {name: value for name, value in others.items() if name in FIGURE_KEYS}


def film_options(others: Mapping[str, object]) -> dict[str, object]:
    """Return the known options of a film."""
    names = (*FILM_KEYS, *NO_EFFECT_ON_FILMS)
    _warn_of_unknown("end()", others, names)
    return {name: value for name, value in others.items() if name in FILM_KEYS}


def _warn_of_unknown(what: str, others: Mapping[str, object], names: Iterable[str]) -> None:
    for name in others:
        if name not in names:
            warn_caller(f"{what} knows no {name}, it changes nothing{suggestion(name, names)}", NoEffectWarning)
