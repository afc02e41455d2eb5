"""Turns: bodies that look at others move one after another, and see those before them moved."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import pytest

import irsim_gym as ig
import irsim_gym.bodies.behaviors
from irsim_gym.base.families import BEHAVIORS
from irsim_gym.base.options import kind, option
from irsim_gym.simulator.step.turns import take_turns
from irsim_gym.simulator.world.group import Group


@kind
class Follow:
    """Drive as fast as the distance that the body before is ahead in x."""

    kinematics: ClassVar[tuple[str, ...]] = ("diff",)
    reads_neighbors: ClassVar[bool] = True
    wander: bool = option(False, meaning="Unused.")
    loop: bool = option(False, meaning="Unused.")

    @staticmethod
    def prepare(group: Group, model: Any, n_slots: int) -> None:
        """Need no memory."""

    @staticmethod
    def decide(group: Group, model: Any, state: Any, shard: Any) -> None:
        """Write the members' commands."""
        for w in shard.worlds:
            for b in group.members:
                state.command[w, b] = [state.pose[w, b - 1, 0] - state.pose[w, b, 0], 0.0, 0.0]


class Alone(Follow):
    """A behaviour that looks at nobody."""

    reads_neighbors: ClassVar[bool] = False


@pytest.fixture
def _follow(monkeypatch: pytest.MonkeyPatch) -> None:
    """The behaviour `follow`, for one test."""
    monkeypatch.setattr(BEHAVIORS, "_entries", dict(BEHAVIORS._entries))
    BEHAVIORS.register("follow", Follow)


def group(kind_class: type[Any], members: list[int]) -> Group:
    return Group(kind_class, [kind_class() for _ in members], np.array(members, np.int64))


def as_lists(turns: list[Any]) -> list[tuple[list[list[int]], list[int], list[list[int]]]]:
    return [
        ([g.members.tolist() for g in t.behaviors], t.movers.tolist(), [g.members.tolist() for g in t.kinematics])
        for t in turns
    ]


def test_a_turn_begins_with_each_body_that_looks_at_others() -> None:
    # Bodies 2 and 5 look at others; 1, 3 and 6 do not; 4 only has a drive; 0 cannot move.
    movers = np.arange(1, 7, dtype=np.int64)
    turns = take_turns(
        movers,
        [group(Follow, [2, 5]), group(Alone, [1, 3, 6])],
        [group(Alone, [1, 2, 3, 4, 5, 6])],
        np.array([1, 2, 3, 5, 6]),
        in_order=True,
    )
    assert [turn.driven.tolist() for turn in turns] == [[1], [2, 3], [5, 6]]  # body 4 coasts
    assert as_lists(turns) == [
        ([[1]], [1], [[1]]),
        ([[2], [3]], [2, 3, 4], [[2, 3, 4]]),
        ([[5], [6]], [5, 6], [[5, 6]]),
    ]


@pytest.mark.parametrize(("reader", "in_order"), [(Follow, False), (Alone, True)])
def test_otherwise_there_is_one_turn(reader: type[Any], in_order: bool) -> None:
    movers = np.arange(4, dtype=np.int64)
    turns = take_turns(movers, [group(reader, [1, 2])], [group(Alone, [0, 1, 2, 3])], movers, in_order=in_order)
    assert as_lists(turns) == [([[1, 2]], [0, 1, 2, 3], [[0, 1, 2, 3]])]


@pytest.mark.parametrize(
    ("update", "expected"),
    [
        # 0 drives 1 m/s for 1 s. Each follower asks for the gap to the one before it: moved already, or not yet.
        ("sequential", [[11, 11, 11], [12, 12, 12]]),
        ("simultaneous", [[11, 10, 5], [12, 11, 10]]),
    ],
)
@pytest.mark.usefixtures("_follow")
def test_followers_see_the_moved_or_the_old_place(update: str, expected: list[list[float]]) -> None:
    drive = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.1}, "vel_max": [50, 1]}
    robots = [
        {**drive, "state": [10, 1, 0], "goal": [1000, 1, 0], "vel_max": [1, 1], "behavior": {"name": "dash"}},
        {**drive, "state": [5, 2, 0], "behavior": {"name": "follow"}},
        {**drive, "state": [0, 3, 0], "behavior": {"name": "follow"}},
    ]
    world = {"width": 20, "height": 20, "step_time": 1.0, "update": update}
    sim = ig.compile(ig.load_scenario({"world": world, "robot": robots}, warn=False))
    sim.reset()
    for row in expected:
        sim.step()
        assert sim.state.pose[0, :, 0].tolist() == pytest.approx(row)
