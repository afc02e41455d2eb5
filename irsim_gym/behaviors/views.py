"""What a behaviour written in Python sees of a body: read-only views on the arrays."""

from __future__ import annotations

from typing import Any

import numpy as np

from irsim_gym import rng
from irsim_gym.arraytypes import Floats, Ints
from irsim_gym.behaviors.view_names import NamedView
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState


class BodyView(NamedView):
    """A body at the moment. Arrays are copies: writing into them changes nothing.

    The names of ``world.robot`` that have a meaning here work as well, IR-SIM's among them. Arrays are flat; a function
    of ``irsim_gym.register_behavior`` gets columns of shape ``(n, 1)`` under the names that IR-SIM has too.
    """

    __slots__ = ()

    def __repr__(self) -> str:
        x, y, heading = self.pose
        return f"<{self.name} at ({x:g}, {y:g}), heading {heading:g}>"

    @property
    def pose(self) -> Floats:
        """Position and heading: x, y [m], heading [rad]."""
        return np.array(self._state.pose[self._world, self.id])

    @property
    def velocity(self) -> Floats:
        """What is executed, in the drive's coordinates [m/s or rad/s], shape ``(3,)``; unused numbers are 0.

        As a column it has only the numbers that the drive uses.
        """
        executed = self._state.velocity[self._world, self.id]
        return self._vector(executed[: self._command_size] if self._columns else executed)

    @property
    def twist(self) -> Floats:
        """Velocity in the world frame: vx, vy [m/s], turn rate [rad/s]."""
        return self._vector(self._state.twist[self._world, self.id])

    @property
    def steering(self) -> float:
        """Steering angle of a car [rad]."""
        return float(self._state.steering[self._world, self.id])

    @property
    def goal(self) -> Floats | None:
        """The next goal: x, y [m], heading [rad]; None without one.

        Where any heading will do it is NaN, and left out of a column.
        """
        if not self._model.has_goal[self.id]:
            return None
        goal = self._state.goal[self._world, self.id]
        return self._vector(goal[:2] if self._columns and np.isnan(goal[2]) else goal)

    @property
    def goal_threshold(self) -> float:
        """Distance under which the goal is reached [m]."""
        return float(self._of(self._model.goal_threshold))

    @property
    def radius(self) -> float:
        """Radius of the least circle around the footprint [m]."""
        return float(self._of(self._model.radius))

    @property
    def center(self) -> Floats:
        """Centre of the footprint's area in the world frame: x, y [m]."""
        return np.array(self._middle())

    @property
    def segments(self) -> Floats:
        """Straight parts of the outline in the world frame: x0, y0, x1, y1 [m], shape ``(n, 4)``."""
        first, count = self._model.segment_start[self.id], self._of(self._model.segment_count)
        return np.array(self._state.segments[self._world, first : first + count])

    @property
    def discs(self) -> Floats:
        """Round parts of the outline in the world frame: x, y, radius [m], shape ``(n, 3)``."""
        first, count = self._model.disc_start[self.id], self._of(self._model.disc_count)
        return np.array(self._state.discs[self._world, first : first + count])

    @property
    def is_movable(self) -> bool:
        """False for a body that never moves."""
        return bool(self._model.movable[self.id])

    @property
    def is_unobstructed(self) -> bool:
        """True for a body that collisions and sensors ignore, such as a mark on the floor."""
        return bool(self._model.unobstructed[self.id])

    @property
    def is_stopped(self) -> bool:
        """True while a collision holds the body in place."""
        return bool(self._state.stopped[self._world, self.id])

    @property
    def has_collided(self) -> bool:
        """True while it touches another body."""
        return bool(self._state.collided[self._world, self.id])

    @property
    def has_arrived(self) -> bool:
        """True while it is at its last goal."""
        return bool(self._state.arrived[self._world, self.id])

    @property
    def hit(self) -> BodyView | None:
        """The body that it touched in the last step (the first one), or None."""
        other = int(self._state.hit[self._world, self.id])
        return None if other < 0 else self._other(other)

    @property
    def external_objects(self) -> list[BodyView]:
        """All other bodies."""
        return [self._other(int(b)) for b in np.flatnonzero(self._model.present[self._world]) if b != self.id]

    @property
    def rvo_neighbors(self) -> list[list[float]]:
        """``rvo_neighbor_state`` of all other bodies but the unobstructed ones."""
        return [body.rvo_neighbor_state for body in self.external_objects if not body.unobstructed]

    def detected(self) -> list[BodyView]:
        """Return the bodies in its field of view (``fov``, ``fov_radius``); nothing hides what is behind it.

        Raises:
            UnknownNameError: It has no field of view.
        """
        return [self._other(b) for b in self._numbers_in_view()]

    def get_fov_detected_objects(self) -> list[BodyView]:
        """Return the bodies in its field of view; see ``detected``."""
        return self.detected()

    def fov_detect_object(self, detected_object: BodyView) -> bool:
        """Return whether a body is in its field of view; see ``detected``."""
        return detected_object in self.detected()

    def _other(self, body: int) -> BodyView:
        return BodyView(self._group, self._model, self._state, self._world, body)


