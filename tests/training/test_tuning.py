"""Tuning: files of search spaces, trials as runs, studies that go on as if they had never stopped, and results."""

from __future__ import annotations

import csv
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml
from command_line import run as command

from irsim_gym.errors import IrsimGymError, ScenarioError
from irsim_gym.evaluation.requests.interruption import TrainingInterruptedError
from irsim_gym.evaluation.saved_policies.checkpoint_files import list_checkpoints
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy, load_policy
from irsim_gym.training.curves.score import score_run
from irsim_gym.training.requests.train import train
from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.searches import tuning
from irsim_gym.training.searches.search_space import Axis, read_space, shipped_space
from irsim_gym.training.searches.trial_settings import check_space, trial_settings, weighted_task
from irsim_gym.training.searches.tuning import run_tuning
from irsim_gym.training.searches.tuning_results import best_of, show_trials
from irsim_gym.training.settings.run import Run

TINY = "n_timesteps: 256, n_envs: 4, n_steps: 16, batch_size: 32, n_epochs: 1, checkpoint_every: 64, gamma: 0.95"
FILE = """\
robot:
  kinematics: {name: diff}
  goal: [9, 9]
  sensors: [{name: lidar2d, range_max: 4}]
task: {max_steps: 20}
"""
SHORT_SPACE = """\
hyperparameters: {gamma: {low: 0.9, high: 0.99}, ent_coef: [0.0, 0.01]}
rewards: {arrival: {low: 0.5, high: 2.0}}
"""
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
WORDS = ("tune", "yard.yaml", "--hyperparameters", "ppo.yaml", "--space", "space.yaml", "--dev-levels", 3)
GRID = """\
hyperparameters: {n_envs: 4, n_steps: 32, batch_size: 64, n_epochs: 1, checkpoint_every: 4096, gamma: [0.9, 0.99]}
seeds: [3, 1]
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A new working directory with a scenario, hyper-parameters and a space for short studies."""
    monkeypatch.chdir(tmp_path)
    Path("yard.yaml").write_text(FILE)
    Path("ppo.yaml").write_text(f"default: {{{TINY}}}")
    Path("space.yaml").write_text(SHORT_SPACE)
    return tmp_path


def asked(**own: Any) -> TrainingRequest:
    return TrainingRequest("yard.yaml", hyperparameters=Path("ppo.yaml"), **own)


def study(out: str, trials: int | None = None, **own: Any) -> Path:
    pytest.importorskip("optuna")
    return run_tuning(asked(), trials, space=Path("space.yaml"), out=Path(out), dev_levels=3, **own)


def rows(out: str) -> list[dict[str, str]]:
    return list(csv.DictReader(Path(out, "trials.csv").read_text().splitlines()))


def weights(place: Path) -> list[Any]:
    policy = load_policy(place)
    assert isinstance(policy, SavedPolicy)
    return [one.tolist() for one in policy.model.policy.state_dict().values()]  # type: ignore[union-attr]


class Greatest:
    """Draws the greatest value of everything."""

    def suggest_float(self, name: str, low: float, high: float, *, log: bool = False) -> float:
        return high - 1.23456789e-7

    def suggest_int(self, name: str, low: int, high: int, *, log: bool = False) -> int:
        return high

    def suggest_categorical(self, name: str, choices: Sequence[Any]) -> Any:
        return choices[-1]


def space_of(text: str, **how: Any) -> Any:
    Path("space.yaml").write_text(text)
    return read_space(Path("space.yaml"), **how)


def messages(text: str, request: TrainingRequest | None = None, **how: Any) -> dict[tuple[int, str], str]:
    """Return what is said about a file, by line and key."""

    def check() -> None:
        check_space(request or asked(), space_of(text, **how))

    with pytest.raises(ScenarioError) as refused:
        check()
    assert refused.value.file == "space.yaml"
    return {(problem.line, problem.path): problem.message for problem in refused.value.problems}


