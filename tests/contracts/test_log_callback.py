"""The log of a training: outcomes and reward terms of episodes, also at Weights & Biases and MLflow."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium
import pytest
from contract_tools import STILL
from stable_baselines3 import DQN, PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.logger import KVWriter, Logger
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv, VecNormalize
from team_tools import MEET

from irsim_gym import sb3
from irsim_gym.errors import IrsimGymError
from irsim_gym.tasks import Outcome

LIMIT = 12
HOW: dict[str, Any] = {"n_steps": 32, "batch_size": 32, "n_epochs": 1, "seed": 0, "device": "cpu"}


class Rows(KVWriter):
    """Keeps what is logged."""

    def __init__(self) -> None:
        self.rows: list[dict[str, Any]] = []

    def write(self, key_values: dict[str, Any], key_excluded: dict[str, tuple[str, ...]], step: int = 0) -> None:
        self.rows.append({**key_values, "step": step})

    def close(self) -> None:
        pass


class Ended(BaseCallback):
    """Notes outcome and return of each episode, from the infos alone."""

    def __init__(self) -> None:
        super().__init__()
        self.outcomes: list[int] = []
        self.returns: list[float] = []

    def _on_step(self) -> bool:
        for info in self.locals["infos"]:
            if "episode" in info:
                self.outcomes.append(info["outcome"])
                self.returns.append(info["episode"]["r"])
        return True


def single() -> gymnasium.Env[Any, Any]:
    return Monitor(gymnasium.make(STILL, max_steps=LIMIT))


ENVIRONMENTS = {
    "batch": lambda: sb3.make_vec_env(STILL, 4, seed=3, max_steps=LIMIT),
    "normalised": lambda: VecNormalize(sb3.make_vec_env(STILL, 4, seed=3, max_steps=LIMIT)),
    "single": lambda: DummyVecEnv([single] * 3),
    "team": lambda: sb3.make_multi_agent_vec_env(MEET, 2, seed=0, max_steps=LIMIT),
    "respawn": lambda: sb3.make_multi_agent_vec_env(MEET, 2, seed=0, max_steps=LIMIT, respawn=True, world_steps=20),
}


@pytest.mark.parametrize("kind", ENVIRONMENTS)
def test_reward_terms_add_up_to_the_return_and_outcomes_to_one(kind: str) -> None:
    rows, ended = Rows(), Ended()
    model = (sb3.MaskedPPO if kind in ("team", "respawn") else PPO)("MlpPolicy", ENVIRONMENTS[kind](), **HOW)
    model.set_logger(Logger(None, [rows]))
    model.learn(500, callback=[ended, sb3.LogCallback(window=10_000)])
    last = rows.rows[-1]
    terms = {key: value for key, value in last.items() if key.startswith("reward/")}
    assert len(terms) > 2
    assert sum(terms.values()) == pytest.approx(sum(ended.returns) / len(ended.returns), abs=1e-5)
    for outcome in Outcome:
        if outcome != Outcome.RUNNING:
            share = sum(one == outcome for one in ended.outcomes) / len(ended.outcomes)
            assert last[f"outcome/{outcome.name.lower()}"] == pytest.approx(share)
    assert len(set(ended.outcomes)) > 1


@pytest.mark.slow
def test_worker_processes_log_the_same() -> None:
    rows = {}
    for kind in (DummyVecEnv, SubprocVecEnv):
        model, rows[kind] = PPO("MlpPolicy", kind([single] * 2), **HOW), Rows()
        model.set_logger(Logger(None, [rows[kind]]))
        model.learn(200, callback=sb3.LogCallback())
        model.get_env().close()
    first, second = (
        [{key: value for key, value in row.items() if key.startswith(("reward/", "outcome/"))} for row in one.rows]
        for one in rows.values()
    )
    assert first == second


def test_only_the_latest_episodes_count() -> None:
    rows, ended = Rows(), Ended()
    task = {"name": "discrete_navigation"}
    env = sb3.make_vec_env(STILL, 2, seed=3, max_steps=LIMIT, task=task)
    model = DQN("MlpPolicy", env, learning_starts=500, seed=0, buffer_size=100)
    model.set_logger(Logger(None, [rows]))
    model.learn(400, callback=[ended, sb3.LogCallback(window=3)])
    latest = ended.outcomes[-3:]
    assert rows.rows[-1]["outcome/timeout"] in [k / 3 for k in range(4)]
    model.logger.dump(0)
    assert len(ended.outcomes) > 10
    known = [row for row in rows.rows if "outcome/timeout" in row]
    assert known[-1]["outcome/timeout"] == pytest.approx(sum(one == Outcome.TIMEOUT for one in latest) / 3)


def test_what_cannot_be_logged_is_said() -> None:
    with pytest.raises(
        IrsimGymError, match=r"no log named 'wanbd' \(did you mean 'wandb'\?\); there are wandb and mlflow"
    ):
        sb3.LogCallback("wanbd")
    with pytest.raises(IrsimGymError, match="mode: further arguments need exactly one service"):
        sb3.LogCallback(mode="offline")
    with pytest.raises(IrsimGymError, match="window must be at least 1, got 0"):
        sb3.LogCallback(window=0)
    model = PPO("MlpPolicy", make_vec_env("CartPole-v1"), **HOW)
    with pytest.raises(IrsimGymError, match="is no environment of irsim_gym"):
        model.learn(64, callback=sb3.LogCallback())


def test_a_service_that_is_not_installed_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "wandb", None)
    with pytest.raises(IrsimGymError, match=r'wandb is not installed: pip install "irsim_gym\[wandb\]"'):
        sb3.LogCallback("wandb")


class StandIn:
    """The part of Weights & Biases' public interface that is used; the tests below use the real one."""

    def __init__(self) -> None:
        self.run: Any = None
        self.begun: list[dict[str, Any]] = []
        self.logged: list[dict[str, float]] = []
        self.finished = 0

    def init(self, **given: Any) -> Any:
        self.begun.append(given)
        return self.opened(given.get("id", "fresh"))

    def opened(self, run_id: str) -> Any:
        return SimpleNamespace(id=run_id, define_metric=lambda *_, **__: None, log=self.logged.append, finish=self._end)

    def _end(self) -> None:
        self.finished += 1


