"""Policies of different perceptions in the same worlds."""

from typing import Any

import numpy as np
import pytest

from irsim_gym.base.families import ACTIONS, OBSERVATIONS
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.evaluation.policies.perception import (
    Perceived,
    Perception,
    UnfitPerceptionError,
    perceived_task,
    perception_of,
)
from irsim_gym.evaluation.policies.policy import ObservationPolicy
from irsim_gym.evaluation.policies.reference_policies import reference_policy
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.scenario import load_scenario
from irsim_gym.tasks import Episodes, load_task

ROOM: dict[str, Any] = {
    "world": {"width": 8, "height": 8},
    "robot": {
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": 0.2},
        "distribution": {"name": "random"},
        "sensors": [{"name": "lidar2d", "number": 24, "range_max": 4}],
    },
    "obstacle": [
        {"number": 4, "distribution": {"name": "random"}, "shape": {"name": "circle", "radius": 0.5}},
        {
            "number": 2,
            "kinematics": {"name": "omni"},
            "behavior": {"name": "dash"},
            "distribution": {"name": "random"},
            "shape": {"name": "circle", "radius": 0.3},
        },
    ],
}
PUSHED = {
    **ROOM,
    "world": {"width": 8, "height": 8, "collision_mode": "contact"},
    "obstacle": {"shape": {"name": "circle", "radius": 0.3}, "mass": 1, "distribution": {"name": "random"}},
}
BLIND = {**ROOM, "robot": {**ROOM["robot"], "sensors": []}}
ENDS = {"endings": ["arrived", "collided"], "rewards": [{"name": "arrival", "weight": 1.0}]}
PLAYED: dict[str, Any] = {"name": "blank", "max_steps": 30, "observations": ["velocity", "goal"], **ENDS}
SCAN = {"name": "scan", "sectors": 6}
OTHER: dict[str, Any] = {"name": "blank", "max_steps": 9, "observations": [SCAN, "trail"], "observation_form": "dict"}
CHOICES = {**OTHER, "observation_form": "flat", "action": {"name": "discrete", "linear": 2, "angular": 3}}


def worlds(task: dict[str, Any], n_worlds: int = 4, scenario: Any = ROOM) -> Episodes:
    return Worlds(scenario, n_worlds, task=task).episodes


def perception(task: dict[str, Any], scenario: Any = ROOM) -> Perception:
    return perception_of(load_task(load_scenario(scenario), task))


def weighed(seen: Any, outputs: int = 2) -> np.ndarray:
    """Return numbers in which every column of an observation counts."""
    rows = np.concatenate(list(seen.values()), axis=1) if isinstance(seen, dict) else seen
    weights = np.cos(1.0 + np.arange(rows.shape[1] * outputs)).reshape(rows.shape[1], outputs)
    return np.tanh(rows.astype(np.float64) @ weights + 0.3).astype(np.float32)


def chosen(seen: Any) -> np.ndarray:
    return weighed(seen, 6).argmax(axis=1)


def test_a_perception_says_what_is_observed_with_all_options() -> None:
    found = perception({"name": "blank", "observations": ["velocity", {"name": "trail", "marks": 5}, SCAN]})
    assert found.names == ["velocity", "trail", "scan"]
    assert found.observations[1] == {
        "name": "trail",
        "sectors": 12,
        "spacing": 0.5,
        "marks": 5,
        "fresh": 2,
        "near": 0.5,
    }
    assert found.observations[2]["sectors"] == 6
    assert (found.action, found.observation_form) == ({"name": "velocity", "frame": "body"}, "flat")


def test_what_stands_for_a_missing_sensor_is_what_was_observed() -> None:
    task = {"name": "blank", "observations": [{**SCAN, "without_sensor": ["nearest_bodies", "route"]}]}
    assert perception(task, BLIND).names == ["nearest_bodies", "route"]
    assert perception(task).names == ["scan"]


@pytest.mark.parametrize("name", OBSERVATIONS.names())
def test_every_observation_comes_back_as_it_was(name: str) -> None:
    scenario = load_scenario(PUSHED if hasattr(OBSERVATIONS.entry(name).kind, "misfit") else ROOM)
    task = load_task(scenario, {"name": "blank", "observations": [name]})
    played = load_task(scenario, PLAYED)
    again = perceived_task(scenario, played, perception_of(task))
    assert again.observations == task.observations
    assert (again.rewards, again.endings, again.max_steps) == (played.rewards, played.endings, 30)


@pytest.mark.parametrize("name", ACTIONS.names())
def test_every_action_comes_back_as_it_was(name: str) -> None:
    scenario = load_scenario(ROOM)
    task = load_task(scenario, {**PLAYED, "action": name})
    assert perceived_task(scenario, load_task(scenario, PLAYED), perception_of(task)).action == task.action


@pytest.mark.parametrize("n_worlds", [1, 3, 8])
def test_policies_drive_as_each_would_alone_with_its_own_observations(n_worlds: int) -> None:
    def alone(function: Any, task: dict[str, Any]) -> list[Any]:
        own = {key: task[key] for key in ("observations", "observation_form", "action") if key in task}
        return evaluate(function, worlds({**PLAYED, **own}), 8)

    expected = [alone(weighed, PLAYED), alone(weighed, OTHER), alone(chosen, CHOICES)]
    assert len({tuple(row.path_length for row in rows) for rows in expected}) == 3  # each drives in another way
    together = Perceived(worlds(PLAYED, n_worlds))
    policies = [
        ObservationPolicy(weighed),
        ObservationPolicy(weighed, perception(OTHER)),
        ObservationPolicy(chosen, perception(CHOICES)),
        reference_policy("dash"),
    ]
    rows = [evaluate(policy, together.of(policy), 8) for policy in policies * 2]
    assert rows[:3] == rows[4:7] == expected
    assert rows[3] == rows[7] == evaluate(reference_policy("dash"), worlds(PLAYED), 8)


def test_policies_that_observe_the_same_share_their_worlds() -> None:
    together = Perceived(worlds(PLAYED))
    other = together.of(ObservationPolicy(weighed, perception(OTHER)))
    assert other is together.of(ObservationPolicy(chosen, perception(OTHER)))
    assert other is not together.episodes
    assert other.simulation is together.episodes.simulation
    assert (other.task.max_steps, other.task.name) == (30, together.episodes.task.name)
    for policy in (
        ObservationPolicy(weighed),
        ObservationPolicy(weighed, perception(PLAYED)),
        reference_policy("dash"),
    ):
        assert together.of(policy) is together.episodes


def test_names_of_what_policies_observe() -> None:
    together = Perceived(worlds(PLAYED))
    assert together.observed_by(ObservationPolicy(weighed)) == ["velocity", "goal"]
    assert together.observed_by(ObservationPolicy(weighed, perception(OTHER))) == ["scan", "trail"]
    assert together.observed_by(reference_policy("dash")) is None


def test_worlds_that_lack_what_is_observed_are_refused() -> None:
    blind = Perceived(worlds(PLAYED, scenario=BLIND))
    with pytest.raises(UnfitPerceptionError) as refused:
        blind.of(ObservationPolicy(weighed, perception(OTHER)))
    assert "the policy was trained with scan, trail, which does not fit" in str(refused.value)
    assert "observations[0]: 'robot_0' has no range sensor" in str(refused.value)
