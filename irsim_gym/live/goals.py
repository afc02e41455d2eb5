"""Goals that are set while a world runs, and those of its start."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.engine import Simulation
from irsim_gym.world.model import LOOP, WorldModel


def read_goals(goal: Any) -> Floats:
    """Return goals as rows x, y, heading [m, m, rad], shape ``(n, 3)``; NaN for a heading that is not given.

    Args:
        goal: None, one goal ``[x, y]`` or ``[x, y, heading]``, or several in order.

    Raises:
        ValueError: It is none of these.
    """
    if goal is None:
        return np.zeros((0, 3))
    given = [np.asarray(item, np.float64).reshape(-1) for item in (goal if _is_several(goal) else [goal])]
    if any(row.size not in (2, 3) or not np.isfinite(row).all() for row in given):
        raise ValueError(f"a goal is [x, y] or [x, y, heading], or a list of such, got {goal!r}")
    return np.array([[row[0], row[1], row[2] if row.size > 2 else np.nan] for row in given]).reshape(-1, 3)


def _is_several(goal: Any) -> bool:
    """Return whether this is a list of goals, not one goal in a row or a column of numbers."""
    shape = np.shape(goal[0]) if isinstance(goal, Sequence | np.ndarray) and len(goal) else ()
    return len(shape) > 0 and bool(np.prod(shape) > 1)


class Goals:
    """Writes goals into a simulation, and remembers those that a reset brings back."""

    def __init__(self) -> None:
        self._at_start: dict[str, tuple[bool, int, Floats]] = {}

    def write(self, simulation: Simulation, body: int, goals: Floats, *, init: bool) -> None:
        """Give a body these goals, the first one next; with ``init`` also after a reset."""
        model, state = simulation.model, simulation.state
        name = simulation.parts.names[body]
        if init:
            self._at_start.pop(name, None)
        elif name not in self._at_start:
            kept = bool(model.has_goal[body]), int(model.waypoint_count[0, body]), model.waypoints[0, body].copy()
            self._at_start[name] = kept
        returns = model.goal_renewal[body] == LOOP and len(goals) == 1
        rows = np.vstack([goals, [*model.start[0, body, :2], np.nan]]) if returns else goals
        _put(simulation, body, len(goals) > 0, len(rows), rows)
        state.waypoint[0, body], state.waypoint_end[0, body] = 0, len(goals)
        state.arrived[0, body] = False
        if len(goals):
            state.goal[0, body] = goals[0]
            state.goal_distance[0, body] = np.linalg.norm(goals[0, :2] - state.pose[0, body, :2])

    def bring_back(self, simulation: Simulation) -> None:
        """Give every body the goals that it has at the start again."""
        for name, (has_goal, count, rows) in self._at_start.items():
            if name in simulation.parts.names:
                _put(simulation, simulation.body(name), has_goal, count, rows)
        self._at_start.clear()


def _put(simulation: Simulation, body: int, has_goal: bool, count: int, rows: Floats) -> None:
    model = simulation.model
    make_room(model, len(rows))
    model.waypoints[0, body, : len(rows)] = rows
    model.waypoint_count[0, body] = count
    model.has_goal[body] = has_goal
    simulation.parts.goal_bodies = np.flatnonzero(model.has_goal)


def make_room(model: WorldModel, n_goals: int) -> None:
    """Let every body have up to so many goals."""
    missing = n_goals - model.waypoints.shape[2]
    if missing > 0:
        pads = ((0, 0), (0, 0), (0, missing), (0, 0))
        model.waypoints = np.pad(model.waypoints, pads, constant_values=np.nan)
