"""The three elements of an observed way: cosine and sine of its direction, and its length over the world's diagonal."""

from typing import ClassVar

import numpy as np

from irsim_gym.simulator.world.names import Point, Rays
from irsim_gym.tasks.terms import Columns, Mirrored, Model, Term, kernel, kind, signed, unit


@kind
class ObservesWay:
    """What observations of a way have in common."""

    needs_goal: ClassVar[bool] = True

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds of the three elements."""
        return np.array([-1.0, -1.0, 0.0], np.float32), np.ones(3, np.float32)

    def mirrored(self, term: Term) -> Mirrored:
        """Return the columns; what is positive to the left changes its sign."""
        return signed(1.0, -1.0, 1.0)


def way_columns(direction: str, length: str, scaled: str) -> list[Columns]:
    """Return the meaning of the columns.

    Args:
        direction: Of what the direction is, such as ``of the direction of ...``.
        length: What the length is that of.
        scaled: The number that the length becomes.
    """
    return [
        Columns(f"cosine {direction}", "1 straight ahead, -1 straight behind"),
        Columns(f"sine {direction}", "1 to the left, -1 to the right"),
        Columns(length, scaled),
    ]


@kernel
def write_direction(row: Rays, place: Point, facing: Point, there: Point) -> float:
    """Write cosine and sine of the direction to a point, (1, 0) at the point itself, and return its distance [m].

    Args:
        row: The elements, of which the first two are written, shape ``(3,)``.
        place: Where the agent is [m].
        facing: Cosine and sine of its heading.
        there: The point [m].

    Writes: row.
    """
    dx, dy = there[0] - place[0], there[1] - place[1]
    far = np.sqrt(dx * dx + dy * dy)
    row[0] = unit((dx * facing[0] + dy * facing[1]) / far if far > 0.0 else 1.0)
    row[1] = unit((dy * facing[0] - dx * facing[1]) / far if far > 0.0 else 0.0)
    return float(far)


@kernel
def write_way(row: Rays, place: Point, facing: Point, there: Point, rest: float, full: float) -> None:
    """Write the direction to the first part of a way, and the length of the whole way over the diagonal.

    Args:
        row: The three elements, shape ``(3,)``.
        place: Where the agent is [m].
        facing: Cosine and sine of its heading.
        there: The last point that can be reached straight [m].
        rest: Length of the way from there on [m].
        full: Diagonal of the world [m].

    Writes: row.
    """
    row[2] = unit((write_direction(row, place, facing, there) + rest) / full)
