"""What a replay remembers of bodies, scans, fog and maps."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from PIL import Image

from irsim_gym.arraytypes import Bytes, Floats
from irsim_gym.render import vocabulary
from irsim_gym.render.outlines import chains, placed, replaced
from irsim_gym.render.packing import METRE, RADIAN, packed
from irsim_gym.render.replay_items import Items, Shared, channels, shape_data
from irsim_gym.render.scene import BodyView, FogView, MapView, ScanView
from irsim_gym.render.shapes import is_filled
from irsim_gym.render.styles import TOP, BodyStyle
from irsim_gym.render.vocabulary import Pen, Shape

SAME = 1e-6
SPEED = 1e-3


class Changes:
    """A value that changes seldom: moments and what it is from then on."""

    def __init__(self) -> None:
        self.list: list[list[Any]] = []

    def note(self, moment: int, value: Any) -> None:
        """Note the value at a moment."""
        if not self.list or self.list[-1][1] != value:
            self.list.append([moment, value])


class BodyTrack:
    """A rigid body: its outline in its own frame, and its poses.

    Args:
        view: The body as it is seen first.
        pose: Its pose then.
        field: Width [rad] and depth [m] of its field of view; None where that is not shown.
        fixed: It never moves.
    """

    def __init__(self, view: BodyView, pose: Floats, field: tuple[float, float] | None, *, fixed: bool) -> None:
        self._view, self._field, self.fixed = view, field, fixed
        self._lines = [_own(line, pose) for line in view.lines]
        self._discs = np.hstack([_own(view.discs[:, :2], pose), view.discs[:, 2:]])
        self._mark = _own(view.heading, pose)
        self._box = None if view.image is None else _own(view.image.corners[[0, 2]], pose).ravel()
        self._rows: dict[int, Floats] = {}

    @property
    def name(self) -> str:
        """The body's name."""
        return self._view.name

    def fits(self, view: BodyView, pose: Floats) -> bool:
        """Return whether the body still has its outline."""
        lines, discs = [_own(line, pose) for line in view.lines], _own(view.discs[:, :2], pose)
        return (
            [line.shape for line in lines] == [line.shape for line in self._lines]
            and discs.shape == self._discs[:, :2].shape
            and view.heading.shape == self._mark.shape
            and all(np.abs(one - other).max() < SAME for one, other in zip(lines, self._lines, strict=True))
            and bool((np.abs(discs - self._discs[:, :2]) < SAME).all())
            and bool((np.abs(view.discs[:, 2] - self._discs[:, 2]) < SAME).all())
        )

    def note(self, view: BodyView, pose: Floats, moment: int) -> None:
        """Note where the body is, and where its mark points."""
        self._rows[moment] = np.array([*pose, _turn(self._mark, _own(view.heading, pose))])

    def stay(self, moment: int) -> None:
        """Note that it is where it was."""
        self._rows[moment] = self._rows[moment - 1]

    def view(self, moment: int) -> BodyView | None:
        """Return the body as it stood at a moment, without an image; None where it was not there."""
        row = self._rows.get(moment)
        if row is None:
            return None
        pose = row[:3]
        return replace(
            self._view,
            lines=tuple(placed(line, pose) for line in self._lines),
            discs=np.hstack([placed(self._discs[:, :2], pose), self._discs[:, 2:]]),
            heading=placed(self._mark, pose + np.array([0.0, 0.0, row[3]])),
            anchor=(float(pose[0]), float(pose[1])),
            image=None,
        )

    def data(self, count: int, shared: Shared) -> dict[str, Any]:
        """Return the body as JSON, with a pose for each of ``count`` moments."""
        rows = np.full((count, 4), np.nan)
        for moment, row in self._rows.items():
            rows[moment] = row
        return {
            "name": self._view.name,
            "fixed": self.fixed,
            "shape": shared.shape(shape_data(self._shape())),
            "poses": [packed(rows[:, :2], METRE), packed(rows[:, 2:], RADIAN)],
        }

    def draw(self, items: Items, number: int, struck: Sequence[int]) -> None:
        """Add what is drawn of the body.

        Args:
            items: Where it is added.
            number: Number of the body in the episode.
            struck: Spans of moments at which it takes part in a collision.
        """
        view, style = self._view, self._view.style
        rank, at, shape = "fixed" if self.fixed else "bodies", {"body": number}, self._shape()
        outline = items.shared.shape(shape_data(shape))
        if view.image is not None and self._box is not None:
            picture, box = items.shared.picture(_url(view.image.pixels)), np.round(self._box, 4).tolist()
            items.add(rank, style.order, "image", picture=picture, box=box, alpha=view.image.alpha, **at)
        else:
            filled = is_filled(view)
            for shift, pen in vocabulary.SHADOWS if self.fixed and filled else ():
                items.figure("shadows", style.order, pen, outline, shift=shift, **at)
            for pen in vocabulary.footprint(style, filled=filled, parts=len(self._lines) + len(self._discs)):
                items.figure(rank, style.order, pen, outline, **at)
        if len(self._mark):
            layer = style.order if style.arrow_order is None else style.arrow_order
            mark = items.shared.shape(shape_data(Shape((np.vstack([self._mark, self._mark[:1]]),))))
            items.figure("headings", layer, vocabulary.heading(style), mark, turned=True, **at)
        if self._field is not None:
            sector = items.shared.shape(shape_data(Shape(sector=self._field)))
            items.figure("fields", style.field_order, vocabulary.field_of_view(style), sector, **at)
        if not self.fixed:
            self._draw_past(items, style, at)
        for pen in vocabulary.IMPACT if struck else ():
            items.figure("impacts", TOP, pen, outline, spans=struck, **at)
        items.body_label(style, view.name, number, fixed=self.fixed)

    def _draw_past(self, items: Items, style: BodyStyle, at: dict[str, int]) -> None:
        """Add the body's trajectory, and the outlines that it leaves behind."""
        if style.show_trajectory:
            pen, length = items.shared.pen(vocabulary.trajectory(style)), style.trajectory_length or None
            items.add("paths", style.trajectory_order, "path", pen=pen, length=length, **at)
        if style.ghost is not None:
            shape, past = style.ghost_shape or "", [style.ghost_every, style.ghost_length]
            sides = [np.hstack([line[:-1], line[1:]]) for line in self._lines]
            segments, discs = replaced(shape, np.vstack([np.zeros((0, 4)), *sides]), self._discs)
            ghost = Shape(chains(segments), discs=discs)
            solid = shape != "linestring" and (bool(shape) or self._view.solid)
            filled = style.ghost.filled and bool(len(discs) or (ghost.chains and solid))
            number = items.shared.shape(shape_data(ghost))
            for pen in vocabulary.footprint(style.ghost, filled=filled, parts=len(ghost.chains) + len(discs)):
                items.figure("ghosts", style.ghost.order, pen, number, past=past, **at)

    def _shape(self) -> Shape:
        return Shape(tuple(self._lines), discs=self._discs)


