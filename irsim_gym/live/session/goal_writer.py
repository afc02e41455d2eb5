"""Goals that are set while a world runs, and those of its start."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.base.arraytypes import Floats
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.world.model import LOOP, STATE, Model


def read_goals(goal: ArrayLike | None) -> Floats:
    """Return goals as rows x, y, heading [m, m, rad], shape ``(n, 3)``; NaN for a heading that is not given.

    Args:
        goal: None, one goal ``[x, y]`` or ``[x, y, heading]``, or several in order.

    Raises:
        ValueError: It is none of these.
    """
    if goal is None:
        return np.zeros((0, 3))
    try:
        rows = [np.asarray(item, np.float64).reshape(-1) for item in (goal if _is_several(goal) else [goal])]
    except (TypeError, ValueError):
        rows = [np.zeros(0)]
    if any(row.size not in (2, 3) or not np.isfinite(row).all() for row in rows):
        raise ValueError(f"a goal is [x, y] or [x, y, heading], or a list of such, got {goal!r}")
    return np.array([[row[0], row[1], row[2] if row.size > 2 else np.nan] for row in rows]).reshape(-1, 3)


def _is_several(goal: ArrayLike) -> TypeGuard[Sequence[ArrayLike]]:
    """Return whether this is a list of goals, and not a single goal as a row or a column of numbers."""
    shape = np.shape(goal[0]) if isinstance(goal, Sequence | np.ndarray) and len(goal) else ()
    return len(shape) > 0 and bool(np.prod(shape) > 1)


@dataclass(frozen=True)
class BodyGoals:
    """The goals of a body as a simulation has them.

    Attributes:
        has_goal: Whether it has any.
        returns: Whether it loops between a single goal and its start.
        rows: Goals in order [m, m, rad], shape ``(n, 3)``; for a body that returns, with its start.
    """

    has_goal: bool
    returns: bool
    rows: Floats


class GoalWriter:
    """Writes goals into a simulation, and stores those that a reset restores."""

    def __init__(self) -> None:
        self._at_start: dict[str, BodyGoals] = {}

    def write(self, simulation: Simulation, body: int, goals: Floats, *, init: bool) -> None:
        """Give a body these goals, the first one next; with ``init`` also after a reset."""
        model, state = simulation.model, simulation.state
        name = simulation.parts.names[body]
        if init:
            self._at_start.pop(name, None)
        elif name not in self._at_start:
            rows = model.waypoints[0, body, : model.waypoint_count[0, body]].copy()
            self._at_start[name] = BodyGoals(bool(model.has_goal[body]), body in simulation.parts.loop_returns, rows)
        returns = model.goal_renewal[body] == LOOP and len(goals) == 1
        # The way back ends at the start; its heading counts only where headings decide about arrival.
        back = model.start[0, body] if model.arrive_mode[body] == STATE else [*model.start[0, body, :2], np.nan]
        rows = np.vstack([goals, back]) if returns else goals
        _put(simulation, body, BodyGoals(len(goals) > 0, returns, rows))
        state.waypoint[0, body], state.waypoint_end[0, body] = 0, len(goals)
        state.arrived[0, body] = False
        if len(goals):
            state.goal[0, body] = goals[0]
            state.goal_distance[0, body] = np.linalg.norm(goals[0, :2] - state.pose[0, body, :2])

    def follow(self, simulation: Simulation) -> None:
        """Forget removed bodies, so that others may use their names."""
        self._at_start = {name: goals for name, goals in self._at_start.items() if name in simulation.parts.names}

    def bring_back(self, simulation: Simulation) -> None:
        """Restore the goals of the start."""
        for name, goals in self._at_start.items():
            _put(simulation, simulation.body(name), goals)
        self._at_start.clear()


def _put(simulation: Simulation, body: int, goals: BodyGoals) -> None:
    model, parts, count = simulation.model, simulation.parts, len(goals.rows)
    make_room(model, count)
    model.waypoints[0, body, :count] = goals.rows
    model.waypoint_count[0, body] = count
    model.has_goal[body] = goals.has_goal
    others = parts.loop_returns[parts.loop_returns != body]
    parts.loop_returns = np.append(others, body) if goals.returns else others
    parts.goal_bodies = np.flatnonzero(model.has_goal)
    simulation.rewire()


def make_room(model: Model, n_goals: int) -> None:
    """Allocate rows for a number of goals of each body."""
    missing = n_goals - model.waypoints.shape[2]
    if missing > 0:
        pads = ((0, 0), (0, 0), (0, missing), (0, 0))
        model.waypoints = np.pad(model.waypoints, pads, constant_values=np.nan)
