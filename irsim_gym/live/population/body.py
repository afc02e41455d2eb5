"""One robot or obstacle of a world that a script steps."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.errors import NoEffectWarning, warn_caller
from irsim_gym.live.population import alone, body_info, free_goals
from irsim_gym.live.session import hints
from irsim_gym.live.session.goal_writer import read_goals
from irsim_gym.live.session.painted import HIGHLIGHT
from irsim_gym.live.session.session import Session
from irsim_gym.live.session.vectors import Vector, row_of, vector
from irsim_gym.scenario.specs.spec import BodySpec
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.levels.body_measures import measured
from irsim_gym.simulator.readings.body_readings import BodyReadings
from irsim_gym.simulator.readings.irsim_names import advice, missing
from irsim_gym.simulator.readings.irsim_readings import IrSimReadings
from irsim_gym.simulator.world.arrays import A, frozen
from irsim_gym.simulator.world.group import WorldContext
from irsim_gym.simulator.world.model import Model
from irsim_gym.simulator.world.state import State

STATE = ("x", "y", "heading", "steering")
COASTS = ("x", "y", "angular")
FLAGS = {"collision_flag": "collided", "arrive_flag": "arrived", "stop_flag": "stopped"}
"""IR-SIM's flags that scripts assign, and the fields of the state that hold them."""
LOW, HIGH = (0.0, 0.0, -np.pi), (10.0, 10.0, np.pi)