@pytest.fixture
def wandb(monkeypatch: pytest.MonkeyPatch) -> StandIn:
    found = StandIn()
    monkeypatch.setitem(sys.modules, "wandb", found)
    return found


def test_a_run_is_begun_gets_all_numbers_and_ends(wandb: StandIn) -> None:
    log = sb3.LogCallback("wandb", project="robots", name="first", config={"a": 1}, mode="offline")
    model = PPO("MlpPolicy", ENVIRONMENTS["batch"](), **HOW)
    model.learn(300, callback=log)
    given = {"project": "robots", "name": "first", "config": {"a": 1}, "mode": "offline"}
    assert (wandb.begun, wandb.finished, log.run_ids) == ([given], 1, {"wandb": "fresh"})
    last = wandb.logged[-1]
    assert {"outcome/timeout", "reward/progress", "rollout/success_rate", "train/value_loss", "steps"} <= set(last)
    assert "time/iterations" not in last  # nor has TensorBoard
    assert all(isinstance(value, float | int) for value in last.values())
    model.learn(128, callback=log)  # the same run goes on
    assert (wandb.begun[-1]["id"], wandb.begun[-1]["resume"], wandb.finished) == ("fresh", "allow", 2)


def test_a_run_under_way_is_used_and_stays_open(wandb: StandIn) -> None:
    wandb.run = wandb.opened("mine")
    log = sb3.LogCallback("wandb")
    PPO("MlpPolicy", ENVIRONMENTS["batch"](), **HOW).learn(300, callback=log)
    assert (wandb.begun, wandb.finished, log.run_ids) == ([], 0, {"wandb": "mine"})
    assert wandb.logged


@pytest.mark.slow
@pytest.mark.filterwarnings("default")  # of these packages about their own parts
def test_weights_and_biases_writes_a_run_without_a_network(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wandb = pytest.importorskip("wandb", reason="the extra `wandb` has it")
    monkeypatch.setenv("WANDB_SILENT", "true")
    log = sb3.LogCallback("wandb", project="robots", name="first", mode="offline", dir=str(tmp_path))
    PPO("MlpPolicy", ENVIRONMENTS["batch"](), **HOW).learn(300, callback=log)
    wandb.teardown()  # its process writes the rest
    (file,) = tmp_path.glob(f"wandb/offline-run-*/run-{log.run_ids['wandb']}.wandb")
    content = file.read_bytes()
    for word in (b"outcome/timeout", b"reward/progress", b"rollout/success_rate", b"robots"):
        assert word in content


@pytest.mark.slow
@pytest.mark.filterwarnings("default")  # of these packages about their own parts
def test_mlflow_stores_a_run_and_goes_on_with_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mlflow = pytest.importorskip("mlflow", reason="the extra `mlflow` has it")
    mlflow.set_tracking_uri(f"sqlite:///{tmp_path.as_posix()}/mlflow.db")
    log = sb3.LogCallback("mlflow", project="robots", name="first", config={"ppo": {"gamma": 0.9}})
    model = PPO("MlpPolicy", ENVIRONMENTS["batch"](), **HOW)
    model.learn(300, callback=log)
    stored = mlflow.MlflowClient().get_run(log.run_ids["mlflow"])
    assert (stored.info.run_name, stored.info.status) == ("first", "FINISHED")
    assert stored.data.params == {"ppo.gamma": "0.9"}
    assert {"outcome/timeout", "reward/progress", "rollout/success_rate"} <= set(stored.data.metrics)
    model.learn(256, callback=sb3.LogCallback("mlflow", run_ids=log.run_ids), reset_num_timesteps=False)
    history = mlflow.MlflowClient().get_metric_history(log.run_ids["mlflow"], "reward/progress")
    assert [one.step for one in history] == sorted({one.step for one in history})
    assert history[-1].step > 300
