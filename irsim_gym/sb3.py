"""Everything for Stable-Baselines3: worlds as a ``VecEnv``, teams of robots, and the buffers that these need."""

from irsim_gym.envs.sb3 import (
    MaskedA2C,
    MaskedDictReplayBuffer,
    MaskedDictRolloutBuffer,
    MaskedPPO,
    MaskedReplayBuffer,
    MaskedRolloutBuffer,
    MaskedVecNormalize,
    TeamVecEnv,
    WorldVecEnv,
    buffers_for,
    make_multi_agent_vec_env,
    make_vec_env,
)
from irsim_gym.envs.sb3_goals import EndingHerReplayBuffer

__all__ = [
    "EndingHerReplayBuffer",
    "MaskedA2C",
    "MaskedDictReplayBuffer",
    "MaskedDictRolloutBuffer",
    "MaskedPPO",
    "MaskedReplayBuffer",
    "MaskedRolloutBuffer",
    "MaskedVecNormalize",
    "TeamVecEnv",
    "WorldVecEnv",
    "buffers_for",
    "make_multi_agent_vec_env",
    "make_vec_env",
]
