"""``VecNormalize`` whose statistics leave out agents that wait for their world."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecNormalize
from stable_baselines3.common.vec_env.base_vec_env import VecEnvStepReturn

from irsim_gym.base.arraytypes import Flags
from irsim_gym.envs.sb3.buffers import team_below


class MaskedVecNormalize(VecNormalize):
    """Normalises like ``VecNormalize``; means and variances are those of experience.

    An observation counts when its agent is about to act on it, a return when its agent has acted. Everything else,
    saving and loading included, is that of ``VecNormalize``, and so are all numbers where no agent waits.
    """

    def step_wait(self) -> VecEnvStepReturn:
        """Return the normalised step."""
        obs, rewards, dones, infos = self.venv.step_wait()
        assert isinstance(obs, np.ndarray | dict)
        self.old_obs, self.old_reward = obs, rewards
        if self.training:
            team = team_below(self)
            self._learn_observations(obs, team.acting)
            self.returns = np.where(team.acted, self.returns * self.gamma + rewards, self.returns)
            self.ret_rms.update(self.returns[team.acted])
        for done, info in zip(dones, infos, strict=True):
            if done and "terminal_observation" in info:
                info["terminal_observation"] = self.normalize_obs(info["terminal_observation"])
        self.returns[dones] = 0.0
        return self.normalize_obs(obs), self.normalize_reward(rewards), dones, infos

    def _learn_observations(self, obs: NDArray[Any] | dict[str, NDArray[Any]], acting: Flags) -> None:
        if not self.norm_obs or not acting.any():
            return
        if isinstance(obs, dict):
            for key, statistics in self.obs_rms.items():
                statistics.update(obs[key][acting])
        else:
            self.obs_rms.update(obs[acting])
