"""What a page draws, as JSON: pens and shapes by number, and items in the order in which they cover each other."""

from __future__ import annotations

import json
from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.arraytypes import Floats
from irsim_gym.raster.ways import DASHES
from irsim_gym.render import vocabulary
from irsim_gym.render.colours import colour
from irsim_gym.render.packing import METRE, packed
from irsim_gym.render.scene import GoalView
from irsim_gym.render.shapes import MOST_BEAMS
from irsim_gym.render.styles import BodyStyle, ScanStyle, faded
from irsim_gym.render.vocabulary import LINE_STYLES, RANKS, Beams, Figure, Ink, Pen, Shape
from irsim_gym.world.marks import Mark, Overlay, TextMark

FINE = 1e-4
"""Unit of vertices in a shape's own frame [m]."""
RANK_NUMBERS = {name: number for number, name in enumerate(RANKS)}


class Seen:
    """Things that are seen at some moments only, in the order in which they come.

    Attributes:
        things: By key, the thing and its spans: first moment, end, first moment, end...
    """

    def __init__(self) -> None:
        self.things: dict[Hashable, tuple[Any, list[int]]] = {}
        self._latest: tuple[int, list[list[int]]] = -1, []

    def note(self, moment: int, key: Hashable, thing: Any) -> None:
        """Note that a thing is seen at a moment."""
        spans = self.things.setdefault(key, (thing, []))[1]
        if self._latest[0] != moment:
            self._latest = moment, []
        self._latest[1].append(spans)
        if spans and spans[-1] == moment:
            spans[-1] = moment + 1
        else:
            spans += [moment, moment + 1]

    def note_again(self, moment: int) -> None:
        """Note that all that was seen one moment before is seen at this one, too."""
        before, latest = self._latest
        if before == moment - 1:
            self._latest = moment, latest
            for spans in latest:
                spans[-1] = moment + 1


class Shared:
    """Pens, shapes and pictures of all episodes of a page; equal ones are held once.

    Attributes:
        pens: Pens as JSON: ``fill``, ``full`` (``filled_radius``), ``edge``, ``width``, ``dashes``, ``cap``, ``metres``.
        shapes: Shapes as JSON, see ``shape_data``.
        pictures: PNG images as data URLs.
    """

    def __init__(self) -> None:
        self.pens: list[Any] = []
        self.shapes: list[Any] = []
        self.pictures: list[str] = []
        self._numbers: dict[tuple[int, str], int] = {}

    def pen(self, pen: Pen) -> int:
        """Return the number of a pen."""
        return self._number(self.pens, pen_data(pen))

    def shape(self, data: dict[str, Any]) -> int:
        """Return the number of a shape."""
        return self._number(self.shapes, data)

    def picture(self, source: str) -> int:
        """Return the number of a picture."""
        return self._number(self.pictures, source)

    def _number(self, known: list[Any], thing: Any) -> int:
        key = id(known), json.dumps(thing)
        if key not in self._numbers:
            self._numbers[key] = len(known)
            known.append(thing)
        return self._numbers[key]


