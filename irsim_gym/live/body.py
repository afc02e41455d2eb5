"""One robot or obstacle of a world that is run by hand."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.live import reports
from irsim_gym.live.goals import read_goals

if TYPE_CHECKING:
    from irsim_gym.engine import Simulation
    from irsim_gym.live.crowd import Crowd
    from irsim_gym.scenario.spec import BodySpec


class Body:
    """A view of one body. It holds no state of its own, so it is always as the world is now.

    Arrays are flat, copies, in metres, radians and seconds. A view outlives resets; a body that was removed
    answers with an UnknownNameError.
    """

    def __init__(self, world: Crowd, name: str) -> None:
        self._world = world
        self._name = name

    def __repr__(self) -> str:
        return f"Body({self._name!r})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Body) and other._world is self._world and other._name == self._name

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
        return np.array([*state.pose[0, self._b], *steering])

    @property
    def velocity(self) -> Floats:
        """Velocity in the drive's coordinates [m/s or rad/s], shape ``(2,)`` or ``(3,)``."""
        velocity: Floats = self._simulation.state.velocity[0, self._b, : self._command_size].copy()
        return velocity

    @property
    def twist(self) -> Floats:
        """vx, vy, turn rate in the world frame [m/s, m/s, rad/s], shape ``(3,)``."""
        twist: Floats = self._simulation.state.twist[0, self._b].copy()
        return twist

    @property
    def goal(self) -> Floats | None:
        """The goal that is next: x, y, heading [m, m, rad], NaN for any heading; None without one."""
        return self.goals[0] if len(self.goals) else None

    @property
    def goals(self) -> Floats:
        """The goals that are left in this round, the next one first, shape ``(n, 3)``."""
        simulation, b = self._simulation, self._b
        if not simulation.model.has_goal[b]:
            return np.zeros((0, 3))
        left = slice(int(simulation.state.waypoint[0, b]), int(simulation.state.waypoint_end[0, b]))
        goals: Floats = simulation.model.waypoints[0, b, left].copy()
        return goals

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
    def hit(self) -> Body | None:
        """The body that it touches (the first one), or None."""
        other = int(self._simulation.state.hit[0, self._b])
        return None if other < 0 else Body(self._world, self._simulation.parts.names[other])

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
        """Corners in the world frame [m], shape ``(n, 2)``; empty for a circle."""
        return reports.outline_rows(self._simulation, self._b)[0][:, :2].copy()

    @property
    def trajectory(self) -> Floats:
        """Its poses since the reset, the start first [m, m, rad], shape ``(n, 3)``."""
        return self._world.track.poses_of(self._name)

    @property
    def info(self) -> reports.RobotInfo:
        """What it is: shape, drive, limits, half-planes."""
        return reports.robot_info(self._simulation, self._b, self.id, self.goal)

    @property
    def obstacle_info(self) -> reports.ObstacleInfo:
        """Where it is: centre, corners, velocity, half-planes."""
        return reports.obstacle_info(self._simulation, self._b)

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

    def detected(self) -> list[Body]:
        """Return the bodies in its field of view (``fov``, ``fov_radius``); nothing hides what is behind it.

        Raises:
            UnknownNameError: It has no field of view.
        """
        seen = self._simulation.detected(self._b)[0]
        return [
            Body(self._world, name) for name, is_seen in zip(self._simulation.parts.names, seen, strict=True) if is_seen
        ]

    @property
    def lidar_offset(self) -> tuple[float, float, float] | None:
        """Mount pose of its first sensor in the body frame [m, m, rad], None without one."""
        return self.spec.sensors[0].offset if self.spec.sensors else None

    def set_state(self, state: Sequence[float] | Floats, *, init: bool = False) -> None:
        """Put it somewhere.

        The outline follows at once; flags and readings follow with the next step or ``World.refresh``.

        Args:
            state: x, y, heading [m, m, rad] and for ``acker`` the steering angle [rad]; missing numbers are 0.
            init: Begin there after a reset as well.

        Raises:
            ValueError: There are too many numbers, one is not finite, or it is the obstacle map.
        """
        simulation, b = self._simulation, self._b
        if reports.is_map(simulation, b):
            raise ValueError(f"'{self._name}' is the obstacle map: its cells stay where they are")
        size = getattr(self.spec.kinematics, "state_size", 3)
        row = _numbers(state, size, "a state")
        simulation.state.pose[0, b], simulation.state.steering[0, b] = row[:3], row[3]
        if init:
            simulation.model.start[0, b], simulation.model.initial_steering[b] = row[:3], row[3]
        simulation.place(np.array([b], np.int64))

    def set_velocity(self, velocity: Sequence[float] | Floats, *, init: bool = False) -> None:
        """Say how fast it is now, which acceleration limits and the others' behaviours start from.

        Args:
            velocity: In the drive's coordinates [m/s or rad/s]; missing numbers are 0.
            init: Begin with it after a reset as well.

        Raises:
            ValueError: It has no drive, there are too many numbers, or one is not finite.
        """
        simulation, b = self._simulation, self._b
        if self.spec.kinematics is None:
            raise ValueError(f"'{self._name}' has no drive, so no velocity")
        row = _numbers(velocity, self._command_size, "a velocity")
        simulation.state.velocity[0, b] = row[:3]
        if init:
            simulation.model.initial_velocity[b] = row[:3]
        simulation.place(np.array([b], np.int64))

    def set_goal(self, goal: Any, *, init: bool = False) -> None:
        """Give it other goals.

        Args:
            goal: ``[x, y]`` or ``[x, y, heading]`` [m, m, rad], several of them in order, or None for no goal.
            init: Have them after a reset as well.

        Raises:
            ValueError: It is none of these.
        """
        self._world.goals.write(self._simulation, self._b, read_goals(goal), init=init)

    def append_goal(self, goal: Any) -> None:
        """Add goals behind those that are left."""
        self._world.goals.write(self._simulation, self._b, np.vstack([self.goals, read_goals(goal)]), init=False)


def _numbers(values: Sequence[float] | Floats, size: int, what: str) -> Floats:
    """Return four numbers, those that are not given as 0."""
    given = np.asarray(values, np.float64).reshape(-1)
    if not 0 < given.size <= size or not np.isfinite(given).all():
        raise ValueError(f"{what} has up to {size} finite numbers, got {given.tolist()}")
    row = np.zeros(4)
    row[: given.size] = given
    return row
