"""Where bodies have been since a reset."""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.engine import Simulation


class Track:
    """The poses of all bodies at each step."""

    def __init__(self) -> None:
        self._rows: list[tuple[tuple[str, ...], Floats]] = []

    def begin(self, simulation: Simulation) -> None:
        """Forget everything, and note where the bodies start."""
        self._rows.clear()
        self.note(simulation)

    def note(self, simulation: Simulation) -> None:
        """Note where the bodies are."""
        self._rows.append((simulation.parts.names, simulation.state.pose[0].copy()))

    def poses_of(self, name: str) -> Floats:
        """Return the poses of a body while it was there [m, m, rad], shape ``(n, 3)``."""
        poses: list[Floats] = []
        names: tuple[str, ...] = ()
        b = -1
        for here, rows in self._rows:
            if here is not names:
                names, b = here, here.index(name) if name in here else -1
            if b >= 0:
                poses.append(rows[b])
        return np.array(poses).reshape(-1, 3)
