"""Mirrored observations: what the columns become when left and right are exchanged."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from irsim_gym.base.arraytypes import Ints, Rays
from irsim_gym.base.families import KINEMATICS
from irsim_gym.simulator.world.kinds import MirrorsCommand
from irsim_gym.tasks.terms.term import Term


@dataclass(frozen=True)
class Mirrored:
    """The columns of an observation in a mirrored world, or the columns of pixels of an image.

    Attributes:
        columns: Column that each takes its number from, shape ``(width,)``.
        signs: 1, or -1 for a number that changes its sign, shape ``(width,)``.
    """

    columns: Ints
    signs: Rays


IN_WORLD = "is in the frame of the world"
"""Reason why an observation has no mirror."""


@runtime_checkable
class HasMirrored(Protocol):
    """An observation that says what it becomes in a mirror."""

    def mirrored(self, term: Term) -> Mirrored | str:
        """Return the columns in a mirrored world; or the reason why they have no mirror, such as ``IN_WORLD``.

        The world is mirrored in the line straight ahead of the agent.
        """


def signed(*signs: float, times: int = 1) -> Mirrored:
    """Return columns that keep their places; the signs are repeated ``times`` times."""
    repeated = np.tile(np.array(signs, np.float32), times)
    return Mirrored(np.arange(repeated.size), repeated)


def unchanged(width: int) -> Mirrored:
    """Return columns that do not change."""
    return signed(*[1.0] * width)


def command_exchanged(term: Term) -> Mirrored | str:
    """Return the components of a command as the agents' drives say, or why they have no mirror."""
    assert term.bodies is not None, "whoever makes a term by hand has to give it bodies"
    assert term.bodies.context is not None, "binding gives it"
    drives = [term.bodies.context.bodies[int(b)].kinematics for b in term.agents]
    unknown = [drive for drive in drives if not isinstance(drive, MirrorsCommand)]
    if unknown:
        name = KINEMATICS.name_of(type(unknown[0]))
        return f"is of commands, and the drive '{name}' does not say what they become (it has no 'mirrored_command')"
    ways = [drive.mirrored_command for drive in drives]
    longest = max(ways, key=len)
    if any(way != longest[: len(way)] for way in ways):
        return "is of commands of drives that are mirrored in different ways"
    return Mirrored(np.array([place for place, _ in longest]), np.array([sign for _, sign in longest], np.float32))


def sectors_exchanged(count: int, times: int = 1) -> Mirrored:
    """Return sectors in reverse order; there are ``times`` groups of ``count`` sectors."""
    return _grouped(np.arange(count)[::-1], times)


def directions_exchanged(count: int, times: int = 1) -> Mirrored:
    """Return directions over a full turn, of which the first one is straight behind, in reverse order."""
    return _grouped(-np.arange(count) % count, times)


def _grouped(columns: Ints, times: int) -> Mirrored:
    width = times * columns.size
    first = columns.size * np.arange(times)
    return Mirrored((first[:, None] + columns).reshape(width), np.ones(width, np.float32))
