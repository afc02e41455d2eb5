"""The configuration of RLlib for the settings of a run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ray.rllib.algorithms.appo import APPOConfig
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.core.rl_module.rl_module import RLModuleSpec
from stable_baselines3.common.base_class import BaseAlgorithm

from irsim_gym import rllib
from irsim_gym.training.rllib.module import PolicyModule, policy_state
from irsim_gym.training.settings.engines import Engine
from irsim_gym.training.settings.hyperparameters import Linear
from irsim_gym.training.settings.run import SEED_STRIDE, Settings

if TYPE_CHECKING:
    Config = Any  # mypy does not follow Ray
else:
    Config = PPOConfig | APPOConfig
SLOWEST_S = 300.0
"""Time after which a fragment of a slow worker is given up [s]."""
RESTARTS = 1_000_000
"""Number of times that a worker may be restarted: in effect unlimited."""


def make_config(settings: Settings, engine: Engine, model: BaseAlgorithm, steps_before: int) -> Config:
    """Return the configuration of a run.

    Args:
        settings: Settings of the run, with its own copy of the scenario.
        engine: Settings of RLlib, without None.
        model: Model that provides the networks and their initial weights.
        steps_before: Number of steps that a resumed run has already taken.
    """
    wanted = settings.hyperparameters
    given: dict[str, Any] = {"gamma": 0.99, "ent_coef": 0.0, "vf_coef": 0.5, "max_grad_norm": 0.5, "clip_range": 0.2}
    given |= {"learning_rate": 3e-4, "n_steps": 2048, "batch_size": 64, "n_epochs": 10, "gae_lambda": 0.95}
    given |= wanted.algorithm_arguments()
    config: Config = PPOConfig() if settings.algorithm == "ppo" else APPOConfig()
    assert engine.workers is not None
    assert engine.worlds_per_worker is not None
    rllib.configure(
        config,
        _absolute(settings.scenario),
        workers=engine.workers,
        worlds_per_worker=engine.worlds_per_worker,
        steps=int(given["n_steps"]),
        task=None if settings.task is None else _absolute(settings.task),
        team=wanted.team,
        first_level=settings.first_level + steps_before % SEED_STRIDE,
        reward_scale=wanted.reward_scale,
        strict=settings.strict,
        parameters=settings.parameters,
    )
    config.training(
        lr=_schedule(given["learning_rate"], steps_before, wanted.n_timesteps),
        gamma=given["gamma"],
        entropy_coeff=given["ent_coef"],
        vf_loss_coeff=given["vf_coef"],
        grad_clip=given["max_grad_norm"],
        grad_clip_by="global_norm",
        use_kl_loss=False,
        clip_param=given["clip_range"],
    )
    if isinstance(config, PPOConfig):
        size = min(int(given["batch_size"]), config.train_batch_size_per_learner)
        config.training(
            minibatch_size=size,
            num_epochs=int(given["n_epochs"]),
            lambda_=given["gae_lambda"],
            vf_clip_param=float("inf"),
            shuffle_batch_per_epoch=True,
        )
    else:
        sampled = config.train_batch_size_per_learner * max(1, engine.workers)
        config.reporting(min_time_s_per_iteration=None, min_sample_timesteps_per_iteration=sampled)
    optimizer = dict(given.get("policy_kwargs", {}).get("optimizer_kwargs") or {})
    _configure_processes(config, engine, {"optimizer": optimizer})
    config.rl_module(rl_module_spec=RLModuleSpec(module_class=PolicyModule, model_config=_networks(model)))
    config.debugging(seed=settings.seed, log_level="ERROR")
    return config


def _configure_processes(config: Config, engine: Engine, learning: Mapping[str, Any]) -> None:
    """Configure the learners and their devices, and the restart of workers that die."""
    cards = engine.learner_gpus or 0
    if cards > 1:
        config.training(train_batch_size_per_learner=config.train_batch_size_per_learner // cards)
    config.learners(
        num_learners=cards if cards > 1 else 0,
        num_gpus_per_learner=1 if cards else 0,
        learner_config_dict=dict(learning),
    )
    config.env_runners(sample_timeout_s=SLOWEST_S)
    config.fault_tolerance(
        restart_failed_env_runners=True, max_num_env_runner_restarts=RESTARTS, delay_between_env_runner_restarts_s=0.0
    )


def _networks(model: BaseAlgorithm) -> dict[str, Any]:
    """Return the class, the arguments and the weights of a model's policy."""
    policy: Any = model.policy
    return {
        "policy": model.policy_class,
        "arguments": {"use_sde": False, **model.policy_kwargs},
        "weights": policy_state(policy),
    }


def _schedule(value: Any, before: int, total: int) -> Any:
    """Return a learning rate in RLlib's form: a number, or pairs of steps and values."""
    if not isinstance(value, Linear):
        return value
    left = max(total - before, 1)
    return [[0, value.start * left / total], [left, 0.0]]


def _absolute(source: str) -> str:
    """Return the absolute path of a file, because workers may run in another folder; return names unchanged."""
    return str(Path(source).resolve()) if Path(source).suffix else source
