"""The present moment of a world, for wrappers: who is where and what robots see. It can be read only.

The names are those of ``world.robot`` and ``world`` of ``irsim_gym.load`` and of behaviours in plain Python. Arrays are
copies that cannot be written into, so they stay as they are when the world goes on.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import Flags, Floats
from irsim_gym.engine import Simulation
from irsim_gym.engine.measures import measure_into
from irsim_gym.errors import UnknownNameError, suggestion
from irsim_gym.world.model import ROBOT

if TYPE_CHECKING:
    from irsim_gym.scenario.spec import BodySpec


class BodyMoment:
    """One body of one world. It holds nothing of its own, so it is always as the world is now."""

    __slots__ = ("_b", "_simulation", "_world")

    def __init__(self, simulation: Simulation, body: int, world: int = 0) -> None:
        self._simulation, self._b, self._world = simulation, body, world

    def __repr__(self) -> str:
        x, y, heading = self.pose
        return f"<{self.name} at ({x:.3g}, {y:.3g}), heading {heading:.3g}>"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, BodyMoment):
            return False
        return other._simulation is self._simulation and (other._b, other._world) == (self._b, self._world)

    def __hash__(self) -> int:
        return hash((id(self._simulation), self._b, self._world))

    @property
    def spec(self) -> BodySpec:
        """What the file says about it."""
        return self._simulation.scenario.bodies[self._b]

    @property
    def name(self) -> str:
        """Its name."""
        return self._simulation.parts.names[self._b]

    @property
    def id(self) -> int:
        """Its number; robots first, then obstacles."""
        return self._b

    @property
    def role(self) -> str:
        """``robot`` or ``obstacle``."""
        return self.spec.role

    @property
    def static(self) -> bool:
        """It never moves."""
        return self.spec.static

    @property
    def pose(self) -> Floats:
        """Position and heading: x, y [m], heading [rad], shape ``(3,)``."""
        return _frozen(self._simulation.state.pose[self._world, self._b])

    @property
    def position(self) -> Floats:
        """x, y [m], shape ``(2,)``."""
        return _frozen(self._simulation.state.pose[self._world, self._b, :2])

    @property
    def velocity(self) -> Floats:
        """Velocity in the drive's coordinates [m/s or rad/s], shape ``(2,)`` or ``(3,)``."""
        size = _command_size(self._simulation, self._b)
        return _frozen(self._simulation.state.velocity[self._world, self._b, :size])

    @property
    def twist(self) -> Floats:
        """Velocity in the world frame: vx, vy [m/s], turn rate [rad/s], shape ``(3,)``."""
        return _frozen(self._simulation.state.twist[self._world, self._b])

    @property
    def steering(self) -> float:
        """Steering angle of a car [rad]."""
        return float(self._simulation.state.steering[self._world, self._b])

    @property
    def goal(self) -> Floats | None:
        """The next goal: x, y [m], heading [rad], shape ``(3,)``; None without one. NaN where any heading will do."""
        if not self._simulation.model.has_goal[self._b]:
            return None
        return _frozen(self._simulation.state.goal[self._world, self._b])

    @property
    def goal_threshold(self) -> float:
        """Distance under which the goal is reached [m]."""
        return float(self._constant(self._simulation.model.goal_threshold))

    @property
    def radius(self) -> float:
        """Radius of the least circle around it [m]."""
        model = self._simulation.model
        radii, middles = np.zeros(model.radius.shape), np.zeros(model.centroid.shape)
        row = self._world % len(radii)
        measure_into(np.array([row], np.int64), np.array([self._b], np.int64), model, radii, middles)
        return float(radii[row, self._b])

    @property
    def segments(self) -> Floats:
        """Straight parts of its outline in the world frame: x0, y0, x1, y1 [m], shape ``(n, 4)``."""
        model = self._simulation.model
        first, count = model.segment_start[self._b], self._constant(model.segment_count)
        return _frozen(self._simulation.state.segments[self._world, first : first + count])

    @property
    def discs(self) -> Floats:
        """Round parts of its outline in the world frame: x, y, radius [m], shape ``(n, 3)``."""
        model = self._simulation.model
        first, count = model.disc_start[self._b], self._constant(model.disc_count)
        return _frozen(self._simulation.state.discs[self._world, first : first + count])

    @property
    def arrived(self) -> bool:
        """It is at its last goal."""
        return bool(self._simulation.state.arrived[self._world, self._b])

    @property
    def collided(self) -> bool:
        """It touches another body."""
        return bool(self._simulation.state.collided[self._world, self._b])

    @property
    def stopped(self) -> bool:
        """A collision holds it in place."""
        return bool(self._simulation.state.stopped[self._world, self._b])

    @property
    def hit(self) -> BodyMoment | None:
        """The body that it touches (the first one), or None."""
        other = int(self._simulation.state.hit[self._world, self._b])
        return None if other < 0 else BodyMoment(self._simulation, other, self._world)

    def scan(self, sensor: int = 0) -> dict[str, Any]:
        """Return the latest scan: ``ranges`` [m], ``(n_beams,)``, ``angle_min``, ``angle_max`` [rad] and so on.

        Args:
            sensor: Which of its range sensors, in the order of the file.

        Raises:
            UnknownNameError: It has no such sensor.
        """
        return _frozen_report(self._simulation.scan_report(self._world, self._b, sensor))

    def scan_points(self, sensor: int = 0) -> Floats | None:
        """Return the points that the latest scan hit, in the sensor's frame [m], shape ``(2, n)``; None without any.

        Raises:
            UnknownNameError: It has no such sensor.
        """
        points = self._simulation.points(self._world, self._b, sensor)
        return None if points is None else _frozen(points)

    def _constant(self, field: NDArray[Any]) -> Any:
        """Return the body's row of a constant that worlds may share."""
        return field[self._world % len(field), self._b]


