"""Where bodies have been, as far as frames were drawn."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from irsim_gym.arraytypes import Floats, Ints

LONGEST = 4096


@dataclass
class _History:
    """Poses of the tracked bodies in one world's present episode."""

    start: bytes
    steps: deque[int] = field(default_factory=lambda: deque(maxlen=LONGEST))
    poses: deque[Floats] = field(default_factory=lambda: deque(maxlen=LONGEST))


class Trails:
    """Poses of some bodies since their episode began, for every world that is drawn.

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
        if history is None or history.start != key or step < history.steps[-1]:
            history = self._histories[world] = _History(key)
        elif step == history.steps[-1]:
            history.steps.pop()
            history.poses.pop()
        history.steps.append(step)
        history.poses.append(pose[self.bodies])

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
        history = self._histories.get(world)
        if history is None:
            return np.zeros((0, 3))
        rows = [pose[index] for step, pose in zip(history.steps, history.poses, strict=True) if step % every == 0]
        return np.array(rows[-length:] if length else rows).reshape(-1, 3)

    def clear(self, world: int | None = None) -> None:
        """Forget one world's trajectories, or all."""
        if world is None:
            self._histories.clear()
        else:
            self._histories.pop(world, None)