class Body(IrSimReadings):
    """A view of one body, which always shows the present state.

    Arrays are read-only copies in metres, radians and seconds, flat unless the world has ``columns``. ``set_state``,
    ``set_velocity`` and ``set_goal`` change the body. A view stays valid after resets; after the body was removed, it
    raises an UnknownNameError. If one of IR-SIM's names is missing, the error says what to use instead.

    Args:
        session: What the parts of a world share; ``World.body`` makes views.
        name: Name of the body.
    """

    __slots__ = ("_name", "_session")

    def __init__(self, session: Session, name: str) -> None:
        self._session, self._name = session, name

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._name!r})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Body) and other._session is self._session and other._name == self._name

    def __hash__(self) -> int:
        return hash((id(self._session), self._name))

    if not TYPE_CHECKING:  # a type checker would otherwise accept any name

        def __getattr__(self, name: str) -> NoReturn:
            if name in dir(type(self)) or (name.startswith("_") and name not in advice("body", "script")):
                object.__getattribute__(self, name)  # raises the error of the property itself
            raise AttributeError(missing("a body", name, advice("body", "script"), dir(self)), name=name, obj=self)

        def __setattr__(self, name: str, value: object) -> None:
            if name in FLAGS:
                getattr(self._now, FLAGS[name])[0, self._b] = bool(value)
                return
            if not name.startswith("_"):
                raise AttributeError(hints.unsettable(name, dir(self)), name=name, obj=self)
            object.__setattr__(self, name, value)

    @property
    def _simulation(self) -> Simulation:
        return self._session.simulation

    @property
    def _model(self) -> Model:
        return self._session.simulation.model

    @property
    def _now(self) -> State:
        return self._session.simulation.state

    @property
    def _w(self) -> int:
        return 0

    @property
    def _b(self) -> int:
        return self._session.roster.index(self._name)

    @property
    def _context(self) -> WorldContext:
        return self._session.simulation.context

    @property
    def _columns(self) -> bool:
        return self._session.columns

    @property
    def _measures(self) -> tuple[Floats, Floats]:
        return measured(self._model, 0, self._b)

    def _array(self, values: Floats) -> Floats:
        return frozen(values)

    def _vector(self, values: Floats) -> Floats:
        return vector(values, self._session.columns)

    def _reading(self, values: A) -> A:
        return values

    def _body(self, index: int) -> Body:
        return Body(self._session, self._session.simulation.parts.names[index])

    @property
    def spec(self) -> BodySpec:
        """Its entry in the file."""
        return self._session.simulation.scenario.bodies[self._b]

    @property
    def name(self) -> str:
        """Its name."""
        return self._name

    @property
    def id(self) -> int:
        """Its number. Robots come first, then obstacles, then added bodies. Numbers never change."""
        return self._session.roster.number(self._name)

    @property
    def _state(self) -> Floats:
        return self.state.view(Vector)

    @_state.setter
    def _state(self, state: Floats) -> None:
        self.set_state(state)

    @property
    def velocity(self) -> Floats:
        """Velocity in the drive's coordinates [m/s or rad/s], shape ``(2,)`` or ``(3,)``."""
        return self._vector(self._now.velocity[0, self._b, : self._command_size])

    @property
    def trajectory(self) -> Floats | list[Floats]:
        """Its poses since the reset, from the start on [m, m, rad], shape ``(n, 3)``.

        With ``columns``, a list of its states as columns, one for each step, without the start, as in IR-SIM. The list
        is empty for a body that never moves.
        """
        track = self._session.track
        if not self._columns:
            return frozen(track.poses_of(self._name))
        states = track.states_of(self._name)[1:, : len(self.state)]
        return [] if self.static else [vector(state, True) for state in states]

    @property
    def info(self) -> body_info.RobotInfo:
        """Its properties: shape, drive, limits, half-planes."""
        model = self._model
        fields = (model.velocity_min, model.velocity_max, model.acceleration_limit)
        least, greatest, changes = map(self._limit, fields)
        limits, kept = (least, greatest, changes), self._session.properties.setdefault(self._name, {})
        return body_info.robot_info(self, limits, self.get_init_Gh(), kept, columns=self._columns)

    @property
    def obstacle_info(self) -> body_info.ObstacleInfo:
        """Its place and motion: centre, corners, velocity, half-planes."""
        return body_info.obstacle_info(self, self.get_init_Gh())

    def get_info(self) -> body_info.RobotInfo:
        """Return ``info``."""
        return self.info

    def get_obstacle_info(self) -> body_info.ObstacleInfo:
        """Return ``obstacle_info``."""
        return self.obstacle_info

    @property
    def init_state(self) -> Floats:
        """The state after ``World.reset``, in the form and shape of ``state``."""
        model, size = self._model, getattr(self.spec.kinematics, "state_size", 3)
        return self._vector(np.array([*model.start[0, self._b], model.initial_steering[self._b]])[:size])

    def get_Gh(self) -> body_info.HalfPlanes:  # noqa: N802
        """Return G, h, ``cone_type`` and ``convex_flag`` of its outline in the world frame; see ``info``."""
        return self._half_planes(local=False)

    def get_init_Gh(self) -> body_info.HalfPlanes:  # noqa: N802
        """Return G, h, ``cone_type`` and ``convex_flag`` of its outline in its own frame; see ``info``."""
        return self._half_planes(local=True)

    def _half_planes(self, *, local: bool) -> body_info.HalfPlanes:
        outline = self._outline(local=local)
        normals, offsets, cone = body_info.half_planes(*outline, solid=bool(self._model.solid[self._b]))
        offsets = None if offsets is None else self._vector(offsets)
        return body_info.HalfPlanes(normals, offsets, cone, cone is not None)

    def clear_flags(self) -> None:
        """Set ``collided``, ``arrived`` and ``stopped`` to False until the next step finds them again.

        After ``set_state`` away from a collision, a stopped body would else lose its next step. ``collision_flag``,
        ``arrive_flag`` and ``stop_flag`` may also be assigned, as in IR-SIM.
        """
        for field in FLAGS.values():
            getattr(self._now, field)[0, self._b] = False

    def step(self, velocity: Sequence[float] | Floats | None = None, sensor_step: bool = True) -> Floats:
        """Move it alone for one step, within its limits, and return ``state``, in its shape.

        Time, other bodies and flags stay.

        Args:
            velocity: A command of its drive [m/s or rad/s], shape ``(n,)`` or a column; None for that of its behaviour.
            sensor_step: Take new scans.

        Raises:
            ValueError: The command has a wrong length.
        """
        alone.move(self._simulation, self._b, None if velocity is None else np.asarray(velocity, np.float64).ravel())
        if sensor_step:
            self.sensor_step()
        return self.state

    def sensor_step(self) -> None:
        """Take new scans of all bodies at their present places; ``World.refresh`` also updates flags."""
        alone.sense(self._simulation)

    def check_status(self) -> None:
        """Update the flags of all bodies from their present places; ``World.refresh`` also takes scans."""
        alone.find_flags(self._simulation)

    check_arrive_status = check_collision_status = check_status

    def set_state(self, state: Sequence[float] | Floats | None, *, init: bool = False) -> None:
        """Move it to a state.

        The outline moves at once. The next step, or ``World.refresh``, updates flags and readings.

        Args:
            state: x, y, heading [m, m, rad] and for ``acker`` the steering angle [rad]; a missing angle is 0. Shape
                ``(3,)`` or ``(4,)``; a column is accepted too. None means zeros.
            init: Start there after a reset, too.

        Raises:
            ValueError: There are too few or too many numbers, one is not finite, or the body is the obstacle map.
        """
        simulation, b = self._simulation, self._b
        body_info.refuse_map(simulation, b)
        names = STATE[: getattr(self.spec.kinematics, "state_size", 3)]
        row = _numbers([0.0, 0.0] if state is None else state, 2, names, f"a state of '{self._name}'")
        simulation.state.pose[0, b], simulation.state.steering[0, b] = row[:3], row[3]
        if init:
            simulation.model.start[0, b], simulation.model.initial_steering[b] = row[:3], row[3]
        simulation.place(np.array([b], np.int64))

    def set_velocity(self, velocity: Sequence[float] | Floats, *, init: bool = False) -> None:
        """Set its present velocity. Acceleration limits apply to it, and the behaviours of others see it.

        Args:
            velocity: Velocity in the drive's coordinates [m/s or rad/s], shape ``(n_components,)`` or a column.
            init: Start with it after a reset, too.

        Raises:
            ValueError: The body never moves, there are too few or too many numbers, or one is not finite.
        """
        simulation, b = self._simulation, self._b
        if self.static:
            raise ValueError(f"'{self._name}' never moves, so it has no velocity")
        names = COASTS if self.spec.kinematics is None else self.spec.kinematics.command_names
        row = _numbers(velocity, len(names), names, f"a velocity of '{self._name}'")
        simulation.state.velocity[0, b] = row[:3]
        if (pushing := simulation.parts.pushing) is not None:
            pushing.drive[0, b] = row[:3]
        if init:
            simulation.model.initial_velocity[b] = row[:3]
        simulation.place(np.array([b], np.int64))

    def set_goal(self, goal: ArrayLike | None, *, init: bool = False) -> None:
        """Replace its goals.

        Args:
            goal: ``[x, y]`` or ``[x, y, heading]`` [m, m, rad], several of them in order, or None for no goal.
            init: Keep them after a reset, too.

        Raises:
            ValueError: ``goal`` has another form.
        """
        self._session.goals.write(self._simulation, self._b, read_goals(goal), init=init)

    def set_random_goal(
        self,
        obstacle_list: Iterable[BodyReadings] = (),
        init: bool = False,
        free: bool = True,
        goal_check_radius: float = 0.2,
        range_limits: Sequence[Sequence[float]] | None = None,
        max_attempts: int = 100,
    ) -> None:
        """Replace each remaining goal by one that is drawn from the world's random stream.

        If no drawn place is clear of the obstacles, the last one is used, with a warning, as in IR-SIM.

        Args:
            obstacle_list: Bodies that a goal must not touch.
            init: Keep the goals after a reset, too.
            free: Whether goals must be clear of these bodies.
            goal_check_radius: Radius around a goal that must be clear [m].
            range_limits: Minimum and maximum x, y, heading [m, m, rad]. Default: ``range_low`` and ``range_high`` of
                its behavior, or else ``[0, 0, -pi]`` and ``[10, 10, pi]``.
            max_attempts: Maximum number of draws for each goal.

        Raises:
            ValueError: The limits are not valid, or ``max_attempts`` is less than 1.
        """
        behavior = self.spec.behavior
        low, high = range_limits or (getattr(behavior, "range_low", LOW), getattr(behavior, "range_high", HIGH))
        if max_attempts < 1:
            raise ValueError(f"max_attempts is 1 or more, got {max_attempts!r}")
        others = [self._body(self._session.roster.index(body.name)) for body in obstacle_list] if free else []
        areas = [free_goals.area(body) for body in others]
        drawn = []
        for _ in range(max(len(self.goals), 1)):
            goal, is_clear = free_goals.draw(self._simulation, low, high, areas, goal_check_radius, max_attempts)
            drawn.append(goal)
            if not is_clear:
                message = f"no place clear of the obstacles for a goal of '{self._name}' in {max_attempts} draws"
                warn_caller(message, NoEffectWarning)
        self._session.goals.write(self._simulation, self._b, np.array(drawn), init=init)

    def set_laser_color(self, laser_indices: Iterable[int], laser_color: str | None = None, alpha: float = 0.3) -> None:
        """Draw some beams of its first range sensor in another colour over their own, until the next call.

        Args:
            laser_indices: Numbers of these beams; numbers without a beam are ignored.
            laser_color: Colour of these beams (default: orange).
            alpha: Opacity of this colour.

        Raises:
            UnknownNameError: The body has no range sensor.
            ValueError: The colour is unknown, or the opacity is not between 0 and 1.
        """
        self._range_sensor(0)
        self._session.painted.paint(self._name, laser_indices, laser_color or HIGHLIGHT, alpha)

    def append_goal(self, goal: ArrayLike) -> None:
        """Append goals to the remaining ones."""
        self._session.goals.write(self._simulation, self._b, np.vstack([self.goals, read_goals(goal)]), init=False)


def _numbers(values: Sequence[float] | Floats, least: int, names: Sequence[str], what: str) -> Floats:
    """Return four numbers, 0 for those that are not given."""
    given = row_of(values)
    if not least <= given.size <= len(names) or not np.isfinite(given).all():
        count = f"{least}" if least == len(names) else f"{least} to {len(names)}"
        raise ValueError(f"{what} has {count} finite numbers ({', '.join(names)}), got {values!r}")
    return np.pad(given, (0, 4 - given.size))
