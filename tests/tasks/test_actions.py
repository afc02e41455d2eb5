"""Actions in [-1, 1] and on a grid become commands."""

from __future__ import annotations

import numpy as np
import pytest
from task_tools import drive, play

from irsim_gym.errors import ScenarioError
from irsim_gym.tasks.actions.discrete import DiscreteAction

DISCRETE = {"name": "navigation", "action": {"name": "discrete", "linear": 3, "angular": 5}}


@pytest.mark.parametrize(
    ("action", "command"),
    [
        ((-1, -1), (0.0, -1.5)),
        ((1, 1), (1.0, 1.5)),
        ((0, 0), (0.5, 0.0)),
        ((0.5, -0.2), (0.75, -0.3)),
        ((7, -9), (1.0, -1.5)),
    ],
)
def test_actions_map_affinely_to_the_limits(action: tuple[float, float], command: tuple[float, float]) -> None:
    episodes = play()
    drive(episodes, *action)
    assert episodes.simulation.state.command[0, 0, :2] == pytest.approx(command, abs=1e-15)


def test_the_episode_begins_with_the_action_of_standing_still() -> None:
    # v lies in [0, 1], so rest is -1; w lies in [-1.5, 1.5], so rest is 0.
    assert play().state.action[0, 0].tolist() == [-1.0, 0.0]
    assert play({"vel_min": [-1, -1], "vel_max": [3, 1]}).state.action[0, 0].tolist() == [-0.5, 0.0]
    assert play({"vel_min": [0.5, -1], "vel_max": [1, 1]}).state.action[0, 0].tolist() == [-1.0, 0.0]
    assert play({"vel_min": [0, -1], "vel_max": [0, 1]}).state.action[0, 0].tolist() == [0.0, 0.0]


def test_an_episode_knows_nothing_of_the_actions_of_the_one_before() -> None:
    # The package reads previous_action in steps alone; an observation of one's own may read it when an episode begins.
    episodes = play()
    for again in (lambda: episodes.begin_next(np.arange(1)), lambda: episodes.respawn(np.ones((1, 1), np.bool_))):
        drive(episodes, 1, 1)
        drive(episodes, 0.5, 0.5)
        assert episodes.state.previous_action[0, 0].tolist() == [1.0, 1.0]
        again()
        assert episodes.state.action[0, 0].tolist() == [-1.0, 0.0]
        assert episodes.state.previous_action[0, 0].tolist() == [-1.0, 0.0]


def test_discrete_choices_run_over_the_grid() -> None:
    episodes = play(task=DISCRETE)
    assert (episodes.action_kind, episodes.n_discrete) == ("discrete", 15)
    for choice, command in {0: (0.0, -1.5), 2: (0.0, 0.0), 7: (0.5, 0.0), 9: (0.5, 1.5), 14: (1.0, 1.5)}.items():
        episodes.step(np.array([[choice]]))
        assert episodes.simulation.state.command[0, 0, :2] == pytest.approx(command)


def test_grids_of_one_value() -> None:
    grid = DiscreteAction(linear=1, angular=1).arrays(play().simulation, np.zeros(1, np.int64))["grid"]
    assert grid.tolist() == [[[1.0, 0.0]]]


@pytest.mark.parametrize("choice", [-1, 15])
def test_a_choice_off_the_grid_is_refused(choice: int) -> None:
    episodes = play(task=DISCRETE)
    with pytest.raises(ValueError, match="not a choice from 0 to 14"):
        episodes.step(np.array([[choice]]))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_an_action_that_is_not_finite_is_refused_before_anything_moves(bad: float) -> None:
    episodes = play(n_worlds=2)
    before = episodes.simulation.state.pose.copy()
    actions = np.zeros((2, 1, 2), np.float32)
    actions[1, 0, 1] = bad
    with pytest.raises(ValueError, match="not finite"):
        episodes.step(actions)
    assert (episodes.simulation.state.pose == before).all()
    episodes.step(actions, np.array([0]))
    assert episodes.view.infos["steps"].tolist() == [[1], [0]]


