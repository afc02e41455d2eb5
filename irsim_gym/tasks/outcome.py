"""How an episode ends."""

from __future__ import annotations

from enum import IntEnum
from typing import Literal, get_args


class Outcome(IntEnum):
    """What became of an agent; the numbers are part of the public face.

    If several things happen in the same step, the first of collision, left the world, success, deadlock and timeout
    counts.
    """

    RUNNING = 0
    SUCCESS = 1
    COLLISION = 2
    TIMEOUT = 3
    LEFT_WORLD = 4
    DEADLOCK = 5


class HitKind(IntEnum):
    """What an agent touches; the numbers are part of the public face."""

    NOTHING = 0
    OBSTACLE = 1
    MOVING_OBSTACLE = 2
    ROBOT = 3
    MAP = 4


Ended = Literal[Outcome.COLLISION, Outcome.LEFT_WORLD, Outcome.SUCCESS, Outcome.DEADLOCK]
PRECEDENCE: tuple[Outcome, ...] = get_args(Ended)
"""The outcomes that endings may declare, the one that wins first; the time limit comes after all of them."""

RUNNING = int(Outcome.RUNNING)
SUCCESS = int(Outcome.SUCCESS)
COLLISION = int(Outcome.COLLISION)
TIMEOUT = int(Outcome.TIMEOUT)
LEFT_WORLD = int(Outcome.LEFT_WORLD)
DEADLOCK = int(Outcome.DEADLOCK)
