"""States as IR-SIM's columns, and flat ones that refuse to meet a column."""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from small_world import DIFF, SCENARIO

import irsim_gym

CAR: dict[str, Any] = {
    "kinematics": {"name": "acker"},
    "shape": {"name": "rectangle", "length": 2, "width": 1, "wheelbase": 1.2},
    "state": [2, 7, 0.3, 0.1],
    "goal": [[6, 7, 0], [8, 7, 0]],
    "vel_max": [2, 0.5],
    "acce": [1, 2],
    "behavior": {"name": "dash"},
}
SIDEWAYS: dict[str, Any] = {
    "kinematics": {"name": "omni"},
    "shape": {"name": "rectangle", "length": 0.4, "width": 0.3},
    "state": [7, 2, 0],
    "goal": [3, 3],
    "vel_max": [1, 2],
}
WIRE = {"shape": {"name": "linestring", "vertices": [[0, 0], [1, 0], [1, 1]]}, "state": [6, 4, 0.2]}
WEDGE = {"shape": {"name": "polygon", "vertices": [[0, 0], [1, 0], [1, 2]]}, "state": [8, 8, 0.2]}
FILE = {
    "world": {"width": 10, "height": 10, "offset": [-1, 0]},
    "robot": [{**DIFF, "state": [1, 1, 0.3], "goal": [4, 5], "behavior": {"name": "dash"}}, CAR, SIDEWAYS],
    "obstacle": [WIRE, WEDGE, {"shape": {"name": "circle", "radius": 0.5}, "state": [5, 9, 0]}],
}


@pytest.fixture
def peers(tmp_path: Path) -> Iterator[tuple[Any, Any]]:
    """Give the world of the file in ir-sim and here, with columns."""
    file = tmp_path / "yard.yaml"
    file.write_text(yaml.safe_dump(FILE))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import irsim

        theirs = irsim.make(str(file), headless=True, log_level="CRITICAL")
    yield theirs, irsim_gym.load(file, columns=True)
    theirs.end()


def alike(ours: Any, other: Any) -> None:
    """Compare what is told in shape and numbers."""
    if other is None or isinstance(other, str | bool):
        assert ours == other
    else:
        assert np.shape(ours) == np.shape(other)
        assert np.asarray(ours, np.float64) == pytest.approx(np.asarray(other, np.float64), abs=1e-9)


def same_names(theirs: Any, ours: Any) -> None:
    """Compare everything that IR-SIM has as a column, and what planners ask for."""
    names = ["state", "position", "velocity_xy", "goal", "init_state", "centroid", "radius", "max_speed"]
    names += ["desired_omni_vel", "rvo_state", "rvo_neighbors", "rvo_line_segments", "state_dim", "state_shape"]
    names += ["abbr", "vertices", "trajectory", "radius_extend", "heading", "orientation"]
    moving = ["velocity", "vel_min", "vel_max", "vel_dim", "vel_shape"]
    for other in theirs.objects:
        body = ours[other.name]
        for name in [*names, *(moving if other.kinematics is not None else [])]:
            if not (other.role == "obstacle" and name in ("goal", "desired_omni_vel", "rvo_state", "velocity_xy")):
                alike(getattr(body, name), getattr(other, name))
        if other.role == "robot":
            for low, high in zip(body.get_vel_range(), other.get_vel_range(), strict=True):
                alike(low, high)
            for threshold, normalized in ((0.1, True), (20.0, False)):
                wanted = other.get_desired_omni_vel(threshold, normalized)
                alike(body.get_desired_omni_vel(threshold, normalized), wanted)
            info, told = body.get_info(), other.get_info()
            for name in ("vel_min", "vel_max", "acce", "angle_range"):  # its goal is that of the start for ever
                alike(getattr(info, name), getattr(told, name))
        for planes, wanted in ((body.get_Gh(), other.get_Gh()), (body.get_init_Gh(), other.get_init_Gh())):
            for one, two in zip(planes[:3], wanted[:3], strict=True):
                alike(one, two)
            assert planes[3] == bool(wanted[3])  # there None stands for what has no area
    for ours_told, told in zip(ours.get_obstacle_info_list(), theirs.get_obstacle_info_list(), strict=True):
        for name in ("center", "vertex", "G", "h"):
            alike(getattr(ours_told, name), getattr(told, name))
    alike(ours.get_robot_state(), theirs.get_robot_state())
    alike(ours.key_vel, np.zeros((3, 1)))


def test_columns_are_those_of_ir_sim(peers: tuple[Any, Any]) -> None:
    theirs, ours = peers
    same_names(theirs, ours)
    for _ in range(3):
        theirs.step()
        ours.step()
    same_names(theirs, ours)


