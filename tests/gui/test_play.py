"""`irsim-gym play` as a person plays it: a program of its own in a real window."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from screen import Screen

import irsim_gym
from irsim_gym.tasks import Outcome

FILE = """
world: {name: hall, step_time: 0.05}
robot:
  - {name: near, kinematics: {name: diff}, shape: {name: circle, radius: 0.2}, state: [2, 5, 0], goal: [4, 5]}
  - {name: far, kinematics: {name: omni}, shape: {name: circle, radius: 0.2}, state: [2, 8, 0], goal: [9, 8]}
task: {agents: near, max_steps: 400}
"""
TITLE = "hall - irsim-gym play"
PROGRAM = """
import signal
from irsim_gym.cli import main
signal.signal(signal.SIGINT, signal.default_int_handler)  # shells let background jobs ignore it
main()
"""
Start = Callable[..., subprocess.Popen[str]]


@pytest.fixture
def start(screen: Screen, tmp_path: Path, until) -> Iterator[Start]:
    """Return a function that begins to play with some options, and waits for the window."""
    (tmp_path / "hall.yaml").write_text(FILE)
    begun: list[subprocess.Popen[str]] = []
    program = [sys.executable, "-c", PROGRAM, "play"]

    def play(*options: str, file: str = "hall.yaml", title: str = TITLE) -> subprocess.Popen[str]:
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        begun.append(subprocess.Popen([*program, file, *options], cwd=tmp_path, **pipes))
        screen.move(5, 5)
        until(lambda: screen.has_window(title) or begun[-1].poll() is not None, most=90.0)
        screen.focus(title)
        for _ in range(6):  # its time goes on, so that the keyboard is ready
            before = screen.picture(640, 40)
            until(lambda last=before: not np.array_equal(screen.picture(640, 40), last), most=20.0)
        return begun[-1]

    yield play
    for one in begun:
        if one.poll() is None:
            one.kill()
        one.communicate()


def said(played: subprocess.Popen[str]) -> str:
    """Return what the program printed until its end."""
    out, errors = played.communicate(timeout=20)
    assert played.returncode == 0, errors
    return out


def test_a_person_demonstrates(start: Start, screen: Screen, tmp_path: Path, kept_picture) -> None:
    played = start("--record", "demo.npz", "--level", "3")
    screen.down("w")
    time.sleep(0.6)
    screen.up("w")
    screen.type("r")  # not good enough: again
    screen.type("space")
    time.sleep(0.2)
    kept_picture(screen.picture())
    screen.type("space")
    screen.down("w")
    time.sleep(3.0)  # 1.9 m at 1 m/s
    screen.up("w")
    kept_picture(screen.picture())
    time.sleep(1.4)  # the end is looked at for a while, then the next level begins
    screen.down("a")
    time.sleep(0.5)
    screen.up("a")
    screen.type("v", "Escape")
    assert said(played) == "1 success\ndemo.npz: 2 episodes\n"
    found = irsim_gym.load_demonstrations(tmp_path / "demo.npz")
    assert found.levels.tolist() == [3, 4]
    assert found.outcomes.tolist() == [Outcome.SUCCESS, Outcome.RUNNING]
    assert found.about["robot"] == "near"
    first = found.actions[: np.flatnonzero(found.ends)[0] + 1]
    assert 38 <= (first[:, 0] == 1.0).sum() <= 40
    assert (first[:, 1] == 0.0).all()
    assert found.by_hand.all()
    assert (found.actions[len(first) :, 1] == 1.0).sum() >= 4
    assert next(file.name for file in tmp_path.glob("*.png")).startswith("hall_4_")


def test_another_robot_that_drives_by_itself(start: Start, screen: Screen, tmp_path: Path, until, kept_picture) -> None:
    played = start()
    layout = irsim_gym.load(tmp_path / "hall.yaml")._camera.seen()
    column, row = (round(value) for value in layout.column_row(1.9, 8.1))  # inside of it, off the lines
    assert screen.picture()[row, column].tolist() != [255, 255, 255]
    screen.type("alt+1", "x")
    until(lambda: screen.picture()[row, column].tolist() == [255, 255, 255])
    kept_picture(screen.picture())
    screen.type("x", "alt+7")
    time.sleep(0.3)
    kept_picture(screen.picture())
    screen.close_window(TITLE)
    assert said(played) == "no episode ended\n"


def test_an_interrupt_keeps_what_was_recorded(start: Start, screen: Screen, tmp_path: Path) -> None:
    import signal

    played = start("--record", "demo.npz", "--robot", "far")
    screen.down("w")
    time.sleep(0.5)
    played.send_signal(signal.SIGINT)
    assert "demo.npz: 1 episode" in said(played)
    found = irsim_gym.load_demonstrations(tmp_path / "demo.npz")
    assert found.about["robot"] == "far"
    assert found.actions[-1].tolist() == [1.0, 0.0]


def test_a_policy_drives_until_the_person_takes_over(start: Start, screen: Screen, tmp_path: Path) -> None:
    """The policy was trained with other observations than those of the scenario's task."""
    options = ("cluttered_room_memory", "--record", "demo.npz", "--speed", "3")
    played = start(*options, file="cluttered_room", title="cluttered_room - irsim-gym play")
    time.sleep(1.0)
    screen.type("x")
    time.sleep(0.5)
    screen.type("Escape")
    assert said(played).endswith("demo.npz: 1 episode\n")
    found = irsim_gym.load_demonstrations(tmp_path / "demo.npz")
    n_watched = int(np.flatnonzero(found.by_hand)[0])
    assert n_watched > 5
    assert found.by_hand[n_watched:].all()
    policy: Any = irsim_gym.load_policy("cluttered_room_memory")
    expected, _ = policy.predict(found.observations[:n_watched], deterministic=True)
    np.testing.assert_allclose(found.actions[:n_watched], expected, atol=1e-4)
