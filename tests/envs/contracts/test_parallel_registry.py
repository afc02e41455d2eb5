"""Ids in PettingZoo's registry, whoever is imported first."""

from __future__ import annotations

import pickle
import subprocess
import sys
from types import SimpleNamespace

import gymnasium
import pettingzoo
import pytest
from team_scenes import TEAMS

import irsim_gym
from irsim_gym.envs.gymnasium.registration import register
from irsim_gym.envs.teams.parallel import WorldParallelEnv

WORLD = """
world: {width: 6, height: 6, step_time: 0.1}
robot:
  - {kinematics: {name: diff}, shape: {name: circle, radius: 0.2}, state: [1, 1, 0], goal: [5, 5, 0]}
  - {kinematics: {name: diff}, shape: {name: circle, radius: 0.2}, state: [1, 3, 0], goal: [5, 3, 0]}
"""
SEEN = """
ids = [one for one in pettingzoo.parallel_registry if one.startswith("irsim_gym/")]
print(len(ids), pettingzoo.spec("parallel", "irsim_gym/orca_circle-v0").entry_point)
"""


@pytest.fixture
def registries():
    """Both registries are left as they were."""
    before = dict(gymnasium.registry), dict(pettingzoo.parallel_registry)
    yield
    for registry, content in zip((gymnasium.registry, pettingzoo.parallel_registry), before, strict=True):
        registry.clear()
        registry.update(content)


@pytest.mark.parametrize("order", ["irsim_gym, pettingzoo", "pettingzoo, irsim_gym"])
def test_either_may_come_first(order):
    """The ids are Gymnasium's, and nothing of PettingZoo's is loaded before somebody asks for it."""
    script = f"import {order}\n{SEEN}"
    done = subprocess.run([sys.executable, "-W", "error", "-c", script], capture_output=True, text=True, check=False)
    count = sum(one.startswith("irsim_gym/") for one in gymnasium.registry)
    assert done.stdout.split() == [str(count), "irsim_gym:parallel_env"], done.stderr


def test_an_id_of_each_team():
    for name in TEAMS:
        for one in (f"irsim_gym/{name}-v0", f"irsim_gym/{name}_v0"):
            spec = pettingzoo.spec("parallel", one)
            assert (spec.kwargs, spec.max_cycles) == ({"scenario": name}, None)


def test_making():
    env = pettingzoo.make("parallel", "irsim_gym/multi_robot_rvo-v0", max_cycles=7, render_mode="rgb_array")
    assert isinstance(env, WorldParallelEnv)
    assert (env.max_cycles, env.render_mode, len(env.possible_agents)) == (7, "rgb_array", 10)
    assert env.reset(seed=0)[0].keys() == set(env.possible_agents)
    again = pettingzoo.spec("parallel", "irsim_gym/multi_robot_rvo-v0").make(padded=True)
    assert isinstance(pickle.loads(pickle.dumps(again)), WorldParallelEnv)


@pytest.mark.usefixtures("registries")
def test_a_folder_of_ones_own(tmp_path):
    """A folder that is registered when PettingZoo is there already; twice is once, and another folder's counts."""
    (tmp_path / "mine.yaml").write_text(WORLD)
    assert irsim_gym.register_scenarios(tmp_path, namespace="lab") == ("lab/mine-v0",)
    irsim_gym.register_scenarios(tmp_path, namespace="lab")
    made = pettingzoo.make("parallel", "lab/mine-v0"), irsim_gym.parallel_env("lab/mine-v0")
    assert [env.possible_agents for env in made] == [["robot_0", "robot_1"]] * 2
    anything = pettingzoo.make("parallel", "irsim_gym/World-v0", scenario=str(tmp_path / "mine.yaml"))
    assert len(anything.possible_agents) == 2
    del gymnasium.registry["lab/mine-v0"]
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "mine.yaml").write_text(WORLD)
    irsim_gym.register_scenarios(tmp_path / "sub", namespace="lab")
    assert pettingzoo.spec("parallel", "lab/mine-v0").kwargs == {"scenario": str(tmp_path / "sub" / "mine.yaml")}


@pytest.mark.usefixtures("registries")
def test_an_older_pettingzoo_has_no_registry(monkeypatch):
    """Before 1.27: environments are made by ``irsim_gym.parallel_env`` alone."""
    monkeypatch.setitem(sys.modules, "pettingzoo", SimpleNamespace())
    for one in [one for one in gymnasium.registry if one.startswith("irsim_gym/")]:
        del gymnasium.registry[one]
    register()
    assert "irsim_gym/orca_circle-v0" in gymnasium.registry