ACTS: dict[str, Callable[[Any], None]] = {
    "an action": lambda world: world.step(np.array([[0.4], [0.2]])),
    "an action by number": lambda world: world.step(np.array([[0.4], [0.2]]), 2),
    "a list of actions": lambda world: world.step([np.array([[0.4], [0.2]]), np.array([[0.5], [0.1]])]),
    "keywords": lambda world: world.step(action_id=[0, 1], action=[np.array([[0.4], [0.2]]), [0.5, 0.1]]),
    "a state": lambda world: world.robot.set_state(np.array([[2.0], [3.0], [0.5]])),
    "a state in a list": lambda world: world.robot.set_state([[2.0], [3.0], [0.5]]),
    "a car's state": lambda world: world.robot_list[1].set_state(np.array([[2.0], [3.0], [0.5], [0.2]])),
    "a goal": lambda world: world.robot.set_goal(np.array([[2.0], [3.0], [0.5]])),
    "goals": lambda world: world.robot.set_goal([[2.0, 3.0, 0.5], [4.0, 4.0, 0.0]]),
    "a velocity": lambda world: world.robot.set_velocity(np.array([[0.4], [0.2]])),
}


@pytest.mark.parametrize("act", ACTS.values(), ids=ACTS)
def test_columns_are_taken_as_in_ir_sim(peers: tuple[Any, Any], act: Callable[[Any], None]) -> None:
    theirs, ours = peers
    for world in peers:
        act(world)
    same_names(theirs, ours)
    for world in peers:
        world.step()
    same_names(theirs, ours)


def test_the_distance_to_a_column() -> None:
    here = irsim_gym.load({"robot": {**DIFF, "state": [1, 1, 0]}}, columns=True)
    assert np.linalg.norm(here.robot.state[0:2] - np.array([[4.0], [5.0]])) == 5.0
    assert here.robot.state[:2, 0].tolist() == [1.0, 1.0]
    with pytest.raises(ValueError, match="read-only"):
        here.robot.state[0, 0] = 3.0


COLUMN = np.array([[4.0], [5.0]])
MIXES: dict[str, Callable[[Any], Any]] = {
    "minus": lambda state: state[0:2] - COLUMN,
    "from the right": lambda state: COLUMN - state[0:2],
    "of another length": lambda state: state - COLUMN,
    "a list": lambda state: np.add(state[:2], [[4.0], [5.0]]),
    "compared": lambda state: state[:2] == COLUMN,
    "a function": lambda state: np.arctan2(state[:2], COLUMN),
    "through a function": lambda state: np.allclose(state[:2], COLUMN),
    "a copy": lambda state: state.copy()[:2] * COLUMN,
}


@pytest.mark.parametrize("mix", MIXES.values(), ids=MIXES)
def test_a_flat_state_refuses_to_meet_a_column(mix: Callable[[Any], Any]) -> None:
    robot = irsim_gym.load(SCENARIO).robot
    with pytest.raises(ValueError, match=r"a column of shape \(2, 1\).*columns=True"):
        mix(robot.state)
    assert mix(np.asarray(robot.state)) is not None  # NumPy says nothing


@pytest.mark.parametrize(
    "read",
    [
        lambda world: world.robot.velocity,
        lambda world: world.robot.position,
        lambda world: world.robot.velocity_xy,
        lambda world: world.robot.goal,
        lambda world: world.robot.init_state,
        lambda world: world.robot.info.vel_max,
        lambda world: world.obstacles[0].obstacle_info.center,
        lambda world: world.get_robot_state(),
        lambda world: world.robot.get_desired_omni_vel(),
    ],
)
def test_all_flat_arrays_refuse(read: Callable[[Any], Any]) -> None:
    with pytest.raises(ValueError, match="columns=True"):
        read(irsim_gym.load(SCENARIO)) - COLUMN


def test_a_flat_state_says_how_it_is_indexed() -> None:
    state = irsim_gym.load(SCENARIO).robot.state
    for key in ((0, 0), (slice(2), 0)):
        with pytest.raises(IndexError, match=r"this array is flat.*columns=True"):
            state[key]
    with pytest.raises(IndexError, match=r"out of bounds for axis 0 with size 3$"):
        state[3]


def test_a_flat_state_is_a_numpy_array_in_all_else() -> None:
    robot = irsim_gym.load(SCENARIO).robot
    state = robot.state
    assert type(state[0]) is np.float64
    for computed in (state * 2, state + state, state - [1, 1, 0], np.cos(state), state @ np.eye(3), state > 0):
        assert type(computed) is np.ndarray
    assert type(np.asarray(state)) is type(np.array(state)) is type(pickle.loads(pickle.dumps(state))) is np.ndarray
    assert repr(state) == "array([1., 1., 0.])"
    assert (state.sum(), state.max(), state.mean()) == (2.0, 1.0, 2.0 / 3.0)
    assert np.linalg.norm(state[:2] - robot.goal[:2]) == pytest.approx(np.hypot(8, 8))
    assert (state.reshape(-1, 1) - np.ones((3, 1))).shape == (3, 1)
    assert np.outer(state, state).shape == np.add.outer(state, state).shape == (3, 3)
    assert (state * np.full((1, 1), 2.0)).shape == (1, 3)
    with pytest.raises(ValueError, match="read-only"):
        state += 1
    own = state.copy()
    own += 1
    assert own.tolist() == [2.0, 2.0, 1.0]


def test_corners_of_a_line_are_all_told() -> None:
    here = irsim_gym.load({"obstacle": {**WIRE, "state": [6, 4, 0]}})
    assert here[0].vertices.tolist() == [[6, 4], [7, 4], [7, 5]]
