from typing import Any

import numpy as np
import pytest

from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.evaluation.policies.behavior_policies import BehaviorPolicy
from irsim_gym.evaluation.policies.drive_actions import to_actions
from irsim_gym.evaluation.policies.named_policies import PolicyOptionError
from irsim_gym.evaluation.policies.reference_policies import RandomPolicy, reference_policy
from irsim_gym.scenario import load_scenario
from irsim_gym.simulator.engine import compile

HERE = np.array([0])


def dash_command(episodes: Any) -> Any:
    policy = BehaviorPolicy("dash")
    policy.begin(episodes, HERE, HERE)
    return policy.command(episodes, HERE)


def scenario(**robot: Any) -> dict[str, Any]:
    given = {
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": 0.2},
        "behavior": {"name": "dash"},
        "state": [2, 2, 2.5],
        "goal": [8, 5, 0],
        "vel_min": [-1, -1.5],
        "vel_max": [1, 1.5],
        "sensors": [{"name": "lidar2d", "number": 36}],
        **robot,
    }
    return {"world": {"height": 10, "width": 10, "step_time": 0.1}, "robot": given}


@pytest.mark.parametrize("acceleration", [[".inf", ".inf"], [2.0, 0.8]])
@pytest.mark.parametrize("state", [[2, 2, 2.5], [2, 2, 0.3], [7.9, 8, -2.0]])
def test_dash_drives_as_the_behaviour_does(state: list[float], acceleration: list[Any]) -> None:
    limits = [float(value) if isinstance(value, float) else np.inf for value in acceleration]
    data = scenario(state=state, acce=limits)
    native = compile(load_scenario(data))
    native.reset()
    episodes, policy = Worlds(data).episodes, reference_policy("dash")
    episodes.begin(HERE, HERE)
    policy.begin(episodes, HERE, HERE)
    for _ in range(60):
        native.step()
        episodes.step(np.asarray(policy.act(episodes, HERE), np.float64)[:, None])
        if episodes.view.terminated[0, 0]:
            break
        np.testing.assert_allclose(episodes.simulation.state.pose[0, 0], native.state.pose[0, 0], atol=1e-9)
        np.testing.assert_allclose(episodes.simulation.state.velocity[0, 0], native.state.velocity[0, 0], atol=1e-9)
    assert episodes.view.infos["steps"][0, 0] > 20


def test_command_by_hand() -> None:
    episodes = Worlds(scenario(state=[0, 0, 0], goal=[3, 3, 0])).episodes
    episodes.begin(HERE, HERE)
    # The goal is pi/4 to the left: v = cos(pi/4), full turn.
    np.testing.assert_allclose(dash_command(episodes), [[[np.sqrt(0.5), 1.5]]])


def test_turn_that_can_still_be_braked_by_hand() -> None:
    episodes = Worlds(scenario(state=[0, 0, 0], goal=[3, 3, 0], acce=[np.inf, 1.0])).episodes
    episodes.begin(HERE, HERE)
    # -0.1 + sqrt(0.01 + 2 (pi/4 - 0.1)) = 1.0750
    assert dash_command(episodes)[0, 0, 1] == pytest.approx(-0.1 + np.sqrt(0.01 + 2.0 * (np.pi / 4.0 - 0.1)))


def test_discrete_actions_are_the_nearest_choices() -> None:
    task = {"name": "navigation", "action": {"name": "discrete", "linear": 3, "angular": 5}}
    episodes = Worlds({**scenario(), "task": task}).episodes
    episodes.begin(HERE, HERE)
    # Forward values -1, 0, 1 m/s; turns -1.5, -0.75, 0, 0.75, 1.5 rad/s.
    for command, choice in [((1.0, 1.5), 14), ((0.1, 0.0), 7), ((-1.0, -0.8), 1)]:
        assert to_actions(episodes, HERE, np.array([[command]])).tolist() == [[choice]]
    random = RandomPolicy()
    random.begin(episodes, HERE, HERE)
    drawn = {int(random.act(episodes, HERE)[0]) for _ in range(300)}
    assert drawn == set(range(15))


