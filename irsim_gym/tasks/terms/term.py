"""The interface of the kinds of a task: how they are bound to a simulation and called.

Each kind is called with the same five arguments: its ``Term``, the ``Model``, the ``State``, the
``EpisodeState`` that it writes into, and the ``Shard`` with the worlds to treat.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Bytes, Flags, Ints, Rays
from irsim_gym.simulator.engine import Shard, Simulation
from irsim_gym.simulator.world.group import Group, records
from irsim_gym.simulator.world.names import Model, State, Struct, kernel, kind
from irsim_gym.tasks.terms.episode_state import EpisodeState
from irsim_gym.tasks.terms.outcome import Ended, Outcome


@dataclass
class Bound(Struct):
    """The part of a term that kernels read.

    Attributes:
        agents: Body of each agent, shape ``(n_agents,)``.
        column: Column that the term writes.
        options: Its numeric options as one record, shape ``(1,)``; see ``simulator.world.group.records``.
    """

    agents: Ints
    column: int
    options: Any


Role = Literal["potential", "bonus", "penalty", "running"]
Words = tuple[tuple[str, str], ...]
AHEAD_AND_LEFT: Words = (("speed ahead", "m/s"), ("speed to the left", "m/s"))


@dataclass
class Term:
    """A kind of a task, bound to a simulation.

    Attributes:
        name: YAML name of the kind.
        options: The kind's instance.
        agents: Body of each agent, shape ``(n_agents,)``.
        max_steps: Steps of a full episode.
        action_size: Number of components of an action, and of its command; the maximum over all agents.
        action_sizes: The same for each agent, shape ``(n_agents,)``; further components are unused.
        column: Column that the term writes: the first one of the observation, or that of the reward or ending.
        arrays: The term's own arrays: tables, memory, live readings of sensors; a dict, or a struct for kernels.
        components: For each agent, the meaning and unit of the components of its action after mapping to its limits:
            ``(("speed ahead", "m/s"), ...)``.
        bodies: The agents as a group, for views of them (``bodies.behaviors.python.views``).
        image: Output of an image observation, ``(n_worlds, n_agents, height, width, n_channels)``; empty for other
            terms.
        bounds: Lower and upper bound of each column of an observation, ``(width,)`` each; empty for other terms.
        measured: The state as it is, for observations that are called with a predicted one; else None.
    """

    name: str
    options: Any
    agents: Ints
    max_steps: int
    action_size: int
    action_sizes: Ints
    column: int = 0
    arrays: Any = field(default_factory=dict)
    components: tuple[Words, ...] = ()
    bodies: Group | None = None
    image: Bytes = field(default_factory=lambda: np.zeros((0, 0, 0, 0, 0), np.uint8))
    bounds: tuple[Rays, Rays] = field(default_factory=lambda: (np.zeros(0, np.float32), np.zeros(0, np.float32)))
    measured: State | None = None

    @cached_property
    def bound(self) -> Bound:
        """The part of the term that kernels read; requires a known column."""
        return Bound(self.agents, self.column, records([self.options]))


@runtime_checkable
class HasArrays(Protocol):
    """A kind with its own arrays."""

    def arrays(self, simulation: Simulation, agents: Ints) -> dict[str, NDArray[Any]] | Struct:
        """Return the value of ``Term.arrays``: arrays of any shapes.

        Args:
            simulation: The worlds.
            agents: Body of each agent, shape ``(n_agents,)``.
        """


@runtime_checkable
class Joins(Protocol):
    """A kind that may share memory with earlier terms of the same family."""

    def join(self, term: Term, earlier: Sequence[Term]) -> None:
        """Let ``term.arrays`` share memory with earlier terms."""


@runtime_checkable
class Remembers(Protocol):
    """A kind that needs the start of episodes."""

    @staticmethod
    def begin(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Prepare ``term.arrays`` for episodes that begin in the shard's worlds, for agents in ``episode.began``."""


@runtime_checkable
class HasUnused(Protocol):
    """An observation with elements that some agents do not have; these are 0."""

    def used(self, term: Term) -> Flags:
        """Return flags of the elements that each agent has, shape ``(n_agents, width)``."""


@runtime_checkable
class IsImage(Protocol):
    """An image observation: it writes ``Term.image``, and has neither bounds nor columns."""

    @property
    def image_shape(self) -> tuple[int, int, int]:
        """Height and width [pixels] and number of channels."""


@runtime_checkable
class MindsClearance(Protocol):
    """A kind that reads ``EpisodeState.clearance``."""

    @property
    def clearance_range(self) -> float:
        """Clearance up to which values must be exact [m]; larger ones may be any value not below it."""


