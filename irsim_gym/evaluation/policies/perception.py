"""What policies perceive: the observations of the task that each was trained with, whatever task is played."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Protocol, runtime_checkable

from irsim_gym.base.errors import IrsimGymError, ScenarioError
from irsim_gym.base.families import ACTIONS, OBSERVATIONS
from irsim_gym.base.options import more_options, option_fields
from irsim_gym.base.registry import Registry
from irsim_gym.scenario import Scenario
from irsim_gym.tasks import Episodes, Task, load_task


class UnfitPerceptionError(IrsimGymError, ValueError):
    """A policy needs observations that a scenario does not offer."""


@dataclass(frozen=True)
class Perception:
    """What a policy observes and how it acts, as plain data in the form of a task.

    Attributes:
        observations: The observations in order, each with all of its options: ``{"name": "scan", "sectors": 36, ...}``.
        action: The action, likewise.
        observation_form: ``"flat"`` or ``"dict"``.
        predict: As in a task.
    """

    observations: tuple[Mapping[str, Any], ...]
    action: Mapping[str, Any]
    observation_form: str = "flat"
    predict: float | bool = False

    @property
    def names(self) -> list[str]:
        """Names of the observations, in order."""
        return [str(item["name"]) for item in self.observations]

    def to_plain(self) -> dict[str, object]:
        """Return the perception as JSON data."""
        plain = {**vars(self), "observations": [dict(item) for item in self.observations]}
        return plain if self.predict else {key: value for key, value in plain.items() if key != "predict"}


def perception_from(data: Mapping[str, Any]) -> Perception:
    """Make a perception from the result of ``to_plain``."""
    return Perception(tuple(data["observations"]), data["action"], data["observation_form"], data.get("predict", False))


def perception_differences(perceptions: Mapping[str, Perception]) -> list[str]:
    """Return descriptions of how perceptions differ from the first one; empty if all are equal.

    Args:
        perceptions: The perceptions, by name.
    """
    (first, reference), *others = perceptions.items()
    return [f"{first} has {text}" for name, other in others for text in _differences(reference, name, other)]


def _differences(one: Perception, name: str, other: Perception) -> Iterator[str]:
    ours, theirs = (
        {str(item["name"]): item for item in (perception.action, *perception.observations)}
        for perception in (one, other)
    )
    if lacking := [kind for kind in ours if kind not in theirs]:
        yield f"{', '.join(lacking)}, which {name} has not"
    if further := [kind for kind in theirs if kind not in ours]:
        yield f"no {', '.join(further)}, which {name} has"
    for kind in (kind for kind in ours if kind in theirs):
        for key, value in ours[kind].items():
            if theirs[kind].get(key) != value:
                yield f"{kind}.{key} {value}, {name} {theirs[kind].get(key)}"
    if one.observation_form != other.observation_form:
        yield f"observation_form {one.observation_form}, {name} {other.observation_form}"
    if one.predict != other.predict:
        yield f"predict {one.predict}, {name} {other.predict}"
    if set(ours) == set(theirs) and one.names != other.names:
        yield f"the order {', '.join(one.names)}, {name} {', '.join(other.names)}"


@runtime_checkable
class Perceives(Protocol):
    """A policy that acts on observations.

    Attributes:
        perception: The perception that it was trained with; None for that of the played task.
    """

    perception: Perception | None


def perception_of(task: Task) -> Perception:
    """Return the perception of a task's learners, with substitutes for missing sensors."""
    observations = tuple(_as_data(OBSERVATIONS, item) for item in task.observations)
    return Perception(observations, _as_data(ACTIONS, task.action), task.observation_form, task.predict)


def perceived_task(scenario: Scenario, task: Task, perception: Perception) -> Task:
    """Return a task with other observations and another action, but the same learners, rewards and endings.

    Args:
        perception: Replaces its observations and action, and says what is predicted if the task does not.

    Raises:
        UnfitPerceptionError: If the learners lack what the observations or the action need.
    """
    fields = {
        "name": "blank",
        "agents": [scenario.bodies[body].name for body in task.agents],
        "action": dict(perception.action),
        "observations": [dict(item) for item in perception.observations],
        "predict": task.predict or perception.predict,
    }
    try:
        loaded = load_task(scenario, fields)
    except ScenarioError as error:
        told = "; ".join(f"{problem.path}: {problem.message}" for problem in error.problems)
        raise UnfitPerceptionError(
            f"the policy was trained with {', '.join(perception.names)}, which does not fit '{scenario.name}': {told}"
        ) from error
    form: Any = perception.observation_form
    changes: dict[str, Any] = {"observations": loaded.observations, "action": loaded.action, "observation_form": form}
    return replace(task, **changes, predict=loaded.predict)


class Perceived:
    """The same worlds as seen by policies of different perceptions, one after another.

    Args:
        episodes: The worlds with the played task.
    """

    def __init__(self, episodes: Episodes) -> None:
        self.episodes = episodes
        self._known = [(perception_of(episodes.task), episodes)]

    def of(self, policy: object) -> Episodes:
        """Return the worlds for a policy, with its own observations and action and everything else as in the task.

        All results share one simulation: only the episodes that began a world's level may step that world.

        Raises:
            UnfitPerceptionError: If the agents lack what the policy's observations or its action need.
        """
        wish = policy.perception if isinstance(policy, Perceives) else None
        if wish is None:
            return self.episodes
        return self._find(wish) or self._make(wish)

    def observed_by(self, policy: object) -> list[str] | None:
        """Return the names of a policy's observations; None for a policy that acts without observations."""
        return perception_of(self.of(policy).task).names if isinstance(policy, Perceives) else None

    def _find(self, wish: Perception) -> Episodes | None:
        return next((episodes for earlier, episodes in self._known if earlier == wish), None)

    def _make(self, wish: Perception) -> Episodes:
        simulation = self.episodes.simulation
        task = perceived_task(simulation.scenario, self.episodes.task, wish)
        episodes = self._find(perception_of(task)) or Episodes(simulation, task)
        self._known.append((wish, episodes))
        return episodes


def _as_data(family: Registry, item: object) -> dict[str, object]:
    """Return a kind as a task writes it, with all options."""
    options = {key: getattr(item, key) for key in option_fields(type(item))} | more_options(item)
    return {"name": family.name_of(type(item)), **{key: _as_list(value) for key, value in options.items()}}


def _as_list(value: object) -> object:
    return [_as_list(part) for part in value] if isinstance(value, list | tuple) else value