class Items:
    """Collects what is drawn in one episode.

    Args:
        shared: Pens, shapes and pictures of the page.
    """

    def __init__(self, shared: Shared) -> None:
        self.shared = shared
        self._rows: list[tuple[float, int, dict[str, Any]]] = []

    def add(self, rank: str, layer: float, draw: str, **fields: Any) -> None:
        """Add an item: a rank's name, a layer, a primitive of the page's script, and what that one reads."""
        known = {name: value for name, value in fields.items() if value is not None}
        self._rows.append((layer, RANK_NUMBERS[rank], {"rank": rank, "draw": draw, **known}))

    def figure(self, rank: str, layer: float, pen: Pen, shape: int, **fields: Any) -> None:
        """Add a shape that is drawn with a pen, at a body or at places."""
        self.add(rank, layer, "figure", pen=self.shared.pen(pen), shape=shape, **fields)

    def place(self, figure: Figure, spans: Sequence[int]) -> None:
        """Add a figure that is seen in some spans of moments."""
        shape = self.shared.shape(shape_data(figure.shape))
        self.figure(figure.rank, figure.layer, figure.pen, shape, places=None if figure.places is None else _places(figure.places), spans=spans)

    def body_label(self, style: BodyStyle, name: str, body: int, *, fixed: bool) -> None:
        """Add the label of a body; one without a label of its own shows its name where names are asked for."""
        offset = style.label_offset if style.label else None
        if style.label or not fixed:
            look = _words(style.label_size, Ink(style.label_colour, style.label_alpha))
            text, rank = style.label or name, "labels" if style.label else "names"
            self.add(rank, style.label_order, "text", text=text, body=body, offset=offset, **look)

    def goals(self, seen: Seen) -> None:
        """Add goals, and their labels below the circles: their flags are above."""
        view: GoalView
        for view, spans in seen.things.values():
            for figure in vocabulary.goal(view):
                self.place(figure, spans)
            style = view.style
            if style.goal_label:
                look = _words(style.label_size, Ink(style.label_colour, style.label_alpha))
                foot, drop = [[view.x, view.y - view.tolerance]], vocabulary.LABEL_HEIGHT * style.label_size
                text = {"text": style.goal_label, "places": _places(foot), "spans": spans, "drop": drop}
                self.add("labels", style.label_order, "text", **text, **look)

    def scan(self, style: ScanStyle, number: int, beams: int) -> None:
        """Add what is drawn of a sensor with this number."""
        every = -(-beams // MOST_BEAMS)
        for part in vocabulary.scan(style):
            fields = {"scan": number, "form": part.form, "which": part.which, "pen": self.shared.pen(part.pen)}
            skipped = every if part.form == "rays" and part.which == "all" and every > 1 else None
            tints = _tints(style, part)
            self.add(part.rank, part.layer, "beams", **fields, every=skipped, radius=part.radius or None, tints=tints)

    def overlays(self, overlays: Sequence[Overlay]) -> None:
        """Add the marks that lay over the world at each moment; what is drawn anew as it was is one mark."""
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
        for mark, spans in seen.things.values():
            if isinstance(mark, TextMark):
                words = _words(mark.size, Ink(*faded(mark.color, mark.alpha)), mark.align, "middle")
                places = _places([[mark.x, mark.y]])
                self.add("words", mark.layer, "text", text=mark.text, places=places, spans=spans, **words)
            else:
                self.place(vocabulary.mark(mark), spans)

    def outcome(self, colour: str, bounds: Floats, spans: Sequence[int]) -> None:
        """Add what shows an outcome: a touch of its colour over the world's rectangle, and a frame around that."""
        x_min, y_min, x_max, y_max = bounds.tolist()
        corners = [(x_min, y_min), (x_max, y_min), (x_max, y_max), (x_min, y_max), (x_min, y_min)]
        shape = Shape((np.array(corners),))
        self.place(Figure("touch", -np.inf, Pen(Ink(colour, 0.07)), shape), spans)
        self.place(Figure("frame", np.inf, Pen(edge=Ink(colour, 0.9), width=2.2), shape), spans)

    def list(self) -> list[dict[str, Any]]:
        """Return the items, the lowest first."""
        return [item for *_, item in sorted(self._rows, key=lambda row: row[:2])]


def pen_data(pen: Pen) -> dict[str, Any]:
    """Return a pen as JSON; colours are what browsers understand."""
    data: dict[str, Any] = {}
    if pen.fill is not None and pen.fill.opacity > 0.0:
        data["fill"] = css(pen.fill)
    if pen.filled_radius:
        data["full"] = pen.filled_radius
    if pen.width > 0.0:
        if pen.edge is not None and pen.edge.opacity > 0.0:
            data["edge"] = css(pen.edge)
        if pen.line != "solid":
            data["dashes"] = DASHES[LINE_STYLES.index(pen.line)].tolist()
        data |= {"width": pen.width, "cap": pen.cap, "metres": pen.in_metres}
    return data


def shape_data(shape: Shape) -> dict[str, Any]:
    """Return a shape as JSON: ``chains`` [m] and ``offsets`` [point] packed, and the others where it has them."""
    data: dict[str, Any] = {}
    if shape.chains:
        data["chains"] = [packed(line, FINE) for line in shape.chains]
    if shape.offsets:
        data["offsets"] = [packed(line, 1e-3) for line in shape.offsets]
    if shape.least:
        data["least"] = shape.least
    if len(shape.discs):
        data["discs"] = np.round(shape.discs, 4).tolist()
    if shape.sector is not None:
        data["sector"] = [round(value, 4) for value in shape.sector]
    if shape.dot:
        data["dot"] = shape.dot
    return data


def css(ink: Ink) -> str:
    """Return a colour as browsers write it, ``#rrggbb`` or ``#rrggbbaa``."""
    *channels, opacity = colour(ink.colour, ink.opacity)
    parts = [round(ink.brightness * value) for value in channels]
    if opacity < 1.0:
        parts.append(round(255.0 * opacity))
    return "#" + "".join(f"{part:02x}" for part in parts)


def channels(name: str) -> list[int]:
    """Return red, green and blue of a colour, 0 to 255."""
    return [round(value) for value in colour(name, 1.0)[:3]]


def _words(size: float, ink: Ink, align: str = "center", level: str = "bottom") -> dict[str, Any]:
    return {"size": size, "ink": css(ink), "align": align, "level": level}


def _places(points: ArrayLike) -> dict[str, Any]:
    return packed(points, METRE, still=False)


def _tints(style: ScanStyle, beams: Beams) -> dict[str, Any] | None:
    """Return the colours of radial velocities, and the speed of the full colour [m/s]."""
    speed = style.velocity
    if speed is None or beams.tinted is None:
        return None
    return {
        "rest": channels(speed.rest_colour),
        "away": channels(speed.away_colour),
        "nearer": channels(speed.nearer_colour),
        "full": speed.full_speed,
        "opacity": beams.tinted,
    }


def _look(mark: Mark) -> Hashable:
    """Return what makes a mark look as it does."""
    return type(mark), *(_hashable(value) for value in vars(mark).values())


def _hashable(value: Any) -> Hashable:
    if isinstance(value, tuple):
        return tuple(map(id, value))  # the parts of a form are the same objects for all marks of one kind
    return value.tobytes() if isinstance(value, np.ndarray) else value
