"""Outcomes of episodes."""

from enum import IntEnum
from typing import Literal, get_args


class Outcome(IntEnum):
    """The outcome of an agent's episode; the numbers are part of the public interface.

    If several outcomes apply in the same step, the first of collision, left the world, success, deadlock and timeout
    counts. An agent that has arrived and waits for its team succeeds whatever comes later. MISPLACED is an arrival that
    the agent only believes in, where its odometry is disturbed.
    """

    RUNNING = 0
    SUCCESS = 1
    COLLISION = 2
    TIMEOUT = 3
    LEFT_WORLD = 4
    DEADLOCK = 5
    MISPLACED = 6


class HitKind(IntEnum):
    """The kind of body that an agent touches; the numbers are part of the public interface."""

    NOTHING = 0
    OBSTACLE = 1
    MOVING_OBSTACLE = 2
    ROBOT = 3
    MAP = 4


Ended = Literal[Outcome.COLLISION, Outcome.LEFT_WORLD, Outcome.SUCCESS, Outcome.DEADLOCK]
PRECEDENCE: tuple[Outcome, ...] = get_args(Ended)
"""The outcomes that endings may declare, in order of precedence; the time limit comes last."""

RUNNING = int(Outcome.RUNNING)
SUCCESS = int(Outcome.SUCCESS)
COLLISION = int(Outcome.COLLISION)
TIMEOUT = int(Outcome.TIMEOUT)
LEFT_WORLD = int(Outcome.LEFT_WORLD)
DEADLOCK = int(Outcome.DEADLOCK)
MISPLACED = int(Outcome.MISPLACED)
