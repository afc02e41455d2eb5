"""The histories of bodies, scans, fog, maps and marks in a recording."""

from collections.abc import Hashable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.rendering.looks.packing import METRE, RADIAN, packed
from irsim_gym.rendering.replay.replay_items import Items, SharedItems
from irsim_gym.rendering.scene import vocabulary
from irsim_gym.rendering.scene.primitives import Figure, Ink, Pen, Shape
from irsim_gym.rendering.scene.scene import DrawnBody, FogView, Form, MapView, ScanView
from irsim_gym.rendering.scene.shapes import placed
from irsim_gym.simulator.readings.marks import Mark, Overlay

SPEED = 1e-3


class Changes:
    """A value that changes seldom: the moments at which it changes, with its new values."""

    def __init__(self) -> None:
        self.list: list[list[Any]] = []

    def note(self, moment: int, value: object) -> None:
        """Record the value at a moment."""
        if not self.list or self.list[-1][1] != value:
            self.list.append([moment, value])


class Seen:
    """Things that are visible at some moments only, in order of appearance.

    Attributes:
        things: Each thing by its key, with its spans: first moment, end, first moment, end...
    """

    def __init__(self) -> None:
        self.things: dict[Hashable, tuple[Any, list[int]]] = {}
        self._latest: list[list[int]] = []
        self._moment = -1

    def note(self, moment: int, key: Hashable, thing: object) -> None:
        """Record that a thing is visible at a moment."""
        if moment != self._moment:
            self._moment, self._latest = moment, []
        spans = self.things.setdefault(key, (thing, []))[1]
        self._latest.append(spans)
        if spans and spans[-1] >= moment:
            spans[-1] = moment + 1
        else:
            spans += [moment, moment + 1]

    def note_again(self, moment: int) -> None:
        """Record that exactly the things of the previous moment are visible at this one."""
        if self._moment == moment - 1:
            self._moment = moment
            for spans in self._latest:
                spans[-1] = moment + 1


class BodyTrack:
    """A rigid body and its poses.

    Args:
        view: The body at the start.
        field: Width [rad] and depth [m] of its field of view; None if that is not shown.
        fixed: Whether it never moves.
    """

    def __init__(self, view: DrawnBody, field: tuple[float, float] | None, *, fixed: bool) -> None:
        self._view, self._form, self._field, self.fixed = view, view.form, field, fixed
        self._rows: dict[int, Floats] = {}

    def fits(self, view: DrawnBody) -> bool:
        """Return whether the body still has the same outline."""
        if view.form is not self._form and not _alike(view.form, self._form):
            return False
        self._form = view.form
        return True

    def note(self, view: DrawnBody, pose: Floats, moment: int) -> None:
        """Record the pose of the body, and the direction of its mark."""
        self._rows[moment] = np.array([*pose, view.turn])

    def stay(self, moment: int) -> None:
        """Record that its pose has not changed."""
        self._rows[moment] = self._rows[moment - 1]

    def view(self, moment: int) -> DrawnBody | None:
        """Return the body at a moment, without an image; None if it is absent."""
        row = self._rows.get(moment)
        if row is None:
            return None
        pose, form = row[:3], self._view.form
        return replace(
            self._view,
            lines=tuple(placed(line, pose) for line in form.lines),
            discs=np.hstack([placed(form.discs[:, :2], pose), form.discs[:, 2:]]),
            heading=placed(form.mark, pose + np.array([0.0, 0.0, row[3]])),
            anchor=(float(pose[0]), float(pose[1])),
            pose=(float(pose[0]), float(pose[1]), float(pose[2])),
            image=None,
        )

    def data(self, count: int, shared: SharedItems) -> dict[str, Any]:
        """Return the track as JSON, with a pose for each of ``count`` moments."""
        rows = np.full((count, 4), np.nan)
        for moment, row in self._rows.items():
            rows[moment] = row
        poses = [packed(rows[:, :2], METRE), packed(rows[:, 2:], RADIAN)]
        shape = shared.shape(vocabulary.outline(self._view.form))
        return {"name": self._view.name, "fixed": self.fixed, "shape": shape, "poses": poses}

    def draw(self, items: Items, number: int, struck: Seen) -> None:
        """Add the items of the body with this number; ``struck`` holds colliding bodies by name."""
        for thing in vocabulary.body(self._view, self._field, fixed=self.fixed):
            items.add(thing, body=number)
        if self._view.name in struck.things:
            for edge in vocabulary.impact(self._view.form):
                items.add(edge, body=number, spans=struck.things[self._view.name][1])


