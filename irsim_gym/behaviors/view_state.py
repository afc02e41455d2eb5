"""What a view of a body reads: the state, the file's words, the sensors; for behaviours written in Python."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from irsim_gym import families
from irsim_gym.arraytypes import Floats
from irsim_gym.errors import UnknownNameError, suggestion
from irsim_gym.world.company import Company, find_sensor
from irsim_gym.world.group import Group
from irsim_gym.world.model import ROBOT, WorldModel
from irsim_gym.world.state import WorldState

CORNERS = 64
"""Points that stand for the outline of a circle, where arrays are columns."""

_ANSWER = "a behaviour only looks at bodies: it returns the command of its own"
_SCRIPT = "a behaviour sees the moment alone; ask the world, in the script"
INSTEAD: dict[str, str] = {
    "set_state": _ANSWER,
    "set_velocity": _ANSWER,
    "set_goal": _ANSWER,
    "append_goal": _ANSWER,
    "set_random_goal": f"{_ANSWER}; behavior: {{wander: true}} draws goals",
    "set_laser_color": "a behaviour draws nothing; a script colours beams with world.robot.set_laser_color()",
    "trajectory": "keep what it needs in ego.memory",
    "info": "its names are here themselves: shape, kinematics, vel_min, vel_max, goal",
    "get_info": "its names are here themselves: shape, kinematics, vel_min, vel_max, goal",
    "obstacle_info": "use center, vertices, velocity_xy, radius",
    "get_obstacle_info": "use center, vertices, velocity_xy, radius",
    "get_Gh": "use segments and discs",
    "get_init_Gh": "use segments and discs",
    "init_state": "keep what it needs in ego.memory",
    "geometry": "use vertices, segments, discs, radius",
    "original_geometry": "use spec.shape",
    "lidar": "scan() is its scan, scan_points() its points, lidar_offset its mount",
    "gf": "use shape, vertices, spec.shape",
    "kf": "use kinematics, spec.kinematics",
    "beh_config": "options are the function's keyword parameters; spec.behavior has all of them",
    "logger": "use Python's own logging",
    "world_param": "use time and step_time",
    "env_param": _SCRIPT,
    "plot": _SCRIPT,
    "step": _ANSWER,
}
"""For names of ``world.robot`` and of IR-SIM's objects that views do not have: what to use."""


