"""What tuning may try: files of search spaces, what is drawn from them, and the files of trials."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
import yaml

from irsim_gym.errors import IrsimGymError, ScenarioError
from irsim_gym.training.hyperparameter_files import with_value
from irsim_gym.training.search_space import read_space, shipped_space, value_of
from irsim_gym.training.training_request import TrainingRequest
from irsim_gym.training.trial_settings import check_space, weighted_task, write_settings

SPACE = """\
hyperparameters:
  learning_rate: {low: 1.0e-4, high: 1.0e-2, log: true, schedule: linear}
  n_epochs: {low: 2, high: 6}
  gamma: [0.98, 0.995]
  policy_kwargs.net_arch: [[64, 64], {pi: [32], vf: [64]}]
  policy_kwargs.log_std_init: {low: -1.5, high: 0.0}
rewards:
  arrival: {low: 1, high: 2, log: true}
"""


class Greatest:
    """Draws the greatest value of everything."""

    def suggest_float(self, name: str, low: float, high: float, *, log: bool = False) -> float:
        return high - 1.23456789e-7

    def suggest_int(self, name: str, low: int, high: int, *, log: bool = False) -> int:
        return high

    def suggest_categorical(self, name: str, choices: Sequence[Any]) -> Any:
        return choices[-1]


def space_of(tmp_path: Path, text: str) -> Any:
    file = tmp_path / "space.yaml"
    file.write_text(text)
    return read_space(file)


def test_what_is_drawn_is_what_a_hyperparameter_file_holds(tmp_path: Path) -> None:
    drawn, factors = space_of(tmp_path, SPACE).draw(Greatest())
    assert drawn == {
        "learning_rate": "lin_0.01",
        "n_epochs": 6,
        "gamma": 0.995,
        "policy_kwargs.net_arch": {"pi": [32], "vf": [64]},
        "policy_kwargs.log_std_init": -1.235e-07,
    }
    assert factors == {"arrival": 2.0}
    assert isinstance(factors["arrival"], float)


def test_the_present_settings_are_the_first_trial(tmp_path: Path) -> None:
    present = {
        "learning_rate": "lin_3e-3",
        "n_epochs": 3,
        "gamma": 0.99,
        "policy_kwargs": {"net_arch": [64, 64]},
    }
    found, outside = space_of(tmp_path, SPACE).to_parameters(present)
    assert found == {"learning_rate": 0.003, "n_epochs": 3, "policy_kwargs.net_arch": "[64, 64]", "reward.arrival": 1.0}
    assert outside == ["gamma", "policy_kwargs.log_std_init"]
    _, outside = space_of(tmp_path, SPACE).to_parameters({**present, "learning_rate": 3e-3})
    assert "learning_rate" in outside  # constant, where the space has schedules


def test_values_of_mappings_in_mappings() -> None:
    data = {"a": {"b": 1, "c": 2}, "d": None}
    assert value_of(data, "a.c") == 2
    assert value_of(data, "a.x") is None
    assert value_of(data, "d.x") is None
    assert with_value(data, "a.b", 5) == {"a": {"b": 5, "c": 2}, "d": None}
    assert with_value(data, "d.e.f", 5)["d"] == {"e": {"f": 5}}
    assert data["a"] == {"b": 1, "c": 2}


def test_every_mistake_is_told_with_its_line(tmp_path: Path) -> None:
    text = """\
hyperparameters:
  gamma: {low: 0.99, high: 0.9}
  n_epochs: {low: 2}
  ent_coef: {low: 0, high: 0.1, log: true}
  gae_lambda: [0.9]
  clip_range: 0.2
  vf_coef: {lo: 0.1, high: 1.0}
rewards:
  time: {low: -1.0, high: 1.0}
  arrival: [1, 2]
reward: {}
"""
    with pytest.raises(ScenarioError) as refused:
        space_of(tmp_path, text)
    told = {(problem.line, problem.path): problem.message for problem in refused.value.problems}
    assert told[2, "hyperparameters.gamma.high"] == "must be greater than low, got 0.9"
    assert told[3, "hyperparameters.n_epochs.high"] == "is required"
    assert told[4, "hyperparameters.ent_coef.low"] == "must be > 0 with log: true"
    assert told[5, "hyperparameters.gae_lambda"].startswith("needs at least two choices")
    assert told[6, "hyperparameters.clip_range"].startswith("must be a mapping")
    assert "did you mean 'low'" in told[7, "hyperparameters.vf_coef.lo"]
    assert told[9, "rewards.time"] == "is a factor >= 0 of the weight, without a schedule"
    assert told[10, "rewards.arrival"].startswith("must be a mapping")
    assert "did you mean 'rewards'" in told[11, "reward"]
    with pytest.raises(ScenarioError, match="must be a mapping with hyperparameters and rewards"):
        space_of(tmp_path, "[1, 2]")


def test_what_the_algorithm_or_the_task_does_not_have_is_told_before_any_trial(tmp_path: Path) -> None:
    text = """\
