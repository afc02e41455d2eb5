"""Trainings with RLlib and sweeps, as far as they need no Ray: settings, errors, tables."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from irsim_gym.errors import IrsimGymError, ScenarioError
from irsim_gym.training.engines import Engine, engine_of
from irsim_gym.training.folders import setting_differences
from irsim_gym.training.run import Settings
from irsim_gym.training.sweep_file import read_sweep
from irsim_gym.training.sweep_results import read_result, show_sweep, write_result, write_sweep
from irsim_gym.training.training_request import TrainingRequest


def test_an_engine_shares_out_the_worlds() -> None:
    assert Engine().chosen(256) == Engine(2, 128, 0)
    assert Engine(0).chosen(256) == Engine(0, 256, 0)
    assert Engine(3, 64, 1).chosen(256) == Engine(3, 64, 1)
    assert Engine(4).or_of(Engine(2, 64, 0)) == Engine(4, 64, 0)


def test_settings_keep_the_engine() -> None:
    settings = TrainingRequest("empty_goal", engine=Engine(2, 8)).settings()
    again = Settings.from_plain(settings.to_plain())
    assert again.engine == Engine(2, 8)
    other = TrainingRequest("empty_goal").settings()
    assert "engine" not in other.to_plain()
    assert any("engine.workers" in one for one in setting_differences(settings, other))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("rlib", None, None, None, None), "no engine named 'rlib' .did you mean 'rllib'"),
        ((None, 2, None, None, None), "--workers: only --engine rllib"),
        (("sb3", None, 8, None, "auto"), "--worlds-per-worker, --address: only --engine rllib"),
    ],
)
def test_options_of_the_other_engine(given: tuple[Any, ...], said: str) -> None:
    with pytest.raises(IrsimGymError, match=said):
        engine_of(*given)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"algorithm": "sac", "engine": Engine()}, "--engine rllib trains ppo and appo, not sac"),
        ({"algorithm": "appo"}, "appo is an algorithm of RLlib: add --engine rllib"),
        ({"curriculum": "learnability", "engine": Engine()}, "--engine rllib cannot pass on curriculum to ppo"),
        ({"device": "cuda", "engine": Engine()}, "--learner-gpus says where it learns"),
    ],
)
def test_what_rllib_does_not_take(asked: dict[str, Any], said: str) -> None:
    with pytest.raises(IrsimGymError, match=said):
        TrainingRequest("empty_goal", **asked).settings()


def test_mirrored_rows_are_not_passed_on(tmp_path: Path) -> None:
    file = tmp_path / "ppo.yaml"
    file.write_text("default: {n_timesteps: 100, n_envs: 2, mirror: true}", encoding="utf-8")
    with pytest.raises(IrsimGymError, match="cannot pass on mirror to ppo"):
        TrainingRequest("empty_goal", hyperparameters=file, engine=Engine()).settings()


def test_a_schedule_that_rllib_does_not_know(tmp_path: Path) -> None:
    file = tmp_path / "ppo.yaml"
    file.write_text("default: {n_timesteps: 100, n_envs: 2, clip_range: lin_0.2}", encoding="utf-8")
    with pytest.raises(IrsimGymError, match="clip_range must be a number"):
        TrainingRequest("empty_goal", hyperparameters=file, engine=Engine()).settings()


SWEEP = """\
scenario: [empty_goal, circle_swap]
algorithm: ppo
team: episode
seeds: 2
hyperparameters:
  learning_rate: [1e-3, lin_3e-3]
  gamma: 0.9
rewards: {arrival: [0.5, 1.0, 2.0]}
"""


def sweep(folder: Path, text: str) -> Any:
    file = folder / "sweep.yaml"
    file.write_text(text, encoding="utf-8")
    return read_sweep(file)


def test_a_sweep_is_every_combination(tmp_path: Path) -> None:
    found = sweep(tmp_path, SWEEP)
    trials = found.trials()
    assert len(trials) == len({(str(trial.condition), trial.seed) for trial in trials}) == 2 * 2 * 2 * 3
    assert trials[0].condition == {
        "scenario": "empty_goal", "learning_rate": "1e-3", "gamma": 0.9, "reward.arrival": 0.5,
    }  # fmt: skip
    assert [trial.seed for trial in trials[:4]] == [0, 1, 0, 1]
    assert found.asked(trials[1]).seed == 1


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("sedes: 2", "sweep.yaml:2   sedes: unknown key (did you mean 'seeds'?)"),
        ("seeds: [1, 1]", "sweep.yaml:2   seeds: must be a list of different seeds >= 0, or how many, got [1, 1]"),
        ("steps: 0", "sweep.yaml:2   steps: must be a whole number >= 1, got 0"),
        ("hyperparameters: {gama: 0.9}", "sweep.yaml:2   hyperparameters.gama: unknown key (did you mean 'gamma'?)"),
        ("rewards: {arrival: -1}", "sweep.yaml:2   rewards.arrival: is a factor >= 0 of the weight"),
        ("rewards: {elegance: 1}", "sweep.yaml:2   rewards.elegance: the task gives no weight for elegance"),
        ("parameters: {n_robots: [4, 8]}", "sweep.yaml:2   parameters.n_robots: "),
        ("hyperparameters: {gamma: []}", "sweep.yaml:2   hyperparameters.gamma: needs at least one value"),
    ],
)
def test_mistakes_are_named_with_line_and_key(line: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError) as error:
        sweep(tmp_path, f"scenario: empty_goal\n{line}\n")
    assert said in str(error.value).replace(f"{tmp_path}/", "")


def test_the_table_has_a_row_for_each_condition(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    trials = sweep(tmp_path, "scenario: empty_goal\nseeds: 3\nhyperparameters: {gamma: [0.9, 0.99]}\n").trials()
    results = [{"success": share, "steps": 10, "training_seconds": 1.5} for share in (0.1, 0.5, 0.3, 0.9, 0.7, 1.0)]
    for number, result in enumerate(results):
        write_result(tmp_path / str(number), result)
        assert read_result(tmp_path / str(number)) == result
    assert read_result(tmp_path / "none") is None
    write_sweep(tmp_path, trials, results)
    rows = (tmp_path / "sweep.csv").read_text(encoding="utf-8").splitlines()
    assert rows[0] == "training,seed,scenario,gamma,success,steps,training_seconds"
    assert rows[1] == "0,0,empty_goal,0.9,0.1,10,1.5"
    show_sweep(trials, results, "mine")
    lines = [line for line in capsys.readouterr().out.splitlines() if "0.9" in line]
    assert "0.99" in lines[0]
    assert [f"{share:.1f}" in lines[0] for share in (90.0, 70.0, 100.0)] == [True] * 3
    assert [f"{share:.1f}" in lines[1] for share in (30.0, 10.0, 50.0)] == [True] * 3
