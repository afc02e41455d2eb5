"""Worlds as RLlib samples them: whole arrays, without an object for each world and step."""

import time
import warnings
from collections.abc import Mapping
from typing import Any, Self

import numpy as np
import ray
import torch
from gymnasium import Space
from gymnasium.spaces import Box
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray
from ray.rllib.core.columns import Columns
from ray.rllib.env.single_agent_env_runner import SingleAgentEnvRunner
from ray.rllib.utils import metrics as names

from irsim_gym.base.arraytypes import Flags, Floats
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.envs.parts.observations import on_each
from irsim_gym.envs.parts.spaces import Observation
from irsim_gym.envs.rllib.fragments import Fragment, FragmentWriter
from irsim_gym.envs.teams.batch import Batch

SUCCESS = "success"
"""Name of the metric with the share of successful episodes."""
CPU_SECONDS = "cpu_seconds"
"""Name of the metric with the processor time of sampling [s]."""
WINDOW = 100
"""Number of fragments over which metrics of episodes are averaged."""


class Rows:
    """The agents of a batch as rows (world, slot), one after the other, with the spaces that RLlib asks for.

    Attributes:
        batch: The worlds.
        num_envs: Number of worlds.
        n_rows: Number of worlds times agents.
    """

    def __init__(self, batch: Batch) -> None:
        self.batch = batch
        self.num_envs, self.n_rows = batch.n_worlds, batch.n_worlds * batch.n_agents
        self.single_observation_space: Space[Any] = batch.observation_space
        self.single_action_space: Space[Any] = batch.action_space
        self.observation_space = batch_space(batch.observation_space, self.n_rows)
        self.action_space = batch_space(batch.action_space, self.n_rows)

    @property
    def unwrapped(self) -> Self:
        """The rows themselves."""
        return self

    def close(self) -> None:
        """Close the worlds."""
        self.batch.close()

    def of(self, values: Observation) -> Any:
        """Return arrays ``(n_worlds, n_agents, ...)`` as ``(n_rows, ...)``."""
        return on_each(values, lambda array: array.reshape(self.n_rows, *array.shape[2:]))

    def given(self, actions: NDArray[Any]) -> NDArray[Any]:
        """Return actions ``(n_rows, ...)`` as the batch takes them, cut off to their bounds."""
        space = self.single_action_space
        if isinstance(space, Box):
            actions = np.clip(actions, space.low, space.high)
        return actions.reshape(self.num_envs, -1, *actions.shape[1:])


def make_rows(n_worlds: int, chosen: Mapping[str, Any]) -> Rows:
    """Make the worlds that ``env_config`` of a runner describes, see ``rllib.configure``."""
    worlds = Worlds(
        chosen["scenario"],
        n_worlds,
        task=chosen.get("task"),
        max_steps=chosen.get("max_steps"),
        team=chosen.get("team") is not None,
        parameters=chosen.get("parameters"),
        strict=chosen.get("strict", True),
    )
    return Rows(Batch(worlds, respawn=chosen.get("team") == "respawn"))


