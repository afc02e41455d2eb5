"""Reads the paths and trails of bodies."""

from collections.abc import Sequence

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats
from irsim_gym.rendering.looks.styles import BodyStyle
from irsim_gym.rendering.scene.body_reader import BodyReader
from irsim_gym.rendering.scene.scene import DrawnBody, Form, TrailView
from irsim_gym.simulator.readings.trails import Trails


class TrackReader:
    """Makes views of paths and of the outlines in trails.

    Args:
        trails: Past poses of bodies.
        bodies: Makes views of bodies.
        styles: Styles of the bodies.
    """

    def __init__(self, trails: Trails, bodies: BodyReader, styles: Sequence[BodyStyle]) -> None:
        self._trails, self._bodies, self._styles = trails, bodies, styles
        tracked = list(enumerate(trails.bodies.tolist()))
        self._paths = [(k, body) for k, body in tracked if styles[body].show_trajectory]
        self._ghosts = [(k, body) for k, body in tracked if styles[body].ghost is not None]

    def paths(self, world: int, present: Flags) -> tuple[TrailView, ...]:
        """Return the paths of present bodies."""
        if not self._paths:
            return ()
        _, table = self._trails.noted(world)
        views = []
        for k, body in self._paths:
            if present[body]:
                style = self._styles[body]
                views.append(TrailView(_latest(table[:, k], style.trajectory_length)[:, :2].copy(), style))
        return tuple(views)

    def ghosts(self, world: int, present: Flags) -> tuple[DrawnBody, ...]:
        """Return the outlines in the trails of present bodies, the oldest first."""
        ghosts: list[tuple[int, int, Form, Floats]] = []
        for k, body in self._ghosts:
            if present[body]:
                style, form = self._styles[body], self._bodies.form(world, body)
                steps, table = self._trails.noted(world, style.ghost_every)
                poses = _latest(table[:, k], style.ghost_length)
                since = steps[len(steps) - len(poses) :].tolist()
                ghosts += [(step, body, form, pose) for step, pose in zip(since, poses, strict=True)]
        ghosts.sort(key=lambda item: item[0])
        return tuple(self._bodies.ghost(body, form, pose) for _, body, form, pose in ghosts)


def _latest(poses: Floats, length: int) -> Floats:
    """Return the latest ``length`` known poses; all for 0."""
    gone = np.isnan(poses[:, 0])
    if gone.any():
        poses = poses[~gone]
    return poses[-length:] if length else poses
