"""Read-only views of bodies for behaviours in Python."""

from __future__ import annotations

from typing import Any

import numpy as np

from irsim_gym.base import rng
from irsim_gym.base.errors import UnknownNameError
from irsim_gym.simulator.readings.irsim_names import advice, missing
from irsim_gym.simulator.readings.irsim_readings import IrSimReadings
from irsim_gym.simulator.world.arrays import A
from irsim_gym.simulator.world.names import Floats, Group, Ints, Model, State, WorldContext, find_sensor, row_of


class BodyView(IrSimReadings):
    """A view of a body's current state. Arrays are copies: writing to them changes nothing.

    Most names of ``world.robot`` work here too, including those of IR-SIM. Arrays are flat; a function of
    ``irsim_gym.register_behavior`` gets columns of shape ``(n, 1)`` under the names that IR-SIM has too.

    Args:
        group: The behaviour's group.
        model: Constants of the worlds.
        state: State of the worlds.
        world: Number of the world.
        body: Number of the body.

    Attributes:
        name: Name of the body.
    """

    __slots__ = ("_b", "_columns", "_group", "_model", "_now", "_w", "name")

    _b: int
    _columns: bool
    _model: Model
    _now: State
    _w: int
    name: str

    def __init__(self, group: Group, model: Model, state: State, world: int, body: int) -> None:
        self._group = group
        self._columns = getattr(group.kind, "columns", False)
        self._model, self._now, self._w, self._b = model, state, world, body
        self.name = group.names[body] if group.names else f"body {body}"

    def __repr__(self) -> str:
        x, y, heading = self.pose
        return f"<{self.name} at ({x:g}, {y:g}), heading {heading:g}>"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, BodyView):
            return False
        return other._now is self._now and (other._w, other._b) == (self._w, self._b)

    def __hash__(self) -> int:
        return hash((id(self._now), self._w, self._b))

    @property
    def _context(self) -> WorldContext:
        assert self._group.context is not None, "a group that is made by hand needs a context"
        return self._group.context

    @property
    def _measures(self) -> tuple[Floats, Floats]:
        return self._model.radius, self._model.centroid

    def _array(self, values: Floats) -> Floats:
        return np.array(values)

    def _vector(self, values: Floats) -> Floats:
        copied = np.array(values, np.float64)
        return copied.reshape(-1, 1) if self._columns else copied

    def _reading(self, values: A) -> A:
        return values

    def _body(self, index: int) -> BodyView:
        return BodyView(self._group, self._model, self._now, self._w, index)

    @property
    def spec(self) -> Any:
        """The body's options in the file."""
        return self._context.bodies[self._b]

    @property
    def id(self) -> int:
        """The body's number."""
        return self._b

    @property
    def _state(self) -> Floats:
        return self.state

    @property
    def velocity(self) -> Floats:
        """Executed velocity in the drive's coordinates [m/s or rad/s], shape ``(3,)``; unused numbers are 0.

        A column has only the numbers that the drive uses.
        """
        executed = self._now.velocity[self._w, self._b]
        return self._vector(executed[: self._command_size] if self._columns else executed)


class EgoView(BodyView):
    """A view of the body that decides, with its readings, its memory, and its world's random numbers.

    Args:
        group: The behaviour's group.
        model: Constants of the worlds.
        state: State of the worlds.
        world: Number of the world.
        body: Number of the body.
        memory: What the function keeps for this body until its episode ends.
    """

    __slots__ = ("memory",)

    def __init__(self, group: Group, model: Model, state: State, world: int, body: int, memory: dict[str, Any]) -> None:
        super().__init__(group, model, state, world, body)
        self.memory = memory

    def reading(self, name: str, index: int = 0) -> Any:
        """Return a copy of the latest reading of one of the body's sensors.

        Args:
            name: Name of the reading: ``ranges``, or the name of a custom sensor.
            index: Index among the body's sensors with this reading, in the order of the file.

        Raises:
            UnknownNameError: If the body has no such sensor.
        """
        sensor = find_sensor(self._context.bodies, self._context.sensors, self._b, name, index)
        if sensor is None:
            raise UnknownNameError(f"'{self.name}' has no sensor number {index} that reads '{name}'")
        group, member = sensor
        return group.arrays[name][self._w, member].copy()

    def uniform(self, low: float, high: float) -> float:
        """Draw a uniform number, in the unit of its bounds, from the world's own stream: a seed reproduces the episode.

        Args:
            low: Lower end, in the [unit] of the number.
            high: Upper end, likewise; it is never drawn.
        """
        return float(rng.uniform(self._now.random, self._w, low, high))

    def normal(self, mean: float, deviation: float) -> float:
        """Draw a normally distributed number, in the unit of the arguments, from the world's own stream.

        Args:
            mean: Mean, in the [unit] of the number.
            deviation: Standard deviation, likewise.
        """
        return float(rng.normal(self._now.random, self._w, mean, deviation))


def reserve_memory(group: Group, model: Model) -> None:
    """Allocate a memory for each world and body, which ``ego_view`` fills and the engine clears."""
    group.arrays["memory"] = np.full(model.present.shape, None, dtype=object)


def ego_view(group: Group, model: Model, state: State, world: int, body: int) -> EgoView:
    """Return the view of a deciding body, with its memory; see ``reserve_memory``."""
    memories = group.arrays["memory"]
    if memories[world, body] is None:
        memories[world, body] = {}
    return EgoView(group, model, state, world, body, memories[world, body])


def others(group: Group, model: Model, state: State, world: int, looking: Ints, role: int) -> list[BodyView]:
    """Return views of the other bodies that a behaviour sees, in the order of their numbers.

    Absent bodies are left out, and so is an occupancy map, which has no outline.

    Args:
        group: The group that decides.
        model: Constants of the worlds.
        state: Current state of the worlds.
        world: World.
        looking: Bodies that look; they are left out, and so are bodies that none of them sees.
        role: Role of the others, -1 for any.
    """
    seen = model.present[world].copy()
    if role >= 0:
        seen &= model.role == role
    seen[looking] = False
    # A row of `watchers` for each set of bodies that are seen alike: which of the rows any of the looking bodies sees.
    visible = np.asarray(model.watchers[:, looking].any(axis=1))
    seen &= visible[model.seen_row]
    if model.heedless[row_of(model.heedless, world), looking].all():
        seen &= ~model.movable
    if (chart := model.cells) is not None:
        seen[chart.body] = False
    return [BodyView(group, model, state, world, int(b)) for b in np.flatnonzero(seen)]


def name_of(group: Group, body: int) -> str:
    """Return a body's name, or ``body`` and its number if the group was made without names."""
    return group.names[body] if group.names else f"body {body}"


def tell_missing(error: AttributeError) -> None:
    """Add a replacement to the error about a name that views do not have.

    Views have no ``__getattr__`` for this, because it would slow down every attribute.
    """
    view, name = error.obj, error.name
    if not isinstance(view, BodyView) or name is None or name in dir(type(view)):
        return
    error.args = (missing("a body in a behaviour", name, advice("body", "behavior"), dir(view)),)
