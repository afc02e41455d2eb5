"""One robot or obstacle of a world that is run by hand."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.live import reports
from irsim_gym.live.body_names import BodyNames
from irsim_gym.live.goals import read_goals

STATE = ("x", "y", "heading", "steering")


class Body(BodyNames):
    """A view of one body. It holds no state of its own, so it is always as the world is now.

    Arrays are flat copies in metres, radians and seconds. They are read-only: writing into one would change nothing,
    so it is an error; ``set_state``, ``set_velocity`` and ``set_goal`` change a body. A view outlives resets; a body
    that was removed answers with an UnknownNameError. A name of IR-SIM's that is not here says what to use.
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