hyperparameters:
  gama: [0.9, 0.99]
  gamma: {low: 0.9, high: 1.1}
rewards:
  arival: {low: 0.5, high: 2.0}
"""
    asked = TrainingRequest("empty_goal")
    with pytest.raises(ScenarioError) as refused:
        check_space(asked, asked.settings(), space_of(tmp_path, text))
    told = {problem.line: problem.message for problem in refused.value.problems}
    assert "did you mean 'gamma'" in told[2]
    assert "1.1" in told[3]
    assert "the task gives no weight for arival; its rewards are progress, arrival, collision" in told[5]


def test_the_type_of_a_hyperparameter_says_which_numbers_are_drawn(tmp_path: Path) -> None:
    """Not the way in which the file writes its limits."""
    text = """\
hyperparameters:
  gamma: {low: 0, high: 1}
  clip_range_vf: {low: 1, high: 2}
  normalize.clip_obs: {low: 5, high: 10}
  policy_kwargs.log_std_init: {low: -2, high: 0}
  n_epochs: {low: 2.0, high: 6.0}
  n_timesteps: {low: 1.0e+3, high: 1e4, log: true}
  policy_kwargs.n_critics: {low: 1.0, high: 3}
  policy_kwargs.optimizer_kwargs.one: {low: 0, high: 1}
  policy_kwargs.optimizer_kwargs.other: {low: 0, high: 1.0}
"""
    space = space_of(tmp_path, text)
    drawn, _ = space.draw(Greatest())
    kinds = {key.rpartition(".")[2]: type(value) for key, value in drawn.items()}
    assert [key for key, kind in kinds.items() if kind is float] == [
        *("gamma", "clip_range_vf", "clip_obs", "log_std_init", "other")
    ]
    assert [key for key, kind in kinds.items() if kind is int] == ["n_epochs", "n_timesteps", "n_critics", "one"]
    assert drawn["n_timesteps"] == 10_000
    present = {"gamma": 0.5, "policy_kwargs": {"optimizer_kwargs": {"one": 0.5, "other": 0.5}}, "n_epochs": 3}
    found, outside = space.to_parameters(present)
    assert found == {"gamma": 0.5, "policy_kwargs.optimizer_kwargs.other": 0.5, "n_epochs": 3}
    assert "policy_kwargs.optimizer_kwargs.one" in outside  # it would be rounded


def test_broken_limits_of_whole_numbers_are_told_with_their_line(tmp_path: Path) -> None:
    text = """\
hyperparameters:
  n_epochs:
    low: 2
    high: 6.5
  gamma: {low: 0.9, high: 0.99}
  batch_size: {low: 0.5, high: 2.5}
"""
    with pytest.raises(ScenarioError) as refused:
        space_of(tmp_path, text)
    assert refused.value.file == str(tmp_path / "space.yaml")
    assert [(one.line, one.path, one.message) for one in refused.value.problems] == [
        (4, "hyperparameters.n_epochs.high", "must be a whole number, got 6.5"),
        (6, "hyperparameters.batch_size.high", "must be a whole number, got 2.5"),
        (6, "hyperparameters.batch_size.low", "must be a whole number, got 0.5"),
    ]


@pytest.mark.parametrize("text", ["hyperparameters: {}", "rewards:", "hyperparameters: {}\nrewards: {}"])
def test_a_space_without_anything_to_draw_is_refused(text: str, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="is empty: give hyperparameters or rewards a range or choices"):
        space_of(tmp_path, text)


@pytest.mark.parametrize(
    ("choices", "got"),
    [
        ("[1, 2, 1.0]", "1 beside 1"),
        ("[true, 1]", "1 beside true"),
        ("[[64, 64], [32], [64, 64.0]]", "[64, 64] beside [64, 64]"),
        ("['[64]', [64]]", "[64] beside '[64]'"),
        ("[null, null]", "nothing beside nothing"),
    ],
)
def test_equal_choices_are_refused(choices: str, got: str, tmp_path: Path) -> None:
    """Optuna knows a choice by its value, so that the later of two would replace the earlier."""
    with pytest.raises(ScenarioError) as refused:
        space_of(tmp_path, f"hyperparameters:\n  gamma: [0.9, 0.99]\n  clone: {choices}")
    (problem,) = refused.value.problems
    assert (problem.line, problem.path[:21]) == (3, "hyperparameters.clone")
    assert problem.message == f"must differ from the other choices, got {got}"


def test_devices_and_policies_that_are_missing_are_told_with_their_line(tmp_path: Path) -> None:
    text = """\
