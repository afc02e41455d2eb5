"""Behaviours registered as for IR-SIM: its arguments, its columns, its classes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.base import families
from irsim_gym.errors import IrsimGymError, ScenarioError, UnknownNameError
from irsim_gym.irsim import (
    register_behavior,
    register_behavior_class,
    register_group_behavior,
    register_group_behavior_class,
)

DISC = {"name": "circle", "radius": 0.2}
DIFF: dict[str, Any] = {"kinematics": {"name": "diff"}, "shape": DISC}
OMNI: dict[str, Any] = {"kinematics": {"name": "omni"}, "shape": DISC}


@pytest.fixture(autouse=True)
def own_registries(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forget what a test registers."""
    families.load()
    for registry in (families.BEHAVIORS, families.GROUP_BEHAVIORS):
        monkeypatch.setattr(registry, "_entries", dict(registry._entries))


def simulation(robots: Any, n_worlds: int = 1) -> Any:
    sim = ig.compile(ig.load_scenario({"robot": robots}), n_worlds)
    sim.reset(seed=3)
    return sim


def test_a_function_gets_irsims_arguments_and_columns() -> None:
    seen: list[Any] = []

    @register_behavior("diff", "own")
    def own(ego_object: Any, external_objects: list[Any], **kwargs: Any) -> Any:
        state, goal = ego_object.state, ego_object.goal
        least, greatest = ego_object.get_vel_range()
        seen.append((state, goal, least, greatest, [other.state for other in external_objects], kwargs))
        return np.array([[greatest[0, 0]], [0.25]])

    robot = {**DIFF, "state": [1, 2, 0.5], "goal": [4, 6], "vel_max": [2, 1], "acce": [5, 10], "velocity": [0.5, 0]}
    other = {**OMNI, "state": [8, 8, 0]}
    sim = simulation(
        [{**robot, "behavior": {"name": "own", "tolerance": 0.1, "points": [[1, 2]], "loop": True}}, other]
    )
    sim.step()
    state, goal, least, greatest, others, kwargs = seen[0]
    assert state.tolist() == [[1.0], [2.0], [0.5]]
    assert goal.tolist() == [[4.0], [6.0]]
    assert (least.tolist(), greatest.tolist()) == ([[0.0], [-1.0]], [[1.0], [1.0]])  # 0.5 -+ 5 m/s2 times 0.1 s
    assert [column.tolist() for column in others] == [[[8.0], [8.0], [0.0]]]
    assert kwargs == {"name": "own", "tolerance": 0.1, "points": [[1, 2]], "loop": True}
    assert sim.state.velocity[0, 0].tolist() == [1.0, 0.25, 0.0]


def test_what_a_function_does_to_its_options_is_forgotten() -> None:
    seen = []

    @register_behavior("omni", "own")
    def own(ego_object: Any, external_objects: list[Any], **kwargs: Any) -> Any:
        seen.append(list(kwargs["points"]))
        kwargs["points"].append(3)
        return [0.0, 0.0]

    sim = simulation([{**OMNI, "behavior": {"name": "own", "points": [1, 2]}}])
    sim.step()
    sim.step()
    assert seen == [[1, 2], [1, 2]]


def test_each_drive_has_a_function_of_its_own() -> None:
    register_behavior("diff", "own")(lambda ego_object, external_objects, **options: [0.5, 0.0])
    register_behavior("omni", "own")(lambda ego_object, external_objects, **options: [[0.0], [-0.5]])
    robots = [{**DIFF, "state": [1, 1]}, {**OMNI, "state": [5, 5]}]
    sim = simulation([{**robot, "behavior": {"name": "own"}} for robot in robots])
    sim.step()
    assert sim.state.velocity[0].tolist() == [[0.5, 0, 0], [0, -0.5, 0]]
    with pytest.raises(ScenarioError, match="'own' cannot drive kinematics 'acker'; it drives 'diff' or 'omni'"):
        simulation([{"kinematics": {"name": "acker"}, "shape": {**DISC, "wheelbase": 1}, "behavior": {"name": "own"}}])


