"""What keys mean, from strokes that are made up; real ones are in tests/gui."""

from __future__ import annotations

import numpy as np
import pytest

from irsim_gym.rendering.controls import keyboard as keyboard_module
from irsim_gym.rendering.controls.keyboard import COMMANDS, Keyboard
from irsim_gym.rendering.controls.keys import REPEAT_S, HeldKeys, Stroke
from irsim_gym.scenario.specs.gui_spec import KeyboardSpec

DIFF, OMNI, TURNING = ("linear", "angular"), ("x", "y"), ("forward", "left", "angular")


class Typed:
    """Strokes that a test writes down."""

    def __init__(self) -> None:
        self.came: list[Stroke] = []

    def strokes(self) -> list[Stroke]:
        came, self.came = self.came, []
        return came


@pytest.fixture
def typed() -> Typed:
    return Typed()


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The time of now [s], which a test sets."""
    now = [0.0]
    monkeypatch.setattr(keyboard_module.time, "perf_counter", lambda: now[0])
    return now


def down(key: str, time: float = 0.0, *, alt: bool = False, shift: bool = False) -> Stroke:
    return Stroke(key, True, time, alt, shift)


def up(key: str, time: float = 0.0) -> Stroke:
    return Stroke(key, False, time)


def test_a_key_that_repeats_stays_down_and_was_pressed_once() -> None:
    held = HeldKeys()
    assert held.take(down("w", 0.0), 0.0)
    for i in range(1, 5):  # as X repeats: up and down at the same moment
        assert not held.take(up("w", 0.03 * i), 0.03 * i)
        held.settle(0.03 * i)
        assert held.latest("w", "s") == "w"
        assert not held.take(down("w", 0.03 * i), 0.03 * i)
    held.take(up("w", 0.2), 0.2)
    held.settle(0.2 + 0.9 * REPEAT_S)
    assert held.latest("w", "s") == "w"
    held.settle(0.2 + 1.1 * REPEAT_S)
    assert held.latest("w", "s") is None


def test_a_key_that_was_let_go_between_two_looks_was_pressed_again() -> None:
    held = HeldKeys()
    pressed = [held.take(stroke, 9.0) for stroke in (down("c", 1.0), up("c", 1.05), down("c", 1.2), up("c", 1.25))]
    assert pressed == [True, False, True, False]


def test_keys_drive_each_drive_its_own_way(typed: Typed, clock: list[float]) -> None:
    keys = Keyboard(KeyboardSpec(key_lv_max=2.0, key_ang_max=0.5), typed)
    typed.came = [down("s"), down("a"), down("e")]
    assert keys.poll(turns=True) == []
    assert keys.command(DIFF).tolist() == [-2.0, 0.5]
    assert keys.command(OMNI).tolist() == [-2.0, 2.0]
    assert keys.command(TURNING).tolist() == [-2.0, 2.0, -0.5]
    assert keys.key_vel.tolist() == [-2.0, 0.5, -0.5]
    typed.came = [down("w"), down("d")]  # the later of two opposite keys counts
    keys.poll(turns=True)
    assert keys.command(DIFF).tolist() == [2.0, -0.5]
    typed.came = [up("w"), up("d"), up("a"), up("e")]
    keys.poll(turns=True)
    clock[0] = 1.0
    keys.poll(turns=True)
    assert keys.command(TURNING).tolist() == [-2.0, 0.0, 0.0]  # s is still down


def test_speeds_at_the_beginning_last_until_a_key_of_theirs(typed: Typed, clock: list[float]) -> None:
    keys = Keyboard(KeyboardSpec(key_lv=0.4, key_ang=-0.2), typed)
    assert keys.command(DIFF).tolist() == [0.4, -0.2]
    typed.came = [down("w", 0.0), up("w", 0.1)]
    keys.poll()
    clock[0] = 1.0
    keys.poll()
    assert keys.command(DIFF).tolist() == [0.0, -0.2]


def test_keys_change_the_greatest_speeds(typed: Typed, clock: list[float]) -> None:
    keys = Keyboard(KeyboardSpec(key_lv_max=0.3, key_ang_max=1.0), typed)
    for key, shift, turns, speeds in (
        ("e", False, False, (0.5, 1.0)),
        ("q", False, False, (0.3, 1.0)),
        ("e", False, True, (0.3, 1.0)),  # it turns the robot
        ("c", False, False, (0.3, 1.2)),
        ("z", False, False, (0.3, 1.0)),
        ("c", True, True, (0.5, 1.0)),
        ("z", True, True, (0.3, 1.0)),
        ("z", True, True, (0.1, 1.0)),
        ("z", True, True, (0.0, 1.0)),  # never negative
    ):
        clock[0] += 1.0
        typed.came = [down(key, clock[0], shift=shift), up(key, clock[0] + 0.1)]
        assert keys.poll(turns=turns) == []
        clock[0] += 1.0
        keys.poll(turns=turns)
        assert (keys.key_lv_max, keys.key_ang_max) == speeds


def test_the_robot_is_chosen_with_alt(typed: Typed) -> None:
    keys = Keyboard(KeyboardSpec(key_id=2), typed)
    typed.came = [down("1"), up("1"), down("alt", alt=True)]
    keys.poll()
    assert keys.key_id == 2
    typed.came = [down("9", alt=True)]
    keys.poll(drives=False)  # keys do not drive
    assert keys.key_id == 2
    typed.came = [up("9"), down("9", 5.0, alt=True)]
    keys.poll()
    assert keys.key_id == 9


def test_each_command_is_told_once_for_a_press(typed: Typed) -> None:
    keys = Keyboard(KeyboardSpec(), typed)
    typed.came = [down(key) for key in COMMANDS]
    assert keys.poll(drives=False) == list(COMMANDS.values())
    typed.came = [down(key) for key in COMMANDS]  # still held
    assert keys.poll() == []
    assert np.array_equal(keys.command(DIFF), [0.0, 0.0])
