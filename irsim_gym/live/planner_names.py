"""IR-SIM's names for what planners ask of a body: what it wants, what it can do next, and what it is as a disc."""

from __future__ import annotations

import math

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.live import reports
from irsim_gym.live.body_names import BodyNames
from irsim_gym.world.model import OMNI_BODY, OMNI_WORLD

MARGIN = 0.1
ARRIVED = 0.1

HalfPlanes = tuple[Floats | None, Floats | None, str | None, bool]


class PlannerNames(BodyNames):
    """What planners ask of a body, as IR-SIM works it out."""

    __slots__ = ()

    @property
    def max_speed(self) -> float:
        """Greatest speed over ground [m/s]; 0 without a drive."""
        if self.spec.kinematics is None:
            return 0.0
        fastest = self._simulation.model.velocity_max[0, self._b]
        return math.hypot(fastest[0], fastest[1]) if self._is_sideways else float(fastest[0])

    def get_vel_range(self) -> tuple[Floats, Floats]:
        """Return least and greatest velocities of the next step [m/s or rad/s], which acceleration limits narrow."""
        model, b, size = self._simulation.model, self._b, self._command_size
        window = model.acceleration_limit[0, b, :size] * self._simulation.scenario.world.step_time
        now = self._simulation.state.velocity[0, b, :size]
        least = np.maximum(model.velocity_min[0, b, :size], now - window)
        greatest = np.minimum(model.velocity_max[0, b, :size], now + window)
        return self._vector(least), self._vector(greatest)

    @property
    def desired_omni_vel(self) -> Floats:
        """``get_desired_omni_vel()``."""
        return self.get_desired_omni_vel()

    def get_desired_omni_vel(self, goal_threshold: float = ARRIVED, normalized: bool = False) -> Floats:
        """Return the velocity straight to the goal at full speed, in the world frame [m/s], shape ``(2,)``.

        Args:
            goal_threshold: Nearer to the goal than this it is 0 [m].
            normalized: Cut it to 1 m/s.
        """
        return self._vector(np.array(self._desired(goal_threshold, normalized)))

    def _desired(self, goal_threshold: float = ARRIVED, normalized: bool = False) -> tuple[float, float]:
        goals, (x, y) = self.goals, self._simulation.state.pose[0, self._b, :2]
        if not len(goals) or math.hypot(goals[0, 0] - x, goals[0, 1] - y) <= goal_threshold:
            return 0.0, 0.0
        ahead, aside = map(float, self._simulation.model.velocity_max[0, self._b, :2])
        bearing = math.atan2(goals[0, 1] - y, goals[0, 0] - x)
        vx, vy = ahead * math.cos(bearing), (aside if self._is_sideways else ahead) * math.sin(bearing)
        speed = max(math.hypot(vx, vy), 1.0) if normalized else 1.0
        return vx / speed, vy / speed

    @property
    def _is_sideways(self) -> bool:
        """Its first two velocities are those along x and y."""
        return self.spec.kinematics is None or self._simulation.model.drive[self._b] in (OMNI_WORLD, OMNI_BODY)

    @property
    def radius_extend(self) -> float:
        """``radius`` and 0.1 m more, the disc that ``rvo`` keeps clear of others."""
        return self.radius + MARGIN

    @property
    def rvo_state(self) -> list[float]:
        """x, y, vx, vy, ``radius_extend``, desired vx and vy, heading [m, m/s, rad]."""
        pose, twist = self._simulation.state.pose[0, self._b], self._simulation.state.twist[0, self._b]
        return [*map(float, (*pose[:2], *twist[:2])), self.radius_extend, *self._desired(), float(pose[2])]

    @property
    def rvo_neighbor_state(self) -> list[float]:
        """X and y of its centroid, vx, vy, ``radius_extend`` [m, m/s]."""
        return [*reports.centroid(self._simulation, self._b), *self._moving(), self.radius_extend]

    def _moving(self) -> tuple[float, float]:
        vx, vy = self._simulation.state.twist[0, self._b, :2]
        return float(vx), float(vy)

    @property
    def rvo_neighbors(self) -> list[list[float]]:
        """``rvo_neighbor_state`` of all other bodies but the unobstructed ones."""
        return [body.rvo_neighbor_state for body in self.external_objects if not body.unobstructed]

    @property
    def rvo_line_segments(self) -> list[list[float]]:
        """Both ends of each piece of a linestring, x, y, x, y [m]; none for other shapes."""
        rows: list[list[float]] = reports.outline_rows(self._simulation, self._b)[0].tolist()
        return rows if self.shape == "linestring" else []

    @property
    def centroid(self) -> Floats:
        """x, y of the middle of its area [m], shape ``(2,)``."""
        return self._vector(np.array(reports.centroid(self._simulation, self._b)))

    @property
    def init_state(self) -> Floats:
        """The state that ``World.reset`` brings back, as ``state``."""
        model, size = self._simulation.model, getattr(self.spec.kinematics, "state_size", 3)
        return self._vector(np.array([*model.start[0, self._b], model.initial_steering[self._b]])[:size])

    def get_Gh(self) -> HalfPlanes:  # noqa: N802
        """Return G, h, ``cone_type`` and ``convex_flag`` of its outline in the world frame; see ``info``."""
        return self._half_planes(local=False)

    def get_init_Gh(self) -> HalfPlanes:  # noqa: N802
        """Return G, h, ``cone_type`` and ``convex_flag`` of its outline in its own frame; see ``info``."""
        return self._half_planes(local=True)

    def _half_planes(self, *, local: bool) -> HalfPlanes:
        normals, offsets, cone = reports.half_planes(self._simulation, self._b, local=local)
        return normals, None if offsets is None else self._vector(offsets), cone, cone is not None

    @property
    def state_dim(self) -> int:
        """How many numbers ``state`` has."""
        return int(self.state.size)

    @property
    def state_shape(self) -> tuple[int, ...]:
        """Shape of ``state``."""
        return self.state.shape

    @property
    def vel_dim(self) -> int:
        """How many numbers ``velocity`` has."""
        return int(self.velocity.size)

    @property
    def vel_shape(self) -> tuple[int, ...]:
        """Shape of ``velocity``."""
        return self.velocity.shape

    @property
    def abbr(self) -> str:
        """The short name that pictures show: first letter of its role, and its number."""
        return f"{self.role[0]}{self.id}"
