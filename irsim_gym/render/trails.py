"""Where bodies have been, as far as frames were drawn."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from irsim_gym.arraytypes import Floats, Ints

LONGEST = 4096


@dataclass
class _History:
    """Positions of the tracked bodies in one world's present episode."""

    start: bytes
    step: int = -1
    positions: deque[Floats] = field(default_factory=lambda: deque(maxlen=LONGEST))


class Trails:
    """Positions of some bodies since their episode began, for every world that is drawn.

    A new episode is recognised by its start poses or by a step count that went back, so that forgetting to
    clear does not join two episodes.

    Args:
        bodies: Ids of the bodies to follow, shape ``(n_tracked,)``.
    """

    def __init__(self, bodies: Ints) -> None:
        self.bodies = bodies
        self._histories: dict[int, _History] = {}

    def record(self, world: int, step: int, start: Floats, pose: Floats) -> None:
        """Note where the bodies are.

        Args:
            world: Index of the world.
            step: Steps since the episode began.
            start: Start poses of all bodies [m, m, rad], shape ``(n_bodies, 3)``.
            pose: Their present poses, likewise.
        """
        key = start.tobytes()
        history = self._histories.get(world)
        if history is None or history.start != key or step < history.step:
            history = self._histories[world] = _History(key)
        elif step == history.step:
            history.positions.pop()
        history.step = step
        history.positions.append(pose[self.bodies, :2].copy())

    def points(self, world: int, index: int, length: int = 0) -> Floats:
        """Return the trajectory of the tracked body number ``index``.

        Args:
            world: Index of the world.
            index: Position of the body in ``bodies``.
            length: Only so many of the latest positions; 0 for all.

        Returns:
            Positions [m], the oldest first, shape ``(n, 2)``.
        """
        history = self._histories.get(world)
        if history is None:
            return np.zeros((0, 2))
        rows = [row[index] for row in history.positions]
        return np.array(rows[-length:] if length else rows).reshape(-1, 2)

    def clear(self, world: int | None = None) -> None:
        """Forget one world's trajectories, or all."""
        if world is None:
            self._histories.clear()
        else:
            self._histories.pop(world, None)
