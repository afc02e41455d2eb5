"""How the marks are drawn that somebody laid over a world."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.path import Path

from irsim_gym.render import shapes
from irsim_gym.render.brush import CLEAR, Brush, tint
from irsim_gym.render.lettering import Lettering, Type
from irsim_gym.render.styles import faded
from irsim_gym.render.washer import Colour
from irsim_gym.world.marks import LineMark, Mark, PointsMark, TextMark


class Marks:
    """Lines, areas and points."""

    def draw(self, brush: Brush, marks: Sequence[Mark]) -> None:
        """Draw these marks, one after the other."""
        brush.ends("butt", "round")
        for mark in marks:
            if isinstance(mark, LineMark):
                _draw_line(brush, mark)
            elif isinstance(mark, PointsMark):
                _draw_points(brush, mark)


def _draw_line(brush: Brush, mark: LineMark) -> None:
    way = np.concatenate([mark.points, mark.points[:1]]) if mark.closed else mark.points
    fill = _ink(mark.fill, mark.alpha) if mark.fill else None
    edge = _ink(mark.color, mark.alpha) if mark.width > 0.0 else CLEAR
    brush.draw(Path(way, closed=mark.closed), fill, edge, mark.width, mark.style)


def _draw_points(brush: Brush, mark: PointsMark) -> None:
    ink, size = _ink(mark.color, mark.alpha), mark.size * brush.point / brush.scale
    if not mark.form:
        ways = [shapes.disc(x, y, 0.5 * size, brush.scale) for x, y in mark.points.tolist()]
        brush.areas(ways, [ink] * len(ways))
    elif mark.width:
        bundles = [[size * part + place for part in mark.form] for place in mark.points]
        brush.bundles(bundles, [ink] * len(bundles), mark.width)
    else:
        ways = [size * part + place for place in mark.points for part in mark.form]
        brush.areas(ways, [ink] * len(ways))


class Words:
    """Texts.

    Args:
        lettering: Who writes.
    """

    def __init__(self, lettering: Lettering) -> None:
        self._lettering = lettering

    def draw(self, brush: Brush, marks: Sequence[TextMark]) -> None:
        """Write these texts."""
        for mark in marks:
            colour, alpha = faded(mark.color, mark.alpha)
            x, y = brush.to_canvas.transform((mark.x, mark.y)).tolist()
            if alpha > 0.0:
                self._lettering.write(brush, mark.text, x, y, Type(mark.size, colour, alpha, align=mark.align))


def _ink(color: str, alpha: float) -> Colour:
    return tint(*faded(color, alpha))
