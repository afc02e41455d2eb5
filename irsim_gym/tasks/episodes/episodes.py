"""Episodes of a task in many worlds: act, step, end, pay, observe."""

from dataclasses import replace
from itertools import chain
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.families import ACTIONS, ENDINGS, OBSERVATIONS, REWARDS
from irsim_gym.simulator.engine.shielding import lay_shield
from irsim_gym.simulator.running.direct import Direct
from irsim_gym.simulator.world.names import OMNI_WORLD, Flags, Ints, Model, Rays
from irsim_gym.simulator.world.state import State as WorldState
from irsim_gym.tasks.actions import commands
from irsim_gym.tasks.definition.task import Task, checked_limit
from irsim_gym.tasks.endings.arrived import Arrived
from irsim_gym.tasks.episodes import account, team_state
from irsim_gym.tasks.episodes.binding import action_sizes, bind, hit_kinds, place_observations
from irsim_gym.tasks.episodes.levels import CHAIN, check_split, take_levels
from irsim_gym.tasks.episodes.prediction import Predictor
from irsim_gym.tasks.episodes.transition import transition_of
from irsim_gym.tasks.terms import EpisodeState, Shard, Simulation
from irsim_gym.tasks.terms.episode_state import EXTRAS
from irsim_gym.tasks.terms.outcome import PRECEDENCE
from irsim_gym.tasks.terms.term import IsImage, MindsClearance, Remembers, Term, is_paid_on_the_way


