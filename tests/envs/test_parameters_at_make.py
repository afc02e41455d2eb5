"""Parameters of a scenario wherever an environment is made; they travel with its spec and through pickle."""

from __future__ import annotations

import inspect
import pickle
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec

import irsim_gym
from irsim_gym import sb3
from irsim_gym.envs.gymnasium.single import WorldEnv
from irsim_gym.envs.gymnasium.vector import WorldVectorEnv
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.envs.sb3.vec_env import make_vec_env
from irsim_gym.envs.teams.batch import make_batch
from irsim_gym.envs.teams.parallel import parallel_env
from irsim_gym.errors import ScenarioError, UnknownNameError
from irsim_gym.live.world import World
from irsim_gym.scenario.reading.parameters import ARGUMENTS

FILE = """
parameters: {n_robots: {default: 2, min: 1, max: 9, meaning: Number of robots.}}
robot:
  number: $n_robots
  kinematics: {name: diff}
  behavior: {name: dash}
  distribution: {name: circle}
  sensors: [{name: lidar2d, number: 8}]
"""


@pytest.fixture
def file(tmp_path: Path) -> str:
    path = tmp_path / "swap.yaml"
    path.write_text(FILE, encoding="utf-8")
    return str(path)


def count(env: Any) -> int:
    return len(env.unwrapped.worlds.scenario.bodies)


def test_every_way_of_making_takes_them(file: str) -> None:
    assert count(irsim_gym.make(file)) == 2
    assert count(irsim_gym.make(file, n_robots=5)) == 5
    assert count(gymnasium.make("irsim_gym/World-v0", scenario=file, n_robots=5)) == 5
    assert count(irsim_gym.make_vec(file, 2, n_robots=5)) == 5
    assert count(gymnasium.make_vec("irsim_gym/World-v0", 2, scenario=file, n_robots=5)) == 5
    env = gymnasium.make_vec("irsim_gym/World-v0", 2, vectorization_mode="sync", scenario=file, n_robots=5)
    assert [count(one) for one in env.envs] == [5, 5]
    assert count(make_vec_env(file, 2, n_robots=5)) == 5
    assert len(irsim_gym.load(file, n_robots=5, display=False).robots) == 5
    assert len(Worlds(file, parameters={"n_robots": 5}).scenario.bodies) == 5
    assert sb3.make_multi_agent_vec_env(file, 2, n_robots=5).num_envs == 10
    assert len(parallel_env(file, n_robots=5).possible_agents) == 5
    assert len(make_batch(file, 2, n_robots=5).worlds.scenario.bodies) == 5


def test_spec_and_pickle_keep_them(file: str) -> None:
    env = irsim_gym.make(file, n_robots=3)
    again = gymnasium.make(EnvSpec.from_json(env.spec.to_json()))
    copied = pickle.loads(pickle.dumps(env.unwrapped))
    first = env.reset(seed=4)[0]
    for other in (again, copied):
        assert count(other) == 3
        np.testing.assert_array_equal(other.reset(seed=4)[0], first)


@pytest.mark.parametrize(
    "make",
    [
        irsim_gym.make,
        irsim_gym.make_vec,
        make_vec_env,
        irsim_gym.load,
        lambda file, **given: Worlds(file, parameters=given),
    ],
)
def test_what_nobody_knows_is_an_error_with_the_list(make: Any, file: str) -> None:
    with pytest.raises(UnknownNameError, match=r"swap\.yaml has no parameter 'n_robot' .*\n    n_robots = 2   a whole"):
        make(file, n_robot=3)
    with pytest.raises(ScenarioError, match=r"from 1 to 9, got 10; its parameters are\n    n_robots = 2   a whole"):
        make(file, n_robots=10)


def test_an_argument_of_another_function_is_told_with_its_owner(file: str) -> None:
    with pytest.raises(
        UnknownNameError, match=r"no parameter 'num_envs' \(the number of worlds is .*, 'n_envs' of sb3.make_vec_env"
    ):
        make_vec_env(file, num_envs=2)
    with pytest.raises(UnknownNameError, match=r"no parameter 'seed' \(an argument of load, reset and those of sb3\)"):
        irsim_gym.make(file, seed=2)


def test_a_loaded_scenario_has_its_parameters_already(file: str) -> None:
    scenario = irsim_gym.load_scenario(file, {"n_robots": 3})
    assert len(Worlds(scenario).scenario.bodies) == 3
    with pytest.raises(UnknownNameError, match="'n_robots': pass parameters to load_scenario"):
        Worlds(scenario, parameters={"n_robots": 4})


@pytest.mark.parametrize(
    "function",
    [
        *(WorldEnv, WorldVectorEnv, Worlds, World, parallel_env, make_batch, sb3.make_vec_env),
        *(sb3.make_multi_agent_vec_env, gymnasium.make, gymnasium.make_vec, irsim_gym.make_vec),
    ],
)
def test_no_parameter_can_hide_behind_an_argument(function: Any) -> None:
    named = [name for name, one in inspect.signature(function).parameters.items() if one.kind is not one.VAR_KEYWORD]
    assert set(named) <= ARGUMENTS
