"""Read access to the present moment of a world, for wrappers: poses, velocities, goals, scans.

The names are those of ``world.robot`` and ``world`` of ``irsim_gym.load`` and of behaviours in plain Python. Arrays are
copies that cannot be written into, so they do not change when the world continues.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, overload

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats
from irsim_gym.base.errors import UnknownNameError, suggestion
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.levels.body_measures import measured
from irsim_gym.simulator.readings.body_readings import BodyReadings
from irsim_gym.simulator.world.arrays import A, frozen
from irsim_gym.simulator.world.group import WorldContext
from irsim_gym.simulator.world.model import ROBOT, Model
from irsim_gym.simulator.world.state import State

if TYPE_CHECKING:
    from irsim_gym.scenario.specs.spec import BodySpec


class BodyMoment(BodyReadings):
    """One body of one world. It always shows the present state.

    Args:
        simulation: The worlds.
        body: Index of the body.
        world: Index of the world.
    """

    __slots__ = ("_b", "_simulation", "_w")

    _b: int
    _w: int

    def __init__(self, simulation: Simulation, body: int, world: int = 0) -> None:
        self._simulation, self._b, self._w = simulation, body, world

    def __repr__(self) -> str:
        x, y, heading = self.pose
        return f"<{self.name} at ({x:.3g}, {y:.3g}), heading {heading:.3g}>"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, BodyMoment):
            return False
        return other._simulation is self._simulation and (other._b, other._w) == (self._b, self._w)

    def __hash__(self) -> int:
        return hash((id(self._simulation), self._b, self._w))

    @property
    def _model(self) -> Model:
        return self._simulation.model

    @property
    def _now(self) -> State:
        return self._simulation.state

    @property
    def _context(self) -> WorldContext:
        return self._simulation.context

    @property
    def _columns(self) -> bool:
        return False

    @property
    def _measures(self) -> tuple[Floats, Floats]:
        return measured(self._model, self._w, self._b)

    def _array(self, values: Floats) -> Floats:
        return frozen(values)

    def _vector(self, values: Floats) -> Floats:
        return frozen(values)

    def _reading(self, values: A) -> A:
        return frozen(values)

    def _body(self, index: int) -> BodyMoment:
        return BodyMoment(self._simulation, index, self._w)

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
    def velocity(self) -> Floats:
        """Velocity in the drive's coordinates [m/s or rad/s], shape ``(2,)`` or ``(3,)``."""
        return frozen(self._now.velocity[self._w, self._b, : self._command_size])


class Bodies(Sequence[BodyMoment]):
    """Bodies of one world, in the order in which they are stepped. Indices are places in this list, or names.

    Args:
        simulation: The worlds.
        numbers: Indices of the bodies.
        world: Index of the world.
    """

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
    """One world, as it is now.

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