class ArrayEnvRunner(SingleAgentEnvRunner):  # type: ignore[misc]
    """Samples the worlds of a scenario with one policy, and returns a ``Fragment`` in place of episodes.

    World ``w`` of the worker with number ``i`` (from 1 on) begins with level ``first_level + (i - 1) * n_worlds + w``
    as a ``WorldVecEnv`` of all these worlds does. A worker that was started again after a failure begins with levels
    from entropy, so that it plays none twice.

    ``rllib.configure`` chooses it. It needs ``ArrayPPOLearner`` or ``ArrayAPPOLearner`` as its learner.
    """

    env: Rows | None
    _seen: Observation

    def make_env(self) -> None:
        """Make the worlds that ``env_config`` describes."""
        if self.env is not None:
            self.env.close()
        if self.worker_index:
            torch.set_num_threads(1)  # the networks are small, and other workers use the other cores
        self.env = make_rows(self.config.num_envs_per_env_runner, self.config.env_config)
        self.num_envs = self.env.num_envs
        self._begun = False

    def sample(
        self,
        *,
        num_timesteps: int | None = None,
        num_episodes: int | None = None,
        explore: bool | None = None,
        random_actions: bool = False,
        force_reset: bool = False,
    ) -> list[Fragment]:
        """Take steps in all worlds.

        Args:
            num_timesteps: Minimum number of rows to sample; None for ``rollout_fragment_length`` steps of every world.
            num_episodes: Minimum number of episodes to finish, after a reset of all worlds.
            explore: Whether to draw actions from the policy's distribution; None for the configuration's value.
            random_actions: Whether to draw actions uniformly from the action space.
            force_reset: Whether to reset all worlds first.

        Returns:
            The fragments, one after the other in time; a single one unless ``num_episodes`` is given.

        Raises:
            ValueError: This runner has no worlds, because remote runners sample.
        """
        if self.env is None:
            raise ValueError("this runner has no worlds: it is the local one beside remote ones")
        if force_reset or num_episodes is not None or not self._begun:
            self._begin()
        explore = self.config.explore if explore is None else explore
        length = self.config.get_rollout_fragment_length(self.worker_index or 0)
        n_steps = length if num_timesteps is None else -(-num_timesteps // self.env.n_rows)
        parts: list[Fragment] = []
        ended, begun = 0, time.process_time()
        with self.metrics.log_time(names.SAMPLE_TIMER):
            while not parts or (num_episodes is not None and ended < num_episodes):
                fragment, n_ended = self._sample_steps(n_steps, explore, random_actions)
                parts.append(fragment)
                ended += n_ended
        self._log_steps(sum(part.steps for part in parts), ended)
        self.metrics.log_value(CPU_SECONDS, time.process_time() - begun, reduce="lifetime_sum")
        return parts

    def get_metrics(self) -> Any:
        """Return the metrics logged since the last call."""
        return self.metrics.reduce()

    def _begin(self) -> None:
        assert self.env is not None
        first = self.config.env_config.get("first_level")
        if first is None or (self.worker_index and _started_again()):
            seed = None
        else:
            seed = first + max((self.worker_index or 0) - 1, 0) * self.env.num_envs
        begun = self.env.batch.reset(None if self._begun else seed)
        self._seen, self._live = self.env.of(begun.observation), begun.live.reshape(-1)
        self._begun = True

    def _sample_steps(self, n_steps: int, explore: bool, random_actions: bool) -> tuple[Fragment, int]:
        """Return the experience of some steps in all worlds, and how many episodes ended in them."""
        env = self.env
        assert env is not None
        writer = FragmentWriter(env.n_rows, n_steps)
        ends: list[Floats] = []
        for t in range(n_steps):
            columns = self._act(explore, random_actions)
            before, acted = self._seen, self._live
            step = env.batch.step(env.given(columns["action"]))
            terminated: Flags = step.terminated.reshape(-1)
            cut = step.truncated.reshape(-1)
            if step.ended.any():
                of = step.infos
                figures = [of[name][step.ended] for name in ("episode_return", "steps", "is_success")]
                ends.append(np.stack(figures).astype(np.float64))
            if t == n_steps - 1:
                cut = acted & ~terminated
            reward = (step.reward.reshape(-1) * self.config.env_config.get("reward_scale", 1.0)).astype(np.float32)
            writer.note(before, {**columns, "reward": reward, "terminated": terminated, "acted": acted})
            writer.note_cuts(np.flatnonzero(cut), env.of(step.final_observation))
            self._seen, self._live = env.of(step.observation), step.live.reshape(-1)
        self._log_ends(ends)
        return writer.fragment(), sum(figures.shape[1] for figures in ends)

    def _act(self, explore: bool, random_actions: bool) -> dict[str, NDArray[Any]]:
        """Return the actions of all rows, and what they were drawn from."""
        env = self.env
        assert env is not None
        if random_actions or self.module is None:
            none = np.zeros(env.n_rows, np.float32)
            return {"action": env.action_space.sample(), "log_probability": none, "distribution": none[:, None]}
        batch = {Columns.OBS: on_each(self._seen, lambda array: torch.from_numpy(array).to(self._device))}
        with torch.inference_mode():
            if explore:
                told = self.module.forward_exploration(batch)
                kind = self.module.get_exploration_action_dist_cls()
            else:
                told = self.module.forward_inference(batch)
                kind = self.module.get_inference_action_dist_cls()
            inputs = told[Columns.ACTION_DIST_INPUTS]
            drawn_from = kind.from_logits(inputs)
            if not explore:
                drawn_from = drawn_from.to_deterministic()
            action = drawn_from.sample()
            probability = kind.from_logits(inputs).logp(action)
        found = {"action": action, "log_probability": probability, "distribution": inputs}
        return {name: tensor.cpu().numpy() for name, tensor in found.items()}

    def _log_ends(self, ends: list[Floats]) -> None:
        """Log the means over the episodes that ended."""
        if not ends:
            return
        means = np.concatenate(ends, axis=1).mean(axis=1).tolist()
        for name, mean in zip((names.EPISODE_RETURN_MEAN, names.EPISODE_LEN_MEAN, SUCCESS), means, strict=True):
            self.metrics.log_value(name, mean, window=WINDOW)

    def _log_steps(self, steps: int, ended: int) -> None:
        """Log how many rows were sampled; RLlib counts these as steps of one environment and agent."""
        self.num_env_steps_sampled_lifetime += steps
        for name, value in ((names.NUM_ENV_STEPS_SAMPLED, steps), (names.NUM_EPISODES, ended)):
            self.metrics.log_value(name, value, reduce="sum")
        for name, value in ((names.NUM_ENV_STEPS_SAMPLED_LIFETIME, steps), (names.NUM_EPISODES_LIFETIME, ended)):
            self.metrics.log_value(name, value, reduce="lifetime_sum")


def _started_again() -> bool:
    """Return whether this worker took the place of one that had died."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the property itself calls one that Ray has deprecated
        return bool(ray.get_runtime_context().was_current_actor_reconstructed)
