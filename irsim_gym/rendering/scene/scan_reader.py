"""Reads the scans of range sensors from the arrays of a simulation."""

from collections.abc import Sequence

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats
from irsim_gym.rendering.looks.styles import BodyStyle, scan_style
from irsim_gym.rendering.scene.scene import ScanView
from irsim_gym.simulator.world.group import Group

HIT_MARGIN = 1e-3


class ScanReader:
    """Makes views of all scans of one group of sensors.

    Args:
        group: The sensors, whose arrays include ``ranges`` and ``angles``.
        styles: Styles of all bodies.
    """

    def __init__(self, group: Group, styles: Sequence[BodyStyle]) -> None:
        self._group = group
        self._shown = [k for k, body in enumerate(group.members.tolist()) if styles[body].show_sensor]
        self._members = group.members[self._shown]
        options = [group.options[k] for k in self._shown]
        mounts = [np.asarray(getattr(sensor, "offset", (0.0, 0.0, 0.0)), np.float64) for sensor in options]
        self._mounts: Floats = np.array(mounts).reshape(len(options), 3)
        self._far: Floats = np.array([sensor.range_max - HIT_MARGIN for sensor in options])[:, None]
        self._near: Floats = np.array([getattr(sensor, "range_min", 0.0) for sensor in options])[:, None]
        self._styles = [scan_style(sensor) for sensor in options]
        self._angles: Floats = group.arrays["angles"].astype(np.float64)
        span = float(self._angles[-1] - self._angles[0])
        # As in ``plan.Plan``: a full turn may leave out the beam that looks like the first one.
        self._surrounds = span > 2.0 * np.pi * (1.0 - 1.5 / max(len(self._angles), 2))

    def read(self, world: int, poses: Floats, present: Flags) -> list[ScanView]:
        """Return the scans of the sensors of present bodies.

        Args:
            world: Index of the world.
            poses: Poses of all bodies in it [m, m, rad], shape ``(n_bodies, 3)``.
            present: Which bodies are present, shape ``(n_bodies,)``.
        """
        if not self._shown:
            return []
        arrays, borne = self._group.arrays, poses[self._members]
        cosine, sine = np.cos(borne[:, 2]), np.sin(borne[:, 2])
        ahead, aside = self._mounts[:, 0], self._mounts[:, 1]
        origins = borne[:, :2] + np.column_stack([cosine * ahead - sine * aside, sine * ahead + cosine * aside])
        headings = borne[:, 2] + self._mounts[:, 2]
        angles = headings[:, None] + self._angles
        ranges = arrays["ranges"][world, self._shown].astype(np.float64)
        ends = np.stack([np.cos(angles), np.sin(angles)], axis=2)
        ends *= ranges[:, :, None]
        ends += origins[:, None]
        hits = ranges < self._far
        valid = hits & (ranges > self._near)
        radial = arrays.get("radial_velocity")
        speeds = np.zeros_like(ranges) if radial is None else radial[world, self._shown]
        return [
            ScanView(
                origin=origins[k],
                ends=ends[k],
                hits=hits[k],
                valid=valid[k],
                speeds=speeds[k],
                surrounds=self._surrounds,
                style=self._styles[k],
                body=body,
                heading=float(headings[k]),
                angles=self._angles,
            )
            for k, body in enumerate(self._members.tolist())
            if present[body]
        ]