class Bodies(Sequence[BodyMoment]):
    """Bodies of one world, in the order in which they are stepped; by their place in this list, or by name."""

    def __init__(self, simulation: Simulation, numbers: Sequence[int], world: int = 0) -> None:
        self._simulation, self._numbers, self._world = simulation, list(numbers), world

    def __len__(self) -> int:
        return len(self._numbers)

    @overload
    def __getitem__(self, index: int | str) -> BodyMoment: ...
    @overload
    def __getitem__(self, index: slice) -> Bodies: ...

    def __getitem__(self, index: int | str | slice) -> BodyMoment | Bodies:
        """Return a body by its place or name, or some of them.

        Raises:
            IndexError: There are not so many.
            UnknownNameError: None has that name.
        """
        if isinstance(index, slice):
            return Bodies(self._simulation, self._numbers[index], self._world)
        if isinstance(index, str):
            if index not in self.names:
                raise UnknownNameError(f"no body named '{index}' here{suggestion(index, self.names)}")
            index = self.names.index(index)
        if not -len(self) <= index < len(self):
            raise IndexError(f"body {index}: there are {len(self)}")
        return BodyMoment(self._simulation, self._numbers[index], self._world)

    def __iter__(self) -> Iterator[BodyMoment]:
        return (BodyMoment(self._simulation, b, self._world) for b in self._numbers)

    def __repr__(self) -> str:
        return f"<{len(self)} bodies: {', '.join(self.names[:6])}{', ...' if len(self) > 6 else ''}>"

    @property
    def names(self) -> list[str]:
        """Their names."""
        return [self._simulation.parts.names[b] for b in self._numbers]


