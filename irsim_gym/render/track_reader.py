"""Reads where bodies have been: their paths, and the outlines that they have left behind."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.render.body_reader import BodyReader
from irsim_gym.render.kept import Kept
from irsim_gym.render.scene import BodyView, Form, TrailView
from irsim_gym.render.styles import BodyStyle
from irsim_gym.world.trails import Trails

Outlines = dict[tuple[int, Form, bytes], BodyView]


class TrackReader:
    """Makes views of paths and of outlines left behind; an outline is made once and kept as long as it is shown.

    Args:
        trails: Where bodies have been.
        bodies: Makes views of bodies.
        styles: How they look.
    """

    def __init__(self, trails: Trails, bodies: BodyReader, styles: Sequence[BodyStyle]) -> None:
        self._trails, self._bodies, self._styles = trails, bodies, styles
        tracked = list(enumerate(trails.bodies.tolist()))
        self._paths = [(k, body) for k, body in tracked if styles[body].show_trajectory]
        self._ghosts = [(k, body) for k, body in tracked if styles[body].ghost is not None]
        self._kept: Kept[Outlines] = Kept()

    def paths(self, world: int, present: Flags) -> tuple[TrailView, ...]:
        """Return the paths of the bodies that are there."""
        if not self._paths:
            return ()
        _, table = self._trails.noted(world)
        views = []
        for k, body in self._paths:
            if present[body]:
                style = self._styles[body]
                views.append(TrailView(_latest(table[:, k], style.trajectory_length)[:, :2].copy(), style))
        return tuple(views)

    def ghosts(self, world: int, present: Flags) -> tuple[BodyView, ...]:
        """Return the outlines that are left behind, the oldest first; each the same object as long as it is shown."""
        found: list[tuple[int, Form, Ints, Floats]] = []
        for k, body in self._ghosts:
            if present[body]:
                style = self._styles[body]
                steps, table = self._trails.noted(world, style.ghost_every)
                poses = _latest(table[:, k], style.ghost_length)
                found.append((body, self._bodies.form(world, body), steps[len(steps) - len(poses) :], poses))
        if not found:
            return ()
        key = tuple((body, form, steps.tobytes(), poses.tobytes()) for body, form, steps, poses in found)
        return tuple(self._kept.get(world, key, lambda before: self._outlines(found, before or {})).values())

    def _outlines(self, found: Sequence[tuple[int, Form, Ints, Floats]], before: Outlines) -> Outlines:
        """Return outlines by body, form and pose; those from before where they are wanted again."""
        wanted = [
            (step, body, form, pose)
            for body, form, steps, poses in found
            for step, pose in zip(steps.tolist(), poses, strict=True)
        ]
        outlines: Outlines = {}
        for _, body, form, pose in sorted(wanted, key=lambda item: item[0]):
            key, style = (body, form, pose.tobytes()), self._styles[body].ghost
            if style is not None:
                outlines[key] = before.get(key) or self._bodies.ghost(body, form, pose, style)
        return outlines


def _latest(poses: Floats, length: int) -> Floats:
    """Return the latest poses that are known; 0 for all."""
    gone = np.isnan(poses[:, 0])
    if gone.any():
        poses = poses[~gone]
    return poses[-length:] if length else poses
