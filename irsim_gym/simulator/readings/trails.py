"""Where bodies have been, for pictures of their paths."""

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats, Ints
from irsim_gym.base.kernels import kernel

LONGEST = 4096
FIRST_LENGTH = 64


class Trails:
    """Poses of some bodies since the episode of their world began, as far as they were noted.

    A step count that goes back begins a new episode. The table grows with the episodes, and from ``LONGEST`` steps
    on the latest poses take the place of the oldest ones.

    Args:
        bodies: Ids of the bodies to follow, shape ``(n_tracked,)``.
        n_worlds: Number of worlds.
    """

    def __init__(self, bodies: Ints, n_worlds: int) -> None:
        self.bodies = bodies
        self._poses: Floats = np.empty((n_worlds, FIRST_LENGTH, len(bodies), 3))
        self._noted: Ints = np.full((n_worlds, FIRST_LENGTH), -1)
        self._latest: Ints = np.full(n_worlds, -1)

    def record(self, worlds: Ints, steps: Ints, poses: Floats) -> None:
        """Note where the bodies are; a second note in one step takes the place of the first.

        Args:
            worlds: Indices of different worlds, shape ``(n,)``.
            steps: Steps since their episodes began, shape ``(n,)``.
            poses: Poses of all bodies there [m, m, rad]; NaN where a body is not, shape ``(n, n_bodies, 3)``.
        """
        if not len(self.bodies):
            return
        beyond = note(worlds, self.bodies, steps, poses, LONGEST, self._noted, self._latest, self._poses)
        if beyond >= 0:
            self._grow(beyond)
            note(worlds, self.bodies, steps, poses, LONGEST, self._noted, self._latest, self._poses)

    def _grow(self, step: int) -> None:
        """Make room for a step; no step has wrapped around yet, so all keep their slots."""
        length = self._noted.shape[1]
        while length <= step and length < LONGEST:
            length *= 2
        noted, poses = self._noted, self._poses
        self._noted = np.full((len(noted), length), -1)
        self._noted[:, : noted.shape[1]] = noted
        self._poses = np.empty((len(noted), length, *poses.shape[2:]))
        self._poses[:, : noted.shape[1]] = poses

    def poses(self, world: int, index: int, *, every: int = 1, length: int = 0) -> Floats:
        """Return where the tracked body number ``index`` has been.

        Args:
            world: Index of the world.
            index: Position of the body in ``bodies``.
            every: Only at steps that this number divides.
            length: Only so many of the latest poses; 0 for all.

        Returns:
            Poses [m, m, rad], the oldest first, shape ``(n, 3)``.
        """
        _, table = self.noted(world, every)
        rows: Floats = table[:, index]
        rows = rows[~np.isnan(rows[:, 0])]
        return rows[-length:] if length else rows

    def noted(self, world: int, every: int = 1) -> tuple[Ints, Floats]:
        """Return when and where all tracked bodies have been, for reading only.

        Args:
            world: Index of the world.
            every: Only at steps that this number divides.

        Returns:
            Steps since the episode began, the oldest first, shape ``(n,)``, and poses [m, m, rad], NaN where a body was
            not, shape ``(n, n_tracked, 3)``.
        """
        steps = self._noted[world]
        last = int(self._latest[world])
        if 0 <= last < len(steps) and steps[0] == 0 and steps[last] == last and (steps[: last + 1] >= 0).all():
            chosen = slice(0, last + 1, every)  # every step from the first on: nothing has to be copied
            return steps[chosen], self._poses[world, chosen]
        slots = np.flatnonzero((steps >= 0) & (steps % every == 0))
        # Slots go by the step modulo the length, so the oldest pose may be anywhere.
        slots = slots[np.argsort(steps[slots])]
        return steps[slots], self._poses[world, slots]

    def tables(self) -> tuple[Floats, Ints, Ints]:
        """Return the tables, for kernels that read them.

        Returns:
            Poses [m, m, rad] by world, slot and tracked body, shape ``(n_worlds, n_slots, n_tracked, 3)``; the step of
            each slot, -1 for none, shape ``(n_worlds, n_slots)``; and the latest step of each world, -1 for none. The
            slot of a step is its number modulo the number of slots.
        """
        return self._poses, self._noted, self._latest

    def forget(self, bodies: Flags) -> None:
        """Forget where some bodies have been: they have just come to another place.

        Args:
            bodies: Which ones, shape ``(n_worlds, n_bodies)``.
        """
        for w, index in np.argwhere(bodies[:, self.bodies]).tolist():
            self._poses[w, :, index] = np.nan

    def clear(self, worlds: Ints | None = None) -> None:
        """Forget what was noted of some worlds, or of all."""
        chosen = slice(None) if worlds is None else worlds
        self._noted[chosen] = -1
        self._latest[chosen] = -1


@kernel
def note(
    worlds: Ints, bodies: Ints, steps: Ints, poses: Floats, longest: int, noted: Ints, latest: Ints, table: Floats
) -> int:
    """Write where bodies are, unless the table is too short and may still grow.

    Returns:
        The highest step that there is no room for, and nothing is written; -1 if all is.
    """
    length, highest = noted.shape[1], -1
    for i in range(worlds.shape[0]):
        highest = max(highest, steps[i])
    # The caller makes the table longer and calls again; at its greatest length, steps wrap around instead.
    if highest >= length and length < longest:
        return highest
    for i in range(worlds.shape[0]):
        w, step = worlds[i], steps[i]
        # An earlier step than the latest: a new episode has begun.
        if step < latest[w]:
            for slot in range(length):
                noted[w, slot] = -1
        slot = step % length
        noted[w, slot] = latest[w] = step
        for k in range(bodies.shape[0]):
            for c in range(3):
                table[w, slot, k, c] = poses[i, bodies[k], c]
    return -1
