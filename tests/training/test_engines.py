"""Trainings with RLlib, as far as they need no Ray: settings and errors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from irsim_gym.errors import IrsimGymError
from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.settings.engines import Engine, engine_of
from irsim_gym.training.settings.folders import setting_differences
from irsim_gym.training.settings.run import Settings


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
        ({"until": 90.0, "engine": Engine()}, "--engine rllib cannot pass on until to ppo"),
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
