"""Windows where there is no display."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import gymnasium
import pytest

from irsim_gym.errors import IrsimGymError, NoWindowError
from irsim_gym.rendering.windows.window import Window


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="other systems always have a display")
@pytest.mark.parametrize(
    ("driver", "remark"),
    [
        ({}, ""),
        ({"SDL_VIDEODRIVER": "dummy"}, "SDL_VIDEODRIVER=dummy chooses where SDL and pygame show windows; these are "),
        ({"MPLBACKEND": "Agg", "QT_QPA_PLATFORM": "offscreen"}, "MPLBACKEND=Agg .* QT_QPA_PLATFORM=offscreen "),
    ],
)
def test_without_a_display_the_error_says_what_works(
    monkeypatch: pytest.MonkeyPatch, driver: dict[str, str], remark: str
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER", "MPLBACKEND", "QT_QPA_PLATFORM"):
        monkeypatch.delenv(name, raising=False)
    for name, value in driver.items():
        monkeypatch.setenv(name, value)
    told = rf"no display \(DISPLAY and WAYLAND_DISPLAY are not set\)\. {remark}.*rgb_array.*`xvfb-run -a python"
    env = gymnasium.make("irsim_gym/empty_goal-v0", render_mode="human")
    with pytest.raises(NoWindowError, match=told) as found:
        env.reset(seed=0)
    assert ("SDL_VIDEODRIVER" in str(found.value)) == ("SDL_VIDEODRIVER" in driver)
    assert issubclass(NoWindowError, IrsimGymError)


def test_a_display_that_does_not_answer_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":4711")

    class FigureCanvas:
        @staticmethod
        def new_manager(figure: object, number: int) -> None:
            raise RuntimeError('couldn\'t connect to display ":4711"')  # Tk's words

    for name in ("tkagg", "qtagg", "gtk4agg", "gtk3agg", "wxagg", "macosx"):
        monkeypatch.setitem(sys.modules, f"matplotlib.backends.backend_{name}", None)
    monkeypatch.setitem(sys.modules, "matplotlib.backends.backend_tkagg", SimpleNamespace(FigureCanvas=FigureCanvas))
    with pytest.raises(NoWindowError, match=r"the display ':4711' does not answer.*xvfb-run.*rgb_array.*\n  tk: could"):
        Window(100, 100)


def test_without_a_toolkit_the_error_tells_the_reason_of_each(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":77")
    for name in ("tkagg", "qtagg", "gtk4agg", "gtk3agg", "wxagg", "macosx"):
        monkeypatch.setitem(sys.modules, f"matplotlib.backends.backend_{name}", None)  # importing it fails
    with pytest.raises(NoWindowError, match=r"python3-tk.*(?s:.)*  tk: .*\n  qt: .*\n  gtk4: ") as found:
        Window(100, 100)
    assert "rgb_array" in str(found.value)