def test_wrong_shapes_and_types_are_refused() -> None:
    episodes = play()
    with pytest.raises(ValueError, match=r"shape \(1, 1, 2\), got \(1, 2\)"):
        episodes.step(np.zeros((1, 2)))
    with pytest.raises(ValueError, match="must be numbers"):
        episodes.step(np.zeros((1, 1, 2), complex))
    with pytest.raises(ValueError, match="whole numbers"):
        play(task=DISCRETE).step(np.zeros((1, 1)))


OMNI = {"kinematics": {"name": "omni"}, "state": [2, 5, np.pi / 2], "vel_min": [-1, -1], "vel_max": [1, 1]}


@pytest.mark.parametrize(("frame", "command"), [("body", (0.5, 1.0)), ("command", (1.0, -0.5))])
def test_an_omni_robot_is_driven_in_its_own_frame_unless_asked_otherwise(
    frame: str, command: tuple[float, float]
) -> None:
    # The robot faces +y: ahead 1 and 0.5 to the right are 1 in y and 0.5 in x.
    episodes = play(OMNI, task={"name": "navigation", "action": {"name": "velocity", "frame": frame}})
    drive(episodes, 1.0, -0.5)
    assert episodes.simulation.state.command[0, 0, :2] == pytest.approx(command, abs=1e-15)


def test_an_omni_robot_that_faces_anywhere_observes_its_velocity_in_its_own_frame() -> None:
    # The commands of an omni drive are velocities in the world frame; (0.3, -0.5) m/s over sqrt(2) m/s, turned by -0.6.
    episodes = play({**OMNI, "state": [2, 5, 0.6]}, task={"name": "blank", "observations": ["velocity"]})
    episodes.simulation.state.velocity[0, 0, :2] = episodes.simulation.state.twist[0, 0, :2] = [0.3, -0.5]
    episodes._observe(episodes.simulation.shards.all[0])
    ahead = 0.3 * np.cos(0.6) - 0.5 * np.sin(0.6)
    left = -0.5 * np.cos(0.6) - 0.3 * np.sin(0.6)
    np.testing.assert_allclose(episodes.view.observation[0, 0], np.array([ahead, left]) / np.sqrt(2), atol=1e-7)


def test_choices_of_three_components() -> None:
    robot = {"kinematics": {"name": "omni_angular"}, "vel_min": [-1, -1, -2], "vel_max": [1, 1, 2]}
    task = {"name": "navigation", "action": {"name": "discrete", "linear": 3, "lateral": 2, "angular": 3}}
    episodes = play(robot, task=task)
    assert episodes.n_discrete == 18
    for choice, command in {0: (-1, -1, -2), 5: (-1, 1, 2), 10: (0, 1, 0), 17: (1, 1, 2)}.items():
        episodes.step(np.array([[choice]]))
        assert episodes.simulation.state.command[0, 0].tolist() == list(command)


def test_a_component_that_the_drive_lacks_has_no_choices() -> None:
    task = {"name": "navigation", "action": {"name": "discrete", "lateral": 3}}
    with pytest.raises(ScenarioError, match=r"action\.lateral: must be 1 for a drive with 2 components"):
        play(task=task)


def test_an_omni_robot_observes_its_velocity_in_its_own_frame() -> None:
    task = {"name": "navigation", "observations": [{"name": "velocity"}], "observation_form": "dict"}
    episodes = play(OMNI, task=task)
    drive(episodes, 1.0, -0.5)
    names = [name for name, _, _ in episodes.observation_terms]
    start = sum(len(low) for _, low, _ in episodes.observation_terms[: names.index("velocity")])
    seen = episodes.view.observation[0, 0, start : start + 2]
    np.testing.assert_allclose(seen, np.array([1.0, -0.5]) / np.sqrt(2.0), atol=1e-6)
