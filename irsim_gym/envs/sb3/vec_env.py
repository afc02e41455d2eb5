"""Many worlds as a Stable-Baselines3 ``VecEnv``."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Flags, Floats, Ints, Rays
from irsim_gym.envs.gymnasium.registration import spec_of
from irsim_gym.envs.gymnasium.world_view import WorldView
from irsim_gym.envs.gymnasium.worlds import ScenarioSource, TaskSource, Worlds
from irsim_gym.envs.parts.level_options import fresh_level
from irsim_gym.envs.parts.limits import ScenarioSpec
from irsim_gym.envs.parts.spaces import Observation
from irsim_gym.envs.sb3.base import NativeVecEnv, checked_mode


def make_vec_env(
    scenario: ScenarioSource,
    n_envs: int = 1,
    seed: int | None = None,
    *,
    task: TaskSource = None,
    max_steps: int | None = None,
    max_episode_steps: int | None = None,
    num_threads: int = 1,
    render_mode: str | None = "rgb_array",
    strict: bool = True,
    **parameters: Any,
) -> WorldVecEnv:
    """Make the worlds of a scenario for Stable-Baselines3.

    Keywords of Stable-Baselines3's own for single environments are refused. As in ``DummyVecEnv``, seed and options set
    later count in the next ``reset()``, not where a world resets itself: use ``env_method("choose_level", number)``.

    Args:
        scenario: Name of a shipped scenario, id, path of a YAML file, plain data or a loaded scenario.
        n_envs: Number of worlds.
        seed: World ``w`` begins with level ``seed + w``; None for levels from entropy.
        task: Name of a shipped task, path, or plain data; None for the scenario's own.
        max_steps: Time limit [steps]; None for the task's.
        max_episode_steps: Another time limit, as ``gymnasium.make`` takes it; the smaller one counts.
        num_threads: Threads that share the worlds.
        render_mode: ``"rgb_array"``: a frame is drawn only where ``render`` is called, ``render("human")`` shows it.
            ``"human"``: each step shows the worlds in a window, sixteen at most. Or None.
        strict: False ignores unused keys with an ``IgnoredKeyWarning``; True raises an error.
        **parameters: Values for the scenario's parameters.

    Raises:
        UnknownKeywordError: A batch does not take an argument; the message names what does.
    """
    asked = {"task": task, "max_steps": max_steps, "max_episode_steps": max_episode_steps, **parameters}
    shown: dict[str, Any] = {"render_mode": checked_mode(render_mode), "strict": strict}
    named: dict[str, Any] = {"parameters": parameters, "worlds_are": "n_envs"}
    kwargs: dict[str, Any] = {"max_steps": max_steps, "outer_limit": max_episode_steps, "num_threads": num_threads}
    worlds = Worlds(scenario, n_envs, task=task, **named, **kwargs, **shown)
    env = WorldVecEnv(worlds, spec_of(scenario, {**asked, **shown}))
    if seed is not None:
        env.seed(seed)
    return env


class WorldVecEnv(NativeVecEnv):
    """Worlds of one scenario, each with one robot that learns.

    World ``w`` equals a ``WorldEnv`` that is reset with ``seed + w``, so that a training run gives the same weights as
    on a ``DummyVecEnv`` of these. An ended world restarts in the same step, and its info holds what the single
    environment tells, ``terminal_observation``, ``TimeLimit.truncated`` and the statistics ``episode`` of
    ``Monitor``; infos of the other worlds are empty. A ``VecMonitor`` around it is not needed.

    Args:
        worlds: The worlds.
        spec: What a single environment like one of them is made from.
    """

    def __init__(self, worlds: Worlds, spec: ScenarioSpec | None = None) -> None:
        self._returns: Floats = np.zeros(worlds.n_worlds)
        self._actions: NDArray[Any] | None = None
        self._action_shape = (worlds.n_worlds, *(worlds.action_space.shape or ()))
        self._all_begun = False
        views = [WorldView(worlds, w, spec=spec) for w in range(worlds.n_worlds)]
        super().__init__(worlds, views, worlds.observation_space, worlds.action_space)

    def reset(self) -> Observation:
        """Begin an episode in every world, with the seeds and options given before, which are then forgotten."""
        worlds = range(self.num_envs)
        self.worlds.begin(worlds, self._seeds, self._options, fresh_level)
        self._reset_seeds()
        self._reset_options()
        self._returns[:] = 0.0
        self._all_begun = True
        self.note_beginnings(np.arange(self.num_envs))
        return self.worlds.observation()

    def step_async(self, actions: NDArray[Any]) -> None:
        """Take the actions ``(n_envs, ...)`` for the next ``step_wait``."""
        rows = np.asarray(actions)
        if rows.shape != self._action_shape:
            raise ValueError(f"actions must have shape {self._action_shape}, got {rows.shape}")
        self._actions = rows[:, None]

    def step_wait(self) -> tuple[Observation, Rays, Flags, list[dict[str, Any]]]:
        """Advance all worlds by one step and restart those that end.

        Returns:
            Observations, rewards (float32), dones and infos; all fresh.
        """
        if not self._all_begun or self._actions is None:
            raise ResetNeeded("call reset() and step_async() before step_wait()")
        worlds = self.worlds
        worlds.step(self._actions)
        self._actions = None
        view = worlds.episodes.view
        reward = view.reward[:, 0]
        self._returns += reward
        dones: Flags = view.terminated[:, 0] | view.truncated[:, 0]
        infos = self.no_infos()
        ended = dones.nonzero()[0]
        rewards = reward.astype(np.float32)
        if len(ended):
            self._end(ended, infos)
        return worlds.observation(), rewards, dones, infos

    def _end(self, ended: Ints, infos: list[dict[str, Any]]) -> None:
        """Fill in the infos of worlds that have ended, and restart them."""
        worlds, view = self.worlds, self.worlds.episodes.view
        cut = (view.truncated[:, 0].take(ended) > view.terminated[:, 0].take(ended)).tolist()
        rows = zip(ended.tolist(), worlds.infos.rows(ended), worlds.observations_of(ended), cut, strict=True)
        for w, row, observation, truncated in rows:
            info = infos[w] = worlds.infos.of_row(row)
            info["terminal_observation"] = observation
            info["TimeLimit.truncated"] = truncated
            info["episode"] = self.episode(self._returns.item(w), info)
        self._returns[ended] = 0.0
        worlds.begin_next(ended)
        self.note_beginnings(ended)
