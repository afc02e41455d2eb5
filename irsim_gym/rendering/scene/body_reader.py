"""Reads the appearance of bodies from the arrays of a simulation: footprints, headings and trails of outlines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.rendering.looks.images import load_image
from irsim_gym.rendering.looks.styles import BodyStyle, is_omni
from irsim_gym.rendering.raster import records
from irsim_gym.rendering.raster.play import LABEL_GAP
from irsim_gym.rendering.scene.scene import DrawnBody, Form, GoalView, ImageView, LabelView
from irsim_gym.rendering.scene.shapes import NOTHING, box, chains, heading_mark, placed, replaced
from irsim_gym.scenario.specs.library import asset
from irsim_gym.simulator.world.model import ACKERMANN, Model
from irsim_gym.simulator.world.state import State

if TYPE_CHECKING:
    from irsim_gym.scenario.specs.spec import Scenario


class BodyReader:
    """Makes views of the bodies of one simulation.

    Args:
        scenario: The scenario, for names and images.
        model: Constants of the simulation.
        state: Its present state.
        styles: Styles of the bodies.
    """

    def __init__(self, scenario: Scenario, model: Model, state: State, styles: Sequence[BodyStyle]) -> None:
        self._model, self._state, self._styles = model, state, styles
        self._names = [body.name for body in scenario.bodies]
        self._turning = [is_omni(body) for body in scenario.bodies]
        self._pixels = {
            b: load_image(asset("images", body.description, scenario.file))
            for b, body in enumerate(scenario.bodies)
            if body.description is not None
        }
        self._solid = [bool(solid) for solid in model.solid]
        self._forms: dict[int, tuple[tuple[bytes, bytes], Form]] = {}

    def signature(self, world: int, bodies: Sequence[int]) -> bytes:
        """Return a key that changes whenever one of the bodies changes its pose or outline."""
        state = self._state
        parts = [np.array(bodies).tobytes(), state.pose[world, bodies].tobytes()]
        for body in bodies:
            segments, discs = self._rows(world, body)
            parts += [state.segments[world, segments].tobytes(), state.discs[world, discs].tobytes()]
        return b"|".join(parts)

    def _rows(self, world: int, body: int) -> tuple[slice, slice]:
        """Return the body's rows in the tables of segments and of discs."""
        model = self._model
        segment, disc = int(model.segment_start[body]), int(model.disc_start[body])
        segments = int(model.segment_count[world % len(model.segment_count), body])
        discs = int(model.disc_count[world % len(model.disc_count), body])
        return slice(segment, segment + segments), slice(disc, disc + discs)

    def form(self, world: int, body: int, rows: tuple[slice, slice] | None = None) -> Form:
        """Return the form of a body's footprint, the same object until a level changes its outline."""
        segment_rows, disc_rows = self._rows(world, body) if rows is None else rows
        segments = self._model.local_segments[world % len(self._model.local_segments), segment_rows]
        discs = self._model.local_discs[world % len(self._model.local_discs), disc_rows]
        key = segments.tobytes(), discs.tobytes()
        entry = self._forms.get(body)
        if entry is None or entry[0] != key:
            entry = self._forms[body] = key, self._make_form(body, segments.copy(), discs.copy())
        return entry[1]

    def _make_form(self, body: int, segments: Floats, discs: Floats) -> Form:
        style, extent = self._styles[body], box(segments, discs)
        corners = ghost = None
        if extent is not None:
            x_min, y_min, x_max, y_max = extent
            corners = np.array([[x_min, y_min], [x_max, y_min], [x_max, y_max], [x_min, y_max]])
        if style.ghost is not None:
            left, left_discs = replaced(style.ghost_shape or "", segments, discs)
            solid = style.ghost_shape != "linestring" and (bool(style.ghost_shape) or self._solid[body])
            ghost = Form(chains(left), left_discs, solid, NOTHING)
        return Form(chains(segments), discs, self._solid[body], self._mark(body, segments, discs), corners, ghost)

    def _mark(self, body: int, segments: Floats, discs: Floats) -> Floats:
        style = self._styles[body]
        if not style.show_arrow:
            return NOTHING
        is_car = self._model.drive[body] == ACKERMANN and body not in self._pixels
        form = records.ARROW if style.arrow is not None else records.WINDSCREEN if is_car else records.WEDGE
        return heading_mark(form, style.arrow or (0.0, 0.0), segments, discs)

    def view(self, world: int, body: int) -> DrawnBody:
        """Return the present view of a body."""
        state, style = self._state, self._styles[body]
        rows = self._rows(world, body)
        form = self.form(world, body, rows)
        pose = state.pose[world, body]
        segments, discs = state.segments[world, rows[0]], state.discs[world, rows[1]].copy()
        lines, first = [], 0
        for line in form.lines:
            lines.append(_chain(segments[first : first + len(line) - 1]))
            first += len(line) - 1
        turn = self._turn(world, body, pose)
        towards = pose + np.array([0.0, 0.0, turn]) if turn else pose
        return DrawnBody(
            body=body,
            name=self._names[body],
            lines=tuple(lines),
            discs=discs,
            solid=form.solid,
            heading=placed(form.mark, towards) if len(form.mark) else NOTHING,
            anchor=_anchor(pose, style, lines, discs),
            style=style,
            form=form,
            pose=(float(pose[0]), float(pose[1]), float(pose[2])),
            turn=turn,
            image=self._image(body, form, pose) if body in self._pixels else None,
        )

    def _turn(self, world: int, body: int, pose: Floats) -> float:
        """Return the displayed heading of a body relative to its heading [rad]: for omni drives, that of its motion."""
        if self._turning[body]:
            x, y = self._state.twist[world, body, :2].tolist()
            if x or y:
                return math.remainder(math.atan2(y, x) - float(pose[2]), math.tau)
        return 0.0

    def _image(self, body: int, form: Form, pose: Floats) -> ImageView | None:
        """Return the image of a body over the rectangle around its footprint; None without a footprint."""
        if form.corners is None:
            return None
        return ImageView(self._pixels[body], placed(form.corners, pose), self._styles[body].image_alpha)

    def ghost(self, body: int, form: Form, pose: Floats) -> DrawnBody:
        """Return the view of an outline left at a pose: that of the body, or a simpler shape around it."""
        left = form if form.ghost is None else form.ghost
        return DrawnBody(
            body=body,
            name=self._names[body],
            lines=tuple(placed(line, pose) for line in left.lines),
            discs=np.hstack([placed(left.discs[:, :2], pose), left.discs[:, 2:]]),
            solid=left.solid,
            heading=NOTHING,
            anchor=(float(pose[0]), float(pose[1])),
            style=self._styles[body].ghost or self._styles[body],
            form=left,
            pose=(float(pose[0]), float(pose[1]), float(pose[2])),
        )