class ScanTrack:
    """What a range sensor saw.

    Args:
        view: The first scan.
        name: Name of the body that carries it.
    """

    def __init__(self, view: ScanView, name: str) -> None:
        self._view, self._name = view, name
        self._rows: list[tuple[int, ScanView]] = []

    def note(self, view: ScanView, moment: int) -> None:
        """Note a scan."""
        self._rows.append((moment, view))

    def data(self, count: int) -> dict[str, Any]:
        """Return the scans as JSON, for each of ``count`` moments."""
        beams = len(self._view.angles)
        ranges, places = np.full((count, beams), np.nan), np.full((count, 3), np.nan)
        speeds, far, near = np.full((count, beams), np.nan), np.inf, -1.0
        for moment, view in self._rows:
            ranges[moment] = np.linalg.norm(view.ends - view.origin, axis=1)
            places[moment] = *view.origin, view.heading
            speeds[moment] = np.where(view.valid, view.speeds, 0.0)
            far = min(far, ranges[moment][~view.hits].min(initial=np.inf))
            near = max(near, ranges[moment][view.hits & ~view.valid].max(initial=-1.0))
        moving = bool(np.nan_to_num(speeds).any())
        return {
            "body": self._name,
            "surrounds": self._view.surrounds,
            "angles": np.round(self._view.angles, 5).tolist(),
            "near": round(near, 4),
            "far": None if far == np.inf else round(far - 0.5 * METRE, 4),
            "ranges": packed(ranges, METRE),
            "places": [packed(places[:, :2], METRE), packed(places[:, 2:], RADIAN)],
            "speeds": packed(speeds, SPEED) if moving else None,
        }

    def draw(self, items: Items, number: int) -> None:
        """Add what is drawn of the scan with this number."""
        items.scan(self._view.style, number, len(self._view.angles))


