"""What libraries learn from an environment without stepping it: its spec as JSON, and which arguments it takes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import AutoresetMode

import irsim_gym
from irsim_gym.errors import UnknownKeywordError, UnknownNameError

ANY = "irsim_gym/World-v0"
FILE = """
parameters: {n_robots: {default: 2, min: 1, max: 9, meaning: Number of robots.}}
robot:
  - {number: $n_robots, kinematics: {name: diff}, distribution: {name: circle}}
task: {agents: [robot_0]}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "swap.yaml"
    path.write_text(FILE, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "make",
    [
        lambda file: gymnasium.make(ANY, scenario=file, task=file.with_name("task.yaml"), n_robots=np.int64(3)),
        lambda file: gymnasium.make_vec(
            ANY, 2, scenario=file, n_robots=3, task={"clip": [file]}, autoreset_mode=AutoresetMode.SAME_STEP
        ),
    ],
)
def test_a_spec_of_paths_and_arrays_is_json(
    make: Callable[[Path], Any], file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("irsim_gym.envs.gymnasium.worlds.load_task", _load_task)
    env = make(file)
    again = EnvSpec.from_json(env.spec.to_json())
    assert again.kwargs["scenario"] == str(file)
    assert again == env.spec


def _load_task(scenario: Any, task: Any, *rest: Any, **named: Any) -> Any:
    """The task of the file: what is looked at here is how another one would be written down."""
    from irsim_gym.tasks import load_task

    return load_task(scenario, None, *rest, **named)


def test_a_spec_makes_the_same_environment_again(file: Path) -> None:
    env = gymnasium.make(ANY, scenario=file, n_robots=3)
    again = gymnasium.make(EnvSpec.from_json(env.spec.to_json()))  # type: ignore[union-attr]
    np.testing.assert_array_equal(again.reset(seed=4)[0], env.reset(seed=4)[0])


def test_a_loaded_scenario_is_no_json(file: Path) -> None:
    loaded = irsim_gym.load_scenario(file, {"n_robots": 3})
    for env in (gymnasium.make(ANY, scenario=loaded), gymnasium.make_vec(ANY, 2, scenario=loaded)):
        with pytest.raises(TypeError, match=r"loaded scenario 'swap'.*scenario='.*swap\.yaml', n_robots=3$"):
            env.spec.to_json()
    assert gymnasium.make_vec(env.spec).unwrapped.worlds.scenario.parameters == {"n_robots": 3}  # type: ignore[attr-defined]
    of_data = irsim_gym.load_scenario({"robot": {"kinematics": {"name": "diff"}, "goal": [5, 5]}})
    env = gymnasium.make(ANY, scenario=of_data)
    with pytest.raises(TypeError, match=r"from the mapping that it was read from$"):
        env.spec.to_json()  # type: ignore[union-attr]


def probed(name: str, **kwargs: Any) -> Any:
    """Make an environment as TorchRL's ``GymEnv`` does: with ``frameskip``, and without it where Python refuses it."""
    kwargs = {**kwargs, "frameskip": 1, "disable_env_checker": True}
    while True:
        try:
            return gymnasium.make(name, **kwargs)
        except TypeError as error:
            if "unexpected keyword argument 'frameskip'" not in str(error):
                raise
            kwargs.pop("frameskip")


def test_an_environment_may_be_probed_for_its_arguments(file: Path) -> None:
    assert probed("irsim_gym/empty_goal-v0").reset(seed=0)[0].shape
    env = probed(ANY, scenario=str(file), n_robots=3)
    assert len(env.unwrapped.worlds.scenario.bodies) == 3
    assert probed(ANY, scenario=irsim_gym.load_scenario(file)).reset(seed=0)[0].shape


@pytest.mark.parametrize(
    "make",
    [
        irsim_gym.make,
        irsim_gym.make_vec,
        irsim_gym.parallel_env,
        irsim_gym.make_batch,
        irsim_gym.load,
        irsim_gym.sb3.make_vec_env,
        irsim_gym.sb3.make_multi_agent_vec_env,
        lambda file, **given: gymnasium.make(ANY, scenario=file, **given),
        lambda file, **given: gymnasium.make_vec(ANY, scenario=file, **given),
    ],
)
def test_an_unknown_keyword_is_told_in_pythons_words_and_with_the_list(make: Callable[..., Any], file: Path) -> None:
    said = r"got an unexpected keyword argument 'n_robot': .*swap\.yaml has no parameter 'n_robot' \(did you mean "
    with pytest.raises(UnknownKeywordError, match=said + r"'n_robots'\?\); it has\n    n_robots = 2   a whole") as told:
        make(str(file), n_robot=3)
    assert isinstance(told.value, TypeError)
    assert isinstance(told.value, UnknownNameError)


def test_what_is_given_as_a_mapping_is_no_keyword(file: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"^\S*swap\.yaml has no parameter 'n_robot'") as told:
        irsim_gym.evaluate(file, "dash", levels=1, parameters={"n_robot": 3})
    assert not isinstance(told.value, TypeError)
