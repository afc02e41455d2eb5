"""The log of a training: outcomes and reward terms of episodes."""

from __future__ import annotations

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
    with pytest.raises(IrsimGymError, match="window must be at least 1, got 0"):
        sb3.LogCallback(window=0)
    model = PPO("MlpPolicy", make_vec_env("CartPole-v1"), **HOW)
    with pytest.raises(IrsimGymError, match="is no environment of irsim_gym"):
        model.learn(64, callback=sb3.LogCallback())
