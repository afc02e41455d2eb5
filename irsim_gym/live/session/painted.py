"""Beams in the colours that ``Body.set_laser_color`` sets, as marks over a world."""

from collections.abc import Iterable, Iterator

import numpy as np

from irsim_gym.base.arraytypes import Ints
from irsim_gym.scenario.specs.colors import color_problem
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.readings.marks import LineMark, Mark

HIGHLIGHT = "#E69F00"
WIDTH, LAYER = 1.0, 2.0
"""Width of a line [point], and its layer: above obstacles, below robots."""


class PaintedBeams:
    """Beams with colours of their own, which are drawn over those of their sensor."""

    def __init__(self) -> None:
        self._looks: dict[str, tuple[Ints, str, float]] = {}

    def paint(self, name: str, beams: Iterable[int], colour: str, alpha: float) -> None:
        """Give some beams of a body's first range sensor a colour, and all others that of the sensor.

        Args:
            name: The body.
            beams: Numbers of these beams; numbers without a beam are ignored.
            colour: Colour of these beams.
            alpha: Opacity of these beams.

        Raises:
            ValueError: The colour is unknown, or the opacity is not between 0 and 1.
        """
        problem = color_problem(colour)
        if problem:
            raise ValueError(f"laser_color: {problem}")
        if not 0.0 <= alpha <= 1.0:
            raise ValueError(f"alpha must be between 0 and 1, got {alpha!r}")
        self._looks[name] = np.asarray(list(beams), np.int64).reshape(-1), colour, float(alpha)

    def marks(self, simulation: Simulation) -> Iterator[Mark]:
        """Yield the beams as they are now."""
        for name, (beams, colour, alpha) in self._looks.items():
            own_scan = simulation.scan(simulation.body(name)) if name in simulation.parts.names else None
            if own_scan is None:
                continue
            group, k = own_scan
            ranges, (x, y, turn) = group.arrays["ranges"][0, k], getattr(group.options[k], "offset", (0.0, 0.0, 0.0))
            place = simulation.state.pose[0, group.members[k]]
            cosine, sine = np.cos(place[2]), np.sin(place[2])
            origin = place[:2] + np.array([cosine * x - sine * y, sine * x + cosine * y])
            chosen = beams[(beams >= -len(ranges)) & (beams < len(ranges))]
            angles = place[2] + turn + group.arrays["angles"][chosen]
            ends = origin + ranges[chosen, None] * np.column_stack([np.cos(angles), np.sin(angles)])
            for end in ends[np.isfinite(ends).all(axis=1)]:
                yield LineMark(np.array([origin, end]), colour, alpha, WIDTH, "solid", False, "", LAYER)