def test_a_class_is_made_once_in_each_episode_and_body() -> None:
    made: list[Any] = []

    class Faster:
        """Gains speed with each step."""

        def __init__(self, object_info: Any, gain: float = 0.5, **kwargs: Any) -> None:
            made.append((object_info.name, object_info.kinematics, gain, kwargs))
            self.speed, self.gain = np.zeros((2, 1)), gain

        def __call__(self, ego_object: Any, external_objects: list[Any], **kwargs: Any) -> Any:
            self.speed = self.speed + self.gain
            return self.speed

    register_behavior_class("omni", "faster")(Faster)
    robots = [{**OMNI, "state": [1, y], "behavior": {"name": "faster", "gain": g}} for y, g in ((1, 0.1), (5, 0.2))]
    sim = simulation(robots, n_worlds=2)
    for _ in range(3):
        sim.step()
    assert sim.state.velocity[:, :, 0] == pytest.approx(np.array([[0.3, 0.6], [0.3, 0.6]]))
    assert len(made) == 4
    assert made[2] == ("robot_1", "omni", 0.2, {"name": "faster"})
    sim.reset(seed=3)
    sim.step()
    assert sim.state.velocity[:, :, 0] == pytest.approx(np.array([[0.1, 0.2], [0.1, 0.2]]))
    assert len(made) == 8


def test_groups_get_their_members_alone() -> None:
    @register_group_behavior("omni", "gather")
    def gather(members: list[Any], **kwargs: Any) -> Any:
        middle = np.mean([member.state[:2, 0] for member in members], axis=0)
        return [np.c_[kwargs.get("pull", 1.0) * (middle - member.state[:2, 0])] for member in members]

    @register_group_behavior_class("omni", "keep")
    def keep(members: list[Any], **kwargs: Any) -> Any:
        starts = [member.position for member in members]
        return lambda members, **kwargs: [
            start - member.position for start, member in zip(starts, members, strict=True)
        ]

    entry = {**OMNI, "number": 2, "state": [[1, 1], [2, 1]]}
    sim = simulation([{**entry, "group_behavior": {"name": "gather", "pull": 0.5}}])
    sim.step()
    assert sim.state.velocity[0, :, 0].tolist() == [0.25, -0.25]
    sim = simulation([{**entry, "group_behavior": {"name": "keep"}}])
    sim.step([[0.5, 0.0]], bodies=np.array([0]))
    sim.step()
    assert sim.state.velocity[0, :, 0] == pytest.approx([-0.05, 0.0])


def test_names_are_taken_once_for_each_drive() -> None:
    register_behavior("diff", "own")(lambda ego_object, external_objects, **options: [0.0, 0.0])
    with pytest.raises(IrsimGymError, match="behavior 'own' is registered twice for kinematics 'diff'"):
        register_behavior_class("diff", "own")(lambda object_info, **options: None)
    with pytest.raises(IrsimGymError, match="behavior 'dash' is registered twice"):
        register_behavior("diff", "dash")(lambda ego_object, external_objects, **options: [0.0, 0.0])
    with pytest.raises(UnknownNameError, match="did you mean 'omni'"):
        register_behavior("omnii", "other")


def test_other_functions_take_any_option_too() -> None:
    seen = []

    @ig.behavior("open")
    def own(ego: Any, others: list[Any], *, gain: float = 1.0, **more: Any) -> Any:
        seen.append((gain, more, ego.goal.shape))
        return [0.0, 0.0]

    sim = simulation(
        [{**DIFF, "goal": [4, 6], "behavior": {"name": "open", "gain": 2.0, "mode": "wide", "wander": False}}]
    )
    sim.step()
    assert seen == [(2.0, {"mode": "wide"}, (3,))]
    with pytest.raises(ScenarioError, match="gain: must be a number, got 'much'"):
        simulation([{**DIFF, "behavior": {"name": "open", "gain": "much", "mode": "wide"}}])
