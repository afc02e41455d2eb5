"""Episodes of a task in many worlds: act, step, end, pay, observe."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import Ints, Rays
from irsim_gym.engine import Shard, Simulation
from irsim_gym.families import ACTIONS, ENDINGS, OBSERVATIONS, REWARDS
from irsim_gym.registry import Registry
from irsim_gym.rng import stream_base
from irsim_gym.tasks import account, actions
from irsim_gym.tasks.levels import check_split, take_levels
from irsim_gym.tasks.outcome import PRECEDENCE
from irsim_gym.tasks.state import EpisodeState
from irsim_gym.tasks.task import Task
from irsim_gym.tasks.term import HasArrays, MindsClearance, Remembers, Term
from irsim_gym.tasks.transition import transition_of
from irsim_gym.world.model import OMNI_WORLD


class Episodes:
    """A task played in all worlds of a simulation; every world has its own episode.

    Nothing restarts by itself: ``begin`` and ``begin_next`` say where an episode begins. An agent whose episode has
    ended is told to stand still, is paid nothing more and keeps its flags until its world begins again.

    Attributes:
        simulation: The worlds, compiled with ``agents=task.agents``.
        task: What is learned.
        state: What the task remembers.
        view: The latest transition.
        observation_terms: Name, least and greatest values of each part of the observation, in order.
        reward_names: Names of the reward terms, in order.
    """

    def __init__(self, simulation: Simulation, task: Task) -> None:
        if tuple(simulation.agents) != task.agents:
            raise ValueError(f"the simulation commands bodies {tuple(simulation.agents)}, the task {task.agents}")
        self.simulation = simulation
        self.task = task
        self._agents = np.array(task.agents, np.int64)
        self._size = len(simulation.scenario.bodies[task.agents[0]].kinematics.command_names)
        is_turned = simulation.model.drive[self._agents] == OMNI_WORLD
        self._turned = self._agents[is_turned & (getattr(task.action, "frame", "command") == "body")]
        self._action = self._bind(ACTIONS, [task.action])[0]
        self._observations = self._bind(OBSERVATIONS, task.observations)
        self._rewards = self._bind(REWARDS, task.rewards)
        by_precedence = sorted(task.endings, key=lambda ending: PRECEDENCE.index(ending.outcome))
        self._endings = self._bind(ENDINGS, by_precedence)
        self._outcomes = np.array([int(term.options.outcome) for term in self._endings], np.int64)
        terms = [*self._observations, *self._rewards]
        self._minded_clearance = max(
            (term.options.clearance_range for term in terms if isinstance(term.options, MindsClearance)), default=0.0
        )
        self._remembering = [term for term in terms if isinstance(term.options, Remembers)]
        self.observation_terms = self._place_observations()
        self.reward_names = tuple(term.name for term in self._rewards)
        self.state = self._allocate()
        self.state.base[:] = stream_base(simulation.scenario.name, "train")
        self.view = transition_of(self.state)
        self._given: NDArray[Any] = self.state.choice if self.n_discrete else self.state.given

    @property
    def n_worlds(self) -> int:
        """Number of worlds."""
        return self.simulation.n_worlds

    @property
    def n_agents(self) -> int:
        """Number of learners in each world."""
        return len(self._agents)

    @property
    def n_features(self) -> int:
        """Length of the flat observation."""
        return sum(len(low) for _, low, _ in self.observation_terms)

    @property
    def action_kind(self) -> Literal["continuous", "discrete"]:
        """Whether an action is a vector in [-1, 1] or a choice."""
        return "discrete" if self.n_discrete else "continuous"

    @property
    def n_discrete(self) -> int:
        """Number of choices of a discrete action, 0 for a continuous one."""
        return int(self.task.action.n_choices)

    @property
    def action_low(self) -> Rays:
        """Least values of a continuous action, shape ``(n_components,)``."""
        return np.full(self._size, -1.0, np.float32)

    @property
    def action_high(self) -> Rays:
        """Greatest values of a continuous action, shape ``(n_components,)``."""
        return np.ones(self._size, np.float32)

    def begin(self, worlds: Ints, levels: Ints, split: str = "train") -> None:
        """Begin a level in some worlds; later ones of these worlds follow from it, within the same split.

        Args:
            worlds: Indices of the worlds, shape ``(n,)``.
            levels: Level of each, >= 0, shape ``(n,)``.
            split: ``train``, ``dev`` or ``test``.

        Raises:
            UnknownNameError: There is no such split.
            PlacementError: A level could not be drawn.
        """
        check_split(split)
        worlds, levels = np.asarray(worlds, np.int64), np.asarray(levels, np.int64)
        if worlds.shape != levels.shape:
            raise ValueError(f"worlds and levels must have the same length, got {worlds.shape} and {levels.shape}")
        if (levels < 0).any():
            raise ValueError(f"levels must be >= 0, got {levels.min()}")
        self.state.base[worlds] = stream_base(self.simulation.scenario.name, split)
        self.state.first_level[worlds] = levels
        self.state.episode[worlds] = 0
        self.simulation.run(self._begin, worlds)

    def begin_next(self, worlds: Ints) -> None:
        """Begin the next level of each world's chain.

        Args:
            worlds: Indices of the worlds, shape ``(n,)``; each has begun a level before.

        Raises:
            PlacementError: A level could not be drawn.
        """
        worlds = np.asarray(worlds, np.int64)
        self.state.episode[worlds] += 1
        self.simulation.run(self._begin, worlds)

    def step(self, given: NDArray[Any], worlds: Ints | None = None) -> None:
        """Play one step.

        Args:
            given: Actions in [-1, 1], shape ``(n_worlds, n_agents, n_components)``; discrete: whole numbers, shape
                ``(n_worlds, n_agents)``.
            worlds: Only these worlds; all by default. Actions of other worlds are not looked at.

        Raises:
            ValueError: An action has the wrong shape or type, is not finite or is no choice; nothing has moved then.
        """
        self._take(given, worlds)
        self.simulation.run(self._step, worlds)

    def _take(self, given: NDArray[Any], worlds: Ints | None) -> None:
        """Check the actions, and copy them."""
        if given.shape != self._given.shape:
            raise ValueError(f"actions must have shape {self._given.shape}, got {given.shape}")
        kinds = "iu" if self.n_discrete else "fiu"
        if given.dtype.kind not in kinds:
            wanted = "whole numbers" if self.n_discrete else "numbers"
            raise ValueError(f"actions must be {wanted}, got an array of {given.dtype}")
        np.copyto(self._given, given, casting="unsafe")
        for shard in self.simulation.shards.all if worlds is None else (Shard(worlds),):
            if self.n_discrete and not actions.all_within(shard.worlds, self.n_discrete, self._given):
                raise ValueError(f"an action is not a choice from 0 to {self.n_discrete - 1}")
            if not self.n_discrete and not actions.all_finite(shard.worlds, self._given):
                raise ValueError("an action is not finite")

    def _begin(self, shard: Shard) -> None:
        """Draw the levels of the shard's worlds and begin their episodes."""
        simulation, state, worlds = self.simulation, self.state, shard.worlds
        take_levels(worlds, state.base, state.first_level, state.episode, state.level, state.stream)
        simulation.begin(shard, state.stream)
        simulation.clearance(shard, self._agents, state.clearance)
        model = simulation.model
        actions.rest(worlds, self._agents, model.velocity_min, model.velocity_max, state.action, state.previous_action)
        account.open_books(
            worlds,
            self._agents,
            simulation.state.pose,
            simulation.state.goal_distance,
            state.clearance,
            state.position,
            state.min_clearance,
            state.path_length,
            state.goal_distance,
            state.steps,
            state.hit,
            state.outcome,
            state.success,
            state.over,
            state.terminated,
            state.truncated,
            state.reward_term,
            state.reward,
        )
        for term in self._remembering:
            term.options.begin(term, model, simulation.state, state, shard)
        self._observe(shard)

    def _step(self, shard: Shard) -> None:
        """Play one step in the shard's worlds. This order is the specification."""
        simulation, model, world, state = self.simulation, self.simulation.model, self.simulation.state, self.state
        self._act(shard)
        simulation.advance(shard)
        account.limit_clearance(shard.worlds, self._minded_clearance, state.min_clearance, state.clearance)
        simulation.clearance(shard, self._agents, state.clearance, limit=state.clearance)
        self._keep_books(shard)
        for term in self._endings:
            term.options.ends(term, model, world, state, shard)
        account.settle(
            shard.worlds,
            self._outcomes,
            self.task.max_steps,
            state.ending,
            state.over,
            state.steps,
            state.outcome,
            state.success,
            state.terminated,
            state.truncated,
        )
        for term in self._rewards:
            term.options.pay(term, model, world, state, shard)
        account.add_up(shard.worlds, state.over, state.reward_term, state.reward)
        self._observe(shard)

    def _act(self, shard: Shard) -> None:
        model, state = self.simulation.model, self.state
        self._action.options.act(self._action, model, self.simulation.state, state, shard)
        actions.command(
            shard.worlds,
            self._agents,
            model.velocity_min,
            model.velocity_max,
            state.outcome,
            state.action,
            self.simulation.state.command,
        )
        if len(self._turned):
            actions.turn_commands(shard.worlds, self._turned, self.simulation.state.pose, self.simulation.state.command)

    def _keep_books(self, shard: Shard) -> None:
        world, state = self.simulation.state, self.state
        account.keep_books(
            shard.worlds,
            self._agents,
            world.pose,
            world.goal_distance,
            world.hit,
            state.clearance,
            state.outcome,
            state.position,
            state.min_clearance,
            state.path_length,
            state.goal_distance,
            state.steps,
            state.hit,
            state.over,
        )

    def _observe(self, shard: Shard) -> None:
        for term in self._observations:
            term.options.write(term, self.simulation.model, self.simulation.state, self.state, shard)

    def _bind(self, family: Registry, options: Sequence[Any]) -> list[Term]:
        """Return the terms of kinds, with their own arrays; the column is the place in the list."""
        terms = []
        for column, item in enumerate(options):
            term = Term(family.name_of(type(item)), item, self._agents, self.task.max_steps, self._size, column)
            if isinstance(item, HasArrays):
                term.arrays = item.arrays(self.simulation, self._agents)
            terms.append(term)
        return terms

    def _place_observations(self) -> tuple[tuple[str, Rays, Rays], ...]:
        """Give each part of the observation its columns, and return names and bounds."""
        parts, column = [], 0
        for term in self._observations:
            term.column = column
            low, high = term.options.bounds(term, self.simulation.model)
            parts.append((term.name, low, high))
            column += len(low)
        return tuple(parts)

    def _allocate(self) -> EpisodeState:
        return EpisodeState.allocate(
            {
                "world": self.n_worlds,
                "agent": self.n_agents,
                "action": self._size,
                "ending": len(self._endings),
                "reward": len(self._rewards),
                "feature": self.n_features,
            }
        )
