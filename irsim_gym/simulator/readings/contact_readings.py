"""What a body weighs, and what it feels of others that it touches (``collision_mode: contact``)."""

from abc import ABC
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.simulator.pushing.matter import gyration, inverse_inertia
from irsim_gym.simulator.pushing.outcome import ground_velocity
from irsim_gym.simulator.readings.body_readings import BodyReadings, SpecField
from irsim_gym.simulator.readings.irsim_names import advice, missing


@dataclass(frozen=True, eq=False)
class ContactRecord:
    """A contact of two bodies in the last step.

    Attributes:
        a: The first body.
        b: The second body.
        normal: Unit vector from b to a, shape ``(2,)``.
        depth: How deep they overlapped [m]; 0 or less for bodies that rest on each other.
        point: Where [m], shape ``(2,)``.
        force: Force on each of them [N].
    """

    a: Any
    b: Any
    normal: Floats
    depth: float
    point: Floats
    force: float

    def report(self, body: Any) -> "ContactReport":
        """Return it as one of its bodies feels it."""
        other, sign = (self.b, 1.0) if self.a._b == body._b else (self.a, -1.0)
        return ContactReport(other, self.point, sign * self.normal, self.depth, self.force)


@dataclass(frozen=True, eq=False)
class ContactReport:
    """A contact as one of its bodies feels it: the other body, and the unit vector from there; see ContactRecord."""

    other: Any
    point: Floats
    normal: Floats
    depth: float
    force: float


@dataclass(frozen=True, eq=False)
class BodyContact:
    """What a body feels after the last step.

    Attributes:
        in_contact: Whether it touches anything.
        force: Sum of the forces on it in the world frame [N], shape ``(2,)`` or a column.
        contact_time: For how long it has been in contact [s], 0 without.
        air_time: For how long it has not [s], 0 in contact.
        started: Whether its contact began in this step.
        ended: Whether it ended in this step.
        records: Its contacts, in the order in which they were found.
        reports: The same, as it feels them.
    """

    in_contact: bool
    force: Floats
    contact_time: float = 0.0
    air_time: float = 0.0
    started: bool = False
    ended: bool = False
    records: list[ContactRecord] = field(default_factory=list)
    reports: list[ContactReport] = field(default_factory=list)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> NoReturn:
            message = missing("what a body feels", name, advice("contact"), dir(self))
            raise AttributeError(message, name=name, obj=self)

    @property
    def partners(self) -> list[Any]:
        """The bodies that it touches, each once."""
        return [report.other for report in self.reports]


class ContactReadings(BodyReadings, ABC):
    """One body of one world, with its mass and its contacts."""

    __slots__ = ()

    mass = SpecField[float]("Mass [kg]; may be infinite.")
    passive = property(lambda self: self.spec.kinematics is None, doc="It has no drive.")
    friction = property(lambda self: self._stuff("friction"), doc="Coefficient of friction.")
    restitution = property(lambda self: self._stuff("restitution"), doc="Share of the speed that a bounce keeps.")
    drive_tau = property(lambda self: self._stuff("tau"), doc="Time constant of its drive's lag [s]; 0 without a lag.")
    friction_force = property(lambda self: self._stuff("grip"), doc="Greatest force of friction with the ground [N].")
    inv_mass = property(lambda self: self._stuff("inverse"), doc="Inverse of the mass [1/kg]; 0 if nobody pushes it.")
    pushable = property(lambda self: self.inv_mass > 0.0, doc="Whether others can push it.")

    def _stuff(self, name: str) -> float:
        return float(self._context.weighed().substance[self._b][name])

    @property
    def inertia(self) -> float:
        """Moment of inertia about its centre of mass [kg m2]; may be infinite."""
        return float(self._of(self._context.weighed().inertia))

    @property
    def inv_inertia(self) -> float:
        """Inverse of ``inertia`` [1/(kg m2)]; 0 if nobody turns it."""
        return float(inverse_inertia(self._context.weighed(), self._w, self._b))

    @property
    def gyration(self) -> float:
        """Radius of gyration [m]; 0 if mass or inertia are infinite."""
        return float(gyration(self._context.weighed(), self._w, self._b))

    @property
    def drive_velocity_xy(self) -> Floats:
        """Velocity of its drive, which contacts do not change, in the world frame [m/s], shape ``(2,)``."""
        push, drive = self._context.pushing, int(self._stuff("drive"))
        rows = self._now.velocity if push is None else push.drive
        return self._vector(np.array(ground_velocity(rows[self._w, self._b], drive, self.orientation)))

    @property
    def contact(self) -> BodyContact:
        """What it feels after the last step; nothing unless the world's ``collision_mode`` is ``contact``."""
        push, w, b = self._context.pushing, self._w, self._b
        if push is None:
            return BodyContact(False, self._vector(np.zeros(2)))
        records = [record for record in self._records() if b in (record.a._b, record.b._b)]
        reports = [record.report(self) for record in records]
        x, y, contact_time, air_time, touches, changed = push.felt[w, b].item()
        began, force = (changed and touches, changed and not touches), self._vector(np.array([x, y]))
        return BodyContact(touches, force, contact_time, air_time, *began, records, reports)

    def _records(self) -> list[ContactRecord]:
        """Return all contacts of its world."""
        push = self._context.pushing
        rows = () if push is None else push.reports[self._w, : push.n_reports[self._w]]
        return [
            ContactRecord(
                self._body(int(row["a"])), self._body(int(row["b"])), np.array([row["nx"], row["ny"]]),
                float(row["depth"]), np.array([row["x"], row["y"]]), float(row["force"]),
            )
            for row in rows
        ]  # fmt: skip
