"""Poses of bodies since a reset."""

from collections.abc import Iterator, Set

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.simulator.engine import Simulation

GONE = ""
"""Replaces the name of a removed body."""


class Track:
    """The poses and steering angles of all bodies at each step."""

    def __init__(self) -> None:
        self._rows: list[tuple[int, tuple[str, ...], Floats]] = []

    def begin(self, simulation: Simulation) -> None:
        """Clear the track, and note the starts of the bodies."""
        self._rows.clear()
        self.note(simulation)

    def note(self, simulation: Simulation) -> None:
        """Note the present poses of the bodies."""
        state = simulation.state
        states = np.column_stack([state.pose[0], state.steering[0]])
        self._rows.append((int(state.step[0]), simulation.parts.names, states))

    def follow(self, simulation: Simulation) -> None:
        """Update to a list of bodies that changed since the last step, and note the present poses."""
        before = self._rows.pop()[1]
        gone = set(before).difference(simulation.parts.names)
        if gone:
            self._forget(gone)
        self.note(simulation)

    def _forget(self, gone: Set[str]) -> None:
        """Keep the poses of removed bodies without a name, so that others may use it."""
        names: tuple[str, ...] = ()
        left_names: tuple[str, ...] = ()
        for i, (step, row_names, poses) in enumerate(self._rows):
            if row_names is not names:
                names, left_names = row_names, tuple(GONE if name in gone else name for name in row_names)
            self._rows[i] = step, left_names, poses

    def states_of(self, name: str) -> Floats:
        """Return poses and steering angles of a body [m, m, rad, rad], shape ``(n, 4)``.

        The rows are the steps in which it existed.
        """
        poses: list[Floats] = []
        names: tuple[str, ...] = ()
        b = -1
        for _, row_names, rows in self._rows:
            if row_names is not names:
                names, b = row_names, row_names.index(name) if name in row_names else -1
            if b >= 0:
                poses.append(rows[b])
        return np.array(poses).reshape(-1, 4)

    def poses_of(self, name: str) -> Floats:
        """Return the poses of a body [m, m, rad], shape ``(n, 3)``.

        The rows are the steps in which it existed.
        """
        return self.states_of(name)[:, :3]

    def __len__(self) -> int:
        return len(self._rows)

    def since(self, first: int, names: tuple[str, ...]) -> Iterator[tuple[int, Floats]]:
        """Yield step and poses of the notes from number ``first`` on.

        Args:
            first: Number of notes to skip.
            names: Names of the bodies, in the order of the poses. Poses of a body that did not exist are NaN.
        """
        for step, row_names, rows in self._rows[first:]:
            if row_names is names:
                yield step, rows[:, :3].copy()
                continue
            places = {name: b for b, name in enumerate(row_names)}
            nowhere = np.full(3, np.nan)
            here_now = [rows[places[name], :3] if name in places else nowhere for name in names]
            yield step, np.array(here_now).reshape(-1, 3)
