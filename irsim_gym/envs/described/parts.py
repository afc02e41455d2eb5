"""What a description consists of, as data."""

import math
from dataclasses import asdict, dataclass
from typing import Any

from irsim_gym.tasks.terms.term import NEEDS, Needs
from irsim_gym.tasks.terms.words import turning


@dataclass(frozen=True)
class Part:
    """Some neighbouring columns of a block; of a picture, channels.

    Attributes:
        start: Index of the first one, in the array of the observation that holds the block.
        stop: Index after the last one.
        meaning: What they hold.
        scale: How a number follows from the measured quantity, with its unit.
        low: Least value of any column, without unit; see ``scale``.
        high: Greatest value of any column, without unit; see ``scale``.
        sectors: Where each looks, from which angle to which [degree], 0 straight ahead of the robot, positive to its
            left; empty where columns are no directions.
    """

    start: int
    stop: int
    meaning: str
    scale: str
    low: float
    high: float
    sectors: tuple[tuple[float, float], ...]

    @property
    def directions(self) -> str:
        """Where its columns look, in words; empty where they are no directions."""
        return turning(tuple((math.radians(begin), math.radians(end)) for begin, end in self.sectors), self.start)


@dataclass(frozen=True)
class Block:
    """What one observation of the task contributes.

    Attributes:
        name: Its name in the task.
        key: Key of the array that holds it, in an observation that is a dict; empty where it is one array.
        summary: What it is, in a sentence.
        needs: What a robot must have for it, see ``tasks.terms.term.NEEDS``; None where a plugin does not say.
        shape: Of the numbers that it contributes.
        parts: Its columns, or the channels of its picture, in order.
        is_image: It is a picture: an array of its own, uint8.
        view: What a picture shows, and what is up in it.
    """

    name: str
    key: str
    summary: str
    needs: Needs | None
    shape: tuple[int, ...]
    parts: tuple[Part, ...]
    is_image: bool = False
    view: str = ""


@dataclass(frozen=True)
class Component:
    """One component of the command that an action becomes.

    Attributes:
        name: What it is.
        unit: Its unit.
        low: Value of the action -1 [``unit``].
        high: Value of the action 1 [``unit``].
        most_change: Greatest change per second [``unit``/s]; infinite without a limit.
    """

    name: str
    unit: str
    low: float
    high: float
    most_change: float


@dataclass(frozen=True)
class Action:
    """What a learner's action means.

    Attributes:
        name: Its kind.
        summary: What it is, in a sentence.
        space: The space of actions, as text.
        components: The components of the command.
        choices: Command of each choice [unit of each component]; empty for a continuous action.
    """

    name: str
    summary: str
    space: str
    components: tuple[Component, ...]
    choices: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Reward:
    """One term of the reward.

    Attributes:
        name: Name of the term in the task.
        role: What the term is for.
        sign: ``"+"``, ``"-"`` or ``"+ or -"``.
        weight: Factor of the term.
        when: When it pays, and how much.
    """

    name: str
    role: str
    sign: str
    weight: float
    when: str


@dataclass(frozen=True)
class Ending:
    """One way in which an episode ends: its ``name`` in the task, the ``outcome`` in infos, and ``when`` it ends."""

    name: str
    outcome: str
    when: str


@dataclass(frozen=True)
class Info:
    """One ``key`` of the infos: the ``unit`` of its value (empty without one) and its ``meaning``."""

    key: str
    unit: str
    meaning: str


@dataclass(frozen=True)
class Described:
    """The content of a ``Description``, which says what it holds."""

    scenario: str
    task: str
    agent: str
    same_for: tuple[str, ...]
    max_steps: int
    step_time: float
    observation_space: str
    form: str
    blocks: tuple[Block, ...]
    action: Action
    rewards: tuple[Reward, ...]
    endings: tuple[Ending, ...]
    infos: tuple[Info, ...]
    numbers: tuple[tuple[str, str], ...]

    def as_dict(self) -> dict[str, Any]:
        """Return plain data, such as ``json.dumps`` takes; an infinite number is None there."""
        plain: dict[str, Any] = _plain(asdict(self))
        return plain

    @property
    def needs(self) -> Needs:
        """What a robot must have to observe all of it, as far as the observations say."""
        kinds = {need for block in self.blocks for need in block.needs or ()}
        return tuple(need for need in NEEDS if need in kinds)

    def block(self, name: str) -> Block:
        """Return the block of an observation; KeyError where the task has none of that name."""
        return {block.name: block for block in self.blocks}[name]


def _plain(value: object) -> Any:
    """Return data with lists in place of tuples and None in place of infinite numbers."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
