"""Support for Ray RLlib: environments registered by name, single ones, batches and teams."""

from irsim_gym.base.extras import require

require("rllib", "irsim_gym.rllib")

from collections.abc import Mapping
from functools import partial
from typing import Any

import gymnasium
from ray.rllib.env.wrappers.pettingzoo_env import ParallelPettingZooEnv
from ray.tune.registry import register_env

from irsim_gym.envs.gymnasium.registration import make, make_vec
from irsim_gym.envs.gymnasium.worlds import ScenarioSource
from irsim_gym.envs.teams.parallel import parallel_env

__all__ = ["register_environments", "register_team"]


def register_environments(*ids: str) -> None:
    """Register environments with Ray, so that RLlib, Tune and their workers can make them by name.

    ``env_config`` has the keywords of ``irsim_gym.make``. Batches use the autoreset mode that RLlib expects: the next
    episode begins in the step after the end.

    Args:
        *ids: Ids such as ``"irsim_gym/cluttered_room-v0"``; by default, all environments of this package.
    """
    every = [one for one in gymnasium.registry if one.startswith("irsim_gym/")]
    for one in ids or every:
        register_env(one, partial(_make_registered, one))


def register_team(scenario: ScenarioSource, name: str) -> None:
    """Register the robots of a scenario with Ray as RLlib's multi-agent environment.

    ``env_config`` has the keywords of ``irsim_gym.parallel_env``.

    Args:
        scenario: Name of a shipped scenario, id, path of a YAML file, or plain data.
        name: Name for ``config.environment``.
    """
    register_env(name, partial(_make_team, scenario))


def _make_registered(one: str, chosen: Mapping[str, Any]) -> Any:
    """Make an environment, or a batch if ``env_config`` has ``num_envs``, with its other values as keywords."""
    given = dict(chosen)
    num_envs = given.pop("num_envs", None)
    return make(one, **given) if num_envs is None else make_vec(one, num_envs, **given)


def _make_team(scenario: ScenarioSource, chosen: Mapping[str, Any]) -> Any:
    return ParallelPettingZooEnv(parallel_env(scenario, **chosen))
