"""How a training ends: at a success, by a signal, where it diverges; and how it goes on after its end."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import torch
import yaml
from command_line import run as command
from rich.table import Table
from test_train import settings, weights

import irsim_gym
from irsim_gym.cli.tools import read_count
from irsim_gym.cli.work import commands
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.requests.interruption import StopRequest, TrainingInterruptedError
from irsim_gym.evaluation.saved_policies.checkpoint_files import list_checkpoints, load_progress, newest_checkpoint
from irsim_gym.training.requests.train import train
from irsim_gym.training.runs import monitoring
from irsim_gym.training.runs.extension import extend
from irsim_gym.training.settings.run import Run

TINY = {"n_envs": 4, "n_steps": 16, "batch_size": 32, "n_epochs": 1, "checkpoint_every": 64}


@pytest.mark.parametrize("text", ["1e6", "1_000_000", "1,000,000", "1000000", "1000000.0"])
def test_a_number_of_steps_as_people_write_it(text: str) -> None:
    assert read_count(text) == 1_000_000


@pytest.mark.parametrize("text", ["0", "-5", "1.5", "1e400", "nan", "many", ""])
def test_what_is_no_number_of_steps(
    text: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command(monkeypatch, "train", "empty_goal", f"--steps={text}") == 2
    assert "must be a whole number >= 1" in capsys.readouterr().err.replace("\n│ ", "")


@pytest.fixture
def tiny(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Be in a folder of one's own, and return the words of a tiny training there."""
    monkeypatch.chdir(tmp_path)
    own = {**TINY, "policy_kwargs": {"net_arch": [8]}}
    Path("tiny.yaml").write_text(yaml.safe_dump({"default": own}))
    return ["train", "empty_goal", "--hyperparameters", "tiny.yaml", "--out", "run"]


