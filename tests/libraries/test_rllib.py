"""Ray RLlib: its own runners sample registered environments and teams."""

from __future__ import annotations

import os
from typing import Any

import pytest
from needed import library
from scenes import ENDS, LIMIT, paid_alone, team

os.environ["RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"] = "0"  # before Ray is imported: on the loopback alone
os.environ["RAY_USAGE_STATS_ENABLED"] = "0"


@pytest.fixture(scope="module", autouse=True)
def ray():
    return library("ray")


@pytest.mark.parametrize("mode", ["sync", "vector_entry_point"])
def test_registered_environments_work_with_rllibs_own_runner(mode):
    from ray.rllib.algorithms.ppo import PPOConfig
    from ray.rllib.env.single_agent_env_runner import SingleAgentEnvRunner

    from irsim_gym import rllib

    rllib.register_environments("irsim_gym/empty_goal-v0")
    config = PPOConfig().environment("irsim_gym/empty_goal-v0", env_config={"max_steps": 7})
    config.env_runners(num_envs_per_env_runner=3, gym_env_vectorize_mode=mode)
    sampler = SingleAgentEnvRunner(config=config, worker_index=None)
    episodes = sampler.sample(num_timesteps=60)
    assert sum(map(len, episodes)) >= 60
    assert max(map(len, episodes)) == 7


def test_a_registered_environment_may_be_a_batch():
    from ray.tune.registry import ENV_CREATOR, _global_registry

    from irsim_gym import rllib

    rllib.register_environments()
    env = _global_registry.get(ENV_CREATOR, "irsim_gym/corridor-v0")({"num_envs": 3, "max_steps": 7})
    assert env.num_envs == 3
    env.close()


def test_the_episodes_of_a_team_are_those_without_a_library():
    """The robots drive ahead whatever the policy does, within a hundredth, and end at different times."""
    from ray.rllib.algorithms.ppo import PPOConfig
    from ray.rllib.env.multi_agent_env_runner import MultiAgentEnvRunner

    from irsim_gym import rllib

    rllib.register_team(team(), "team")
    config = PPOConfig().environment("team").debugging(seed=0)
    config.multi_agent(policies={"shared"}, policy_mapping_fn=lambda agent, episode, **kwargs: "shared")
    (episode,) = MultiAgentEnvRunner(config=config, worker_index=None).sample(num_episodes=1)
    alone: dict[str, Any] = paid_alone()
    assert set(episode.agent_ids) == set(ENDS)
    for name, end in ENDS.items():
        own = episode.agent_episodes[name]
        assert len(own) == end
        assert own.get_return() == pytest.approx(alone[name], abs=0.05)
        assert own.is_truncated == (end == LIMIT)
        assert own.is_terminated  # RLlib adds it to the last one's truncation, see docs/rllib.md