def test_what_is_drawn_is_what_a_hyperparameter_file_holds() -> None:
    drawn = space_of(SPACE + "parameters: {n_robots: 3}\nseeds: 2\n", scenarios=["a", "b"]).draw(Greatest())
    assert drawn == {
        ("scenario",): "b",
        ("hyperparameters", "learning_rate"): "lin_0.01",
        ("hyperparameters", "n_epochs"): 6,
        ("hyperparameters", "gamma"): 0.995,
        ("hyperparameters", "policy_kwargs.net_arch"): {"pi": [32], "vf": [64]},
        ("hyperparameters", "policy_kwargs.log_std_init"): -1.235e-07,
        ("rewards", "arrival"): 2.0,
        ("parameters", "n_robots"): 3,
        ("seeds",): 1,
    }
    assert isinstance(drawn["rewards", "arrival"], float)


def test_a_grid_is_every_combination() -> None:
    text = (
        "seeds: 2\nrewards: {arrival: [0.5, 1.0, 2.0]}\nhyperparameters: {learning_rate: [1e-3, lin_3e-3], gamma: 0.9}"
    )
    points = space_of(text, grid=True, scenarios=["empty_goal", "circle_swap"]).grid()
    assert len(points) == len({str(point) for point in points}) == 2 * 2 * 2 * 3
    same = {"scenario": "empty_goal", "learning_rate": "1e-3", "gamma": 0.9, "reward.arrival": 0.5}
    assert points[:2] == [{**same, "seed": 0}, {**same, "seed": 1}]


def test_every_mistake_is_told_with_its_line() -> None:
    text = """\
hyperparameters:
  gamma: {low: 0.99, high: 0.9}
  n_epochs: {low: 2}
  ent_coef: {low: 0, high: 0.1, log: true}
  gae_lambda: []
  n_steps:
    low: 2
    high: 1
  vf_coef: {lo: 0.1, high: 1.0}
rewards:
  time: {low: -1.0, high: 1.0}
  arrival: [1, true]
  collision: {low: 1, high: 2, schedule: linear}
parameters: [3]
seeds: [1, -1]
reward: {}
"""
    told = messages(text)
    assert told[2, "hyperparameters.gamma.high"] == "must be greater than low, got 0.9"
    assert told[3, "hyperparameters.n_epochs.high"] == "is required"
    assert told[4, "hyperparameters.ent_coef.low"] == "must be > 0 with log: true"
    assert told[5, "hyperparameters.gae_lambda"] == "needs at least one value"
    assert "did you mean 'low'" in told[9, "hyperparameters.vf_coef.lo"]
    assert told[11, "rewards.time"] == "is a factor >= 0 of the weight, without a schedule, got -1"
    assert "without a schedule, got true" in told[12, "rewards.arrival"]
    assert "without a schedule, got 'lin_" in told[13, "rewards.collision"]
    assert told[14, "parameters"].startswith("must be a mapping")
    assert told[15, "seeds"] == "must be a list of seeds >= 0, or how many, got -1"
    assert "did you mean 'rewards'" in told[16, "reward"]
    assert "must be a mapping with hyperparameters, rewards" in next(iter(messages("[1, 2]").values()))
    for nothing in ("hyperparameters: {}", "rewards:", "seeds: 0"):
        (problem,) = messages(nothing).values()
        assert problem.startswith(("is empty: give hyperparameters", "needs at least one value"))
    told = messages("hyperparameters: {gamma: {low: 0.1, high: 0.9}}\nseeds: 10001", grid=True)
    assert told[1, "hyperparameters.gamma"] == "is a range: --grid needs a value or a list of values"
    assert "makes 20,002 trials; 10,000 at most" in told.values()


