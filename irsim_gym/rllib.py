"""Support for Ray RLlib: an environment runner that samples arrays, its configuration, and registered environments."""

from irsim_gym.base.extras import require

require("rllib", "irsim_gym.rllib")

from collections.abc import Mapping
from functools import partial
from typing import Any, TypeVar

import gymnasium
from ray.rllib.algorithms.appo import APPOConfig
from ray.rllib.algorithms.ppo import PPOConfig
from ray.tune.registry import register_env

from irsim_gym.envs.gymnasium.registration import make, make_vec
from irsim_gym.envs.gymnasium.worlds import ScenarioSource, TaskSource
from irsim_gym.envs.rllib.batches import ArrayAPPOLearner, ArrayPPOLearner
from irsim_gym.envs.rllib.fragments import Fragment
from irsim_gym.envs.rllib.runner import CPU_SECONDS, SUCCESS, ArrayEnvRunner, make_rows

__all__ = ["CPU_SECONDS", "SUCCESS", "ArrayAPPOLearner", "ArrayEnvRunner", "ArrayPPOLearner", "Fragment", "configure"]
__all__ += ["register_environments"]

Config = TypeVar("Config", PPOConfig, APPOConfig)


def configure(
    config: Config,
    scenario: ScenarioSource,
    *,
    workers: int = 0,
    worlds_per_worker: int = 256,
    steps: int = 64,
    task: TaskSource = None,
    max_steps: int | None = None,
    team: str | None = None,
    first_level: int | None = None,
    reward_scale: float = 1.0,
    strict: bool = True,
    parameters: Mapping[str, object] | None = None,
) -> Config:
    """Configure PPO or APPO to learn in the worlds of a scenario.

    This sets the environment runner, the learner, the spaces and the batch size of an update, and removes RLlib's
    learner connectors, which process episodes. All other settings may be changed before and after. The robots of a team
    share one policy. Steps of robots that wait are not used for learning.

    Args:
        config: The configuration, which is changed.
        scenario: Name of a shipped scenario, id, path of a YAML file, or plain data.
        workers: Number of processes that sample; 0 samples in this process.
        worlds_per_worker: Number of worlds of each process.
        steps: Number of steps of each world for an update.
        task: Name of a shipped task, path, or plain data; None for the scenario's own.
        max_steps: Time limit [steps]; None for the task's own.
        team: Team mode: all robots learn, and those whose episode has ended wait (``"episode"``) or restart
            (``"respawn"``). None for a single learner.
        first_level: Level of the first world; the other worlds begin with the following ones. None for random levels.
        reward_scale: Factor on the rewards that the algorithm gets.
        strict: Whether unused keys of the scenario are an error; False ignores them.
        parameters: Values for the scenario's parameters.

    Returns:
        The same configuration.
    """
    chosen: dict[str, Any] = {"scenario": scenario, "task": task, "max_steps": max_steps, "team": team}
    chosen |= {"first_level": first_level, "reward_scale": reward_scale, "strict": strict}
    chosen["parameters"] = dict(parameters or {})
    config.environment("irsim_gym/World-v0", env_config=chosen)
    _configure_sampling(config, workers, worlds_per_worker, steps)
    return config


def _configure_sampling(config: PPOConfig | APPOConfig, workers: int, worlds: int, steps: int) -> None:
    """Set the environment runner, the learner, the spaces and the batch size of an update."""
    rows, is_ppo = make_rows(1, config.env_config), isinstance(config, PPOConfig)
    rows.close()
    config.environment(observation_space=rows.single_observation_space, action_space=rows.single_action_space)
    config.env_runners(
        env_runner_cls=ArrayEnvRunner,
        num_env_runners=workers,
        num_envs_per_env_runner=worlds,
        rollout_fragment_length=steps,
    )
    config.learners(
        learner_class=ArrayPPOLearner if is_ppo else ArrayAPPOLearner,
        add_default_connectors_to_learner_pipeline=False,
        num_aggregator_actors_per_learner=0,
    )
    sampled = rows.n_rows * max(workers, 1) if is_ppo else 1
    config.training(train_batch_size_per_learner=steps * worlds * sampled)


def register_environments(*ids: str) -> None:
    """Register environments with Ray, so that its workers and RLlib's own environment runner can make them.

    Batches use the autoreset mode that RLlib expects: the next episode begins in the step after the end.

    Args:
        *ids: Ids such as ``"irsim_gym/cluttered_room-v0"``; by default, all environments of this package.
    """
    every = [one for one in gymnasium.registry if one.startswith("irsim_gym/")]
    for one in ids or every:
        register_env(one, partial(_make_registered, one))


def _make_registered(one: str, chosen: Mapping[str, Any]) -> Any:
    """Make an environment, or a batch if ``env_config`` has ``num_envs``, with its other values as keywords."""
    given = dict(chosen)
    num_envs = given.pop("num_envs", None)
    return make(one, **given) if num_envs is None else make_vec(one, num_envs, **given)
