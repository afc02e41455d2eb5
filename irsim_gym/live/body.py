"""One robot or obstacle of a world that is run by hand."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.errors import NoEffectWarning
from irsim_gym.live import free_goals, reports
from irsim_gym.live.goals import read_goals
from irsim_gym.live.moment import Moment
from irsim_gym.live.painted import HIGHLIGHT
from irsim_gym.live.planner_names import PlannerNames

STATE = ("x", "y", "heading", "steering")
LOW, HIGH = (0.0, 0.0, -np.pi), (10.0, 10.0, np.pi)


class Body(PlannerNames):
    """A view of one body. It holds no state of its own, so it is always as the world is now.

    Arrays are copies in metres, radians and seconds, flat unless the world has ``columns``. They are read-only:
    writing into one would change nothing, so it is an error; ``set_state``, ``set_velocity`` and ``set_goal`` change a
    body. A view outlives resets; a body that was removed answers with an UnknownNameError. A name of IR-SIM's that is
    not here says what to use.
    """

    __slots__ = ()

    def set_state(self, state: Sequence[float] | Floats, *, init: bool = False) -> None:
        """Put it somewhere.

        The outline follows at once; flags and readings follow with the next step or ``World.refresh``.

        Args:
            state: x, y, heading [m, m, rad] and for ``acker`` the steering angle [rad]; a missing angle is 0.
            init: Begin there after a reset as well.

        Raises:
            ValueError: There are too few or too many numbers, one is not finite, or it is the obstacle map.
        """
        simulation, b = self._simulation, self._b
        reports.refuse_map(simulation, b)
        names = STATE[: getattr(self.spec.kinematics, "state_size", 3)]
        row = _numbers(state, 2, names, f"a state of '{self._name}'")
        simulation.state.pose[0, b], simulation.state.steering[0, b] = row[:3], row[3]
        if init:
            simulation.model.start[0, b], simulation.model.initial_steering[b] = row[:3], row[3]
        simulation.place(np.array([b], np.int64))

    def set_velocity(self, velocity: Sequence[float] | Floats, *, init: bool = False) -> None:
        """Say how fast it is now, which acceleration limits and the others' behaviours start from.

        Args:
            velocity: In the drive's coordinates [m/s or rad/s].
            init: Begin with it after a reset as well.

        Raises:
            ValueError: It has no drive, there are too few or too many numbers, or one is not finite.
        """
        simulation, b = self._simulation, self._b
        if self.spec.kinematics is None:
            raise ValueError(f"'{self._name}' has no drive, so no velocity")
        names = self.spec.kinematics.command_names
        row = _numbers(velocity, len(names), names, f"a velocity of '{self._name}'")
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

    def set_random_goal(
        self,
        obstacle_list: Iterable[Moment] = (),
        init: bool = False,
        free: bool = True,
        goal_check_radius: float = 0.2,
        range_limits: Sequence[Sequence[float]] | None = None,
        max_attempts: int = 100,
    ) -> None:
        """Draw a goal in place of each of those that are left, from the world's random stream.

        Where no place is clear of the obstacles, the last one drawn is taken, with a warning, as in IR-SIM.

        Args:
            obstacle_list: The bodies that a goal must not touch.
            init: Have them after a reset as well.
            free: Keep them clear of these bodies.
            goal_check_radius: Room around a goal that counts for that [m].
            range_limits: Least and greatest x, y, heading [m, m, rad]; by default ``range_low`` and ``range_high`` of
                its behavior, else ``[0, 0, -pi]`` and ``[10, 10, pi]``.
            max_attempts: Draws for each goal.

        Raises:
            ValueError: The limits are none, or there is not even one attempt.
        """
        behavior = self.spec.behavior
        low, high = range_limits or (getattr(behavior, "range_low", LOW), getattr(behavior, "range_high", HIGH))
        if max_attempts < 1:
            raise ValueError(f"max_attempts is 1 or more, got {max_attempts!r}")
        others = [self._world.roster.index(body.name) for body in obstacle_list] if free else []
        drawn = []
        for _ in range(max(len(self.goals), 1)):
            goal, is_clear = free_goals.draw(self._simulation, low, high, others, goal_check_radius, max_attempts)
            drawn.append(goal)
            if not is_clear:
                message = f"no place clear of the obstacles for a goal of '{self._name}' in {max_attempts} draws"
                warnings.warn(message, NoEffectWarning, stacklevel=2)
        self._world.goals.write(self._simulation, self._b, np.array(drawn), init=init)

    def set_laser_color(self, laser_indices: Iterable[int], laser_color: str | None = None, alpha: float = 0.3) -> None:
        """Draw some beams of its first range sensor in another colour, and all others in the sensor's.

        Args:
            laser_indices: Which of them; numbers that no beam has are passed over.
            laser_color: Their colour; orange by default.
            alpha: Their opacity; 0 hides them.

        Raises:
            UnknownNameError: It has no range sensor.
            ValueError: There is no such colour, or the opacity is not between 0 and 1.
        """
        count = len(self.scan()["ranges"])
        self._world.painted.paint(self._name, count, laser_indices, laser_color or HIGHLIGHT, alpha)

    def append_goal(self, goal: Any) -> None:
        """Add goals behind those that are left."""
        self._world.goals.write(self._simulation, self._b, np.vstack([self.goals, read_goals(goal)]), init=False)


def _numbers(values: Sequence[float] | Floats, least: int, names: Sequence[str], what: str) -> Floats:
    """Return four numbers, those that are not given as 0."""
    try:
        given = np.asarray(values, np.float64).reshape(-1)
    except (TypeError, ValueError):
        given = np.zeros(0)
    if not least <= given.size <= len(names) or not np.isfinite(given).all():
        count = f"{least}" if least == len(names) else f"{least} to {len(names)}"
        raise ValueError(f"{what} has {count} finite numbers ({', '.join(names)}), got {values!r}")
    return np.pad(given, (0, 4 - given.size))
