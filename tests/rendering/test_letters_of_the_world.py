"""Names in any script are written without a warning: in a font that is installed, else as boxes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from matplotlib import font_manager
from pixels import WAYS, of_world

from irsim_gym import load
from irsim_gym.base.arraytypes import Bytes
from irsim_gym.rendering.looks import fonts

ROBOT = {"kinematics": {"name": "diff"}, "state": [5, 5, 0], "plot": {"show_text": True, "text_size": 40}}
NAMES = ["\u4e16\u754c", "\u0645\u0631\u062d\u0628\u0627", "\u65e5\u672c \U0001f916", "a\u202eb\tc", "\U000fffff"]
SCRIPT = "\U0001d4d0"
"""A letter that STIX has, which comes with matplotlib, and DejaVu Sans has not."""
hows = pytest.mark.parametrize("how", WAYS)


@pytest.fixture
def only_stix(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    stix = Path(font_manager.findfont("STIXGeneral:style=normal:weight=400", fallback_to_default=False))
    monkeypatch.setattr(fonts, "_installed", lambda: {stix: "STIXGeneral"})
    monkeypatch.setattr(fonts, "_unlisted", lambda: ())
    yield from _with_fresh_answers(stix)


@pytest.fixture
def no_other_font(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setattr(fonts, "_installed", dict)
    monkeypatch.setattr(fonts, "_unlisted", tuple)
    yield from _with_fresh_answers(fonts.usual(bold=False))


def _with_fresh_answers(font: Path) -> Iterator[Path]:
    fonts.runs.cache_clear()
    fonts._installed_with.cache_clear()
    yield font
    fonts.runs.cache_clear()
    fonts._installed_with.cache_clear()


def frame(name: str, how: str) -> Bytes:
    """Draw a robot of that name in a world of that name."""
    with load({"world": {"name": name}, "robot": {**ROBOT, "name": name}}) as world:
        return of_world(world, how)


@hows
@pytest.mark.parametrize("name", NAMES)
def test_no_name_warns(name: str, how: str) -> None:
    assert frame(name, how).shape[2] == 3


@pytest.mark.usefixtures("no_other_font")
@hows
def test_a_letter_that_no_font_has_is_a_box(how: str) -> None:
    assert fonts.runs("x\u4e16") == (("x\N{WHITE SQUARE}", fonts.usual(bold=False)),)
    assert np.array_equal(frame("x\u4e16", how), frame("x\N{WHITE SQUARE}", how))


@hows
def test_a_font_that_is_installed_lends_its_letters(only_stix: Path, how: str) -> None:
    own = fonts.usual(bold=False)
    assert fonts.runs(f"a{SCRIPT}b") == (("a", own), (SCRIPT, only_stix), ("b", own))
    assert fonts.families(f"a{SCRIPT}b") == (
        f"a{SCRIPT}b",
        {"family": ["DejaVu Sans", "STIXGeneral"], "weight": "normal", "parse_math": False},
    )
    assert fonts.runs(f"a{SCRIPT}b", bold=True) == fonts.runs(f"a{SCRIPT}b"), "no mixture of bold and other letters"
    assert not np.array_equal(frame(SCRIPT, how), frame("\N{WHITE SQUARE}", how))


def test_marks_that_are_not_seen_are_left_out() -> None:
    own = fonts.usual(bold=False)
    assert fonts.runs("a\tb\x07") == (("ab", own),)
    assert fonts.runs("") == ()