class StateView:
    """A body at the moment, in one of the worlds."""

    __slots__ = ("_columns", "_group", "_model", "_state", "_world", "id", "name")

    def __init__(self, group: Group, model: WorldModel, state: WorldState, world: int, body: int) -> None:
        self._group = group
        self._columns: bool = group.kind.columns
        self._model, self._state, self._world = model, state, world
        self.id = body
        self.name = group.names[body] if group.names else f"body {body}"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, StateView):
            return False
        return other._state is self._state and (other._world, other.id) == (self._world, self.id)

    def __hash__(self) -> int:
        return hash((id(self._state), self._world, self.id))

    @property
    def spec(self) -> Any:
        """What the file says about it."""
        return self._company.bodies[self.id]

    @property
    def _company(self) -> Company:
        assert self._group.company is not None, "whoever makes a group by hand has to give it company"
        return self._group.company

    @property
    def state(self) -> Floats:
        """x, y, heading [m, m, rad], shape ``(3,)``; with the steering angle [rad] of an ``acker`` drive ``(4,)``."""
        pose, steering = self._state.pose[self._world, self.id], self._state.steering[self._world, self.id]
        return self._vector(np.append(pose, steering)[: getattr(self.spec.kinematics, "state_size", 3)])

    @property
    def goals(self) -> Floats:
        """The goals that are left in this round, the next one first, shape ``(n, 3)``."""
        if not self._model.has_goal[self.id]:
            return np.zeros((0, 3))
        w, b = self._world, self.id
        left = slice(int(self._state.waypoint[w, b]), int(self._state.waypoint_end[w, b]))
        return np.array(self._model.waypoints[w, b, left])

    @property
    def vertices(self) -> Floats:
        """Corners in the world frame [m], shape ``(n, 2)``; empty for a circle.

        Where arrays are columns they are ``(2, n)``, and a circle has 64.
        """
        first, disc = self._model.segment_start[self.id], self._model.disc_start[self.id]
        segments = self._state.segments[self._world, first : first + self._of(self._model.segment_count)]
        discs = self._state.discs[self._world, disc : disc + self._of(self._model.disc_count)]
        return self._corners(segments, discs, self._state.pose[self._world, self.id, 2])

    @property
    def goal_vertices(self) -> Floats | None:
        """Corners where it stands on its next goal, as ``vertices``; its heading is kept where any will do."""
        model, w, b = self._model, self._world, self.id
        if not model.has_goal[b]:
            return None
        x, y, heading = self._state.goal[w, b]
        heading = self._state.pose[w, b, 2] if np.isnan(heading) else heading
        cosine, sine = math.cos(heading), math.sin(heading)
        turn, place = np.array([[cosine, sine], [-sine, cosine]]), np.array([x, y])
        segments, discs = self._local_rows()
        placed = np.hstack([segments[:, :2] @ turn + place, segments[:, 2:] @ turn + place])
        return self._corners(placed, np.column_stack([discs[:, :2] @ turn + place, discs[:, 2]]), heading)

    def _local_rows(self) -> tuple[Floats, Floats]:
        """Return segments and discs of its outline in its own frame."""
        model, w, b = self._model, self._world, self.id
        first, disc = model.segment_start[b], model.disc_start[b]
        segments = model.local_segments[w % len(model.local_segments), first : first + self._of(model.segment_count)]
        return segments, model.local_discs[w % len(model.local_discs), disc : disc + self._of(model.disc_count)]

    def _corners(self, segments: Floats, discs: Floats, heading: float) -> Floats:
        """Return the corners of an outline whose body has a heading."""
        corners = np.array(segments[:, :2])
        if len(segments) and not np.array_equal(segments[-1, 2:], segments[0, :2]):
            corners = np.vstack([corners, segments[-1:, 2:]])
        if self._columns and len(discs) == 1 and not len(segments):
            turns = heading - np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False)
            corners = discs[0, :2] + discs[0, 2] * np.column_stack([np.cos(turns), np.sin(turns)])
        return corners.T.copy() if self._columns else corners

    def scan(self, sensor: int = 0) -> dict[str, Any]:
        """Return the latest scan under IR-SIM's keys: ``angle_min``, ``angle_max``, ``ranges`` and so on.

        Args:
            sensor: Which of its range sensors, in the order of the file.

        Raises:
            UnknownNameError: It has no such sensor.
        """
        group, member = self._range_sensor(sensor)
        report: dict[str, Any] = group.kind.report(group, member, self._world)
        return report

    def scan_points(self, sensor: int = 0) -> Floats | None:
        """Return the points that the latest scan hit, in the sensor's frame [m], shape ``(2, n)``; None without any."""
        group, member = self._range_sensor(sensor)
        points: Floats | None = group.kind.points(group, member, self._world)
        return points

    def _range_sensor(self, index: int) -> tuple[Group, int]:
        found = find_sensor(self._company.bodies, self._company.sensors, self.id, "ranges", index)
        if found is None:
            raise UnknownNameError(f"'{self.name}' has no range sensor number {index}")
        return found

    @property
    def lidar_offset(self) -> tuple[float, float, float] | None:
        """Mount pose of its first sensor in the body frame [m, m, rad], None without one."""
        return self.spec.sensors[0].offset if self.spec.sensors else None

    def _numbers_in_view(self) -> list[int]:
        spec = self.spec
        if spec.fov is None or spec.fov_radius is None:
            raise UnknownNameError(f"'{self.name}' has no field of view: give it fov and fov_radius")
        found = np.zeros(self._model.present.shape, np.bool_)
        here = np.array([self._world], np.int64)
        self._company.detect(here, self.id, spec.fov, spec.fov_radius, self._model, self._state, found)
        return [int(b) for b in np.flatnonzero(found[self._world])]

    @property
    def role(self) -> str:
        """``robot`` or ``obstacle``."""
        return "robot" if self._model.role[self.id] == ROBOT else "obstacle"

    @property
    def shape(self) -> str:
        """Name of its shape; ``map`` for the obstacle map."""
        is_map = int(self._model.map_frame[0].body) == self.id
        return "map" if is_map else families.FOOTPRINTS.name_of(type(self.spec.shape))

    @property
    def kinematics(self) -> str | None:
        """Name of its drive, None without one."""
        drive = self.spec.kinematics
        return None if drive is None else families.KINEMATICS.name_of(type(drive))

    @property
    def _command_size(self) -> int:
        drive = self.spec.kinematics
        return 2 if drive is None else len(drive.command_names)

    def _vector(self, values: Floats) -> Floats:
        """Return a copy of numbers, flat or as a column."""
        copied = np.array(values, np.float64)
        return copied.reshape(-1, 1) if self._columns else copied

    def _of(self, field: Any) -> Any:
        """Return the body's row of a constant that worlds may share."""
        return field[self._world % field.shape[0], self.id]


def tell_missing(error: AttributeError) -> None:
    """Let an error about a name that a view does not have say what to use.

    Views have no ``__getattr__`` for it, which would make each of their names slower.
    """
    view, name = error.obj, error.name
    if not isinstance(view, StateView) or name is None or name in dir(type(view)):
        return
    hint = f": {INSTEAD[name]}" if name in INSTEAD else suggestion(name, [one for one in dir(view) if one[0] != "_"])
    error.args = (f"a body in a behaviour has no '{name}'{hint}",)