def test_what_the_algorithm_or_the_task_or_the_scenario_does_not_have_is_told_before_any_trial() -> None:
    text = """\
hyperparameters:
  gama: [0.9, 0.99]
  gamma: {low: 0.9, high: 1.1}
  n_epochs: {low: 2, high: 6.5}
  clone: [null, dash, nobody]
  device: [cpu, "cuda:77"]
rewards: {arival: {low: 0.5, high: 2.0}}
parameters: {n_robots: [4, 8]}
"""
    told = {line: message for (line, _), message in messages(text, TrainingRequest("empty_goal")).items()}
    assert "did you mean 'gamma'" in told[2]
    assert "1.1" in told[3]
    assert told[4].startswith("must be a whole number, got 6.5")
    assert "nobody" in told[5]
    assert "device cuda:77" in told[6]
    assert "the task gives no weight for arival; its rewards are progress, arrival, collision" in told[7]
    assert "n_robots" in told[8]


def test_the_type_of_a_hyperparameter_says_which_numbers_are_drawn() -> None:
    """Not the way in which the file writes its limits."""
    text = """\
hyperparameters:
  gamma: {low: 0, high: 1}
  clip_range_vf: {low: 1, high: 2}
  normalize.clip_obs: {low: 5, high: 10}
  policy_kwargs.log_std_init: {low: -2, high: 0}
  n_epochs: {low: 2, high: 6}
  policy_kwargs.optimizer_kwargs.one: {low: 0, high: 1}
  policy_kwargs.optimizer_kwargs.other: {low: 0, high: 1.0}
parameters: {n: {low: 1, high: 2}}
"""
    space = space_of(text)
    drawn = space.draw(Greatest())
    kinds = {axis[-1].rpartition(".")[2]: type(value) for axis, value in drawn.items()}
    assert [key for key, kind in kinds.items() if kind is float] == [
        *("gamma", "clip_range_vf", "clip_obs", "log_std_init", "other")
    ]
    assert [key for key, kind in kinds.items() if kind is int] == ["n_epochs", "one", "n"]


@pytest.mark.parametrize(
    ("values", "got"),
    [("[1, 2, 1.0]", "1"), ("[true, 1]", "1"), ("['[64]', [64]]", "[64]"), ("[null, null]", "nothing")],
)
def test_equal_values_are_refused(values: str, got: str) -> None:
    """Optuna knows a choice by its value, so that the later of two would replace the earlier."""
    (((line, path), message),) = messages(f"hyperparameters:\n  gamma: [0.9, 0.99]\n  clone: {values}").items()
    assert (line, path[:21]) == (3, "hyperparameters.clone")
    assert message == f"must differ from the other values, got {got} again"


@pytest.mark.parametrize(("key", "value"), [("clone", "nobody"), ("device", "cuda:77"), ("until", "90")])
def test_what_every_trial_would_miss_is_told_before_the_first(key: str, value: str) -> None:
    Path("ppo.yaml").write_text(f"default: {{n_timesteps: 64, n_envs: 2, {key}: {value!r}}}".replace("'90'", "90"))
    with pytest.raises(IrsimGymError, match="'until' ends a single training" if key == "until" else value):
        check_space(asked(), space_of("hyperparameters: {gamma: [0.9, 0.99]}"))


def test_the_shipped_space_fits_the_shipped_settings_and_each_of_its_corners_can_be_trained(tmp_path: Path) -> None:
    """A collision costs more than all running costs, also where it costs least and time most."""
    space = read_space(shipped_space("ppo"))
    factors: dict[Axis, Any] = {("rewards", "collision"): space.axes["rewards", "collision"].ends()[0]}
    factors["rewards", "time"] = space.axes["rewards", "time"].ends()[1]
    for scenario in ("cluttered_room", "circle_swap"):
        request = TrainingRequest(scenario)
        check_space(request, space)
        trial_settings(request, factors, tmp_path / scenario)
    shipped = r"no search space for td3 is shipped \(only for ppo\): give one with --space"
    with pytest.raises(IrsimGymError, match=shipped):
        shipped_space("td3")