class Episodes:
    """A task played in all worlds of a simulation; each world has its own episode.

    Nothing restarts automatically: ``begin`` and ``begin_next`` start episodes. An agent whose episode has ended is
    commanded to stand still, gets reward 0 and keeps its flags until its world restarts.

    Attributes:
        simulation: The worlds, compiled with ``agents=task.agents``.
        task: The task.
        waits: Whether agents that have arrived drive on until their team has.
        state: The state of the episodes.
        view: The latest transition.
        observation_terms: Name, lower and upper bounds of each part of the observation, in order; images have no
            columns and are only in ``view.percepts``.
        reward_names: Names of the reward terms, in order.
        extra_names: Names of the infos that only this task has, in order.
        agent_names: Names of the agents' bodies, in order.
        action_sizes: Number of components of each agent's actions, shape ``(n_agents,)``; further ones are ignored.
        feature_mask: Columns of the observation that each agent has, shape ``(n_agents, n_features)``; the others are
            0.
        direct: Plays a step of all worlds in the caller's thread with less overhead; None for discrete commands.
    """

    def __init__(self, simulation: Simulation, task: Task) -> None:
        if tuple(simulation.agents) != task.agents:
            raise ValueError(f"the simulation's agents are {tuple(simulation.agents)}, the task {task.agents}")
        self.simulation = simulation
        self.task = task
        self.waits = any(isinstance(ending, Arrived) and ending.wait for ending in task.endings)
        self._agents = np.array(task.agents, np.int64)
        self.agent_names = tuple(simulation.parts.names[b] for b in task.agents)
        self.action_sizes = action_sizes(simulation, self._agents)
        self._size = int(self.action_sizes.max())
        is_turned = simulation.model.drive[self._agents] == OMNI_WORLD
        self._turned = self._agents[is_turned & (getattr(task.action, "frame", "command") == "body")]
        self._action = bind(ACTIONS, [task.action], simulation, task)[0]
        self._observations = bind(OBSERVATIONS, task.observations, simulation, task)
        self._predictor = Predictor(simulation, task) if task.predict else None
        if self._predictor is not None:
            self._predictor.show(self._observations)
        self._rewards = bind(REWARDS, task.rewards, simulation, task)
        by_precedence = sorted(task.endings, key=lambda ending: PRECEDENCE.index(ending.outcome))
        self._endings = bind(ENDINGS, by_precedence, simulation, task)
        self._shielding = None if task.shield is None else lay_shield(simulation, task.shield, self._agents)
        has = {"shield": task.shield is not None, "cost": task.near is not None}
        self.extra_names = tuple(name for name in EXTRAS if has[name])
        self._hit_kinds = hit_kinds(simulation)
        self._outcomes = np.array([int(term.options.outcome) for term in self._endings], np.int64)
        self._on_the_way = np.array([is_paid_on_the_way(reward) for reward in task.rewards], np.bool_)
        terms = [*self._observations, *self._rewards]
        minded = (term.options.clearance_range for term in terms if isinstance(term.options, MindsClearance))
        self._minded_clearance = max((*minded, task.near or 0.0))
        self._remembering = [term for term in terms if isinstance(term.options, Remembers)]
        self.observation_terms, self.feature_mask = place_observations(self._observations, simulation)
        self.reward_names = tuple(term.name for term in self._rewards)
        self.state = self._allocate()
        images = {term.name: term.image for term in self._observations if isinstance(term.options, IsImage)}
        self.view = transition_of(self.state, images, self.extra_names)
        self._given: NDArray[Any] = self.state.choice if self.n_discrete else self.state.given
        kinds = [type(term.options) for term in chain(*self.terms.values())]
        kinds += [] if task.shield is None else [type(task.shield)]
        levels = [group.kind for group in (*simulation.parts.footprints, *simulation.parts.placements)]
        self._play, self._begin_episodes = (simulation.fuse(run, kinds) for run in (self._step, self._begin_agents))
        self._begin = simulation.fuse(self._begin_levels, [*kinds, *levels])
        everything = self._play, simulation.shards.all[0].worlds, self.action_sizes, self.state.given
        self.direct = None if self.n_discrete else Direct(*everything)

    @property
    def terms(self) -> dict[str, list[Term]]:
        """The bound kinds of the task: ``action`` (one) and the lists of its other families, in order."""
        return {
            "action": [self._action],
            "observations": self._observations,
            "rewards": self._rewards,
            "endings": self._endings,
        }

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
        """Number of choices of a discrete action; 0 for a continuous one."""
        return int(self.task.action.n_choices)

    @property
    def action_low(self) -> Rays:
        """Lower bounds of a continuous action, shape ``(n_components,)``."""
        return np.full(self._size, -1.0, np.float32)

    @property
    def action_high(self) -> Rays:
        """Upper bounds of a continuous action, shape ``(n_components,)``."""
        return np.ones(self._size, np.float32)

    @property
    def team_state_size(self) -> int:
        """Length of a world's ``team_state``."""
        return team_state.WIDTH * self.n_agents

    def team_state(self, worlds: Ints | None = None) -> Rays:
        """Return the state of whole teams in [-1, 1], for a centralised critic.

        Args:
            worlds: Indices of the worlds, shape ``(n,)``; all by default.

        Returns:
            A fresh array of shape ``(n, team_state_size)``, ten numbers for each agent; see
            ``tasks/episodes/team_state.py``.
        """
        chosen = np.arange(self.n_worlds) if worlds is None else np.asarray(worlds, np.int64)
        return team_state.team_states(self.simulation, self._agents, self.state.outcome, chosen)

    def steps_to_arrival(self, worlds: Ints | int) -> Ints:
        """Return the steps that agents have taken, without those after an arrival.

        Args:
            worlds: Index of a world, or indices, shape ``(n,)``.

        Returns:
            Steps, shape ``(n_agents,)`` or ``(n, n_agents)``.
        """
        arrival = self.state.arrival[worlds]
        steps: Ints = np.where(arrival > 0, arrival, self.state.steps[worlds])
        return steps

    def limit(self, max_steps: int) -> None:
        """Set the time limit [steps]; rewards that are spread over an episode change with it."""
        self.task = replace(self.task, max_steps=checked_limit(max_steps))
        for term in chain(*self.terms.values()):
            term.max_steps = max_steps
        self._play.forget()
        self._begin_episodes.forget()
        self._begin.forget()

    def begin(self, worlds: Ints, levels: Ints, split: str = "train") -> None:
        """Begin a level in some worlds; it determines later levels of these worlds, within the same split.

        Args:
            worlds: Indices of the worlds, shape ``(n,)``.
            levels: Level of each, >= 0, shape ``(n,)``.
            split: ``train``, ``dev`` or ``test``.

        Raises:
            UnknownNameError: If there is no such split.
            PlacementError: If a level cannot be drawn.
        """
        check_split(split)
        worlds, levels = np.asarray(worlds, np.int64), np.asarray(levels, np.int64)
        if worlds.shape != levels.shape:
            raise ValueError(f"worlds and levels must have the same length, got {worlds.shape} and {levels.shape}")
        if (levels < 0).any():
            raise ValueError(f"levels must be >= 0, got {levels.min()}")
        self.state.base[worlds], self.state.count[worlds] = self.simulation.level_base(split)
        self.state.first_level[worlds] = levels
        self.state.episode[worlds], self.state.chosen[worlds] = 0, CHAIN
        self.simulation.run_beginning(self._begin, worlds)

    def begin_next(self, worlds: Ints) -> None:
        """Begin the next level of some worlds: the chosen one, else the next one in the world's chain.

        Args:
            worlds: Indices of the worlds, shape ``(n,)``; each has begun a level before.

        Raises:
            PlacementError: If a level cannot be drawn.
        """
        worlds = np.asarray(worlds, np.int64)
        self.state.episode[worlds] += 1
        self.simulation.run_beginning(self._begin, worlds)

    def choose(self, worlds: Ints, levels: Ints) -> None:
        """Choose the level of the next ``begin_next`` in some worlds; ``begin`` discards the choice.

        Args:
            worlds: Indices of the worlds, shape ``(n,)``; each has begun a level before.
            levels: Level of each, in the world's split; -1 for the next one in its chain. Shape ``(n,)``.
        """
        self.state.chosen[worlds] = levels

    def respawn(self, agents: Flags) -> None:
        """Give agents a new start and goal in their running worlds, and begin new episodes for them.

        The distribution of their entry draws their starts from the world's random stream, clear of all bodies; if that
        leaves no room, they start anywhere in the world. Sensors and observations of all agents of these worlds are
        updated.

        Args:
            agents: Flags of the agents, shape ``(n_worlds, n_agents)``.

        Raises:
            ValueError: If ``agents`` has another shape.
            PlacementError: If there is no room for an agent.
        """
        chosen = np.asarray(agents, np.bool_)
        if chosen.shape != self.state.began.shape:
            raise ValueError(f"agents must have shape {self.state.began.shape}, got {chosen.shape}")
        worlds = np.flatnonzero(chosen.any(axis=1))
        if len(worlds):
            self.state.began[:] = chosen
            self.simulation.run(self._respawn, worlds)

    def _respawn(self, shard: Shard) -> None:
        self.simulation.respawn(shard, self._agents, self.state.began)
        self._begin_episodes(shard)

    def step(self, actions: NDArray[Any], worlds: Ints | None = None) -> None:
        """Play one step.

        Args:
            actions: Actions in [-1, 1], shape ``(n_worlds, n_agents, n_components)``; discrete: whole numbers, shape
                ``(n_worlds, n_agents)``.
            worlds: Indices of the worlds to step; all by default. Actions of other worlds are ignored.

        Raises:
            ValueError: If an action has the wrong shape or type, or an invalid value; then no body moves.
        """
        shards, direct = self.simulation.shards, self.direct if worlds is None else None
        if (
            direct is not None
            and actions.shape == self._given.shape
            and shards.is_alone(self._play, self.n_worlds)
            and direct.run(actions.reshape(-1))
        ):
            return
        rows = shards.all[0].worlds if worlds is None else worlds
        commands.take(actions, rows, self.n_discrete, self.action_sizes, self._given)
        self.simulation.run(self._play, worlds)

    def _begin_levels(self, shard: Shard) -> None:
        """Draw the levels of the shard's worlds and begin their episodes."""
        simulation, state, worlds = self.simulation, self.state, shard.worlds
        take_levels(worlds, state)
        simulation.begin(shard, state.stream)
        account.mark(worlds, True, state.began)
        self._begin_episodes(shard)

    def _begin_agents(self, shard: Shard) -> None:
        """Begin the episodes of the agents that ``state.began`` flags, at their bodies' present poses."""
        simulation, model, state, worlds = self.simulation, self.simulation.model, self.state, shard.worlds
        simulation.clearance(shard, self._agents, state.clearance)
        commands.rest(worlds, self._agents, model, state)
        account.begin_episodes(worlds, self._agents, simulation.state, state)
        for term in self._remembering:
            term.options.begin(term, *self._known_to(term), state, shard)
        self._observe(shard)
        account.mark(worlds, False, state.began)

    def _step(self, shard: Shard) -> None:
        """Play one step in the shard's worlds; this method defines the order of a step."""
        simulation, model, world, state = self.simulation, self.simulation.model, self.simulation.state, self.state
        # Flags are those of the step before: learners have seen the end of their episode, then the body goes.
        if self.task.ended == "vanish":
            account.note_ended(shard.worlds, state)
            simulation.vanish(shard, self._agents, state.over)
        self._act(shard)
        simulation.advance(shard)
        # Exact as far as a term asks for it, or a new minimum needs it; ``clearance`` serves as its own limit.
        account.limit_clearance(shard.worlds, self._minded_clearance, state)
        simulation.clearance(shard, self._agents, state.clearance, limit=state.clearance)
        self._record_step(shard)
        for term in self._endings:
            term.options.ends(term, model, world, state, shard)
        account.decide_outcomes(shard.worlds, self._outcomes, self.task.max_steps, state)
        if simulation.told is not world:
            account.find_misplaced(shard.worlds, self._agents, model, world, simulation.told, state)
        if self.waits:
            account.hold_arrivals(shard.worlds, state)
        for term in self._rewards:
            term.options.pay(term, model, world, state, shard)
        if self.waits:
            account.settle_arrivals(shard.worlds, self._on_the_way, state)
        if self.task.team_reward > 0.0 and self.n_agents > 1:
            account.share_rewards(shard.worlds, self.task.team_reward, state)
        account.sum_rewards(shard.worlds, state)
        self._observe(shard)

    def _act(self, shard: Shard) -> None:
        model, state = self.simulation.model, self.state
        term = self._action
        term.options.act(term, model, self.simulation.state, state, shard)
        commands.write_commands(shard.worlds, self._agents, model, self.simulation.state, state)
        if len(self._turned):
            commands.turn_commands(shard.worlds, self._turned, self.simulation.state)
        if self._shielding is not None:
            self._shielding.act(self.simulation, shard)
            account.count_shielded(shard.worlds, self._shielding.acted, self.extra_names.index("shield"), state)

    def _record_step(self, shard: Shard) -> None:
        world, state = self.simulation.state, self.state
        account.record_step(shard.worlds, self._agents, world, state, self._hit_kinds)
        task, model = self.task, self.simulation.model
        account.measure_standstill(
            shard.worlds, self._agents, model, world, state, task.deadlock_speed, task.deadlock_time
        )
        if self.task.near is not None:
            account.note_cost(shard.worlds, self.task.near, self.extra_names.index("cost"), state)

    def _observe(self, shard: Shard) -> None:
        if self._predictor is not None:
            self._predictor.look_ahead(self.state, shard)
        for term in self._observations:
            model, state = self._known_to(term)
            if self._predictor is not None:
                state = self._predictor.state
            term.options.write(term, model, state, self.state, shard)

    def _known_to(self, term: Term) -> tuple[Model, WorldState]:
        """Return what a term reads: for observations, except those of true bodies, what the robot knows."""
        needs = getattr(term.options, "needs", ("bodies",)) or ()
        sees_bodies = "bodies" in needs and "map_frame" not in needs
        simulation = self.simulation
        return (simulation.model, simulation.state) if sees_bodies else (simulation.known, simulation.told)

    def _allocate(self) -> EpisodeState:
        sizes = {"world": self.n_worlds, "agent": self.n_agents, "action": self._size, "ending": len(self._endings)}
        sizes |= {"reward": len(self._rewards), "extra": len(self.extra_names), "feature": self.n_features}
        return EpisodeState.allocate(sizes)
