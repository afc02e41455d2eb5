"""The same file and the same calls in ir-sim 2.12.0."""

from __future__ import annotations

import contextlib
import io
import logging
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import irsim_gym
from irsim_gym.live.world import World

DIFF: dict[str, Any] = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}, "acce": [2, 4]}
SCENARIO: dict[str, Any] = {
    "world": {"height": 10, "width": 10, "step_time": 0.1, "sample_time": 0.3},
    "robot": [
        {**DIFF, "state": [1, 1, 0], "goal": [6, 3, 0], "behavior": {"name": "dash"}},
        {**DIFF, "state": [1, 5, 0], "goal": [9, 5, 0]},
    ],
    "obstacle": [
        {"shape": {"name": "rectangle", "length": 1, "width": 2}, "state": [5, 5, 0], "goal": [8, 8, 0]},
        {**DIFF, "state": [2, 8, 0], "goal": [9, 9, 0]},
    ],
}
Act = Callable[[Any], None]


@pytest.fixture
def peers(tmp_path: Path) -> Iterator[tuple[Any, Any]]:
    """Give the world of the file in ir-sim and here."""
    file = tmp_path / "yard.yaml"
    file.write_text(yaml.safe_dump(SCENARIO))
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        import irsim

        theirs = irsim.make(str(file), headless=True, log_level="CRITICAL")
        yield theirs, irsim_gym.load(file)
        theirs.end()
    logging.getLogger("irsim").handlers.clear()


def compare(theirs: Any, ours: Any) -> None:
    """Compare states, velocities, flags and how the world stands."""
    assert [body.name for body in ours] == theirs.names
    for body, other in zip(ours, theirs.objects, strict=True):
        assert body.state == pytest.approx(other.state[:3, 0], abs=1e-9), body
        if body.spec.kinematics is not None:
            assert body.velocity == pytest.approx(other.velocity[:, 0], abs=1e-9), body
            assert body.stopped == other.stop_flag, body  # what never moves is not held
        assert body.collided == other.collision_flag, body
        if body.role == "robot":
            assert body.arrived == other.arrive_flag, body
    assert ours.status == theirs.status
    assert ours.time == pytest.approx(theirs.time)
    assert [ours.done("all"), ours.done("any")] == [theirs.done("all"), theirs.done("any")]


CALLS: dict[str, list[Act]] = {
    "behaviours": [lambda world: world.step()] * 5,
    "one action": [lambda world: world.step([0.5, 0.3])] * 3 + [lambda world: world.step(np.array([[0.2], [0.1]]))],
    "by id and name": [
        lambda world: world.step([0.5, 0.3], 1),
        lambda world: world.step((0.1, 0.3), "obstacle_3"),
        lambda world: world.step([0.4, 0.1], [0, "robot_1"]),
        lambda world: world.step(),
    ],
    "lists": [
        lambda world: world.step([[0.5, 0.3], [0.2, 0.2]]),
        lambda world: world.step([[0.5, 0.3], None, [0, 0], [0.1, 0.1]]),
        lambda world: world.step([[0.5, 0.3], [0.2, 0.2]], ["obstacle_3", 0]),
        lambda world: world.step([[0.5, 0.3]], 1),
        lambda world: world.step([]),
    ],
    "names": [lambda world: world.step({"robot_1": [0.3, 0.3], "obstacle_3": [9, 9]}), lambda world: world.step()],
    "into the wall": [lambda world: world.step([1.0, 0.0], "robot_1")] * 45,
    "arrival and reset": [
        lambda world: world.robot.set_goal([1.2, 1, 0]),
        *[lambda world: world.step()] * 4,
        lambda world: world["robot_1"].set_goal([1, 5.05, 0]) if _is_ours(world) else _set_theirs(world),
        lambda world: world.step(),
        lambda world: world.reset(),
        lambda world: world.step(),
    ],
    "pause": [
        lambda world: world.step(),
        lambda world: world.pause(),
        lambda world: world.step([1, 1]),
        lambda world: world.resume(),
        lambda world: world.step(),
        lambda world: world.pause(),
        lambda world: world.reset(),
        lambda world: world.step(),
    ],
    "set states and velocities": [
        lambda world: world.robot.set_state([3, 3, 1]),
        lambda world: world.robot.set_velocity([0.3, 0.1]),
        lambda world: world.step([1.0, 1.0]),
        lambda world: world.robot.set_state([4.5, 3.7, 0], init=True),
        lambda world: world.refresh(),
        lambda world: world.reset(),
        lambda world: world.step([0.2, 0.0]),
        lambda world: world.step([0.2, 0.0]),
    ],
    "come and go": [
        lambda world: world.step(),
        lambda world: _add(world, shape={"name": "circle", "radius": 0.3}, state=[1.45, 1, 0]),
        lambda world: world.step(),
        lambda world: world.step(),
        lambda world: world.delete_object(4),
        lambda world: world.step(),
        lambda world: world.step(),
        lambda world: world.delete_object(2),
        lambda world: world.step([0.3, 0.3], 3),
    ],
}


def _is_ours(world: Any) -> bool:
    return isinstance(world, World)


def _set_theirs(world: Any) -> None:
    world.robot_list[1].set_goal([1, 5.05, 0])


def _add(world: Any, **entry: Any) -> None:
    made = world.create_obstacle(**entry)
    if not _is_ours(world):
        world.add_object(made)


@pytest.mark.parametrize("calls", CALLS.values(), ids=CALLS)
def test_the_same_calls_do_the_same(peers: tuple[Any, Any], calls: list[Act]) -> None:
    theirs, ours = peers
    compare(theirs, ours)
    for call in calls:
        call(theirs)
        call(ours)
        compare(theirs, ours)


def test_frames_are_due_at_the_same_steps(peers: tuple[Any, Any]) -> None:
    theirs, ours = peers
    for _ in range(7):
        theirs.step()
        ours.step()
        assert ours.sampling == theirs._world.sampling


def test_what_bodies_tell(peers: tuple[Any, Any]) -> None:
    theirs, ours = peers
    assert np.array_equal(ours.get_robot_state(), theirs.get_robot_state()[:, 0])
    for info, other in zip(ours.get_obstacle_info_list(), theirs.get_obstacle_info_list(), strict=True):
        assert info.center == pytest.approx(other.center[:2, 0])
        assert info.radius == pytest.approx(other.radius)
        assert (info.cone_type, info.convex_flag) == (other.cone_type, other.convex_flag)
    box, disc = ours["obstacle_2"], ours["robot_0"]
    rows = {tuple(row) for row in np.column_stack([box.info.G, box.info.h]).round(9).tolist()}
    assert rows == {tuple(row) for row in np.column_stack([theirs.objects[2].G, theirs.objects[2].h]).tolist()}
    assert np.array_equal(disc.info.G, theirs.robot.G)
    assert disc.info.h == pytest.approx(theirs.robot.h[:, 0], abs=1e-9)
    assert sorted(map(tuple, box.vertices.tolist())) == sorted(map(tuple, theirs.objects[2].vertices.T.tolist()))
    for body, other in zip(ours, theirs.objects, strict=True):
        assert (body.length, body.width) == pytest.approx((other.length, other.width))
