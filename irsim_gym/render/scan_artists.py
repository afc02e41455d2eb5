"""How is drawn what range sensors see: beams, the points that they hit, and how fast these go."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.colors import to_rgba
from matplotlib.path import Path
from matplotlib.transforms import Affine2D

from irsim_gym.arraytypes import Floats
from irsim_gym.render import shapes
from irsim_gym.render.brush import Brush, tint
from irsim_gym.render.scene import ScanView
from irsim_gym.render.styles import VelocityStyle
from irsim_gym.render.washer import Colour

BEAM_WIDTH, HIT_RADIUS = 0.45, 1.3


class Scans:
    """For each scan the area seen and the beams, or beams in the colours of their radial velocity."""

    def draw(self, brush: Brush, views: Sequence[ScanView]) -> None:
        """Draw these scans: all areas, then all beams."""
        brush.ends("butt", "miter")
        plain = []
        for view in views:
            velocity = view.style.velocity
            if velocity is not None and velocity.coloured:
                _draw_velocities(brush, view, velocity)
            else:
                plain.append(view)
        if plain:
            looks = [(view.style.colour, view.style.alpha) for view in plain]
            brush.areas([shapes.seen(view) for view in plain], [tint(one, min(0.22 * a, 1.0)) for one, a in looks])
            beams = [shapes.beams(view) for view in plain]
            brush.bundles(beams, [tint(one, min(0.9 * a, 1.0)) for one, a in looks], BEAM_WIDTH)


def _draw_velocities(brush: Brush, view: ScanView, style: VelocityStyle) -> None:
    free = shapes.rays(view.origin, view.ends[~view.valid])
    if free:
        brush.bundles([free], [tint(style.free_colour, style.free_alpha)], style.free_width)
    ends = view.ends[view.valid]
    paths = [Path(np.stack([view.origin, end])) for end in ends]
    if paths:
        colours = [_plain(colour) for colour in velocity_colours(view, style, view.style.alpha)]
        brush.lines(paths, colours, [style.width] * len(paths), ["solid"] * len(paths))


class Hits:
    """The points where beams end on something."""

    def draw(self, brush: Brush, views: Sequence[ScanView]) -> None:
        """Draw the hits of these scans; those of one colour together."""
        alike: dict[Colour, list[Floats]] = {}
        for view in views:
            if view.style.velocity is not None:
                _draw_marks(brush, view, view.style.velocity)
            else:
                colour = tint(view.style.colour, min(3.0 * view.style.alpha, 1.0))
                alike.setdefault(colour, []).append(view.ends[view.hits])
        for colour, places in alike.items():
            brush.dots(np.concatenate(places), HIT_RADIUS, colour)


def _draw_marks(brush: Brush, view: ScanView, style: VelocityStyle) -> None:
    if style.mark_size <= 0.0:
        return
    radius = 0.5 * np.sqrt(style.mark_size) * brush.point
    edge = tint(style.mark_edge_colour, 1.0)
    brush.ends("butt", "round")
    for end, colour in zip(view.ends[view.valid], velocity_colours(view, style, 1.0), strict=True):
        place = Affine2D().scale(radius).translate(*brush.to_canvas.transform(end))
        brush.draw(Path.unit_circle(), _plain(colour), edge, style.mark_edge_width, place=place)


def _plain(colour: Floats) -> Colour:
    red, green, blue, alpha = colour.tolist()
    return red, green, blue, alpha


def velocity_colours(view: ScanView, style: VelocityStyle, alpha: float) -> Floats:
    """Return the colours of the beams that hit: the sign's, mixed with that of rest below the full speed.

    Returns:
        Red, green, blue, opacity, shape ``(n_valid, 4)``.
    """
    speeds = view.speeds[view.valid]
    share = np.minimum(np.abs(speeds) / style.full_speed, 1.0)[:, None]
    ends = np.where(speeds[:, None] >= 0.0, to_rgba(style.away_colour), to_rgba(style.nearer_colour))
    colours: Floats = (1.0 - share) * np.array(to_rgba(style.rest_colour)) + share * ends
    colours[:, 3] = alpha
    return colours