def test_a_trial_changes_what_is_drawn_and_nothing_else(tmp_path: Path) -> None:
    request = TrainingRequest("circle_swap", steps=5000, parameters={"n_robots": 3})
    settings = request.settings()
    hyperparameters = {"gamma": 0.9, "policy_kwargs.log_std_init": -1.0, "learning_rate": "lin_0.01"}
    drawn: dict[Axis, Any] = {("hyperparameters", key): value for key, value in hyperparameters.items()}
    drawn |= {("rewards", "collision"): 0.95, ("rewards", "arrival"): 1.5}
    made = trial_settings(request, drawn, tmp_path)
    expected = settings.hyperparameters.to_plain()
    inner = {**expected["policy_kwargs"], "log_std_init": -1.0}
    assert made.hyperparameters.to_plain() == {
        **expected, "gamma": 0.9, "learning_rate": "lin_0.01", "policy_kwargs": inner,
    }  # fmt: skip
    assert (made.parameters, made.hyperparameters.n_timesteps) == (settings.parameters, 5000)
    before, after = (one.snapshot().values() for one in (settings, made))
    assert {place: value for place, value in after.items() if before[place] != value} == {
        ("task", "rewards", "collision", "weight"): 19.0,
        ("task", "rewards", "arrival", "weight"): 7.5,
    }
    assert before.keys() == after.keys()
    task = weighted_task(settings, {"collision": 0.95, "arrival": 1.5})
    assert yaml.safe_load((tmp_path / "task.yaml").read_text()) == task
    other: dict[Axis, Any] = {("scenario",): "empty_goal", ("seeds",): 7}
    made = trial_settings(TrainingRequest("circle_swap"), other, tmp_path)
    assert (made.scenario, made.seed) == ("empty_goal", 7)
    assert trial_settings(request, {("parameters", "n_robots"): 4}, tmp_path).parameters["n_robots"] == 4


def test_without_optuna_the_command_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "optuna", None)
    assert command(monkeypatch, *WORDS) == 1
    assert capsys.readouterr().err == (
        "irsim-gym tune needs the extra 'tune' (optuna not found): pip install \"irsim_gym[tune]\"\n"
    )
    assert not Path("runs").exists()


def test_what_looks_at_checkpoints_changes_nothing(folder: Path) -> None:
    settings, seen = asked().settings(), []

    def score(run: Run) -> None:
        seen.append(len(score_run(run, levels=3, picture=False)))

    watched = train(settings, folder / "watched", on_checkpoint=score)
    assert seen == [1, 2, 3]  # of four, the last is that of the end
    assert weights(watched.folder) == weights(train(settings, folder / "alone").folder)


