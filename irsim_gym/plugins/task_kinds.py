"""Actions, observations, rewards and endings of one's own, written as functions of one agent."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base import families
from irsim_gym.bodies.behaviors.python.views import EgoView
from irsim_gym.plugins.functions import answer, registering
from irsim_gym.simulator.engine import Shard, Simulation
from irsim_gym.simulator.world.names import Floats, Ints, Model, Rays, State, kind, option
from irsim_gym.tasks.terms.episode_state import EpisodeState
from irsim_gym.tasks.terms.outcome import Ended, Outcome
from irsim_gym.tasks.terms.term import Need, Needs, Role, Term

F = TypeVar("F", bound=Callable[..., Any])


class AgentView(EgoView):
    """A learner's body, with what its episode has come to: an ``EgoView`` and more.

    Args:
        term: The term that asks.
        model: Constants of the worlds.
        state: State of the worlds.
        episode: The episodes of the agents.
        place: Number of the world, and of the agent in it.
    """

    __slots__ = ("_agent", "_episode", "_term")

    def __init__(self, term: Term, model: Model, state: State, episode: EpisodeState, place: tuple[int, int]) -> None:
        world, agent = place
        body, memories = int(term.agents[agent]), term.arrays["memory"]
        assert term.bodies is not None, "whoever makes a term by hand has to give it bodies"
        if memories[world, agent] is None:
            memories[world, agent] = {}
        super().__init__(term.bodies, model, state, world, body, memories[world, agent])
        self._term, self._episode, self._agent = term, episode, agent

    @property
    def steps(self) -> int:
        """Steps of the episode so far."""
        return int(self._episode.steps[self._w, self._agent])

    @property
    def max_steps(self) -> int:
        """Steps of a full episode."""
        return self._term.max_steps

    @property
    def action(self) -> Floats:
        """Latest action, in [-1, 1], shape ``(n_components,)``."""
        return self._numbers(self._episode.action)

    @property
    def previous_action(self) -> Floats:
        """The action before the latest, in [-1, 1], shape ``(n_components,)``."""
        return self._numbers(self._episode.previous_action)

    @property
    def outcome(self) -> Outcome:
        """What has become of it; ``Outcome.RUNNING`` while its episode goes on."""
        return Outcome(self._episode.outcome[self._w, self._agent])

    @property
    def path_length(self) -> float:
        """Distance travelled [m]."""
        return float(self._episode.path_length[self._w, self._agent])

    def _numbers(self, field: Floats) -> Floats:
        return np.array(field[self._w, self._agent, : self._term.action_sizes[self._agent]])


@kind
class FunctionTerm:
    """What all terms written as functions have in common: their memories, and how they are called."""

    def arrays(self, simulation: Simulation, agents: Ints) -> dict[str, NDArray[Any]]:
        """Make room for a memory for each world and agent."""
        return {"memory": np.full((simulation.n_worlds, len(agents)), None, dtype=object)}

    @staticmethod
    def begin(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Empty the memories of agents whose episodes begin."""
        for w in shard.worlds.tolist():
            term.arrays["memory"][w, episode.began[w]] = None


def answers(
    term: Term, moment: tuple[Model, State, EpisodeState], shard: Shard, sizes: Sequence[int], *inputs: Any
) -> Iterator[tuple[int, int, Floats]]:
    """Yield world, agent and the function's answer, world by world.

    Args:
        moment: The constants, the state of the worlds and that of the episodes.
        sizes: How many numbers the function returns for each agent.
        *given: Arrays ``(n_worlds, n_agents, ...)`` whose rows the function is called with, after the agent.
    """
    options, kind = term.options.own_options(term.options), type(term.options)
    for w in shard.worlds.tolist():
        for a, size in enumerate(sizes):
            ego = AgentView(term, *moment, (w, a))
            arguments = [rows[w, a] for rows in inputs]
            yield w, a, answer(kind, ego, size, kind.function, arguments, options)


