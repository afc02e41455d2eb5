"""Support for Stable-Baselines3: worlds as a ``VecEnv``, teams of robots and their buffers, a curriculum and a log."""

from irsim_gym.extras import require

require("train", "irsim_gym.sb3")

from irsim_gym.envs.sb3 import WorldVecEnv, make_vec_env
from irsim_gym.envs.sb3_buffers import (
    MaskedDictReplayBuffer,
    MaskedDictRolloutBuffer,
    MaskedReplayBuffer,
    MaskedRolloutBuffer,
)
from irsim_gym.envs.sb3_gru import DictSequenceBuffer, GruPPO, SequenceBuffer
from irsim_gym.envs.sb3_learnability import LearnabilityCallback
from irsim_gym.envs.sb3_log import LogCallback
from irsim_gym.envs.sb3_masked import MaskedA2C, MaskedPPO
from irsim_gym.envs.sb3_memory import GruPolicy
from irsim_gym.envs.sb3_mirror import MirrorCallback
from irsim_gym.envs.sb3_mixture import MixtureVecEnv
from irsim_gym.envs.sb3_normalize import MaskedVecNormalize
from irsim_gym.envs.sb3_teams import TeamVecEnv, buffers_for, make_multi_agent_vec_env

__all__ = ["GruPPO", "GruPolicy", "LearnabilityCallback", "LogCallback"]
__all__ += ["MaskedA2C", "MaskedDictReplayBuffer", "MaskedDictRolloutBuffer", "MaskedPPO", "MaskedReplayBuffer"]
__all__ += ["MaskedRolloutBuffer", "MaskedVecNormalize", "MirrorCallback", "MixtureVecEnv", "TeamVecEnv"]
__all__ += ["WorldVecEnv", "buffers_for", "make_multi_agent_vec_env", "make_vec_env"]

for _pickled in (*map(globals().get, __all__), SequenceBuffer, DictSequenceBuffer):
    if isinstance(_pickled, type):
        _pickled.__module__ = __name__  # a policy.zip names this module, wherever the class is
