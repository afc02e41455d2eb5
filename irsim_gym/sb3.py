"""Support for Stable-Baselines3: worlds as a ``VecEnv``, teams of robots and their buffers, and a log."""

from irsim_gym.base.extras import require

require("train", "irsim_gym.sb3")

from irsim_gym.envs.sb3.buffers import MaskedDictRolloutBuffer, MaskedRolloutBuffer
from irsim_gym.envs.sb3.mixture import MixtureVecEnv
from irsim_gym.envs.sb3.teams import TeamVecEnv, make_multi_agent_vec_env
from irsim_gym.envs.sb3.vec_env import WorldVecEnv, make_vec_env
from irsim_gym.envs.sb3_learning.gru import DictSequenceBuffer, GruPPO, SequenceBuffer
from irsim_gym.envs.sb3_learning.log import LogCallback
from irsim_gym.envs.sb3_learning.masked import MaskedA2C, MaskedPPO
from irsim_gym.envs.sb3_learning.memory import GruPolicy
from irsim_gym.envs.sb3_learning.mirror import MirrorCallback
from irsim_gym.envs.sb3_learning.normalize import MaskedVecNormalize

__all__ = ["GruPPO", "GruPolicy", "LogCallback", "MaskedA2C", "MaskedDictRolloutBuffer", "MaskedPPO"]
__all__ += ["MaskedRolloutBuffer", "MaskedVecNormalize", "MirrorCallback", "MixtureVecEnv", "TeamVecEnv"]
__all__ += ["WorldVecEnv", "make_multi_agent_vec_env", "make_vec_env"]

for _pickled in (*map(globals().get, __all__), SequenceBuffer, DictSequenceBuffer):
    if isinstance(_pickled, type):
        _pickled.__module__ = __name__  # a policy.zip names this module, wherever the class is