def test_a_run_ends_at_a_success_and_goes_on_after_its_end(
    tiny: list[Any], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    points: list[float] = []

    def score(run: Run, **how: Any) -> list[dict[str, float]]:
        points.append(load_progress(list_checkpoints(run.checkpoints)[-1]).steps)
        return [{"success": 0.97 if len(points) < 2 else 0.98}]

    with monkeypatch.context() as patch:
        patch.setattr(commands, "score_run", score)
        enough = partial(commands.is_enough, 98.0, 5)
        patch.setattr(commands, "is_enough", lambda until, levels, run: enough(run))
        patch.setattr(commands, "_verdict_lines", lambda *_: [])
        patch.setattr(commands, "marks_table", lambda _: Table())
        assert command(patch, *tiny, "--steps", "1e3", "--until", 98, "--hp", "gamma=0.9", "--dev-levels", 5) == 0
    run = Run(Path("run"))
    assert points[:2] == [64, 128]
    assert run.finished()
    assert run.settings().hyperparameters.until == 98.0
    assert (run.settings().hyperparameters.n_timesteps, run.settings().hyperparameters.arguments["gamma"]) == (
        1000,
        0.9,
    )
    newest = newest_checkpoint(run.checkpoints)
    assert newest is not None
    assert load_progress(newest).steps == 128

    before = torch.cat([value.flatten() for value in weights(run).values()])
    assert command(monkeypatch, "train", "empty_goal", "--out", "run", "--more-steps", 64) == 1
    assert "pass --resume too" in capsys.readouterr().err
    resume = ["train", "empty_goal", "--out", "run", "--resume", "--dev-levels", 0]
    assert command(monkeypatch, *resume, "--seed", 5, "--more-steps", 64) == 1
    assert run.finished()  # a refused command changes nothing
    assert command(monkeypatch, *resume, "--more-steps", "1e2") == 0
    assert "going on from 128 to 228 steps; learning_rate goes on at 44% of its start, to 0" in capsys.readouterr().err
    newest = newest_checkpoint(run.checkpoints)
    assert newest is not None
    assert load_progress(newest).steps == 256  # whole rollouts
    assert (run.settings().hyperparameters.n_timesteps, run.settings().hyperparameters.until) == (228, None)
    assert not torch.equal(before, torch.cat([value.flatten() for value in weights(run).values()]))
    run.policy.unlink()
    assert command(monkeypatch, *resume, "--more-steps", 64) == 1
    assert "go on with --resume alone" in capsys.readouterr().err
    assert command(monkeypatch, *tiny, "--until", 98, "--dev-levels", 0, "--overwrite") == 1
    assert "--dev-levels must be at least 1" in capsys.readouterr().err


def test_a_training_from_python_is_that_of_the_command(
    tiny: list[Any], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command(monkeypatch, *tiny, "--steps", 128, "--hp", "gamma=0.9", "--dev-levels", 0) == 0
    own = {**TINY, "policy_kwargs": {"net_arch": [8]}, "gamma": 0.9}
    found = Run(irsim_gym.train("empty_goal", "other", steps=128, hyperparameters=own, dev_levels=0))
    assert (found.folder, found.finished()) == (Path("other"), True)
    assert found.settings() == Run(Path("run")).settings()
    for name, value in weights(Run(Path("run"))).items():
        assert torch.equal(value, weights(found)[name])
    env = irsim_gym.make("empty_goal")
    action, _ = irsim_gym.load_policy(found.folder).predict(env.reset(seed=0)[0])
    assert env.action_space.contains(action)
    found = Run(irsim_gym.train("empty_goal", "other", resume=True, more_steps=64, dev_levels=0))
    assert found.settings().hyperparameters.n_timesteps == 192
    with pytest.raises(IrsimGymError, match="save the scenario and name the file"):
        irsim_gym.train({"robot": [{}]})  # type: ignore[arg-type]
    capsys.readouterr()


def test_a_longer_run_is_that_of_one_command(tmp_path: Path) -> None:
    """Without schedules, a run that goes on after its end equals one that was as long from the beginning."""
    own = {"n_timesteps": 128, "learning_rate": 1e-3, "clip_range": 0.2}

    def asked(steps: int) -> Any:
        found = settings(n_timesteps=steps)
        arguments = {**found.hyperparameters.to_plain(), **own, "n_timesteps": steps}
        return type(found)(found.scenario, "ppo", 3, None, type(found.hyperparameters).from_plain(arguments))

    whole = train(asked(256), tmp_path / "whole")
    parts = train(asked(128), tmp_path / "parts")
    assert extend(parts, 128, None) == "going on from 128 to 256 steps"
    parts = train(parts.settings(), parts.folder, resume=True)
    for name, value in weights(whole).items():
        assert torch.equal(value, weights(parts)[name]), name


def test_a_finished_run_keeps_no_replay_buffer(tmp_path: Path) -> None:
    run = train(settings("sac", n_timesteps=128, checkpoint_every=64), tmp_path / "run")
    assert not list(run.folder.rglob("replay_buffer*"))
    with pytest.raises(IrsimGymError, match=r"its replay buffer is not kept; --from \S+ starts a new run"):
        extend(run, 64, None)
    assert run.finished()


def test_a_divergence_is_one_sentence_and_keeps_the_newest_checkpoint(
    tiny: list[Any], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    wild = [*tiny, "--dev-levels", 0, "--steps", 6400, "--hp", "learning_rate=1e6", "--hp", "max_grad_norm=1e6"]
    assert command(monkeypatch, *wild) == 1
    told = capsys.readouterr().err
    assert "the training has diverged after" in told
    assert "take a smaller learning_rate (it was 1000000.0)" in told
    run = Run(Path("run"))
    assert not run.finished()
    newest = newest_checkpoint(run.checkpoints)
    assert (str(newest) if newest else "there is no checkpoint yet") in told


def test_a_policy_that_is_not_finite_replaces_no_checkpoint(tmp_path: Path) -> None:
    asked = settings(n_timesteps=512, checkpoint_every=64)
    original = monitoring.TrainingMonitor._on_rollout_start

    def on_rollout_start(self: monitoring.TrainingMonitor) -> None:
        if self.num_timesteps >= 192:
            with torch.no_grad():
                next(self.model.policy.parameters()).fill_(float("nan"))
        original(self)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(monitoring.TrainingMonitor, "_on_rollout_start", on_rollout_start)
        with pytest.raises(IrsimGymError, match="has diverged after 192 steps") as end:
            train(asked, tmp_path / "run")
    newest = newest_checkpoint(tmp_path / "run" / "checkpoints")
    assert newest is not None
    assert load_progress(newest).steps == 128
    assert str(newest) in str(end.value)
    assert train(asked, tmp_path / "run", resume=True).finished()


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="Windows has no SIGHUP")
def test_a_closed_terminal_ends_a_training_with_a_checkpoint(
    tmp_path: Path, interrupt: Callable[[int, int], None]
) -> None:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # nohup, under which these tests may run, has it ignored
    interrupt(100, signal.SIGHUP)
    with pytest.raises(TrainingInterruptedError) as stop:
        train(settings(), tmp_path / "run")
    assert stop.value.signal == signal.SIGHUP
    assert newest_checkpoint(tmp_path / "run" / "checkpoints") is not None


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="Windows has no SIGHUP")
def test_a_signal_that_nohup_ignores_stays_ignored() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with StopRequest().listening() as request:
            os.kill(os.getpid(), signal.SIGHUP)
        assert request.signal is None
    finally:
        signal.signal(signal.SIGHUP, before)


def test_a_range_of_seeds_takes_no_more_steps(
    tiny: list[Any], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command(monkeypatch, *tiny, "--seeds", 2, "--resume", "--more-steps", 64) == 1
    assert "--more-steps is for one run" in capsys.readouterr().err
    assert not list(Path().glob("run*"))
