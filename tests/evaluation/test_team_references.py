"""Reference policies of teams drive as the behaviours of the language do in the simulation."""

from typing import Any

import numpy as np
import pytest

from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.policies.behavior_policies import BehaviorPolicy
from irsim_gym.evaluation.policies.drive_actions import to_actions
from irsim_gym.evaluation.policies.reference_policies import RandomPolicy, reference_policy
from irsim_gym.scenario import load_scenario
from irsim_gym.simulator.engine import compile
from irsim_gym.tasks import Episodes, Outcome

HERE = np.array([0])
LIMITS = {"diff": ([-1.2, -3.0], [1.2, 3.0]), "omni": ([-1.0, -1.0], [1.0, 1.0])}
STATES = [[1.0, 5.0, 0.1], [9.0, 5.2, 3.0], [5.1, 1.0, 1.5], [4.8, 9.0, -1.6]]
GOALS = [[9.0, 5.1, 0.0], [1.0, 4.9, 0.0], [5.0, 9.0, 0.0], [5.2, 1.0, 0.0]]
TASK = {"max_steps": 400, "action": {"name": "velocity", "frame": "command"}}
"""Actions in the frame of the command: in a turned frame the corners of an omni drive's limits are out of reach."""


def team_of(scenario: Any, n_worlds: int = 1) -> Episodes:
    return Worlds(scenario, n_worlds, team=True).episodes


def crossing(drives: tuple[str, ...], **own: Any) -> dict[str, Any]:
    """Four robots that meet in the middle, each with its own drive; a box stands beside."""
    robots = [
        {
            "kinematics": {"name": drive},
            "shape": {"name": "circle", "radius": 0.2},
            "state": state,
            "goal": goal,
            "goal_threshold": 0.15,
            "vel_min": LIMITS[drive][0],
            "vel_max": LIMITS[drive][1],
            **own,
        }
        for drive, state, goal in zip(drives, STATES, GOALS, strict=True)
    ]
    box = {"shape": {"name": "rectangle", "length": 0.8, "width": 0.4}, "state": [6.5, 6.3, 0.4]}
    world = {"height": 10, "width": 10, "step_time": 0.1, "update": "simultaneous"}
    return {"world": world, "robot": robots, "obstacle": [box], "task": TASK}


def drive_beside(name: str, scenario: dict[str, Any]) -> int:
    """Drive the team by a reference policy beside robots that have the behaviour, until the first agent has ended."""
    native = compile(load_scenario(scenario))
    native.reset()
    episodes, policy = team_of(scenario), reference_policy(name)
    episodes.begin(HERE, HERE)
    policy.begin(episodes, HERE, HERE)
    while (episodes.view.infos["outcome"] == Outcome.RUNNING).all():
        native.step()
        episodes.step(np.asarray(policy.act(episodes, HERE)))
        np.testing.assert_allclose(episodes.simulation.state.pose, native.state.pose, atol=1e-9)
    return int(episodes.view.infos["steps"].min())


MIXED = ("diff", "omni", "diff", "omni")


@pytest.mark.parametrize("drives", [("diff",) * 4, ("omni",) * 4, MIXED])
@pytest.mark.parametrize(
    ("name", "own"),
    [
        ("dash", {"behavior": {"name": "dash"}}),
        ("rvo", {"behavior": {"name": "rvo", "vxmax": 1.1, "vymax": 1.3, "neighbor_threshold": 4.0}}),
        ("orca", {"group_behavior": {"name": "orca", "timeHorizon": 3.0, "safe_radius": 0.05}, "group": 0}),
    ],
)
def test_the_team_drives_as_robots_with_the_behaviour_do(
    name: str, own: dict[str, Any], drives: tuple[str, ...]
) -> None:
    assert drive_beside(name, crossing(drives, **own)) > 30


def begun(name: str, scenario: dict[str, Any]) -> tuple[Episodes, BehaviorPolicy]:
    episodes, policy = team_of(scenario), BehaviorPolicy(name)
    episodes.begin(HERE, HERE)
    policy.begin(episodes, HERE, HERE)
    return episodes, policy


def test_speeds_are_those_of_the_drive_unless_the_file_says_more() -> None:
    _, policy = begun("rvo", crossing(("diff",) * 4))
    assert [(own.vxmax, own.vymax) for own in policy._groups[0].options] == [(1.2, 1.2)] * 4
    _, policy = begun("rvo", crossing(("omni",) * 4, vel_max=[0.7, 0.9]))
    assert [(own.vxmax, own.vymax) for own in policy._groups[0].options] == [(0.7, 0.9)] * 4
    _, policy = begun("rvo", crossing(("diff",) * 4, behavior={"name": "rvo", "vxmax": 0.5}))
    assert [(own.vxmax, own.vymax) for own in policy._groups[0].options] == [(0.5, 1.5)] * 4