class FogTrack:
    """The cells that nobody has seen yet.

    Args:
        view: The fog as it is first.
    """

    def __init__(self, view: FogView) -> None:
        self._view = view
        self._covered = np.zeros(view.covered.size, np.bool_)
        self._changes: list[list[Any]] = []

    def note(self, view: FogView, moment: int) -> None:
        """Note which cells are covered."""
        covered = view.covered.ravel()
        changed = np.flatnonzero(covered != self._covered)
        if len(changed):
            self._changes.append([moment, np.diff(changed, prepend=0).tolist()])
        self._covered = covered.copy()

    def data(self) -> dict[str, Any]:
        """Return the fog as JSON: at each moment the cells that change, as differences; none is covered before."""
        return {
            "extent": [round(float(value), 6) for value in self._view.extent],
            "size": list(self._view.covered.shape),
            "ink": [*channels(self._view.colour), self._view.alpha],
            "changes": self._changes,
        }


def draw_map(items: Items, view: MapView, spans: Sequence[int]) -> None:
    """Add a map that is shown in some spans of moments; a thin edge keeps thin walls visible and hides seams."""
    ink = vocabulary.Ink(view.colour, view.alpha)
    items.figure("map", -np.inf, Pen(ink, ink, 0.5), items.shared.shape({"cells": cells_data(view)}), spans=spans)


def cells_data(view: MapView) -> dict[str, Any]:
    """Return the occupied cells of a map as JSON: its rectangle [m], number of columns and rows, and boxes of cells.

    A box is first column, first row, end column, end row; together the boxes are what is occupied.
    """
    boxes: list[list[int]] = []
    open_runs: dict[tuple[int, int], int] = {}
    for column, cells in enumerate([*view.occupied, np.zeros(view.occupied.shape[1], np.bool_)]):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], cells.astype(np.int8), [0]]))).tolist()
        runs = set(zip(edges[0::2], edges[1::2], strict=True))
        for run in [run for run in open_runs if run not in runs]:
            boxes.append([open_runs.pop(run), run[0], column, run[1]])
        for run in runs:
            open_runs.setdefault(run, column)
    return {
        "extent": [round(float(value), 6) for value in view.extent],
        "size": list(view.occupied.shape),
        "boxes": [value for box in sorted(boxes) for value in box],
    }


def _url(pixels: Bytes) -> str:
    """Return an image as a data URL."""
    content = io.BytesIO()
    Image.fromarray(pixels).save(content, "png", optimize=True)
    return f"data:image/png;base64,{base64.b64encode(content.getvalue()).decode()}"


def _own(points: Floats, pose: Floats) -> Floats:
    """Move points of the world frame, shape ``(n, 2)`` [m], to the frame of a body."""
    return placed(points - pose[:2], np.array([0.0, 0.0, -pose[2]]))


def _turn(mark: Floats, now: Floats) -> float:
    """Return by how much a mark is turned about the body's origin [rad]."""
    across = float((mark[:, 0] * now[:, 1] - mark[:, 1] * now[:, 0]).sum())
    along = float((mark * now).sum())
    return float(np.arctan2(across, along)) if len(mark) else 0.0
