"""One sensor of a body, with its options and readings under IR-SIM's names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from irsim_gym.base import families
from irsim_gym.base.arraytypes import Floats
from irsim_gym.simulator.readings.irsim_names import advice, missing

if TYPE_CHECKING:
    from irsim_gym.simulator.readings.body_readings import BodyReadings


SCANNED = {"range_data": "ranges", "angle_inc": "angle_increment", "time_inc": "time_increment"}
"""IR-SIM's names for what ``scan`` reports under others."""


class SensorView:
    """A sensor of one body.

    Its options can be read as attributes, such as ``number`` and ``range_max``, and so can all that its latest scan
    reports: ``range_data`` [m], ``valid``, ``angle_min``, ``angle_max``, ``angle_inc`` [rad] and others. A contact
    sensor has what its body feels, such as ``force``.

    Args:
        body: The body.
        index: Which of its sensors, in the order of the file.

    Attributes:
        parent: The body.
        options: Its options in the file.
    """

    __slots__ = ("_index", "_range_index", "options", "parent")

    options: Any
    parent: BodyReadings

    def __init__(self, body: BodyReadings, index: int) -> None:
        self.parent, self.options = body, body.spec.sensors[index]
        self._index = index
        self._range_index = sum(1 for options in body.spec.sensors[:index] if options.reading == "ranges")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, SensorView) and (other.parent, other._index) == (self.parent, self._index)

    def __hash__(self) -> int:
        return hash((self.parent, self._index))

    def __repr__(self) -> str:
        return f"<{self.sensor_type} of {self.parent.name}>"

    if not TYPE_CHECKING:  # a type checker would otherwise accept any name

        def __getattr__(self, name: str) -> Any:
            if name in self.__slots__:  # not set yet, while it is copied
                raise AttributeError(name, name=name, obj=self)
            if hasattr(self.options, name):
                return getattr(self.options, name)
            if self.options.reading == "ranges" and SCANNED.get(name, name) in (report := self.get_scan()):
                return report[SCANNED.get(name, name)]
            if self.sensor_type == "contact2d" and hasattr(self.parent.contact, name):
                return getattr(self.parent.contact, name)
            message = missing(f"a sensor '{self.sensor_type}'", name, advice("sensor"), dir(self))
            raise AttributeError(message, name=name, obj=self)

    @property
    def sensor_type(self) -> str:
        """Its name in the file, such as ``lidar2d``."""
        return families.SENSORS.name_of(type(self.options))

    @property
    def offset(self) -> Any:
        """Mount pose in the body frame [m, m, rad], a column in a world with ``columns``."""
        mount = self.options.offset
        return np.array(mount).reshape(-1, 1) if self.parent._columns else mount

    def get_offset(self) -> list[float]:
        """Return ``offset`` as a list."""
        return list(self.options.offset)

    def get_scan(self) -> dict[str, Any]:
        """Return the latest scan; see ``scan`` of the body.

        Raises:
            UnknownNameError: It is no range sensor.
        """
        return self.parent.scan(self._range_index)

    def get_points(self) -> Floats | None:
        """Return the points that the latest scan hit, in the sensor's frame [m], shape ``(2, n)``; None without any."""
        return self.parent.scan_points(self._range_index)

    scan_to_pointcloud = get_points

    @property
    def angle_list(self) -> Floats:
        """Directions of the beams in the sensor frame [rad], shape ``(n_beams,)``."""
        return np.array(self.options.angles(), np.float64)

    @property
    def obj_id(self) -> int:
        """Number of its body."""
        return self.parent.id

    @property
    def state(self) -> Floats:
        """Pose of its body [m, m, rad], shape ``(3,)`` or a column."""
        return self.parent._vector(self.parent.pose)

    @property
    def lidar_origin(self) -> Floats:
        """Pose of the sensor in the world [m, m, rad], shape ``(3,)`` or a column."""
        x, y, heading = map(float, self.parent.pose)
        ahead, left, turn = self.options.offset
        cosine, sine = np.cos(heading), np.sin(heading)
        place = x + cosine * ahead - sine * left, y + sine * ahead + cosine * left
        return self.parent._vector(np.array([*place, (heading + turn + np.pi) % (2.0 * np.pi) - np.pi]))