def test_orca_looks_less_far_ahead_than_by_default_unless_the_file_says_so() -> None:
    _, policy = begun("orca", crossing(("diff",) * 4))
    assert (policy._groups[0].options[0].timeHorizon, policy._groups[0].options[0].sidestep) == (5.0, True)
    _, policy = begun("orca", crossing(("diff",) * 4, group_behavior={"name": "orca"}, group=0))
    assert (policy._groups[0].options[0].timeHorizon, policy._groups[0].options[0].sidestep) == (20.0, False)


def test_agents_that_have_ended_stand_and_are_seen_standing() -> None:
    states, goals = [[2, 5, 0], [5, 5.05, 0]], [[8, 5, 0], [5.1, 5.05, 0]]
    scenario = crossing(
        ("omni",) * 4, group_behavior={"name": "orca", "timeHorizon": 2.0, "safe_radius": 0.05}, group=0
    )
    scenario["robot"] = [
        {**robot, "state": state, "goal": goal}
        for robot, state, goal in zip(scenario["robot"][:2], states, goals, strict=True)
    ]
    episodes, policy = begun("orca", scenario)
    simulation = episodes.simulation
    episodes.step(policy.act(episodes, HERE))
    assert episodes.view.infos["outcome"].tolist() == [[Outcome.RUNNING, Outcome.SUCCESS]]
    stands = simulation.state.pose[0, 1].copy()
    while episodes.view.infos["outcome"][0, 0] == Outcome.RUNNING:
        action = policy.act(episodes, HERE)
        episodes.step(action)
        np.testing.assert_array_equal(simulation.state.pose[0, 1], stands)
    assert episodes.view.infos["outcome"].tolist() == [[Outcome.SUCCESS, Outcome.SUCCESS]]
    assert 0.0 < episodes.view.infos["min_clearance"][0, 0] < 0.3


def test_everything_that_moves_is_seen_by_orca() -> None:
    scenario = crossing(("omni",) * 4)
    walker = {"kinematics": {"name": "diff"}, "behavior": {"name": "dash"}, "state": [2, 8, 0], "goal": [8, 8, 0]}
    scenario["obstacle"].append({**walker, "shape": {"name": "circle", "radius": 0.3}})
    _, policy = begun("orca", scenario)
    group = policy._groups[0]
    assert group.members.tolist() == [0, 1, 2, 3, 5]
    assert group.members[group.arrays["decides"]].tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize("name", ["rvo", "orca"])
def test_a_drive_that_a_behaviour_cannot_command_is_told(name: str) -> None:
    acker = {"kinematics": {"name": "acker", "wheelbase": 0.3}, "vel_min": [-1, -0.6], "vel_max": [1, 0.6]}
    with pytest.raises(IrsimGymError, match=f"'{name}' cannot drive kinematics 'acker' of 'robot_0'"):
        begun(name, crossing(("diff",) * 4, **acker))


def test_random_agents_of_a_level_differ_and_follow_from_it() -> None:
    episodes = team_of(crossing(("diff",) * 4), 3)
    both, alone = RandomPolicy(), RandomPolicy()
    both.begin(episodes, np.array([0, 2]), np.array([4, 9]))
    alone.begin(episodes, np.array([1]), np.array([9]))
    first = both.act(episodes, np.array([0, 2]))
    assert first.shape == (2, 4, 2)
    assert len(np.unique(first)) == first.size
    np.testing.assert_array_equal(first[1], alone.act(episodes, np.array([1]))[0])
    assert (both.act(episodes, np.array([0, 2])) != first).all()


def test_choices_of_a_mixed_team_are_the_nearest_ones() -> None:
    scenario = crossing(("diff",) * 4)
    turning = {"kinematics": {"name": "omni_angular"}, "vel_min": [-1, -1, -1], "vel_max": [1, 1, 1]}
    scenario["robot"] = [scenario["robot"][0], {**scenario["robot"][1], **turning}]
    scenario["task"] = {"action": {"name": "discrete", "linear": 3, "angular": 5}, "max_steps": 9}
    episodes = team_of(scenario)
    episodes.begin(HERE, HERE)
    # diff: -1.2, 0, 1.2 m/s and -3, -1.5, 0, 1.5, 3 rad/s; omni_angular: -1, 0, 1 m/s, no sideways, -1 to 1 rad/s.
    command = np.array([[[1.0, -1.6, 0.0], [-0.1, 0.9, 0.6]]])
    assert to_actions(episodes, HERE, command).tolist() == [[2 * 5 + 1, 1 * 5 + 3]]
    policy = reference_policy("random")
    policy.begin(episodes, HERE, HERE)
    assert policy.act(episodes, HERE).shape == (1, 2)
