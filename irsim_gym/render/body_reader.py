"""Reads the bodies of a scene from the arrays of a simulation, where they are and where they were."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from irsim_gym.arraytypes import Bytes, Floats
from irsim_gym.render.images import load_image
from irsim_gym.render.outlines import NOTHING, arrow, box, chains, placed, replaced, wedge, windscreen
from irsim_gym.render.scene import BodyView, GoalView, ImageView, LabelView
from irsim_gym.render.styles import BodyStyle, is_omni
from irsim_gym.scenario.images import image_file
from irsim_gym.world.model import ACKERMANN, WorldModel
from irsim_gym.world.state import WorldState

if TYPE_CHECKING:
    from irsim_gym.scenario.spec import Scenario


class BodyReader:
    """Makes views of the bodies of one simulation.

    Args:
        scenario: What is simulated, for names and images.
        model: Its constants.
        state: Its present state.
        styles: How the bodies look.
    """

    def __init__(self, scenario: Scenario, model: WorldModel, state: WorldState, styles: Sequence[BodyStyle]) -> None:
        self._model, self._state, self._styles = model, state, styles
        self._names = [body.name for body in scenario.bodies]
        self._turns_with_motion = [is_omni(body) for body in scenario.bodies]
        self._pixels = {
            b: load_image(image_file(body.description, scenario.file))
            for b, body in enumerate(scenario.bodies)
            if body.description is not None
        }

    def signature(self, world: int, bodies: Sequence[int]) -> bytes:
        """Return what changes whenever one of the bodies changes its place or outline."""
        state = self._state
        parts = [np.array(bodies).tobytes(), state.pose[world, bodies].tobytes()]
        for body in bodies:
            segments, discs = self._rows(world, body)
            parts += [state.segments[world, segments].tobytes(), state.discs[world, discs].tobytes()]
        return b"|".join(parts)

    def view(self, world: int, body: int) -> BodyView:
        """Return a body as it stands now."""
        state, style = self._state, self._styles[body]
        segment_rows, disc_rows = self._rows(world, body)
        segments, discs = state.segments[world, segment_rows].copy(), state.discs[world, disc_rows].copy()
        return BodyView(
            body=body,
            name=self._names[body],
            lines=chains(segments),
            discs=discs,
            solid=bool(self._model.solid[body]),
            heading=self._heading(world, body, segment_rows, disc_rows) if style.show_arrow else NOTHING,
            anchor=_anchor(state.pose[world, body], style, segments, discs),
            style=style,
            image=self._image(world, body, self._pixels[body]) if body in self._pixels else None,
        )

    def _image(self, world: int, body: int, pixels: Bytes) -> ImageView | None:
        """Return the image of a body over the rectangle around its footprint; None without a footprint."""
        model, (segment_rows, disc_rows) = self._model, self._rows(world, body)
        segments = model.local_segments[world % len(model.local_segments), segment_rows]
        extent = box(segments, model.local_discs[world % len(model.local_discs), disc_rows])
        if extent is None:
            return None
        x_min, y_min, x_max, y_max = extent
        corners = np.array([[x_min, y_min], [x_max, y_min], [x_max, y_max], [x_min, y_max]])
        return ImageView(pixels, placed(corners, self._state.pose[world, body]), self._styles[body].image_alpha)

    def _heading(self, world: int, body: int, segment_rows: slice, disc_rows: slice) -> Floats:
        model, style, pose = self._model, self._styles[body], self._state.pose[world, body]
        if self._turns_with_motion[body] and self._state.twist[world, body, :2].any():
            x, y = self._state.twist[world, body, :2]
            pose = np.array([pose[0], pose[1], np.arctan2(y, x)])
        if style.arrow is not None:
            return placed(arrow(*style.arrow), pose)
        segments = model.local_segments[world % len(model.local_segments), segment_rows]
        discs = model.local_discs[world % len(model.local_discs), disc_rows]
        is_car = model.drive[body] == ACKERMANN and len(segments) > 0 and body not in self._pixels
        return placed(windscreen(segments, discs) if is_car else wedge(segments, discs), pose)

    def ghost(self, world: int, body: int, pose: Floats, style: BodyStyle, shape: str) -> BodyView:
        """Return the body as it stood at a pose, or a simpler shape around it."""
        model, (segment_rows, disc_rows) = self._model, self._rows(world, body)
        segments = model.local_segments[world % len(model.local_segments), segment_rows]
        discs = model.local_discs[world % len(model.local_discs), disc_rows]
        if shape:
            segments, discs = replaced(shape, segments, discs)
        return BodyView(
            body=body,
            name=self._names[body],
            lines=tuple(placed(line, pose) for line in chains(segments)),
            discs=np.hstack([placed(discs[:, :2], pose), discs[:, 2:]]),
            solid=shape != "linestring" and (bool(shape) or bool(model.solid[body])),
            heading=NOTHING,
            anchor=(float(pose[0]), float(pose[1])),
            style=style,
        )

    def _rows(self, world: int, body: int) -> tuple[slice, slice]:
        """Return the body's rows in the tables of segments and of discs."""
        model = self._model
        segment, disc = int(model.segment_start[body]), int(model.disc_start[body])
        segments = int(model.segment_count[world % len(model.segment_count), body])
        discs = int(model.disc_count[world % len(model.disc_count), body])
        return slice(segment, segment + segments), slice(disc, disc + discs)


def labels(bodies: Sequence[BodyView], goals: Sequence[GoalView]) -> tuple[LabelView, ...]:
    """Return the texts beside bodies and below goals."""
    beside = [
        LabelView(*view.anchor, view.style.label, view.style, None if view.style.label_offset else _foot(view))
        for view in bodies
        if view.style.label
    ]
    below = [
        LabelView(view.x, view.y, view.style.goal_label, view.style, view.y - view.tolerance)  # its own flag is there
        for view in goals
        if view.style.goal_label
    ]
    return tuple(beside + below)


def _anchor(pose: Floats, style: BodyStyle, segments: Floats, discs: Floats) -> tuple[float, float]:
    """Return where a body's label stands: at the chosen offset, or above the footprint."""
    x, y = float(pose[0]), float(pose[1])
    if style.label_offset is not None:
        return x + style.label_offset[0], y + style.label_offset[1]
    extent = box(segments, discs)
    return (x, y) if extent is None else (0.5 * (extent[0] + extent[2]), extent[3] + 0.08)


def _foot(view: BodyView) -> float | None:
    """Return the lowest ordinate of a footprint; None without one."""
    lowest = [float(line[:, 1].min()) for line in view.lines] + [float(y - radius) for _, y, radius in view.discs]
    return min(lowest, default=None)