def labels(bodies: Sequence[DrawnBody], goals: Sequence[GoalView]) -> tuple[LabelView, ...]:
    """Return the texts beside bodies and below goals."""
    named = [(view, view.style) for view in bodies if view.style.label]
    beside = [LabelView(*view.anchor, one.label, one, None if one.label_offset else _foot(view)) for view, one in named]
    below = [
        LabelView(view.x, view.y, view.style.goal_label, view.style, view.y - view.tolerance)  # below its own flag
        for view in goals
        if view.style.goal_label
    ]
    return tuple(beside + below)


def _chain(segments: Floats) -> Floats:
    """Return the vertices of consecutive segments, shape ``(n_segments + 1, 2)``."""
    vertices = np.empty((len(segments) + 1, 2))
    vertices[:-1], vertices[-1] = segments[:, :2], segments[-1, 2:]
    return vertices


def _anchor(pose: Floats, style: BodyStyle, lines: Sequence[Floats], discs: Floats) -> tuple[float, float]:
    """Return the position of a body's label: at the given offset, or above the footprint."""
    x, y, _ = pose.tolist()
    if style.label_offset is not None:
        return x + style.label_offset[0], y + style.label_offset[1]
    if not style.label:
        return x, y
    if not lines and len(discs) == 1:
        x, y, radius = discs[0].tolist()
        return x, y + radius + LABEL_GAP
    corners = [*lines, discs[:, :2] - discs[:, 2:], discs[:, :2] + discs[:, 2:]]
    points = np.concatenate(corners)
    if not len(points):
        return x, y
    (x_min, _), (x_max, y_max) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    return 0.5 * (x_min + x_max), y_max + LABEL_GAP


def _foot(view: DrawnBody) -> float | None:
    """Return the lowest y coordinate of a footprint; None for an empty one."""
    if not view.lines and len(view.discs) == 1:
        _, y, radius = view.discs[0].tolist()
        return float(y - radius)
    lowest = [float(line[:, 1].min()) for line in view.lines] + [float(y - radius) for _, y, radius in view.discs]
    return min(lowest, default=None)
