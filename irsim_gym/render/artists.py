"""How goals, paths, fields of view and labels are drawn."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from operator import is_

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.render import shapes
from irsim_gym.render.brush import Brush, tint
from irsim_gym.render.lettering import Lettering, Type
from irsim_gym.render.scene import FieldView, GoalView, LabelView
from irsim_gym.render.washer import Colour

FLAG = (6.5, 10.5)
"""Width and height of a goal's flag, from its foot [point]."""
POLE = np.array([(0.0, 0.0), (0.0, 10.0)])
PENNANT = np.array([(0.0, 10.0), (6.25, 7.75), (0.0, 5.5)])
RIM, POLE_WIDTH, LATER_RADIUS, FIELD_EDGE = 1.1, 1.3, 2.25, 0.9


GoalWays = tuple[list[Floats], list[Floats], list[list[Floats]], list[Floats]]


def turned(goal: GoalView) -> bool:
    """Return whether a goal asks for a heading."""
    return not math.isnan(goal.heading)


class Goals:
    """For each goal the circle of its tolerance, a flag, and dots for the goals after it; goals seldom change.

    Where a heading counts as well, an arrow points there.
    """

    def __init__(self) -> None:
        self._views: list[GoalView] = []
        self._scale = (0.0, 0.0)
        self._ways: GoalWays = [], [], [], []

    def _shapes(self, brush: Brush, views: Sequence[GoalView]) -> GoalWays:
        """Return circles, arrows, poles and pennants; the last ones again for the same goals at the same scale."""
        scale = brush.scale, brush.point
        if scale != self._scale or len(views) != len(self._views) or not all(map(is_, views, self._views)):
            metre = brush.point / brush.scale
            feet = [np.array([view.x, view.y]) for view in views]
            circles = [shapes.disc(view.x, view.y, view.tolerance, brush.scale) for view in views]
            arrows = [
                shapes.goal_arrow(view.x, view.y, view.tolerance, view.heading, metre) for view in views if turned(view)
            ]
            poles, pennants = [[POLE * metre + foot] for foot in feet], [PENNANT * metre + foot for foot in feet]
            self._ways = circles, arrows, poles, pennants
            self._views, self._scale = list(views), scale
        return self._ways

    def draw(self, brush: Brush, views: Sequence[GoalView]) -> None:
        """Draw these goals: all circles, then dots, then flags."""
        brush.ends("round", "round")
        colours = [tint(view.style.goal_colour, view.style.goal_alpha) for view in views]
        looks = list(zip(views, colours, strict=True))
        fills = [_faded(colour, 0.30 if view.arrived else 0.14) for view, colour in looks]
        edges = [_faded(colour, 0.9) for colour in colours]
        circles, arrows, poles, pennants = self._shapes(brush, views)
        brush.areas(circles, fills, edges, [RIM] * len(views))
        if arrows:
            brush.areas(arrows, [edge for view, edge in zip(views, edges, strict=True) if turned(view)])
        for view, colour in looks:
            if len(view.later):
                brush.dots(view.later, LATER_RADIUS, _faded(colour, 0.45))
        brush.ends("butt", "round")
        brush.bundles(poles, colours, POLE_WIDTH)
        brush.areas(pennants, colours)


class Fields:
    """Fields of view: sectors of a disc, or a whole one."""

    def draw(self, brush: Brush, views: Sequence[FieldView]) -> None:
        """Draw these fields of view."""
        brush.ends("round", "round")
        styles = [view.style for view in views]
        fills = [tint(style.field_colour, style.field_alpha) for style in styles]
        edges = [tint(style.field_edge_colour, style.field_alpha) for style in styles]
        brush.areas([shapes.sector(view, brush.scale) for view in views], fills, edges, [FIELD_EDGE] * len(views))


class Labels:
    """Texts beside bodies and goals.

    Args:
        lettering: Who writes.
    """

    def __init__(self, lettering: Lettering) -> None:
        self._lettering = lettering

    def draw(self, brush: Brush, views: Sequence[LabelView]) -> None:
        """Draw these labels."""
        places = brush.to_canvas.transform([(view.x, view.y) for view in views]).tolist()
        for view, (x, y) in zip(views, places, strict=True):
            style = view.style
            look = _look(style.label_size, style.label_colour, style.label_alpha, style.label_halo)
            self._lettering.write(brush, view.text, x, y, look)


@functools.lru_cache(maxsize=256)
def _look(size: float, colour: str, alpha: float, halo: str) -> Type:
    return Type(size, colour, alpha, align="center", level="bottom", halo=halo)


def clear_of_flags(labels: Sequence[LabelView], goals: Sequence[GoalView], point: float) -> list[LabelView]:
    """Return labels, those of bodies below them where they would stand on the flag of a goal.

    Args:
        labels: The labels.
        goals: The goals that are shown.
        point: A point of type [m].
    """
    if not labels or not goals:
        return list(labels)
    places = np.array([(view.x, view.y, view.style.label_size, len(view.text)) for view in labels])
    x, y, size, letters = (column[:, None] for column in places.T)
    flag_x, flag_y = np.array([(goal.x, goal.y) for goal in goals]).T
    height, half = 1.3 * size * point, 0.35 * size * letters * point
    beside = (flag_x + FLAG[0] * point < x - half) | (flag_x > x + half)
    apart = (flag_y + FLAG[1] * point < y) | (flag_y > y + height)
    found = list(labels)
    for k in np.flatnonzero((~beside & ~apart).any(axis=1)).tolist():
        view = found[k]
        if view.under is not None:
            found[k] = LabelView(view.x, view.under - float(height[k, 0]), view.text, view.style, view.under)
    return found


def _faded(colour: Colour, share: float) -> Colour:
    return *colour[:3], colour[3] * share
