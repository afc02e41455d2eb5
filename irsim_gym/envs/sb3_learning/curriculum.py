"""Sampling for learnability as a callback of Stable-Baselines3."""

from typing import Any

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

from irsim_gym.base.arraytypes import Flags, Ints
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.envs.sb3_learning.learnability import LearnableLevels


class LearnabilityCallback(BaseCallback):
    """Lets worlds play levels again in which the policy sometimes succeeds and sometimes fails.

    It goes with any algorithm, and with all environments of this package, also in worker processes:
    ``model.learn(100_000, callback=LearnabilityCallback())``. Levels are of the split that the worlds play, which is
    ``train`` unless a reset says otherwise. The success of a team is the mean over its robots. See ``LearnableLevels``.

    Args:
        share: Share of the levels that are chosen; all others are drawn.
        size: Greatest number of levels to choose from.
        seed: Seed of the choices.
        levels: What another callback learned of the levels, to go on with; the other arguments are then ignored.

    Attributes:
        levels: What is known of the levels; None before the training begins.
    """

    def __init__(
        self, *, share: float = 0.5, size: int = 1000, seed: int = 0, levels: LearnableLevels | None = None
    ) -> None:
        super().__init__()
        self.levels = levels
        self._how: dict[str, Any] = {"share": share, "size": size, "seed": seed}
        self._n_agents = 1
        self._is_team = False

    def _on_training_start(self) -> None:
        env = self.training_env
        if not env.has_attr("choose_level"):
            raise IrsimGymError(f"LearnabilityCallback: {env.unwrapped} is no environment of irsim_gym")
        if hasattr(env.unwrapped, "parts"):
            raise IrsimGymError("LearnabilityCallback: levels are known by their numbers, and a mixture has several 0")
        self._is_team = hasattr(env.unwrapped, "n_agents")
        self._n_agents = getattr(env.unwrapped, "n_agents", 1)
        worlds = np.arange(env.num_envs // self._n_agents)
        if self.levels is None:
            self.levels = LearnableLevels(len(worlds), **self._how)
        if (known := len(self.levels.following)) != len(worlds):
            raise IrsimGymError(f"LearnabilityCallback: 'levels' are of {known} worlds, but there are {len(worlds)}")
        if self.num_timesteps == 0:  # the worlds have just been reset
            self.levels.follow(worlds)
        self._ask_for(worlds)

    def _on_rollout_start(self) -> None:
        levels = self._known()
        levels.update()
        self.logger.record("curriculum/success_in_drawn_levels", levels.success)

    def _on_step(self) -> bool:
        dones: Flags = self.locals["dones"]
        ended = dones.nonzero()[0]
        if len(ended):
            levels, infos = self._known(), self.locals["infos"]
            for slot in ended.tolist():
                info = infos[slot]
                if "is_success" in info:
                    levels.count(slot // self._n_agents, int(info["level"]), float(info["is_success"]))
            begun = self._begun(dones)
            levels.follow(begun)
            self._ask_for(begun)
        return True

    def _begun(self, dones: Flags) -> Ints:
        """Return the worlds that have begun another level in the latest step."""
        begun: Ints = np.flatnonzero(np.all(dones.reshape(-1, self._n_agents), axis=1))
        if not self._is_team or not len(begun):
            return begun
        times = self.training_env.get_attr("time", indices=(begun * self._n_agents).tolist())
        has_restarted: Flags = np.array(times) == 0.0  # else all robots have respawned in a level that goes on
        return begun[has_restarted]

    def _ask_for(self, worlds: Ints) -> None:
        """Tell the environment which levels follow, where they are chosen."""
        env, following = self.training_env, self._known().following[worlds]
        for w, level in zip(worlds.tolist(), following.tolist(), strict=True):
            if level >= 0:
                env.env_method("choose_level", level, indices=[w * self._n_agents])

    def _known(self) -> LearnableLevels:
        assert self.levels is not None, "it is made when the training starts"
        return self.levels
