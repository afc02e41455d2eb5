"""Beams in the colours that ``Body.set_laser_color`` sets."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import groupby, pairwise
from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.scenario.specs.colors import color_problem
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.world.group import Group

HIGHLIGHT = "#E69F00"
READINGS = ("ranges", "radial_velocity")

Look = tuple[str, float] | None
"""Colour and opacity of a beam; None for those of its sensor."""


class PaintedBeams:
    """Beams with colours of their own. The renderer gets scans in pieces of one colour each.

    Attributes:
        version: A number that differs after each change.
    """

    def __init__(self) -> None:
        self.version = 0
        self._looks: dict[str, list[Look]] = {}
        self._copies: list[tuple[Group, Group, int, slice]] = []

    def paint(self, name: str, n_beams: int, beams: Iterable[int], colour: str, alpha: float) -> None:
        """Give some beams of a body's first range sensor a colour, and all others that of the sensor.

        Args:
            name: The body.
            n_beams: Number of beams.
            beams: Indices of the beams to paint; others than existing ones are ignored.
            colour: Their colour.
            alpha: Their opacity; 0 hides them.

        Raises:
            ValueError: There is no such colour, or the opacity is not between 0 and 1.
        """
        problem = color_problem(colour)
        if problem:
            raise ValueError(f"laser_color: {problem}")
        if not 0.0 <= alpha <= 1.0:
            raise ValueError(f"alpha must be between 0 and 1, got {alpha!r}")
        looks: list[Look] = [None] * n_beams
        for beam in np.asarray(list(beams), np.int64).reshape(-1).tolist():
            if -n_beams <= beam < n_beams:
                looks[beam] = colour, float(alpha)
        if self._looks.get(name) != looks:
            self._looks[name] = looks
            self.version += 1

    def groups(self, simulation: Simulation) -> list[Group]:
        """Return the range sensors of a simulation with scans that have painted beams in pieces."""
        self._copies, made = [], []
        for group in simulation.sensors:
            names = [simulation.parts.names[b] for b in group.members]
            if "angles" not in group.arrays or not any(name in self._looks for name in names):
                made.append(group)
                continue
            for k, name in enumerate(names):
                plain: list[Look] = [None] * len(group.arrays["angles"])
                first = simulation.scan(int(group.members[k]))
                is_first = first is not None and first[0] is group and first[1] == k
                looks = self._looks.get(name, plain) if is_first else plain
                made += list(self._pieces(group, k, looks if len(looks) == len(plain) else plain))
        self.follow()
        return made

    def _pieces(self, group: Group, k: int, looks: list[Look]) -> Iterator[Group]:
        """Yield one sensor for each run of beams that look alike."""
        ends = np.cumsum([0, *(len(list(run)) for _, run in groupby(looks))]).tolist()
        for first, last in pairwise(ends):
            part, look = slice(first, last), looks[first]
            if look is not None and look[1] == 0.0:
                continue
            arrays: dict[str, Any] = {"angles": group.arrays["angles"][part]}
            arrays |= {key: group.arrays[key][:, k : k + 1, part].copy() for key in READINGS if key in group.arrays}
            options = group.options[k] if look is None else _coloured(group.options[k], *look)
            piece = Group(group.kind, [options], group.members[k : k + 1], arrays=arrays)
            self._copies.append((piece, group, k, part))
            yield piece

    def follow(self) -> None:
        """Update the readings of the pieces."""
        for piece, group, k, part in self._copies:
            for key in READINGS:
                if key in piece.arrays:
                    reading: Floats = group.arrays[key][:, k : k + 1, part]
                    piece.arrays[key][:] = reading


def _coloured(options: Any, colour: str, alpha: float) -> object:
    """Return a sensor's options with another look of its beams."""
    changed = replace(options, color=colour, alpha=alpha)
    plot = getattr(options, "plot", None)
    if plot is None:
        return changed
    plain = {"velocity_color": False} if hasattr(plot, "velocity_color") else {}
    return replace(changed, plot=replace(plot, color=colour, alpha=alpha, **plain))
