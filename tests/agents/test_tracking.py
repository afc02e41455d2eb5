"""Runs of `irsim-gym train` at a tracking service, with a stand-in of its public interface."""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from command_line import run as command
from test_train import settings

from irsim_gym.errors import IrsimGymError
from irsim_gym.training.interruption import TrainingInterruptedError
from irsim_gym.training.tracking import begin_log
from irsim_gym.training.train import train


class StandIn:
    """Weights & Biases as far as it is used; tests/contracts/test_log_callback.py uses the real one."""

    def __init__(self) -> None:
        self.run = None
        self.begun: list[dict[str, Any]] = []
        self.steps: list[int] = []
        self.finished = 0

    def init(self, **given: Any) -> Any:
        self.begun.append(given)
        return SimpleNamespace(id="abc", define_metric=lambda *_, **__: None, log=self._log, finish=self._finish)

    def _log(self, numbers: dict[str, float]) -> None:
        self.steps.append(int(numbers["steps"]))

    def _finish(self) -> None:
        self.finished += 1


@pytest.fixture
def wandb(monkeypatch: pytest.MonkeyPatch) -> StandIn:
    found = StandIn()
    monkeypatch.setitem(sys.modules, "wandb", found)
    for name in ("WANDB_PROJECT", "MLFLOW_EXPERIMENT_NAME"):
        monkeypatch.delenv(name, raising=False)
    return found


def test_an_interrupted_run_goes_on_at_the_service(
    tmp_path: Path, wandb: StandIn, interrupt: Callable[[int, int], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    interrupt(200, signal.SIGINT)
    with pytest.raises(TrainingInterruptedError):
        train(settings(), tmp_path / "empty_goal-ppo-3", log=["wandb"])
    assert wandb.finished == 1
    (given,) = wandb.begun
    assert (given["project"], given["name"]) == ("irsim_gym", "empty_goal-ppo-3")
    assert given["config"]["hyperparameters"]["n_envs"] == 4
    assert json.loads((tmp_path / "empty_goal-ppo-3" / "tracking.json").read_text(encoding="utf-8")) == {"wandb": "abc"}
    monkeypatch.setenv("WANDB_PROJECT", "mine")
    run = train(settings(), tmp_path / "empty_goal-ppo-3", resume=True, log=["wandb"])
    assert (wandb.begun[1]["id"], wandb.begun[1]["resume"], wandb.begun[1]["project"]) == ("abc", "allow", None)
    assert (wandb.finished, wandb.steps[-1]) == (2, 512)
    assert (run.folder / "tracking.json").is_file()
    monkeypatch.setattr(sys.modules[train.__module__], "_learn", lambda *_, logged: begin_log(run, logged))
    train(settings(), run.folder, overwrite=True, log=["wandb"])  # a new run there too
    assert "id" not in wandb.begun[2]
    run.clear()
    assert not (run.folder / "tracking.json").exists()


def test_nothing_is_written_where_there_is_no_such_service(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert command(monkeypatch, "train", "empty_goal", "--steps", 64, "--log", "tensorbord") == 1
    assert "no log named 'tensorbord'; there are wandb and mlflow" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "mlflow", None)
    with pytest.raises(IrsimGymError, match="mlflow is not installed"):
        train(settings(), tmp_path / "run", log=["mlflow"])
    assert not list(tmp_path.iterdir())
