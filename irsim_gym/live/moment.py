"""What a body of a world that is run by hand tells, at the moment."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Self

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.live import reports
from irsim_gym.live.vectors import frozen, goal_of, vector

if TYPE_CHECKING:
    from irsim_gym.engine import Simulation
    from irsim_gym.live.crowd import Crowd
    from irsim_gym.scenario.spec import BodySpec


class Moment:
    """Reads what a body is, where it is and what it sees; its arrays are copies that cannot be written into."""

    __slots__ = ("_name", "_world")

    def __init__(self, world: Crowd, name: str) -> None:
        self._world = world
        self._name = name

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._name!r})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Moment) and other._world is self._world and other._name == self._name

    def __hash__(self) -> int:
        return hash((id(self._world), self._name))

    @property
    def _simulation(self) -> Simulation:
        return self._world.simulation

    @property
    def _b(self) -> int:
        return self._world.roster.index(self._name)

    @property
    def _command_size(self) -> int:
        return reports.command_size(self._simulation, self._b)

    def _vector(self, values: Floats) -> Floats:
        """Return numbers as the world gives them away: flat, or as a column."""
        return vector(values, self._world.columns)

    @property
    def spec(self) -> BodySpec:
        """What the file says about it."""
        return self._simulation.scenario.bodies[self._b]

    @property
    def name(self) -> str:
        """Its name."""
        return self._name

    @property
    def id(self) -> int:
        """Its number; robots first, then obstacles, then what was added. Removing a body renumbers no other."""
        return self._world.roster.number(self._name)

    @property
    def role(self) -> str:
        """``robot`` or ``obstacle``."""
        return self.spec.role

    @property
    def group(self) -> int:
        """Number of its group."""
        return self.spec.group

    @property
    def group_name(self) -> str:
        """Name of its group."""
        return self.spec.group_name

    @property
    def static(self) -> bool:
        """It never moves."""
        return self.spec.static

    @property
    def state(self) -> Floats:
        """x, y, heading [m, m, rad], shape ``(3,)``; with the steering angle [rad] of an ``acker`` drive ``(4,)``."""
        state, drive = self._simulation.state, self.spec.kinematics
        steering = [float(state.steering[0, self._b])] if getattr(drive, "state_size", 3) > 3 else []
        return self._vector(np.array([*state.pose[0, self._b], *steering]))

    @property
    def velocity(self) -> Floats:
        """Velocity in the drive's coordinates [m/s or rad/s], shape ``(2,)`` or ``(3,)``."""
        return self._vector(self._simulation.state.velocity[0, self._b, : self._command_size])

    @property
    def twist(self) -> Floats:
        """vx, vy, turn rate in the world frame [m/s, m/s, rad/s], shape ``(3,)``."""
        return self._vector(self._simulation.state.twist[0, self._b])

    @property
    def goal(self) -> Floats | None:
        """The goal that is next: x, y, heading [m, m, rad]; None without one.

        Where any heading will do, it is NaN, or with ``columns`` left out.
        """
        goals = self.goals
        return goal_of(goals[0], self._world.columns) if len(goals) else None

    @property
    def goals(self) -> Floats:
        """The goals that are left in this round, the next one first, shape ``(n, 3)``."""
        simulation, b = self._simulation, self._b
        if not simulation.model.has_goal[b]:
            return frozen(np.zeros((0, 3)))
        left = slice(int(simulation.state.waypoint[0, b]), int(simulation.state.waypoint_end[0, b]))
        return frozen(simulation.model.waypoints[0, b, left])

    @property
    def arrived(self) -> bool:
        """It is at its last goal."""
        return bool(self._simulation.state.arrived[0, self._b])

    @property
    def collided(self) -> bool:
        """It touches another body."""
        return bool(self._simulation.state.collided[0, self._b])

    @property
    def stopped(self) -> bool:
        """A collision holds it in place."""
        return bool(self._simulation.state.stopped[0, self._b])

    @property
    def hit(self) -> Self | None:
        """The body that it touches (the first one), or None."""
        other = int(self._simulation.state.hit[0, self._b])
        return None if other < 0 else type(self)(self._world, self._simulation.parts.names[other])

    @property
    def radius(self) -> float:
        """Radius of the least circle around it [m]."""
        return reports.radius(self._simulation, self._b)

    @property
    def length(self) -> float:
        """Size along its own x axis [m]."""
        return reports.extent(self._simulation, self._b)[0]

    @property
    def width(self) -> float:
        """Size along its own y axis [m]."""
        return reports.extent(self._simulation, self._b)[1]

    @property
    def vertices(self) -> Floats:
        """Corners in the world frame [m], shape ``(n, 2)``; empty for a circle.

        With ``columns`` they are ``(2, n)``, and a circle has 64.
        """
        return reports.corners(self._simulation, self._b, columns=self._world.columns)

    @property
    def trajectory(self) -> Any:
        """Its poses since the reset, the start first [m, m, rad], shape ``(n, 3)``.

        With ``columns`` as IR-SIM has it: a list of its states as columns, one for each step, without the start; empty
        for a body that never moves.
        """
        if not self._world.columns:
            return frozen(self._world.track.poses_of(self._name))
        states = self._world.track.states_of(self._name)[1:, : len(self.state)]
        return [] if self.static else [vector(state, True) for state in states]

    @property
    def info(self) -> reports.RobotInfo:
        """What it is: shape, drive, limits, half-planes."""
        return reports.robot_info(self._simulation, self._b, self.id, self.goal, columns=self._world.columns)

    @property
    def obstacle_info(self) -> reports.ObstacleInfo:
        """Where it is: centre, corners, velocity, half-planes."""
        return reports.obstacle_info(self._simulation, self._b, columns=self._world.columns)

    def scan(self, sensor: int = 0) -> dict[str, Any]:
        """Return a scan under IR-SIM's keys: ``angle_min``, ``angle_max``, ``angle_increment``, ``ranges`` and so on.

        Args:
            sensor: Which of its range sensors, in the order of the file.

        Raises:
            UnknownNameError: It has no such sensor.
        """
        return self._simulation.scan_report(0, self._b, sensor)

    def scan_points(self, sensor: int = 0) -> Floats | None:
        """Return the points that a scan hit, in the sensor's frame [m], shape ``(2, n)``; None without any."""
        return self._simulation.points(0, self._b, sensor)

    def detected(self) -> list[Self]:
        """Return the bodies in its field of view (``fov``, ``fov_radius``); nothing hides what is behind it.

        Raises:
            UnknownNameError: It has no field of view.
        """
        seen = self._simulation.detected(self._b)[0]
        names = self._simulation.parts.names
        return [type(self)(self._world, name) for name, is_seen in zip(names, seen, strict=True) if is_seen]

    @property
    def lidar_offset(self) -> tuple[float, float, float] | None:
        """Mount pose of its first sensor in the body frame [m, m, rad], None without one."""
        return getattr(self.spec.sensors[0], "offset", None) if self.spec.sensors else None
