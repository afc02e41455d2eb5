"""Many worlds with many learners each, as arrays, for multi-agent trainers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Flags, Floats, Ints, Rays
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.envs.described.description import Description
from irsim_gym.envs.gymnasium.explained import ManyWorlds
from irsim_gym.envs.gymnasium.worlds import ScenarioSource, TaskSource, Worlds
from irsim_gym.envs.parts.level_options import fresh_level
from irsim_gym.envs.parts.spaces import Observation
from irsim_gym.envs.teams.batch_step import BatchStep
from irsim_gym.tasks.episodes.transition import Percepts

WORLD_LIMITS = 4
"""How many time limits a world lasts before it begins another level, where its agents are given new goals."""


def make_batch(
    scenario: ScenarioSource,
    num_envs: int = 1,
    *,
    task: TaskSource = None,
    max_steps: int | None = None,
    num_threads: int = 1,
    render_mode: str | None = None,
    autoreset: bool = True,
    respawn: bool = False,
    world_steps: int | None = None,
    team_state: bool = True,
    strict: bool = True,
    **parameters: object,
) -> Batch:
    """Make worlds in which all robots learn, for trainers that want arrays ``(n_worlds, n_agents, ...)``.

    Args:
        scenario: Name of a shipped scenario, id, path of a YAML file, plain data or a loaded scenario.
        num_envs: Number of worlds.
        task: Name of a shipped task, path, or plain data; None for the scenario's own. Without ``agents`` in it, all
            robots learn.
        max_steps: Time limit of an agent [steps]; None for the task's.
        num_threads: Threads that share the worlds.
        render_mode: ``"rgb_array"``, ``"rgb_array_list"``, ``"human"`` or None, see ``Batch.render``.
        autoreset: A world whose agents have all ended begins its next level in the same step.
        respawn: An agent that has ended gets a new start and goal at once; its world continues.
        world_steps: With ``respawn``, steps after which a world begins its next level; None for four time limits.
        team_state: Steps hold the state of the team too, for a centralised critic.
        strict: False ignores unused keys with an ``IgnoredKeyWarning``; True raises an error.
        **parameters: Values for the scenario's parameters, e.g. ``n_robots=8``.
    """
    worlds = Worlds(
        scenario,
        num_envs,
        task=task,
        max_steps=max_steps,
        num_threads=num_threads,
        render_mode=render_mode,
        team=True,
        parameters=parameters,
        strict=strict,
    )
    return Batch(worlds, autoreset=autoreset, respawn=respawn, world_steps=world_steps, team_state=team_state)


class Batch(ManyWorlds):
    """Worlds of one scenario whose agents have episodes of their own; see ``make_batch``.

    World ``w`` that is reset with seed ``s`` begins level ``s + w``. When agents end, wait and begin again is written
    down here alone; the environments for Stable-Baselines3 stand on it.

    Args:
        worlds: The worlds.
        autoreset: Restart worlds by themselves once all their agents have ended.
        respawn: An agent that has ended begins anew while its world goes on.
        world_steps: With ``respawn``, steps after which a world restarts; None for four time limits.
        team_state: Add the state of the team, for a centralised critic.

    Attributes:
        n_worlds: Their number.
        n_agents: Learners in each world.
        agent_names: Names of the learners, in the order of the agent axis.
        reward_names: Names of the reward terms, in the order of the last axis of ``BatchStep.reward_terms``.
        observation_space: Of one agent; robots of different drives share it.
        action_space: Of one agent.
        state_size: Length of the state of the team; 0 where it was left out.
        returns: Sum of the rewards of each agent's episode so far, ``(n_worlds, n_agents)``.
        last_seen: What each agent perceived last in the latest of its episodes that has ended, zeros before.

    Raises:
        ValueError: ``respawn`` without ``autoreset``, or ``world_steps`` without ``respawn`` or below 1.
        IrsimGymError: ``respawn`` with a task whose arrivals wait for the team.
    """

    def __init__(
        self,
        worlds: Worlds,
        *,
        autoreset: bool = True,
        respawn: bool = False,
        world_steps: int | None = None,
        team_state: bool = False,
    ) -> None:
        if respawn and not autoreset:
            raise ValueError("with respawn=True, agents restart by themselves, so autoreset=False has no effect")
        if world_steps is not None and (not respawn or world_steps < 1):
            raise ValueError(f"world_steps is for agents that respawn and must be >= 1, got {world_steps!r}")
        if respawn and worlds.episodes.waits:
            raise IrsimGymError("agents that restart one by one cannot wait: omit respawn, or set wait: false")
        self.worlds = worlds
        self.autoreset, self.respawn = autoreset, respawn
        self.world_steps = world_steps or WORLD_LIMITS * worlds.episodes.task.max_steps
        self.n_worlds, self.n_agents = worlds.n_worlds, worlds.episodes.n_agents
        self.agent_names, self.reward_names = worlds.agent_names, worlds.episodes.reward_names
        self.state_size = worlds.episodes.team_state_size if team_state else 0
        self.observation_space, self.action_space = worlds.observation_space, worlds.action_space
        shape = (self.n_worlds, self.n_agents)
        self._live: Flags = np.zeros(shape, np.bool_)
        self.last_seen: Percepts = worlds.episodes.view.percepts.each(np.zeros_like)
        self.returns: Floats = np.zeros(shape)
        self._age: Ints = np.zeros(self.n_worlds, np.int64)

    @property
    def render_mode(self) -> str | None:
        """How the worlds are shown."""
        return self.worlds.render_mode

    @property
    def live(self) -> Flags:
        """The agents whose episodes are under way, ``(n_worlds, n_agents)``."""
        return self._live.copy()

    def reset(
        self, seed: int | Sequence[int | None] | None = None, options: Mapping[str, object] | None = None
    ) -> BatchStep:
        """Begin an episode in every world.

        Args:
            seed: World ``w`` begins level ``seed + w``; a sequence holds one seed, or None, for each world; None goes
                on with the next levels.
            options: ``{"split": "test", "level": 17}`` begins this level in all worlds.

        Raises:
            ValueError: There are more or fewer seeds than worlds.
        """
        if seed is None or isinstance(seed, int | np.integer):
            seeds = [None if seed is None else int(seed) + w for w in range(self.n_worlds)]
        else:
            seeds = list(seed)
            if len(seeds) != self.n_worlds:
                raise ValueError(f"seeds must hold one for each of the {self.n_worlds} worlds, got {len(seeds)}")
        return self.begin(seeds, [options or {}] * self.n_worlds)

    def begin(self, seeds: Sequence[int | None], options: Sequence[Mapping[str, object]]) -> BatchStep:
        """Begin an episode in every world, with ``seeds`` and ``options`` for each, see ``reset``."""
        self.worlds.begin(range(self.n_worlds), seeds, options, fresh_level)
        return self._beginning(np.arange(self.n_worlds))

    def restart(self, chosen: Ints) -> BatchStep:
        """Begin the next level of the worlds ``chosen``, indices ``(n,)``: what to do with ``autoreset=False``.

        Raises:
            ResetNeeded: One of them has not begun an episode.
            ValueError: They are no indices, such as a mask.
        """
        chosen = np.asarray(chosen)
        if chosen.size and (chosen.ndim != 1 or chosen.dtype.kind not in "iu"):
            raise ValueError(f"restart takes the indices of worlds, got {chosen.dtype} of shape {chosen.shape}")
        chosen = chosen.astype(np.int64).ravel()
        if not self.worlds.begun[chosen].all():
            raise ResetNeeded("call reset() before restart()")
        self.worlds.begin_next(chosen)
        return self._beginning(chosen)

    def step(self, actions: NDArray[Any]) -> BatchStep:
        """Advance all worlds by one step; agents and worlds restart as the arguments of the batch say.

        Args:
            actions: In [-1, 1], ``(n_worlds, n_agents, n_components)``; discrete: whole numbers,
                ``(n_worlds, n_agents)``. Those of agents that are not live do nothing, but must be finite.

        Raises:
            ResetNeeded: A world has not begun an episode.
            ValueError: The actions have a wrong shape or are not finite.
        """
        reward, terminated, truncated, acted = self.advance(actions)
        terms, infos = self.worlds.episodes.view.reward_terms.copy(), self._infos()
        final, final_state = self.observation(), self.state()
        began = self.begin_again(terminated | truncated)
        return BatchStep(
            observation=self.observation(),
            reward=reward,
            terminated=terminated,
            truncated=truncated,
            acted=acted,
            live=self.live,
            began=began,
            final_observation=final,
            reward_terms=terms,
            infos=infos,
            state=self.state(),
            final_state=final_state,
        )

    def advance(self, actions: NDArray[Any]) -> tuple[Floats, Flags, Flags, Flags]:
        """Do the first half of ``step``: advance all worlds, and restart nothing.

        Args:
            actions: As for ``step``, shape ``(n_worlds, n_agents, n_components)``, or ``(n_worlds, n_agents)`` if they
                are discrete.

        Returns:
            ``reward``, ``terminated``, ``truncated`` and ``acted`` of ``BatchStep``, of shape ``(n_worlds, n_agents)``,
            all fresh. ``begin_again`` has to follow.

        Raises:
            ResetNeeded: The worlds have not begun an episode.
        """
        if not self.worlds.begun.all():
            raise ResetNeeded("call reset() before step()")
        self.worlds.step(np.asarray(actions))
        view, acted = self.worlds.episodes.view, self.live
        self._age += 1
        reward = np.where(acted, view.reward, 0.0)
        self.returns += reward
        terminated, truncated = acted & view.terminated, acted & view.truncated & ~view.terminated
        if self.respawn:
            truncated |= (self._age >= self.world_steps)[:, None] & ~terminated
        return reward, terminated, truncated, acted

    def observation(self) -> Observation:
        """Return a fresh copy of what the agents perceive now."""
        view, layout = self.worlds.episodes.view, self.worlds.layout
        if self._live.all():
            return layout.fresh(view)
        seen = view.percepts.each(np.ndarray.copy)
        seen.overwrite(~self._live, self.last_seen)
        return layout.formed(seen)

    def state(self) -> Rays:
        """Return what a centralised critic sees now, fresh, ``(n_worlds, state_size)``."""
        if not self.state_size:
            return np.zeros((self.n_worlds, 0), np.float32)
        return self.worlds.episodes.team_state()

    def describe(self, agent: str | None = None) -> Description:
        """Return what observations, actions, rewards, endings and infos mean to an agent; it prints as tables.

        Args:
            agent: Its name; the first by default. The description names those that observe and act alike.

        Raises:
            UnknownNameError: There is no such agent.
        """
        return self.worlds.describe(agent or 0)

    def close(self) -> None:
        """Close the window and free the renderer; may be called twice."""
        self.worlds.close()

    def begin_again(self, ended: Flags) -> Flags:
        """Do the second half of ``step``: begin levels and episodes where they are due.

        Args:
            ended: The agents whose episodes have ended in this step, ``(n_worlds, n_agents)``.

        Returns:
            The agents that begin an episode, of the same shape.
        """
        if ended.any():
            self.last_seen.overwrite(ended, self.worlds.episodes.view.percepts)
            self._live &= ~ended
        over = self._age >= self.world_steps if self.respawn else ~self._live.any(axis=1) & self.autoreset
        began: Flags = np.zeros_like(ended)
        if over.any():
            chosen = np.flatnonzero(over)
            self.worlds.begin_next(chosen)
            self._age[chosen] = 0
            began[chosen] = True
        respawned = ended & ~began
        if self.respawn and respawned.any():
            self.worlds.respawn(respawned)
            began |= respawned
        self._open(began)
        return began

    def note_beginnings(self, chosen: Ints) -> Flags:
        """Note that worlds ``chosen``, ``(n,)``, begin a level; return who begins in them, ``(n_worlds, n_agents)``."""
        began = np.zeros((self.n_worlds, self.n_agents), np.bool_)
        began[chosen] = True
        self._age[chosen] = 0
        self._open(began)
        return began

    def _beginning(self, chosen: Ints) -> BatchStep:
        """Return what a reset gives to the chosen worlds, in which no agent has acted yet."""
        began = self.note_beginnings(chosen)
        none = np.zeros_like(began)
        return BatchStep(
            observation=self.observation(),
            reward=np.zeros(began.shape),
            terminated=none,
            truncated=none.copy(),
            acted=none.copy(),
            live=self.live,
            began=began,
            final_observation=self.observation(),
            reward_terms=np.zeros_like(self.worlds.episodes.view.reward_terms),
            infos=self._infos(),
            state=self.state(),
            final_state=self.state(),
        )

    def _open(self, began: Flags) -> None:
        """Open the books of agents that begin."""
        if not began.any():
            return
        self._live |= began
        self.returns[began] = 0.0

    def _infos(self) -> dict[str, NDArray[Any]]:
        infos = {key: values.copy() for key, values in self.worlds.episodes.view.infos.items()}
        infos["episode_return"] = self.returns.copy()
        return infos