def test_a_study_on_disk(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("optuna")
    Path("my_kinds.py").write_text("")
    monkeypatch.setattr(sys, "path", [*sys.path])
    assert command(monkeypatch, *WORDS, "--out", "study", "--trials", 2, "--import", "my_kinds.py") == 0
    said = capsys.readouterr()
    assert "yard.yaml: 2 trials, 0 of them pruned" in said.out
    first, second = rows("study")
    assert (first["trial"], first["ending"]) == ("0", "finished")
    assert 0.9 <= float(second["gamma"]) <= 0.99
    last = json.loads(Path("study/trials/0001/curve.json").read_text())["points"][-1]
    assert float(second["success"]) == pytest.approx(last["success"], abs=1e-6)
    own = [Run(Path("study/trials", name)).settings().hyperparameters.to_plain() for name in ("0000", "0001")]
    assert own[1]["gamma"] == float(f"{float(second['gamma']):.4g}")
    won = max((0, 1), key=lambda number: float(rows("study")[number]["success"]))
    assert yaml.safe_load(Path("study/best_hyperparameters.yaml").read_text())["default"] == own[won]
    assert Path("study/best_task.yaml").read_text() == Path(f"study/trials/000{won}/task.yaml").read_text()
    assert not list(Path("study").rglob("state.pkl"))

    assert command(monkeypatch, *WORDS, "--out", "study", "--trials", 2) == 0
    again = capsys.readouterr()
    assert again.out == said.out
    assert "2 trials, 0 of them to do" in again.err
    assert command(monkeypatch, *WORDS, "--out", "study", "--trials", 3) == 0
    assert rows("study")[:2] == [first, second]
    assert len(rows("study")) == 3
    capsys.readouterr()
    assert command(monkeypatch, *WORDS, "--out", "study", "--seed", 1) == 1
    assert re.search(r"study with other\s+settings \(seed 0", capsys.readouterr().err)
    assert command(monkeypatch, *WORDS, "--out", "study", "--trials", 1, "--overwrite", "--seed", 1) == 0
    assert len(rows("study")) == 1
    Path("other").mkdir()
    Path("other/file").write_text("mine")
    capsys.readouterr()
    assert command(monkeypatch, *WORDS, "--out", "other", "--overwrite") == 1
    assert "other holds something other than a study" in capsys.readouterr().err


def test_an_interrupted_study_ends_as_an_uninterrupted_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C comes in the midst of the second trial, after its second checkpoint."""
    study("whole", 3)
    real, calls = tuning.score_run, []

    def interrupted(run: Run, **options: Any) -> Any:
        calls.append(run.folder.name)
        if calls.count("0001") == 2:
            signal.raise_signal(signal.SIGINT)
        return real(run, **options)

    monkeypatch.setattr(tuning, "score_run", interrupted)
    with pytest.raises(TrainingInterruptedError, match="To continue, run the same command"):
        study("stopped", 3)
    monkeypatch.setattr(tuning, "score_run", real)
    assert len(rows("stopped")) == 1
    study("stopped", 3)
    assert rows("stopped") == rows("whole")
    for number in range(3):
        places = (Path(out, "trials", f"{number:04d}") for out in ("whole", "stopped"))
        first, second = (weights(place) for place in places)
        assert first == second


def test_trials_below_the_median_are_pruned(monkeypatch: pytest.MonkeyPatch) -> None:
    real = tuning.score_run
    monkeypatch.setattr(tuning, "FINISHED_FIRST", 2)
    monkeypatch.setattr(tuning, "FIRST_PRUNED", 2)

    def scored(run: Run, **options: Any) -> Any:
        success = {"0000": 0.5, "0001": 0.7, "0002": 0.4}[run.folder.name]
        return [{**point, "success": success} for point in real(run, **options)]

    monkeypatch.setattr(tuning, "score_run", scored)
    study("study", 3)
    assert [(row["success"], row["ending"]) for row in rows("study")] == [
        *(("0.5", "finished"), ("0.7", "finished"), ("0.4", "pruned at 2"))
    ]
    assert not Path("study/trials/0002/policy.zip").exists()
    assert Path("study/best_task.yaml").read_text() == Path("study/trials/0001/task.yaml").read_text()


def test_settings_that_cannot_be_trained_are_refused_and_count(capsys: pytest.CaptureFixture[str]) -> None:
    Path("space.yaml").write_text("rewards: {collision: {low: 0.1, high: 0.2}}")
    study("study", 2)
    assert [row["ending"].partition(":")[0] for row in rows("study")] == ["refused", "refused"]
    assert "one that continues can cost 3" in rows("study")[1]["ending"]
    assert not Path("study/best_task.yaml").exists()
    assert "refused: " in capsys.readouterr().err


def test_a_training_that_fails_is_kept_with_its_reason_and_the_study_goes_on(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    real = tuning.score_run
    errors = {
        "0000": ValueError("found invalid values: nan"),
        "0001": RuntimeError("out of memory"),
        "0002": IrsimGymError("no place for the robot"),
    }

    def scored(run: Run, **options: Any) -> Any:
        if run.folder.name in errors:
            raise errors[run.folder.name]
        return real(run, **options)

    monkeypatch.setattr(tuning, "score_run", scored)
    study("study", 4)
    first = rows("study")
    assert [row["ending"] for row in first] == [*(f"failed: {error}" for error in errors.values()), "finished"]
    assert Path("study/best_task.yaml").read_text() == Path("study/trials/0003/task.yaml").read_text()
    assert not list(Path("study").rglob("state.pkl"))
    said = capsys.readouterr()
    assert "failed: found invalid values: nan" in said.err
    assert "4 trials, 0 of them pruned" in said.out
    study("study", 4)
    assert rows("study") == first


def test_what_only_a_new_model_can_tell_fails_one_trial(capsys: pytest.CaptureFixture[str]) -> None:
    Path("ppo.yaml").write_text(f"default: {{{TINY}, normalize: true}}")
    Path("space.yaml").write_text("hyperparameters: {clone: [dash, random]}")
    study("study", 2)
    assert all(
        re.match("failed: clone: .*statistics of normalize would change", row["ending"]) for row in rows("study")
    )
    assert "failed: clone: " in capsys.readouterr().err


def trial(number: int, success: float, ending: str = "finished", **params: Any) -> Any:
    return SimpleNamespace(user_attrs={"trial": number, "success": success, "ending": ending}, params=params)


def test_the_best_trials_come_first_even_without_scores_at_checkpoints(capsys: pytest.CaptureFixture[str]) -> None:
    nan = float("nan")
    kept = [(nan, "failed: nan"), (0.2, "finished"), (0.9, "pruned at 1"), (0.6, "finished"), (0.4, "finished")]
    show_trials([trial(number, *end, gamma=number) for number, end in enumerate(kept)], "yard")
    said = capsys.readouterr().out
    assert "5 trials, 1 of them pruned" in said
    assert re.findall(r"^\W*(\d) .*(?:finished|failed|pruned at)", said, re.MULTILINE) == ["3", "4", "1", "2", "0"]


def test_seeds_share_a_row_and_the_luckiest_is_not_the_best(capsys: pytest.CaptureFixture[str]) -> None:
    shares = (0.1, 1.0, 0.3, 0.9, 0.7, 0.8)
    trials = [trial(i, share, gamma=0.9 if i < 3 else 0.99, seed=i % 3) for i, share in enumerate(shares)]
    show_trials(trials, "mine")
    lines = capsys.readouterr().out.splitlines()
    assert "80.0 [70.0, 90.0]" in lines[4]
    assert "0.99" in lines[4]
    assert "30.0 [10.0, 100.0]" in lines[5]
    assert "0, 1, 2" in lines[5]
    assert best_of(trials) is trials[3]


@pytest.mark.slow
def test_a_study_of_two_processes_is_interrupted_as_from_a_terminal_and_goes_on(folder: Path) -> None:
    """Finished trainings are left alone, the others go on at their checkpoints."""
    pytest.importorskip("optuna")
    Path("space.yaml").write_text(GRID)
    words = [sys.executable, "-m", "irsim_gym", *map(str, WORDS), "--out", "grid", "--grid", "--workers", "2"]
    words += ["--steps", "20480"]

    def until(there: Callable[[], Any]) -> None:
        start = time.monotonic()
        while not there():
            assert time.monotonic() - start < 200, "it never came"
            time.sleep(0.05)

    def started() -> subprocess.Popen[str]:
        return subprocess.Popen(words, start_new_session=True, text=True, stdout=-1, stderr=-1)

    first = started()
    try:
        until((folder / "grid/trials/0001/curve.csv").exists)  # a checkpoint is on disk, and has its score
        os.killpg(first.pid, signal.SIGINT)
        said = first.communicate(timeout=100)[1]
        assert first.returncode == 130
        assert "To continue, run the same command" in said
        assert "Traceback" not in said
        reached = {
            place.name: list_checkpoints(place / "checkpoints")[-1].name for place in folder.glob("grid/trials/*")
        }
        assert sorted(reached) == ["0000", "0001"]
        curve = (folder / "grid/trials/0001/curve.csv").read_text()
        second = started()
        assert second.communicate(timeout=300)[0].count("finished") == 2
        assert second.returncode == 0
    finally:
        for one in (first, second):
            if one.poll() is None:
                os.killpg(one.pid, signal.SIGKILL)
    assert (folder / "grid/trials/0001/curve.csv").read_text().startswith(curve)
    assert [(row["gamma"], row["seed"]) for row in rows("grid")] == [
        *(("0.9", "3"), ("0.9", "1"), ("0.99", "3"), ("0.99", "1"))
    ]
