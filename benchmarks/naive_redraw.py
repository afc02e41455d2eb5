"""A picture of a scene as one writes it first with matplotlib: new artists for everything, each time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np


def redraw(axes: Any, scene: Any, side: float) -> None:
    """Clear the axes and add an artist for each thing in the scene."""
    axes.clear()
    axes.set(
        xlim=(0.0, side), ylim=(0.0, side), aspect="equal", title=f"{scene.title}, {scene.time:.1f} s, {scene.status}"
    )
    for draw in (add_sensors, add_goals, add_tracks, add_bodies):
        draw(axes, scene)
    for view in scene.labels:
        axes.text(view.x, view.y, view.text, color=view.style.label_colour, fontsize=view.style.label_size, ha="center")


def add_bodies(axes: Any, scene: Any) -> None:
    """Add footprints and headings."""
    from matplotlib.patches import Polygon

    for view in scene.fixed + scene.moving:
        add_outline(axes, view, facecolor=view.style.colour, edgecolor="black")
        if len(view.heading):
            axes.add_patch(Polygon(view.heading, facecolor="white", zorder=4))


def add_outline(axes: Any, view: Any, **look: Any) -> None:
    """Add the discs and chains of a footprint."""
    from matplotlib.patches import Circle, Polygon

    for x, y, radius in view.discs:
        axes.add_patch(Circle((x, y), radius, zorder=3, **look))
    for line in view.lines:
        if view.solid:
            axes.add_patch(Polygon(line, zorder=3, **look))
        else:
            axes.plot(line[:, 0], line[:, 1], color=view.style.colour)


def add_goals(axes: Any, scene: Any) -> None:
    """Add goals with their tolerances."""
    from matplotlib.patches import Circle

    for view in scene.goals:
        axes.add_patch(Circle((view.x, view.y), view.tolerance, facecolor="none", edgecolor=view.style.goal_colour))
        axes.plot([view.x], [view.y], marker=10, color=view.style.goal_colour)


def add_sensors(axes: Any, scene: Any) -> None:
    """Add beams, the area that they see, where they end, and fields of view."""
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Polygon, Wedge

    for view in scene.scans:
        axes.add_patch(Polygon(view.ends, facecolor=view.style.colour, alpha=0.07))
        lines = np.stack([np.broadcast_to(view.origin, view.ends.shape), view.ends], axis=1)
        axes.add_collection(LineCollection(lines, colors=view.style.colour, alpha=0.3, linewidths=0.5))
        axes.plot(*view.ends[view.hits].T, ".", color=view.style.colour, markersize=3)
    for view in scene.fields:
        low, high = (math.degrees(view.heading + sign * 0.5 * view.span) for sign in (-1.0, 1.0))
        axes.add_patch(Wedge((view.x, view.y), view.radius, low, high, facecolor=view.style.field_colour, alpha=0.5))


def add_tracks(axes: Any, scene: Any) -> None:
    """Add paths and the outlines left behind."""
    for view in scene.trails:
        axes.plot(view.points[:, 0], view.points[:, 1], color=view.style.trajectory_colour, alpha=0.8)
    for view in scene.ghosts:
        add_outline(axes, view, facecolor="none", edgecolor=view.style.colour, alpha=view.style.alpha)
