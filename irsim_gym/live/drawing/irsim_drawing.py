"""Drawing over a world under IR-SIM's names."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.base.arraytypes import Floats
from irsim_gym.live.drawing import looks, places, strokes
from irsim_gym.live.drawing.drawing import ARROW, GROUND_LAYER, LINE_LAYER, PATH, Drawing
from irsim_gym.live.drawing.looks import Colors
from irsim_gym.live.session.session import Session

LINE_WORDS = {
    "color": "color", "c": "color", "linewidth": "width", "lw": "width", "linestyle": "style", "ls": "style",
    "marker": "marker", "markersize": "size", "ms": "size", "alpha": "alpha", "zorder": "layer",
}  # fmt: skip
POINT_WORDS = {
    "marker": "marker", "alpha": "alpha", "zorder": "layer", "linewidths": "width", "linewidth": "width", "lw": "width",
}  # fmt: skip
ARROW_WORDS = {"color": "color", "alpha": "alpha", "zorder": "layer"}
MARKER_EDGE = 1.0
"""Width of the edge by which markers of matplotlib are larger [point]."""
SHARE, FEWEST = 1.8, 10.0
"""An arrow is shorter than the world by this factor times the root of the number of arrows, at least the second one."""
THICK, THIN = 0.0075, 0.003
"""Width of the shafts of arrows, and of those along a trajectory, relative to the width of the world."""
ORIGIN_SIZE = 36.0


class IrSimDrawing:
    """Draws over a world with the names, arguments and defaults of IR-SIM. New scripts use ``draw``.

    Args:
        session: Bodies of the world.
        drawing: Receives the marks.
    """

    def __init__(self, session: Session, drawing: Drawing) -> None:
        self._session, self._drawing = session, drawing

    def draw_trajectory(
        self,
        /,
        traj: ArrayLike,
        traj_type: str = "-",
        label: str = "trajectory",
        show_direction: bool = False,
        refresh: bool = False,
        **kwargs: Any,
    ) -> None:
        """Draw a line through points. New scripts use ``draw.path``.

        Args:
            traj: A list of points, each flat or a column, or an array with one column per point [m]. An array with two,
                three or four rows is read as columns, while ``draw.path`` reads rows.
            traj_type: Colour, marker and line style, such as ``"r--"``.
            label: Ignored, as in IR-SIM.
            show_direction: Whether to draw an arrow at each point, in the direction of its third coordinate [rad].
            refresh: Whether only the next picture shows it; otherwise it stays until ``draw.clear``.
            **kwargs: ``color``, ``linewidth`` [point], ``linestyle``, ``marker``, ``markersize`` [point], ``alpha``,
                ``zorder``, and their short names.

        Raises:
            ValueError: These are no points, they have no headings where these are asked for, or there is no such look.
            TypeError: Another keyword.
        """
        points = places.rows(traj, columns=True)
        if show_direction and len(points) and points.shape[1] < 3:
            raise ValueError("show_direction needs the heading of each point as its third coordinate: x, y, heading")
        options = looks.known_as("draw_trajectory", kwargs, LINE_WORDS)
        named = looks.parsed(traj_type)
        ink = strokes.StrokeInk.of(_first(options.get("color"), named.color, PATH), *_look(options, LINE_LAYER))
        style = looks.line_style(options["style"]) if "style" in options else named.style
        marker = looks.marker(options["marker"]) if "marker" in options else named.marker
        look = looks.Format(named.color, style, marker)
        marks = strokes.line(points, look, ink, options.get("width", 1.5), options.get("size", strokes.MARKER_SIZE))
        self._drawing.add(marks, refresh)
        if show_direction and len(points):
            headings = np.column_stack([np.cos(points[:, 2]), np.sin(points[:, 2])])
            self._draw_arrows(np.hstack([points[:, :2], headings]), THIN, {"alpha": ink.alpha}, refresh)

    def draw_points(
        self, /, points: ArrayLike | None, s: float = 30.0, c: Colors | None = None, refresh: bool = True, **kwargs: Any
    ) -> None:
        """Mark points. New scripts use ``draw.points``.

        Args:
            points: A list of points, each flat or a column, or an array with one column per point [m]; None draws
                nothing.
            s: Area of the markers, the square of their diameter [point^2].
            c: Colour, or a list with a colour for each point.
            refresh: Whether only the next picture shows them; otherwise they stay until ``draw.clear``.
            **kwargs: ``marker``, ``alpha``, ``zorder``, ``linewidths`` [point] of crosses.

        Raises:
            ValueError: These are no points, or there is no such look.
            TypeError: Another keyword.
        """
        options = looks.known_as("draw_points", kwargs, POINT_WORDS)
        if points is None:
            return
        rows, size = places.rows(points, columns=True), math.sqrt(looks.number("s", s)) + MARKER_EDGE
        width = options.get("width", strokes.MARKER_WIDTH)
        form = options.get("marker", "o")
        self._drawing.add(strokes.points(rows, c, form, size, width, *_look(options, GROUND_LAYER)), refresh)

    def draw_box(self, vertex: ArrayLike, refresh: bool = False, color: str = "-") -> None:
        """Draw the edge of a polygon. New scripts use ``draw.polygon``.

        Args:
            vertex: Corners: an array with one column per corner, or a list of points, each flat or a column [m].
            refresh: Whether only the next picture shows it; otherwise it stays until ``draw.clear``.
            color: Colour and line style, such as ``"b--"``.

        Raises:
            ValueError: These are not three points, or there is no such look.
        """
        look = looks.parsed(color)
        ink = strokes.StrokeInk.of(look.color or PATH, 1.0, LINE_LAYER)
        corners = places.rows(vertex, columns=True)
        marks = strokes.area(corners, ink, None, look.style, 1.5)
        if look.marker:
            marks += strokes.forms(corners, ink, look.marker, strokes.MARKER_SIZE)
        self._drawing.add(marks, refresh)

    def draw_quiver(self, /, point: ArrayLike | None, refresh: bool = False, **kwargs: object) -> None:
        """Draw a dot and an arrow.

        As in IR-SIM, all such arrows have one length, an eighteenth of the width of the world. ``draw.arrows`` draws
        arrows as long as their vectors.

        Args:
            point: Tail and direction: x, y [m], u, v; None draws nothing.
            refresh: Whether only the next picture shows it; otherwise it stays until ``draw.clear``.
            **kwargs: ``color``, ``alpha``, ``zorder``.

        Raises:
            ValueError: These are not four numbers, or there is no such look.
            TypeError: Another keyword.
        """
        options = looks.known_as("draw_quiver", kwargs, ARROW_WORDS)
        if point is not None:
            self._draw_quivers([np.asarray(point, np.float64).ravel()], options, refresh)

    def draw_quivers(self, /, points: ArrayLike, refresh: bool = False, **kwargs: object) -> None:
        """Draw a dot and an arrow for each point; see ``draw_quiver``.

        Args:
            points: A list of x, y, u, v, or an array with a row for each.
            refresh: Whether only the next picture shows them; otherwise they stay until ``draw.clear``.
            **kwargs: ``color``, ``alpha``, ``zorder``.

        Raises:
            ValueError: These are not four numbers each, or there is no such look.
            TypeError: Another keyword.
        """
        self._draw_quivers(points, looks.known_as("draw_quivers", kwargs, ARROW_WORDS), refresh)

    def set_title(self, title: str | None) -> None:
        """Write a title above the world until the next reset, like ``draw.title``; None restores the usual one."""
        self._drawing.title(title)

    def _draw_quivers(self, points: ArrayLike, options: Mapping[str, Any], once: bool) -> None:
        rows = places.rows(points, least=4)
        ink = strokes.StrokeInk.of(options.get("color", ARROW), *_look(options, GROUND_LAYER))
        self._drawing.add(strokes.forms(rows, ink, "o", ORIGIN_SIZE**0.5 + MARKER_EDGE), once)
        for row in rows:
            self._draw_arrows(row[None], THICK, options, once)

    def _draw_arrows(self, rows: Floats, width: float, options: Mapping[str, object], once: bool) -> None:
        """Draw arrows of equal length. The more there are, the shorter they are, as in matplotlib."""
        x_min, _, x_max, _ = self._session.simulation.model.bounds.tolist()
        length = (x_max - x_min) / (SHARE * max(math.ceil(math.sqrt(len(rows))), FEWEST))
        size = {"length": length, "width": width * (x_max - x_min)}
        alpha, layer = _look(options, GROUND_LAYER)
        look = {"color": options.get("color", ARROW), "alpha": alpha, "layer": layer}
        self._drawing.arrows(rows[:, :2], rows[:, 2:4], **size, **look, once=once)


def _look(options: Mapping[str, object], layer: float) -> tuple[Any, Any]:
    return options.get("alpha", 1.0), options.get("layer", layer)


def _first(*values: object) -> Any:
    return next(value for value in values if value is not None)