@kind
class FunctionAction(FunctionTerm):
    """An action written as a function."""

    n_choices: ClassVar[int] = 0

    @staticmethod
    def act(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Keep the latest action and write the function's, cut to [-1, 1]."""
        episode.previous_action[shard.worlds] = episode.action[shard.worlds]
        sizes, moment = term.action_sizes.tolist(), (model, state, episode)
        actions = episode.choice if term.options.n_choices else episode.given
        for w, a, row in answers(term, moment, shard, sizes, actions):
            episode.action[w, a, : sizes[a]] = np.clip(row, -1.0, 1.0)


@kind
class FunctionObservation(FunctionTerm):
    """A part of the observation written as a function."""

    needs_goal: ClassVar[bool] = False
    needs: ClassVar[Needs | None] = None
    size: ClassVar[int] = 1
    low: ClassVar[Any] = -1.0
    high: ClassVar[Any] = 1.0

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds that the decorator was given."""
        low, high = (np.array(np.broadcast_to(bound, self.size), np.float32) for bound in (self.low, self.high))
        return low, high

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the function's numbers."""
        size, moment = term.options.size, (model, state, episode)
        for w, a, row in answers(term, moment, shard, [size] * len(term.agents)):
            episode.observation[w, a, term.column : term.column + size] = row


@kind
class FunctionReward(FunctionTerm):
    """A term of the reward written as a function."""

    role: ClassVar[Role] = "running"
    outcome: ClassVar[Outcome] = Outcome.RUNNING
    needs_goal: ClassVar[bool] = False
    needs_ending: ClassVar[bool] = False

    weight: float = option(1.0, ge=0.0, meaning="Factor of what the function returns.")

    @staticmethod
    def pay(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Pay what the function returns, times the weight."""
        for w, a, row in answers(term, (model, state, episode), shard, [1] * len(term.agents)):
            episode.reward_term[w, a, term.column] = term.options.weight * row[0]


@kind
class FunctionEnding(FunctionTerm):
    """An ending written as a function."""

    outcome: ClassVar[Outcome] = Outcome.LEFT_WORLD
    needs_goal: ClassVar[bool] = False

    @staticmethod
    def ends(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """End where the function says so."""
        for w, a, row in answers(term, (model, state, episode), shard, [1] * len(term.agents)):
            episode.ending[w, a, term.column] = row[0] != 0.0


def action(name: str, *, n_choices: int = 0) -> Callable[[F], F]:
    """Register a function as an action, to be used as ``action: {name: ...}`` in a task.

    It is called as ``f(ego, given, **options)`` for one agent of one world at a time, and returns the action: one
    number for each component of the drive's command, from -1 for the least to 1 for the greatest command. ``given`` is
    what the learner gave, as many numbers, or with ``n_choices`` one whole number. ``ego`` is an ``AgentView``, whose
    ``action`` is still the latest one.

    Options are keyword-only parameters as for ``irsim_gym.behavior``. What the function remembers belongs into
    ``ego.memory``, a dictionary for each world and agent that is empty when an episode begins; random numbers come from
    ``ego.uniform`` and ``ego.normal``, which draw from the world's own stream.

    Args:
        name: Its name in YAML.
        n_choices: Number of choices; 0 for a continuous action.

    Raises:
        TypeError: The function's parameters are not as above.
        IrsimGymError: The name is taken.
    """
    return registering(families.ACTIONS, name, FunctionAction, ("ego", "given"), n_choices=n_choices)


def observation(
    name: str,
    *,
    size: int = 1,
    low: float | Sequence[float] = -1.0,
    high: float | Sequence[float] = 1.0,
    needs_goal: bool = False,
    needs: Sequence[Need] | None = None,
) -> Callable[[F], F]:
    """Register a function as a part of the observation, to be used in ``observations:`` of a task.

    It is called as ``f(ego, **options)`` for one agent of one world at a time, also at the start of an episode, and
    returns ``size`` numbers within their bounds. ``ego`` is an ``AgentView``; options, memory and random numbers are as
    for ``action``.

    Args:
        name: Its name in YAML.
        size: How many numbers it returns.
        low: Least value of each, or of all, within [-1, 1].
        high: Greatest value of each, or of all, within [-1, 1].
        needs_goal: It means nothing for an agent without a goal.
        needs: What a robot must have for it: some of ``"scan"``, ``"odometry"``, ``"map_frame"``, ``"grid"``,
            ``"bodies"`` and ``"messages"``, or ``()`` for nothing. None leaves it unsaid: descriptions show that, and
            policies that observe it cannot be exported to a robot.

    Raises:
        TypeError: The function's parameters are not as above.
        IrsimGymError: The name is taken.
    """
    told = None if needs is None else tuple(needs)
    members: dict[str, Any] = {"size": size, "low": low, "high": high, "needs_goal": needs_goal, "needs": told}
    return registering(families.OBSERVATIONS, name, FunctionObservation, ("ego",), **members)


def reward(
    name: str,
    *,
    role: Role = "running",
    outcome: Outcome = Outcome.RUNNING,
    needs_goal: bool = False,
    needs_ending: bool = False,
) -> Callable[[F], F]:
    """Register a function as a term of the reward, to be used in ``rewards:`` of a task.

    It is called as ``f(ego, **options)`` for one agent of one world at a time, after each step, and returns what it
    pays for a weight of 1; every such reward has the option ``weight``. ``ego`` is an ``AgentView``; options, memory
    and random numbers are as for ``action``.

    Args:
        name: Its name in YAML.
        role: ``running`` (never positive, and over an episode never below -1: divide by ``ego.max_steps``),
            ``potential`` (a difference of potentials), ``bonus`` (positive, once) or ``penalty`` (negative).
        outcome: What a bonus or a penalty is for.
        needs_goal: It means nothing for an agent without a goal.
        needs_ending: It is paid only where the task ends on its outcome.

    Raises:
        TypeError: The function's parameters are not as above.
        IrsimGymError: The name is taken.
    """
    members = {"role": role, "outcome": outcome, "needs_goal": needs_goal, "needs_ending": needs_ending}
    return registering(families.REWARDS, name, FunctionReward, ("ego",), **members)


def ending(name: str, *, outcome: Ended, needs_goal: bool = False) -> Callable[[F], F]:
    """Register a function as an ending, to be used in ``endings:`` of a task.

    It is called as ``f(ego, **options)`` for one agent of one world at a time, after each step, and returns whether the
    agent's episode ends. ``ego`` is an ``AgentView``; options, memory and random numbers are as for ``action``.

    Args:
        name: Its name in YAML.
        outcome: What becomes of an agent whose episode ends so: ``Outcome.SUCCESS``, ``COLLISION``, ``LEFT_WORLD`` or
            ``DEADLOCK``.
        needs_goal: It means nothing for an agent without a goal.

    Raises:
        TypeError: The function's parameters are not as above.
        IrsimGymError: The name is taken.
    """
    return registering(families.ENDINGS, name, FunctionEnding, ("ego",), outcome=outcome, needs_goal=needs_goal)