hyperparameters:
  clone: [null, dash, nobody]
  gamma: [0.9, 0.99]
  device: [cpu, "cuda:77"]
"""
    asked = TrainingRequest("empty_goal")
    with pytest.raises(ScenarioError) as refused:
        check_space(asked, asked.settings(), space_of(tmp_path, text))
    told = {(one.line, one.path): one.message for one in refused.value.problems}
    assert sorted(told) == [(2, "hyperparameters.clone"), (4, "hyperparameters.device")]
    assert "nobody" in told[2, "hyperparameters.clone"]
    assert "device cuda:77" in told[4, "hyperparameters.device"]


@pytest.mark.parametrize(("key", "value"), [("clone", "nobody"), ("device", "cuda:77")])
def test_what_every_trial_would_miss_is_told_before_the_first(key: str, value: str, tmp_path: Path) -> None:
    file = tmp_path / "ppo.yaml"
    file.write_text(f"default: {{n_timesteps: 64, n_envs: 2, {key}: '{value}'}}")
    asked, space = TrainingRequest("empty_goal", hyperparameters=file), space_of(tmp_path, SPACE)
    with pytest.raises(IrsimGymError, match=value):
        check_space(asked, asked.settings(), space)


def test_the_shipped_space_fits_the_shipped_settings() -> None:
    space = read_space(shipped_space("ppo"))
    for scenario in ("cluttered_room", "circle_swap"):
        asked = TrainingRequest(scenario)
        settings = asked.settings()
        check_space(asked, settings, space)
        assert space.to_parameters(settings.hyperparameters.to_plain())[1] == []
    with pytest.raises(
        IrsimGymError, match=r"no search space for td3 is shipped \(only for ppo\): give one with --space"
    ):
        shipped_space("td3")


def test_every_corner_of_the_shipped_space_can_be_trained(tmp_path: Path) -> None:
    """A collision costs more than all running costs, also where it costs least and time most."""
    space = read_space(shipped_space("ppo"))
    factors = {"collision": space.rewards["collision"].low, "time": space.rewards["time"].high}
    for scenario in ("cluttered_room", "circle_swap"):
        asked = TrainingRequest(scenario)
        write_settings(tmp_path / scenario, asked, asked.settings(), {}, factors).settings()


def test_a_trial_is_told_by_its_files(tmp_path: Path) -> None:
    asked = TrainingRequest("circle_swap", steps=5000, parameters={"n_robots": 3}, curriculum="learnability")
    settings = asked.settings()
    drawn = {"gamma": 0.9, "policy_kwargs.log_std_init": -1.0}
    own = write_settings(tmp_path, asked, settings, drawn, {"collision": 0.95, "arrival": 1.5})
    found = own.settings()
    expected = settings.hyperparameters.to_plain()
    changed = {name for name, value in found.hyperparameters.to_plain().items() if value != expected[name]}
    assert changed == {"gamma", "policy_kwargs"}
    assert found.hyperparameters.arguments["gamma"] == 0.9
    inner = dict(expected["policy_kwargs"])
    assert found.hyperparameters.arguments["policy_kwargs"] == {**inner, "log_std_init": -1.0}
    assert (found.parameters, found.hyperparameters.n_timesteps) == (settings.parameters, 5000)
    before, after = (one.snapshot().values() for one in (settings, found))
    assert {place: value for place, value in after.items() if before[place] != value} == {
        ("task", "rewards", "collision", "weight"): 19.0,
        ("task", "rewards", "arrival", "weight"): 7.5,
    }
    assert before.keys() == after.keys()
    assert yaml.safe_load((tmp_path / "task.yaml").read_text()) == weighted_task(
        settings, {"collision": 0.95, "arrival": 1.5}
    )