class EgoView(BodyView):
    """The body that decides: what only it knows, its memory, and its world's random numbers."""

    __slots__ = ("memory",)

    def __init__(
        self, group: Group, model: WorldModel, state: WorldState, world: int, body: int, memory: dict[str, Any]
    ) -> None:
        super().__init__(group, model, state, world, body)
        self.memory = memory

    @property
    def velocity_min(self) -> Floats:
        """Least velocities in the drive's coordinates [m/s or rad/s], shape ``(3,)``."""
        return np.array(self._of(self._model.velocity_min))

    @property
    def velocity_max(self) -> Floats:
        """Greatest velocities in the drive's coordinates [m/s or rad/s], shape ``(3,)``."""
        return np.array(self._of(self._model.velocity_max))

    @property
    def acceleration_limit(self) -> Floats:
        """Greatest changes of the velocities per second [m/s2 or rad/s2], shape ``(3,)``; may be infinite."""
        return np.array(self._of(self._model.acceleration_limit))

    def uniform(self, low: float, high: float) -> float:
        """Draw a number from low to high from the world's own stream, so that a seed gives the same episode again."""
        return float(rng.uniform(self._state.random, self._world, low, high))

    def normal(self, mean: float, deviation: float) -> float:
        """Draw a number from a normal distribution, likewise."""
        return float(rng.normal(self._state.random, self._world, mean, deviation))


def ego_view(group: Group, model: WorldModel, state: WorldState, world: int, body: int) -> EgoView:
    """Return the view of a body that decides, with its memory; see ``forget``."""
    memories = group.arrays["memory"]
    if memories[world, body] is None:
        memories[world, body] = {}
    return EgoView(group, model, state, world, body, memories[world, body])


def forget(group: Group, shard: Shard) -> None:
    """Let nothing be remembered at the start of an episode, not even by bodies that others command at first."""
    group.arrays["memory"][shard.worlds] = None


def others(group: Group, model: WorldModel, state: WorldState, world: int, unseen: Ints, role: int) -> list[BodyView]:
    """Return views of the bodies that a behaviour looks at, by their numbers.

    Absent bodies are left out, and an occupancy map, which is no outline.

    Args:
        group: The group that decides.
        model: The constants.
        state: The moment.
        world: The world.
        unseen: Bodies to leave out besides.
        role: Role of the others, -1 for any.
    """
    seen = model.present[world].copy()
    if role >= 0:
        seen &= model.role == role
    seen[unseen] = False
    if (chart := model.cells) is not None:
        seen[chart.body] = False
    return [BodyView(group, model, state, world, int(b)) for b in np.flatnonzero(seen)]


def name_of(group: Group, body: int) -> str:
    """Return a body's name, or its number where a group was made without names."""
    return group.names[body] if group.names else f"body {body}"
