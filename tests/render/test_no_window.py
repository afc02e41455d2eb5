"""Windows where there is no display."""

from __future__ import annotations

import sys

import pytest

from irsim_gym.errors import IrsimGymError, NoWindowError
from irsim_gym.render.window import Window


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="other systems always have a display")
def test_without_a_display_the_error_says_what_works(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(NoWindowError, match=r"no display \(DISPLAY and WAYLAND_DISPLAY are not set\).*rgb_array"):
        Window(100, 100)
    assert issubclass(NoWindowError, IrsimGymError)


def test_without_a_toolkit_the_error_tells_the_reason_of_each(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":77")
    for name in ("tkagg", "qtagg", "gtk4agg", "gtk3agg", "wxagg", "macosx"):
        monkeypatch.setitem(sys.modules, f"matplotlib.backends.backend_{name}", None)  # importing it fails
    with pytest.raises(NoWindowError, match=r"python3-tk.*(?s:.)*  tk: .*\n  qt: .*\n  gtk4: ") as found:
        Window(100, 100)
    assert "rgb_array" in str(found.value)
