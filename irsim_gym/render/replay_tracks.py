"""What a replay remembers of bodies, scans, maps and whatever changes seldom."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterable
from dataclasses import asdict, is_dataclass, replace
from typing import Any

import numpy as np
from matplotlib.colors import to_hex
from PIL import Image

from irsim_gym.arraytypes import Floats
from irsim_gym.render import shapes
from irsim_gym.render.outlines import chains, placed, replaced
from irsim_gym.render.packing import METRE, RADIAN, packed
from irsim_gym.render.scene import BodyView, FogView, ImageView, MapView, ScanView
from irsim_gym.render.styles import BodyStyle

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


class Styles:
    """Styles by number; colours are what browsers understand."""

    def __init__(self) -> None:
        self.list: list[dict[str, Any]] = []
        self._known: dict[int, tuple[Any, int]] = {}

    def number(self, style: Any) -> int:
        """Return the number of a style; equal ones have the same."""
        known = self._known.get(id(style))
        if known is not None:
            return known[1]
        plain = _plain(style)
        if plain not in self.list:
            self.list.append(plain)
        number = self.list.index(plain)
        self._known[id(style)] = style, number
        return number


class BodyTrack:
    """A rigid body: its outline in its own frame, and its poses.

    Args:
        view: The body as it is seen first.
        pose: Where it is then.
        style: Number of its style.
        field: Width [rad] and depth [m] of its field of view, None where that is not shown.
        fixed: It never moves.
    """

    def __init__(
        self, view: BodyView, pose: Floats, style: int, field: tuple[float, float] | None, *, fixed: bool
    ) -> None:
        self._view, self._style, self._field, self.fixed = view, style, field, fixed
        self._filled = shapes.is_filled(view)
        self._lines = [_own(line, pose) for line in view.lines]
        self._discs = np.hstack([_own(view.discs[:, :2], pose), view.discs[:, 2:]])
        self._mark = _own(view.heading, pose)
        self._image = None if view.image is None else _image(view.image, pose)
        self._ghost = None if view.style.ghost is None else self._left_behind(view, view.style.ghost)
        self._rows: dict[int, Floats] = {}

    def _left_behind(self, view: BodyView, style: BodyStyle) -> dict[str, Any]:
        """Return the outline that the body leaves behind on its way."""
        shape = view.style.ghost_shape or ""
        sides = [np.hstack([line[:-1], line[1:]]) for line in self._lines]
        segments, discs = replaced(shape, np.vstack([np.zeros((0, 4)), *sides]), self._discs)
        lines = chains(segments)
        solid = shape != "linestring" and (bool(shape) or view.solid)
        return {**_outline(lines, discs), "filled": style.filled and bool(len(discs) or (lines and solid))}

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

    def data(self, count: int) -> dict[str, Any]:
        """Return the body as JSON, with a pose for each of ``count`` moments."""
        rows = np.full((count, 4), np.nan)
        for moment, row in self._rows.items():
            rows[moment] = row
        return {
            "name": self._view.name,
            "style": self._style,
            "fixed": self.fixed,
            "filled": self._filled,
            "field": None if self._field is None else [round(value, 4) for value in self._field],
            "ghost": self._ghost,
            "image": self._image,
            **_outline(self._lines, self._discs),
            "mark": np.round(self._mark, 4).ravel().tolist(),
            "poses": [packed(rows[:, :2], METRE), packed(rows[:, 2:], RADIAN)],
        }


class ScanTrack:
    """What a range sensor saw.

    Args:
        view: The first scan.
        name: Name of the body that carries it.
        style: Number of its style.
    """

    def __init__(self, view: ScanView, name: str, style: int) -> None:
        self._view, self._name, self._style = view, name, style
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
            "style": self._style,
            "surrounds": self._view.surrounds,
            "angles": np.round(self._view.angles, 5).tolist(),
            "near": round(near, 4),
            "far": None if far == np.inf else round(far - 0.5 * METRE, 4),
            "ranges": packed(ranges, METRE),
            "places": [packed(places[:, :2], METRE), packed(places[:, 2:], RADIAN)],
            "speeds": packed(speeds, SPEED) if moving else None,
        }


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
            "colour": to_hex(self._view.colour, keep_alpha=True),
            "alpha": self._view.alpha,
            "changes": self._changes,
        }


def map_data(view: MapView) -> dict[str, Any]:
    """Return a map as JSON: its rectangle [m], number of columns and rows, colour, opacity, and boxes of cells.

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
        "colour": to_hex(view.colour, keep_alpha=True),
        "alpha": view.alpha,
        "boxes": [value for box in sorted(boxes) for value in box],
    }


def _image(view: ImageView, pose: Floats) -> dict[str, Any]:
    """Return an image: the picture as a data URL, its corners in the body's frame [m], and its opacity."""
    content = io.BytesIO()
    Image.fromarray(view.pixels).save(content, "png", optimize=True)
    lower, upper = _own(view.corners[[0, 2]], pose).tolist()
    return {
        "picture": f"data:image/png;base64,{base64.b64encode(content.getvalue()).decode()}",
        "box": [round(value, 4) for value in (*lower, *upper)],
        "alpha": view.alpha,
    }


def _outline(lines: Iterable[Floats], discs: Floats) -> dict[str, Any]:
    return {
        "lines": [np.round(line, 4).ravel().tolist() for line in lines],
        "discs": np.round(discs, 4).tolist(),
    }


def _own(points: Floats, pose: Floats) -> Floats:
    """Move points of the world frame, shape ``(n, 2)`` [m], to the frame of a body."""
    return placed(points - pose[:2], np.array([0.0, 0.0, -pose[2]]))


def _turn(mark: Floats, now: Floats) -> float:
    """Return by how much a mark is turned about the body's origin [rad]."""
    across = float((mark[:, 0] * now[:, 1] - mark[:, 1] * now[:, 0]).sum())
    along = float((mark * now).sum())
    return float(np.arctan2(across, along)) if len(mark) else 0.0


def _plain(style: Any) -> dict[str, Any]:
    assert is_dataclass(style)
    assert not isinstance(style, type)
    return {key: _browsers(key, value) for key, value in asdict(style).items()}


def _browsers(key: str, value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _browsers(name, inner) for name, inner in value.items()}
    return to_hex(value, keep_alpha=True) if key.endswith("colour") and isinstance(value, str) else value
