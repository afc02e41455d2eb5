"""The names that a behaviour in plain Python has for what a body tells: they are the same in a script."""

from __future__ import annotations

import math

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.engine.measures import measure_into
from irsim_gym.live import reports
from irsim_gym.live.moment import Moment
from irsim_gym.live.vectors import frozen, points


class ViewNames(Moment):
    """Names of behaviours' views (``irsim_gym.behavior``); their arrays are always flat."""

    __slots__ = ()

    @property
    def pose(self) -> Floats:
        """Position and heading: x, y [m], heading [rad]."""
        return frozen(self._simulation.state.pose[0, self._b])

    @property
    def steering(self) -> float:
        """Steering angle of a car [rad]."""
        return float(self._simulation.state.steering[0, self._b])

    @property
    def center(self) -> Floats:
        """Centre of the footprint's area in the world frame: x, y [m]."""
        model, b = self._simulation.model, self._b
        radii, centers = np.zeros(model.radius.shape), np.zeros(model.centroid.shape)
        measure_into(np.zeros(1, np.int64), np.array([b], np.int64), model, radii, centers)
        x, y, heading = self.pose
        (ahead, left), cosine, sine = centers[0, b], math.cos(heading), math.sin(heading)
        return frozen(np.array([x + cosine * ahead - sine * left, y + sine * ahead + cosine * left]))

    @property
    def segments(self) -> Floats:
        """Straight parts of the outline in the world frame: x0, y0, x1, y1 [m], shape ``(n, 4)``."""
        return frozen(reports.outline_rows(self._simulation, self._b)[0])

    @property
    def discs(self) -> Floats:
        """Round parts of the outline in the world frame: x, y, radius [m], shape ``(n, 3)``."""
        return frozen(reports.outline_rows(self._simulation, self._b)[1])

    @property
    def goal_vertices(self) -> Floats | None:
        """Corners where it stands on its next goal [m], shape ``(n, 2)``, with columns ``(2, n)``; None without a goal.

        Its heading is kept where any will do.
        """
        if not self._simulation.model.has_goal[self._b]:
            return None
        x, y, heading = self._simulation.state.goal[0, self._b]
        heading = self.pose[2] if math.isnan(heading) else heading
        segments = reports.outline_rows(self._simulation, self._b, local=True)[0]
        corners = segments[:, :2]
        if len(segments) and not np.array_equal(segments[-1, 2:], segments[0, :2]):
            corners = np.vstack([corners, segments[-1:, 2:]])
        cosine, sine = math.cos(heading), math.sin(heading)
        placed: Floats = corners @ np.array([[cosine, sine], [-sine, cosine]]) + np.array([x, y])
        return points(placed, self._world.columns)

    @property
    def is_movable(self) -> bool:
        """False for a body that never moves."""
        return bool(self._simulation.model.movable[self._b])

    @property
    def is_unobstructed(self) -> bool:
        """True for a body that touches nobody."""
        return bool(self._simulation.model.unobstructed[self._b])

    @property
    def is_stopped(self) -> bool:
        """True while a collision holds the body in place."""
        return self.stopped

    @property
    def has_collided(self) -> bool:
        """True while it touches another body."""
        return self.collided

    @property
    def has_arrived(self) -> bool:
        """True while it is at its last goal."""
        return self.arrived

    @property
    def velocity_min(self) -> Floats:
        """Least velocities in the drive's coordinates [m/s or rad/s], shape ``(3,)``; unused numbers are 0."""
        return frozen(self._simulation.model.velocity_min[0, self._b])

    @property
    def velocity_max(self) -> Floats:
        """Greatest velocities in the drive's coordinates [m/s or rad/s], shape ``(3,)``; unused numbers are 0."""
        return frozen(self._simulation.model.velocity_max[0, self._b])

    @property
    def acceleration_limit(self) -> Floats:
        """Greatest changes of the velocities per second [m/s2 or rad/s2], shape ``(3,)``; may be infinite."""
        return frozen(self._simulation.model.acceleration_limit[0, self._b])

    @property
    def time(self) -> float:
        """Time since the start of the episode [s]; that of the world."""
        return float(self._simulation.state.time[0])

    @property
    def step_time(self) -> float:
        """Duration of a step [s]; that of the world."""
        return float(self._simulation.model.step_time[0])
