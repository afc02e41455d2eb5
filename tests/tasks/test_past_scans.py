"""past_scans against values worked out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from task_tools import BALL, ROBOT, drive, play

from irsim_gym.errors import ScenarioError
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.observations.scan import past_scans

STAND = (-1.0, 0.0)
FREE = 6.0


def inverse(depth: float) -> float:
    return (1 / (depth + 0.5) - 0.3) / 1.7


def task(**options: Any) -> dict[str, Any]:
    return {"name": "blank", "observations": [{"name": "past_scans", "sectors": 4, "ago": [5], **options}]}


def seen(episodes: Episodes, agent: int = 0) -> Any:
    return episodes.view.observation[0, agent]


# Sectors: left behind, right behind, ... in order of the bearing from -pi: ahead are 1 (right) and 2 (left).


def test_what_stands_still_is_where_it_is_now() -> None:
    episodes = play(obstacle=BALL, task=task())
    ahead = [inverse(FREE), inverse(2.3), inverse(2.3), inverse(FREE)]
    assert seen(episodes) == pytest.approx(ahead, abs=2e-3)
    for _ in range(8):
        drive(episodes, 1, 0)
    # It was seen from x = 2.3 m; now the robot stands at 2.8 m.
    assert seen(episodes) == pytest.approx([inverse(FREE), inverse(1.5), inverse(1.5), inverse(FREE)], abs=2e-3)


def test_a_turn_of_the_agent_turns_what_it_saw() -> None:
    episodes = play({"vel_min": [0, -2]}, BALL, task(ago=[3]))
    for _ in range(8):
        drive(episodes, -1, -1)
    # It has turned right by 1.6 rad: the ball lies left of it, mostly a little behind.
    reading = seen(episodes)
    assert reading[3] == pytest.approx(inverse(2.3), abs=2e-3)
    assert reading[:2] == pytest.approx([inverse(FREE)] * 2, abs=1e-6)


def test_what_moves_is_where_it_was() -> None:
    mover = {**ROBOT, "sensors": [], "state": [5, 8, "-pi / 2"], "goal": [5, 1], "behavior": {"name": "dash"}}
    episodes = play([ROBOT, mover], task={**task(ago=[1, 6], sectors=2), "agents": "robot_0"})
    for _ in range(10):
        drive(episodes, *STAND)
    assert episodes.simulation.state.pose[0, 1, 1] == pytest.approx(7.0, abs=1e-6)
    # Right and left side, one step ago and six: it was 2.1 and 2.6 m ahead in y, 3 m in x; two radii are 0.4 m.
    depths = [FREE, np.hypot(3, 2.1) - 0.4, FREE, np.hypot(3, 2.6) - 0.4]
    assert seen(episodes) == pytest.approx([inverse(depth) for depth in depths], abs=2e-3)


def test_the_mount_of_the_sensor_does_not_matter() -> None:
    readings = []
    for offset in ([0, 0, 0], [0.1, 0.05, 1.0]):
        sensor = {**ROBOT["sensors"][0], "number": 2001, "offset": offset}
        episodes = play({"sensors": [sensor]}, BALL, task(sectors=12))
        for _ in range(4):
            drive(episodes, 1, 1)
        readings.append(seen(episodes).copy())
    assert (readings[0] > inverse(4.0)).any()
    assert readings[1] == pytest.approx(readings[0], abs=1e-2)


def test_an_episode_begins_without_memory_of_the_one_before() -> None:
    episodes = play(obstacle=BALL, task=task(), n_worlds=2)
    first = seen(episodes).copy()
    for _ in range(7):
        drive(episodes, 1, 0.5)
    other = episodes.view.observation[1].copy()
    episodes.begin_next(np.array([0]))
    np.testing.assert_array_equal(seen(episodes), first)
    np.testing.assert_array_equal(episodes.view.observation[1], other)


def test_each_agent_of_a_team_remembers_its_own_scans() -> None:
    robots = [{**ROBOT, "state": [2, 5, 0]}, {**ROBOT, "state": [6, 5, 0], "goal": [9, 5]}]
    episodes = play(robots, task=task(sectors=2), team=True)
    for _ in range(6):
        episodes.step(np.array([[[1.0, 0.0], STAND]]))
    # The first has gone to 2.6 m and remembers the second 3 m ahead, on both sides; it was itself seen at 2.1 m.
    assert seen(episodes, 0) == pytest.approx([inverse(3.0)] * 2, abs=2e-3)
    assert seen(episodes, 1) == pytest.approx([inverse(3.5)] * 2, abs=2e-3)


def test_contact_and_nothing_are_the_bounds() -> None:
    wall = {"shape": {"name": "linestring", "vertices": [[2.2001, 0], [2.2001, 10]]}}
    episodes = play(obstacle=wall, task=task(sectors=8))
    (_, low, high) = episodes.observation_terms[0]
    assert (seen(episodes) >= low).all()
    assert (seen(episodes) <= high).all()
    assert seen(episodes).max() == pytest.approx(1.0, abs=1e-2)
    assert seen(episodes).min() == pytest.approx(inverse(FREE), abs=1e-6)


def test_compiled_and_plain_agree() -> None:
    generator = np.random.default_rng(2)
    angles = np.linspace(-np.pi, np.pi, 50)
    beams = np.stack([np.cos(angles), np.sin(angles)])
    scan = generator.uniform(0.5, 4.5, 50).astype(np.float32)
    then, now = np.array([1.0, 2.0, 0.3]), np.array([1.4, 1.9, -0.8])
    rows = [np.full(9, 4.0, np.float32) for _ in range(2)]
    kernels = past_scans.find_ends, past_scans.lower_depths
    plain = (getattr(kernel, "py_func", kernel) for kernel in kernels)
    for (find_ends, lower_depths), row in zip((kernels, plain), rows, strict=True):
        ends = np.zeros((2, 50))
        find_ends(scan, then, now, np.array([0.1, 0.0]), beams, ends)
        lower_depths(scan, ends, np.float32(4.0), 0.2, row)
    assert rows[0] == pytest.approx(rows[1], abs=1e-5)
    assert rows[0].min() < 2.0


@pytest.mark.parametrize("ago", [[], [0, 3], [1001]])
def test_only_earlier_scans_can_be_remembered(ago: list[int]) -> None:
    with pytest.raises(ScenarioError, match=r"ago.*whole numbers from 1 to 1000"):
        play(task=task(ago=ago))


@pytest.mark.parametrize("name", ["scan", "free_travel", "past_scans"])
def test_a_code_may_not_rise_with_the_depth(name: str) -> None:
    # Where contact reads 1 / near - zero = 0, the code would be divided by 0; half of the way there is the limit.
    with pytest.raises(ScenarioError, match=r"observations\[0\]\.zero: must be <= 0\.5 / near = 0\.1, got 0\.3"):
        play(task={"name": "blank", "observations": [{"name": name, "near": 5.0}]})


def test_it_needs_a_range_sensor_or_a_substitute() -> None:
    with pytest.raises(ScenarioError, match="has no range sensor"):
        play({"sensors": []}, task=task())
    episodes = play({"sensors": []}, task=task(without_sensor="nearest_bodies"))
    assert [name for name, *_ in episodes.observation_terms] == ["nearest_bodies"]
