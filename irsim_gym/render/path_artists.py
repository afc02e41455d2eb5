"""How the ways that bodies have come are drawn."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from matplotlib.path import Path

from irsim_gym.arraytypes import Floats, Ints
from irsim_gym.render import shapes
from irsim_gym.render.brush import Brush, tint
from irsim_gym.render.colours import Colour
from irsim_gym.render.scene import TrailView

FAINTEST, FADE_STEPS = 0.12, 16
THIN, THINNEST_BAND = 1.9, 0.3
"""Width of a path without one of its own, and the least of those with one [point]."""
APART = 3.0
"""Points of a path that are nearer to each other are left out [pixel]."""


class Trails:
    """Trajectories: thin ones fade towards their beginning, those with a width are one band."""

    def draw(self, brush: Brush, views: Sequence[TrailView]) -> None:
        """Draw these trajectories; thin ones of one look together, what is faintest first."""
        brush.ends("butt", "round")
        alike: dict[tuple[str, float, str], list[Floats]] = {}
        for view in views:
            style = view.style
            if len(view.points) > 1 and style.trajectory_width is None:
                look = style.trajectory_colour, style.trajectory_alpha, style.trajectory_style
                alike.setdefault(look, []).append(view.points)
            elif len(view.points) > 1:
                _draw_band(brush, view)
        strengths = np.linspace(FAINTEST, 1.0, FADE_STEPS).tolist()
        for (colour, alpha, line), ways in alike.items():
            colours = [tint(colour, strength * alpha) for strength in strengths]
            if line == "solid":
                brush.bundles(faded(ways, APART / brush.scale), colours, THIN)
            else:
                _draw_dashes(brush, ways, colours, line)


def _draw_dashes(brush: Brush, ways: Sequence[Floats], colours: Sequence[Colour], line: str) -> None:
    """Draw thin trajectories in a line style, what is faintest first; dashes go on from one part to the next."""
    cut, lengths = [faded([way], APART / brush.scale) for way in ways], [0.0] * len(ways)
    for k, colour in enumerate(colours):
        for i, parts in enumerate(cut):
            for part in parts[k]:
                brush.draw(Path(part), None, colour, THIN, line, before=lengths[i])
                lengths[i] += float(np.hypot(*np.diff(part, axis=0).T).sum()) * brush.scale / brush.point


def _draw_band(brush: Brush, view: TrailView) -> None:
    style, path = view.style, Path(shapes.thinned(view.points, APART / brush.scale))
    width = max((style.trajectory_width or 0.0) * brush.scale / brush.point, THINNEST_BAND)
    colour = tint(style.trajectory_colour, style.trajectory_alpha)
    brush.draw(path, None, colour, width, style.trajectory_style)


def faded(ways: Sequence[Floats], apart: float) -> list[list[Floats]]:
    """Return the first parts of some ways, then the second ones, and so on; none of a way that has too few points.

    Args:
        ways: Points [m], at least two of each, each of shape ``(n, 2)``.
        apart: Points that stand closer along the way are left out [m].

    Returns:
        ``FADE_STEPS`` lists.
    """
    points = np.concatenate(ways)
    ends = np.cumsum([len(way) for way in ways])
    kept = _far_apart(points, ends, apart)
    points, ends = points[kept], np.searchsorted(kept, ends)
    begins = np.concatenate([[0], ends[:-1]])
    cuts = begins[None, :] + np.arange(FADE_STEPS + 1)[:, None] * (ends - 1 - begins) // FADE_STEPS
    return [
        [points[first : last + 1] for first, last in zip(firsts, lasts, strict=True) if last > first]
        for firsts, lasts in pairwise(cuts.tolist())
    ]


def _far_apart(points: Floats, ends: Ints, apart: float) -> Ints:
    """Return the indices of the points that stay: first and last ones of each way, and one for each ``apart``."""
    steps = np.diff(points, axis=0)
    bins = np.floor(np.cumsum(np.sqrt(np.einsum("ij,ij->i", steps, steps))) / apart)
    kept = np.empty(len(points), np.bool_)
    kept[1:], kept[0] = np.diff(bins, prepend=0.0) > 0.0, True
    kept[ends - 1] = True
    kept[ends[:-1]] = True
    return np.flatnonzero(kept)