class ScanTrack:
    """The scans of a range sensor.

    Args:
        view: The first scan.
        name: Name of the body that carries the sensor.
    """

    def __init__(self, view: ScanView, name: str) -> None:
        self._view, self._name = view, name
        self._rows: list[tuple[int, ScanView]] = []

    def note(self, view: ScanView, moment: int) -> None:
        """Record a scan."""
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
            # The page knows hits by their range alone: below the shortest one of a beam without a hit, and above the
            # longest one that is too near.
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
        """Add the items of the scan with this number."""
        for beams in vocabulary.scan(self._view.style, len(self._view.angles)):
            items.add(beams, scan=number)


class FogTrack:
    """The cells that no robot has seen yet.

    Args:
        view: The fog at the start.
    """

    def __init__(self, view: FogView) -> None:
        self._view = view
        self._covered = np.zeros(view.covered.size, np.bool_)
        self._changes: list[list[Any]] = []

    def note(self, view: FogView, moment: int) -> None:
        """Record which cells are covered."""
        covered = view.covered.ravel()
        changed = np.flatnonzero(covered != self._covered)
        if len(changed):
            # Numbers of cells as distances from the one before, which compress well.
            self._changes.append([moment, np.diff(changed, prepend=0).tolist()])
        self._covered = covered.copy()

    def data(self) -> dict[str, Any]:
        """Return the fog as JSON: the cells that change at each moment, as differences; initially none is covered."""
        extent = [round(float(value), 6) for value in self._view.extent]
        return {"extent": extent, "size": list(self._view.covered.shape), "changes": self._changes}

    def draw(self, items: Items) -> None:
        """Add the fog."""
        items.add(vocabulary.fog(self._view))


def _alike(first: Form, other: Form) -> bool:
    """Return whether two footprints have the same outline and mark."""
    parts, others = ([*form.lines, form.discs, form.mark] for form in (first, other))
    return len(parts) == len(others) and all(map(np.array_equal, parts, others))


def map_figure(view: MapView) -> Figure:
    """Return a map as boxes of occupied cells, with a thin edge that keeps thin walls visible and hides seams."""
    boxes: list[list[int]] = []
    open_runs: dict[tuple[int, int], int] = {}
    # Equal runs of occupied cells in neighbouring columns form one box. The empty column at the end closes all.
    for column, cells in enumerate([*view.occupied, np.zeros(view.occupied.shape[1], np.bool_)]):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], cells.astype(np.int8), [0]]))).tolist()
        runs = set(zip(edges[0::2], edges[1::2], strict=True))
        for run in [run for run in open_runs if run not in runs]:
            boxes.append([open_runs.pop(run), run[0], column, run[1]])
        for run in runs:
            open_runs.setdefault(run, column)
    x_min, y_min, x_max, y_max = (float(value) for value in view.extent)
    cell = x_min, y_min, (x_max - x_min) / view.occupied.shape[0], (y_max - y_min) / view.occupied.shape[1]
    ink, shape = Ink(view.colour, view.alpha), Shape(boxes=np.array(sorted(boxes), np.int64).reshape(-1, 4), cell=cell)
    return Figure("map", -np.inf, Pen(ink, ink, 0.5), shape)


def marks_seen(overlays: Sequence[Overlay]) -> Seen:
    """Return the marks over the world with their spans; marks that are drawn again unchanged count as one."""
    seen, looks = Seen(), dict[int, Hashable]()
    for moment, overlay in enumerate(overlays):
        if moment and overlay is overlays[moment - 1]:
            seen.note_again(moment)
            continue
        counts = dict[Hashable, int]()
        for mark in overlay.marks:
            look = looks[id(mark)] = looks.get(id(mark)) or _look(mark)
            counts[look] = counts.get(look, 0) + 1
            seen.note(moment, (look, counts[look]), mark)
    return seen


def _look(mark: Mark) -> Hashable:
    """Return a key of a mark's appearance; the parts of its form are identified as objects, which marks share."""
    values = [tuple(map(id, value)) if isinstance(value, tuple) else value for value in vars(mark).values()]
    return type(mark), *(value.tobytes() if isinstance(value, np.ndarray) else value for value in values)