def test_random_actions_follow_from_the_level() -> None:
    episodes = Worlds(scenario(), 3).episodes
    both, alone = RandomPolicy(), RandomPolicy()
    both.begin(episodes, np.array([0, 2]), np.array([4, 9]))
    alone.begin(episodes, np.array([1]), np.array([9]))
    for _ in range(70):
        np.testing.assert_array_equal(both.act(episodes, np.array([0, 2]))[1], alone.act(episodes, np.array([1]))[0])
    other = RandomPolicy(seed=1)
    other.begin(episodes, np.array([1]), np.array([9]))
    alone.begin(episodes, np.array([1]), np.array([9]))
    assert (other.act(episodes, np.array([1])) != alone.act(episodes, np.array([1]))).all()


DRIVES = {
    "omni": {"kinematics": {"name": "omni"}, "vel_min": [-1, -1], "vel_max": [1, 1]},
    "omni in its own frame": {"kinematics": {"name": "omni", "frame": "body"}, "vel_min": [-1, -1], "vel_max": [1, 1]},
    "omni_angular": {"kinematics": {"name": "omni_angular"}, "vel_min": [-1, -1, -1], "vel_max": [1, 1, 1]},
    "acker": {"kinematics": {"name": "acker", "wheelbase": 0.3}, "vel_min": [-1, -0.6], "vel_max": [1, 0.6]},
}


@pytest.mark.parametrize("robot", DRIVES.values(), ids=DRIVES.keys())
def test_dash_reaches_the_goal_with_every_drive_as_the_behaviour_does(robot: dict[str, Any]) -> None:
    data = scenario(**{**robot, "state": [2, 2, 0.9]})
    native = compile(load_scenario(data))
    native.reset()
    episodes, policy = Worlds(data).episodes, reference_policy("dash")
    episodes.begin(HERE, HERE)
    policy.begin(episodes, HERE, HERE)
    while not episodes.view.terminated[0, 0] and episodes.view.infos["steps"][0, 0] < 200:
        native.step()
        episodes.step(np.asarray(policy.act(episodes, HERE), np.float64)[:, None])
        np.testing.assert_allclose(episodes.simulation.state.pose[0, 0], native.state.pose[0, 0], atol=1e-9)
    assert episodes.view.infos["is_success"][0, 0]


def test_a_behaviour_that_cannot_drive_the_learner_is_refused() -> None:
    data = scenario(**DRIVES["acker"])
    episodes, policy = Worlds(data).episodes, reference_policy("rvo")
    with pytest.raises(ValueError, match="'rvo' cannot drive kinematics 'acker'"):
        policy.begin(episodes, HERE, HERE)


def test_options_of_a_policy_by_name() -> None:
    """On an empty way rvo takes the sample next to its own top speed, or, without the option, to that of the drive."""
    open_way = scenario(kinematics={"name": "omni"}, state=[2, 5, 0], goal=[8, 5, 0], vel_min=[-1, -1], vel_max=[1, 1])
    for name, speed in (("rvo:vxmax=0.5", 0.5), ("rvo", 1.0)):
        episodes, policy = Worlds(open_way, 1).episodes, reference_policy(name)
        episodes.begin(HERE, HERE, "dev")
        policy.begin(episodes, HERE, HERE)
        assert isinstance(policy, BehaviorPolicy)
        assert policy.command(episodes, HERE)[0, 0, :2] == pytest.approx([speed, 0.0], abs=0.1)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("rvo:vxmax", "'rvo:vxmax': write NAME:OPTION=VALUE:..., each option once, got 'vxmax'"),
        ("rvo:vxmx=1", "'rvo:vxmx=1': vxmx: unknown key (did you mean 'vxmax'?)"),
        ("rvo:vxmax=fast", "'rvo:vxmax=fast': vxmax: must be a number, got 'fast'"),
        ("random:a=1", "'random:a=1': 'random' is no behavior, and has no options"),
    ],
)
def test_wrong_options_of_a_policy_are_named(name: str, told: str) -> None:
    with pytest.raises(PolicyOptionError) as error:
        reference_policy(name)
    assert str(error.value).startswith(told)
