"""Ids of shipped and of a user's scenarios."""

from __future__ import annotations

import pickle

import gymnasium
import pytest

import irsim_gym
from irsim_gym.envs.gymnasium.registration import env_id, register
from irsim_gym.errors import IrsimGymError, UnknownNameError

WORLD = """
world: {width: 6, height: 6, step_time: 0.1}
robot:
  - {kinematics: {name: diff}, shape: {name: circle, radius: 0.2}, state: [1, 1, 0], goal: [5, 5, 0]}
"""


@pytest.fixture
def folder(tmp_path):
    before = dict(gymnasium.registry)
    for name in ("one.yaml", "two.yml", "a b+c.yaml"):
        (tmp_path / name).write_text(WORLD)
    (tmp_path / "note.txt").write_text("no scenario")
    (tmp_path / "sub").mkdir()
    yield tmp_path
    gymnasium.registry.clear()
    gymnasium.registry.update(before)


def test_registering_twice_is_silent():
    before = dict(gymnasium.registry)
    register()
    assert dict(gymnasium.registry) == before
    assert pickle.loads(pickle.dumps(irsim_gym.register)) is register  # workers can be told to call it


def test_a_folder(folder):
    ids = irsim_gym.register_scenarios(folder, namespace="mine")
    assert ids == ("mine/a_b_c-v0", "mine/one-v0", "mine/two-v0")
    assert irsim_gym.register_scenarios(folder, namespace="mine") == ids
    for one in ids:
        gymnasium.make(one).reset(seed=0)
    assert gymnasium.make_vec("mine/one-v0", num_envs=2).reset(seed=0)[0].shape[0] == 2


def test_two_files_with_one_id(folder):
    (folder / "one.yml").write_text(WORLD)
    with pytest.raises(IrsimGymError, match=r"mine/one-v0.*taken"):
        irsim_gym.register_scenarios(folder, namespace="mine")


@pytest.mark.parametrize("make", [irsim_gym.make, irsim_gym.make_vec, irsim_gym.parallel_env, irsim_gym.make_batch])
def test_an_id_that_is_none_is_no_file(make):
    with pytest.raises(
        UnknownNameError, match=r"no environment 'irsim_gym/corridr-v0' \(did you mean 'irsim_gym/corri"
    ):
        make("irsim_gym/corridr-v0")
    with pytest.raises(UnknownNameError, match=r"no environment 'irsim_gym:irsim_gym/qqqqqqq'; `irsim-gym list` shows"):
        make("irsim_gym:irsim_gym/qqqqqqq")


def test_a_file_that_is_missing_is_told_with_its_neighbor(folder):
    (folder / "my_world.yaml").write_text("robot: {}\n")
    with pytest.raises(FileNotFoundError, match=r"no such file \(did you mean 'my_world.yaml'\?\)"):
        irsim_gym.make(folder / "myworld.yaml")
    with pytest.raises(FileNotFoundError, match=r"no such file: there is no folder .*nowhere"):
        irsim_gym.make(folder / "nowhere" / "my_world.yaml")


def test_no_folder(tmp_path):
    with pytest.raises(NotADirectoryError):
        irsim_gym.register_scenarios(tmp_path / "none")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("corridor", "irsim_gym/corridor-v0"),
        ("corridor_4", "irsim_gym/corridor_4-v0"),
        ("hall-v3", "irsim_gym/hall-v3-v0"),
        ("a.b:c d+e/f", "irsim_gym/a_b_c_d_e_f-v0"),
        ("größe", "irsim_gym/gr__e-v0"),
    ],
)
def test_ids_follow_the_grammar(name, expected):
    assert env_id(name) == expected
    namespace, _, version = gymnasium.envs.registration.parse_env_id(expected)
    assert (namespace, version) == ("irsim_gym", 0)


def test_making_by_name_by_id_and_by_module():
    for source in ("sparse_circles", "irsim_gym/sparse_circles-v0", "irsim_gym:irsim_gym/sparse_circles-v0"):
        env = irsim_gym.make(source)
        assert env.spec.id == "irsim_gym/sparse_circles-v0"
    envs = irsim_gym.make_vec("sparse_circles", 3, autoreset_mode="SameStep")
    assert envs.num_envs == 3
