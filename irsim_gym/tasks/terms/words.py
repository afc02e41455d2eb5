"""Descriptions of a task's kinds: the meaning of columns, and when rewards pay or endings apply.

Each kind describes itself in a method beside the code. A kind without such a method is described only by its docstring
and its options.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from irsim_gym.simulator.world.names import Floats, Model
from irsim_gym.tasks.terms.term import Term

Sectors = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Columns:
    """The meaning of neighbouring columns of an observation, or of the channels of an image.

    Attributes:
        meaning: Their content, e.g. ``"cosine of the bearing"``.
        scale: Formula of the number, with units, e.g. ``"d / 14.1 m, at most 1"``.
        count: Number of columns.
        sectors: Start and end angle of each column in the robot's frame [rad], 0 straight ahead, positive to the left;
            equal for a single direction. Empty if columns are not directions.
    """

    meaning: str
    scale: str = ""
    count: int = 1
    sectors: Sectors = ()


@runtime_checkable
class TellsColumns(Protocol):
    """An observation that describes its columns, or the channels of its image."""

    def columns(self, term: Term, model: Model, agent: int) -> Sequence[Columns]:
        """Return the meaning of the columns for an agent, in order; their counts add up to the observation's width.

        Args:
            agent: Number of the agent.
        """


@runtime_checkable
class TellsWhen(Protocol):
    """A reward that describes when and how much it pays, or an ending that describes when it applies."""

    def when(self, term: Term) -> str:
        """Return the description, with numbers and units."""


@runtime_checkable
class TellsActions(Protocol):
    """An action that describes the result of a learner's numbers or choices."""

    def samples(self, term: Term) -> Floats:
        """Return actions in [-1, 1], ``(n_agents, n, n_components)``: one for each choice, else those of -1 and +1."""


def evenly(count: int) -> Sectors:
    """Return sectors of equal angle over a full turn; the first one begins straight behind."""
    edges = 2.0 * np.pi * np.arange(count + 1) / count - np.pi
    return tuple(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True))


def coded(options: Any, what: str, far: float) -> str:
    """Return the formula that encodes a distance with the options ``code``, ``near`` and ``zero``, as text.

    Args:
        options: The kind's options.
        what: A letter for the distance.
        far: Maximum distance [m].
    """
    if options.code == "linear":
        return f"1 - {what} / {far:g} m: 1 at 0 m, 0 at {far:g} m"
    near, zero = options.near, options.zero
    top = 1.0 / near - zero
    nothing = f"0 at {1.0 / zero - near:.3g} m, " if zero > 0.0 else ""
    least = (1.0 / (far + near) - zero) / top
    return f"(1 / ({what} + {near:g} m) - {zero:g} / m) / {top:g}: 1 at 0 m, {nothing}{least:.2g} at {far:g} m"


def turning(sectors: Sectors, start: int = 0) -> str:
    """Return the position of the first sector, the sense of rotation and the column straight ahead, as text.

    Args:
        sectors: Start and end angle of each sector [rad].
        start: Number of the first sector.
    """
    if not sectors:
        return ""
    first = _direction_words(*sectors[0])
    if len(sectors) == 1:
        return first
    sense = "left (counter-clockwise)" if sectors[1][0] > sectors[0][0] else "right (clockwise)"
    ahead = " and ".join(str(start + k) for k in _ahead(sectors))
    where = f"; straight ahead: column {ahead}" if ahead else ""
    return f"the first {first}, the next ones turn {sense}, the last {_direction_words(*sectors[-1])}{where}"


def _ahead(sectors: Sectors) -> list[int]:
    """Return the sectors nearest to straight ahead; two if it is their common border."""
    middles = np.array([0.5 * (begin + end) for begin, end in sectors])
    away = np.abs(np.remainder(middles + np.pi, 2.0 * np.pi) - np.pi)
    return np.flatnonzero(away <= away.min() + 1e-9).tolist() if away.min() < 0.5 * np.pi else []


def _direction_words(begin: float, end: float) -> str:
    low, high = degrees(begin), degrees(end)
    return f"looks at {low}" if math.isclose(begin, end, abs_tol=1e-12) else f"covers {low} to {high}"


def degrees(angle: float) -> str:
    """Return an angle [rad] in degrees, as text."""
    return f"{round(math.degrees(angle), 1) + 0.0:g}°"


def first_sentence(kind: type[Any]) -> str:
    """Return the first paragraph of a kind's docstring in one line; empty without one."""
    words = (kind.__doc__ or "").strip().split("\n\n")[0]
    return " ".join(words.split()).replace("``", "")


def relative(value: NDArray[Any]) -> str:
    """Return one number, or the range of several numbers, as text."""
    low, high = float(np.min(value)), float(np.max(value))
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"
