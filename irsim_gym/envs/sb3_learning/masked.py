"""PPO and A2C of Stable-Baselines3 that leave out robots that wait for their world."""

from typing import Any, ClassVar

from gymnasium.spaces import Dict, Space
from stable_baselines3 import A2C, PPO
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.vec_env import VecEnv

from irsim_gym.envs.sb3.buffers import MaskedDictRolloutBuffer, MaskedRolloutBuffer, read_mask_of


class MaskedAlgorithm(OnPolicyAlgorithm):
    """What ``MaskedPPO`` and ``MaskedA2C`` share."""

    leaves_out_waiting: ClassVar[bool] = True

    def _setup_model(self) -> None:
        self.rollout_buffer_class = _masked(self.rollout_buffer_class, self.observation_space)
        super()._setup_model()

    def collect_rollouts(
        self, env: VecEnv, callback: BaseCallback, rollout_buffer: RolloutBuffer, n_rollout_steps: int
    ) -> bool:
        """Let the buffer read the mask of ``env``, then collect a rollout."""
        read_mask_of(env, rollout_buffer)
        return super().collect_rollouts(env, callback, rollout_buffer, n_rollout_steps)


class MaskedPPO(MaskedAlgorithm, PPO):
    """``PPO`` that learns from the rows of robots that acted, and no others; for ``make_multi_agent_vec_env``.

    It takes the arguments of ``PPO``; of classes for the rollout buffer, those derived from ``MaskedRolloutBuffer`` or
    ``MaskedDictRolloutBuffer``. ``MaskedPPO.load`` also reads files of ``PPO``. Where no robot waits, both learn the
    same weights.
    """


class MaskedA2C(MaskedAlgorithm, A2C):
    """``A2C`` that learns from the rows of robots that acted, and no others; see ``MaskedPPO``."""


def _masked(kind: type[RolloutBuffer] | None, space: Space[Any]) -> type[RolloutBuffer]:
    """Return a class for the rollout buffer: ``kind`` if it is a masked one."""
    masked: type[RolloutBuffer] = MaskedDictRolloutBuffer if isinstance(space, Dict) else MaskedRolloutBuffer
    return kind if kind is not None and issubclass(kind, masked) else masked