class WorldMoment:
    """One world. It holds nothing of its own, so it is always as the world is now.

    Args:
        simulation: The worlds.
        world: Which of them.
    """

    __slots__ = ("_simulation", "_world")

    def __init__(self, simulation: Simulation, world: int = 0) -> None:
        self._simulation, self._world = simulation, world

    def __repr__(self) -> str:
        return f"<{self._simulation.scenario.name} at {self.time:g} s: {len(self.bodies)} bodies>"

    @property
    def time(self) -> float:
        """Time since the start of the episode [s]."""
        return float(self._simulation.state.time[self._world])

    @property
    def step_time(self) -> float:
        """Duration of a step [s]."""
        return float(self._simulation.model.step_time[0])

    @property
    def robot(self) -> BodyMoment:
        """The robot that learns; of several the first."""
        return BodyMoment(self._simulation, int(self._simulation.agents[0]), self._world)

    @property
    def robots(self) -> Bodies:
        """All robots that this level has."""
        return self._bodies(self._simulation.model.role == ROBOT)

    @property
    def bodies(self) -> Bodies:
        """All bodies that this level has, robots first."""
        return self._bodies(np.ones(len(self._simulation.model.role), np.bool_))

    def _bodies(self, chosen: Flags) -> Bodies:
        present = self._simulation.model.present[self._world] & chosen
        return Bodies(self._simulation, np.flatnonzero(present).tolist(), self._world)


class RobotMoments:
    """The first learner of each world of a batch; every array begins with the axis of the worlds."""

    __slots__ = ("_b", "_simulation")

    def __init__(self, simulation: Simulation) -> None:
        self._simulation, self._b = simulation, int(simulation.agents[0])

    def __repr__(self) -> str:
        return f"<{self.name} in {self._simulation.n_worlds} worlds>"

    @property
    def name(self) -> str:
        """Its name."""
        return self._simulation.parts.names[self._b]

    @property
    def pose(self) -> Floats:
        """x, y [m], heading [rad], shape ``(n_worlds, 3)``."""
        return _frozen(self._simulation.state.pose[:, self._b])

    @property
    def velocity(self) -> Floats:
        """Velocity in the drive's coordinates [m/s or rad/s], shape ``(n_worlds, 2)`` or ``(n_worlds, 3)``."""
        return _frozen(self._simulation.state.velocity[:, self._b, : _command_size(self._simulation, self._b)])

    @property
    def twist(self) -> Floats:
        """vx, vy [m/s], turn rate [rad/s] in the world frame, shape ``(n_worlds, 3)``."""
        return _frozen(self._simulation.state.twist[:, self._b])

    @property
    def goal(self) -> Floats | None:
        """The next goals: x, y [m], heading [rad], shape ``(n_worlds, 3)``; None without goals."""
        if not self._simulation.model.has_goal[self._b]:
            return None
        return _frozen(self._simulation.state.goal[:, self._b])

    @property
    def arrived(self) -> Flags:
        """It is at its last goal, shape ``(n_worlds,)``."""
        return _frozen(self._simulation.state.arrived[:, self._b])

    @property
    def collided(self) -> Flags:
        """It touches another body, shape ``(n_worlds,)``."""
        return _frozen(self._simulation.state.collided[:, self._b])

    @property
    def stopped(self) -> Flags:
        """A collision holds it in place, shape ``(n_worlds,)``."""
        return _frozen(self._simulation.state.stopped[:, self._b])

    def scan(self, sensor: int = 0) -> dict[str, Any]:
        """Return the latest scans, as ``BodyMoment.scan`` does; ``ranges`` has shape ``(n_worlds, n_beams)``.

        Raises:
            UnknownNameError: It has no such sensor.
        """
        reports = [self._simulation.scan_report(w, self._b, sensor) for w in range(self._simulation.n_worlds)]
        arrays = [key for key, value in reports[0].items() if isinstance(value, np.ndarray)]
        return _frozen_report({**reports[0], **{key: np.stack([one[key] for one in reports]) for key in arrays}})


def _command_size(simulation: Simulation, body: int) -> int:
    drive = simulation.scenario.bodies[body].kinematics
    return 2 if drive is None else len(drive.command_names)


def _frozen(values: NDArray[Any]) -> NDArray[Any]:
    """Return a copy that cannot be written into."""
    copied = values.copy()
    copied.flags.writeable = False
    return copied


def _frozen_report(report: dict[str, Any]) -> dict[str, Any]:
    return {key: _frozen(value) if isinstance(value, np.ndarray) else value for key, value in report.items()}
