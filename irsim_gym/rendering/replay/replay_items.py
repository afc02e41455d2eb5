"""The items of a replay page as JSON: pens, shapes and pictures by number, and primitives in drawing order."""

import base64
import io
import json
from typing import Any

import numpy as np
from PIL import Image

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.rendering.looks.colours import colour
from irsim_gym.rendering.looks.packing import METRE, packed
from irsim_gym.rendering.scene.primitives import Ink, Pen, Primitive, Shape
from irsim_gym.rendering.scene.vocabulary import RANKS

FINE = 1e-4
"""Unit of numbers up to 1; the unit of larger ones is a millimetre."""
RANK_NUMBERS = {name: number for number, name in enumerate(RANKS)}


class SharedItems:
    """Pens, shapes and pictures (PNG images as data URLs) of all episodes of a page, without duplicates."""

    def __init__(self) -> None:
        self._tables: dict[str, dict[str, int]] = {"pens": {}, "shapes": {}, "pictures": {}}

    def number(self, table: str, thing: object) -> int:
        """Return the number of an entry in a table, after adding it if it is new."""
        rows = self._tables[table]
        return rows.setdefault(json.dumps(thing), len(rows))

    def shape(self, shape: Shape) -> int:
        """Return the number of a shape."""
        return self.number("shapes", _fields_as_json(shape, self))

    def data(self) -> dict[str, list[Any]]:
        """Return the tables as JSON."""
        return {table: [json.loads(thing) for thing in things] for table, things in self._tables.items()}


class Items:
    """Collects the items of one episode.

    Args:
        shared: Pens, shapes and pictures of the page.
    """

    def __init__(self, shared: SharedItems) -> None:
        self._shared = shared
        self._rows: list[tuple[float, int, dict[str, Any]]] = []

    def add(self, thing: Primitive, **where: object) -> None:
        """Add a primitive, with the number of its ``body`` or ``scan``, or the ``spans`` in which it is visible."""
        data = _fields_as_json(thing, self._shared)
        del data["layer"]
        self._rows.append((thing.layer, RANK_NUMBERS[thing.rank], {"draw": type(thing).__name__, **data, **where}))

    def list(self) -> list[dict[str, Any]]:
        """Return the items, the lowest first."""
        return [item for *_, item in sorted(self._rows, key=lambda row: row[:2])]


def css(ink: Ink) -> str:
    """Return a colour in CSS notation, ``#rrggbb`` or ``#rrggbbaa``."""
    red, green, blue, opacity = colour(ink.colour, ink.opacity)
    parts = [round(ink.brightness * value) for value in (red, green, blue)]
    return "#" + bytes([*parts, round(255.0 * opacity)]).hex().removesuffix("ff" if opacity >= 1.0 else "")


def _fields_as_json(thing: Any, shared: SharedItems) -> dict[str, object]:
    """Return the fields of a primitive, a pen or a shape as JSON, without those at their defaults."""
    data = {}
    for name, value in thing._asdict().items():
        is_given = len(value) if isinstance(value, np.ndarray) else value != thing._field_defaults.get(name, ...)
        if is_given:
            data[name] = _plain(value, shared)
    return data


def _plain(value: object, shared: SharedItems) -> object:
    match value:
        case Ink():
            return css(value)
        case Pen():
            return shared.number("pens", _fields_as_json(value, shared))
        case Shape():
            return shared.shape(value)
        case np.ndarray() if value.ndim == 3:
            return shared.number("pictures", _url(value))
        case np.ndarray():
            is_whole = np.issubdtype(value.dtype, np.integer)
            return packed(
                value, 1 if is_whole else FINE if np.abs(value).max(initial=0.0) <= 1.0 else METRE, still=False
            )
        case tuple() if hasattr(value, "_fields"):
            return _fields_as_json(value, shared)
        case tuple():
            return [_plain(part, shared) for part in value]
        case float():
            return round(value, 6)
    return value


def _url(pixels: Bytes) -> str:
    """Return an image as a data URL."""
    content = io.BytesIO()
    Image.fromarray(pixels).save(content, "png", optimize=True)
    return f"data:image/png;base64,{base64.b64encode(content.getvalue()).decode()}"