Need = Literal["scan", "odometry", "map_frame", "grid", "bodies", "messages"]
Needs = tuple[Need, ...]
NEEDS: dict[Need, str] = {
    "scan": "a range sensor",
    "odometry": "its pose and velocity, in a frame that may drift",
    "map_frame": "its pose in the fixed frame of the world",
    "grid": "a map that it keeps of its own scans",
    "bodies": "the true state of other bodies",
    "messages": "what its team mates tell it",
}
"""What a robot must have, to observe what a kind observes."""
NEEDS_MEANING = f"what a robot must have for it, a tuple of some of {', '.join(NEEDS)}; None: not said"
NeedsGoal = Annotated[bool, "True if it means nothing for an agent without a goal, else False"]
Weight = Annotated[float, "write 'weight: float = option(1.0, ge=0.0, meaning=...)'"]


class ActionKind(Protocol):
    """Converts a learner's output to actions."""

    @property
    def n_choices(self) -> int:
        """Number of choices of a discrete action; 0 for a continuous one in [-1, 1]."""

    @staticmethod
    def act(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Convert ``episode.given`` or ``episode.choice`` to ``episode.action``, in [-1, 1].

        Before that, copy ``episode.action`` to ``episode.previous_action``.
        """


@runtime_checkable
class HasBounds(Protocol):
    """A numeric observation."""

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the lower and upper bounds of each element, within [-1, 1], shape ``(width,)`` each."""


class ObservationKind(Protocol):
    """One part of an observation: a row of numbers (``HasBounds``) or an image (``IsImage``)."""

    needs_goal: ClassVar[NeedsGoal]
    needs: ClassVar[Annotated[Needs | None, NEEDS_MEANING]]

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the columns of ``episode.observation`` from ``term.column`` on, or ``term.image``."""


def needs_of(observations: Iterable[Any]) -> Needs:
    """Return what a robot must have for some observations, in the order of ``NEEDS``; without those that do not say."""
    kinds = {need for item in observations for need in item.needs or ()}
    return tuple(need for need in NEEDS if need in kinds)


class RewardKind(Protocol):
    """One term of the reward; its weight is never negative, so that its role determines its sign.

    ``role``: ``potential`` (a difference of potentials), ``bonus`` (positive, once), ``penalty`` (negative, on an
    event) or ``running`` (never positive, and over a whole episode never below ``-weight``).
    ``least(bodies)``: optional, the smallest penalty if it depends on the body, for the audit of rewards.
    ``after_arrival``: optional, True if a running cost is paid after an arrival, too (ending ``arrived`` with
    ``wait``).

    Attributes:
        weight: Factor on what the term pays.
    """

    role: ClassVar[Role]
    outcome: ClassVar[Annotated[Outcome, "what a bonus or a penalty is for, else Outcome.RUNNING"]]
    needs_goal: ClassVar[NeedsGoal]
    needs_ending: ClassVar[Annotated[bool, "True if it is paid only where the task ends on its outcome, else False"]]
    weight: Weight

    @staticmethod
    def pay(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write column ``term.column`` of ``episode.reward_term``."""


@kind
class RewardDefaults:
    """What a reward of the package is unless it says otherwise: a cost that needs neither a goal nor an ending."""

    role: ClassVar[Role] = "running"
    outcome: ClassVar[Outcome] = Outcome.RUNNING
    needs_goal: ClassVar[bool] = False
    needs_ending: ClassVar[bool] = False


def is_paid_on_the_way(reward: RewardKind) -> bool:
    """Return whether a reward is paid up to the arrival only, where agents drive on after it."""
    return reward.role in ("potential", "running") and not getattr(reward, "after_arrival", False)


class EndingKind(Protocol):
    """One ending of the task."""

    outcome: ClassVar[Annotated[Ended, "what becomes of an agent whose episode ends so"]]
    needs_goal: ClassVar[NeedsGoal]

    @staticmethod
    def ends(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write column ``term.column`` of ``episode.ending``."""


def forget(memory: NDArray[Any], value: object, episode: EpisodeState, shard: Shard) -> None:
    """Write ``value`` into the rows of a memory ``(n_worlds, n_agents, ...)`` of agents whose episodes begin."""
    overwrite(shard.worlds, episode.began, memory.dtype.type(value), memory.reshape(*memory.shape[:2], -1))


@kernel
def overwrite(worlds: Ints, chosen: Flags, value: Any, memory: NDArray[Any]) -> None:
    """Write a value into the chosen rows ``(n_worlds, n_agents)`` of a memory ``(n_worlds, n_agents, n)``."""
    for w in worlds:
        for a in range(chosen.shape[1]):
            for k in range(memory.shape[2] if chosen[w, a] else 0):
                memory[w, a, k] = value
