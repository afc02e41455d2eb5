"""The mouse in a window that shows a world: positions, clicks and zooming."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from irsim_gym.rendering.scene.frame_layout import Layout, Limits
    from irsim_gym.rendering.windows.window import Window, WindowEvent

LEFT, MIDDLE, RIGHT = 1, 2, 3
"""Buttons."""
Point = tuple[float, float]


class Mouse:
    """Tracks positions in the world, and the visible part of the world.

    A press of the left or right button stores its position, rounded to 2 decimals, until the next press, so that a
    loop that polls now and then misses no click. The wheel zooms about the cursor, and the middle button shows the
    whole world again.

    Args:
        window: The window.
        zoom_factor: Factor of the view for one step of the wheel.
        seen: Returns the layout of the frame that the window shows.
    """

    def __init__(self, window: Window, zoom_factor: float, seen: Callable[[], Layout]) -> None:
        self.zoom_factor = zoom_factor
        self.left: Point | None = None
        self.right: Point | None = None
        self._pixel: Point | None = None
        self._limits: Limits | None = None
        self._changed = False
        self._seen = seen
        window.connect("mouse_move", self._move)
        window.connect("mouse_leave", self._leave)
        window.connect("mouse_press", self._press)
        window.connect("scroll", self._scroll)

    @property
    def position(self) -> Point | None:
        """Position of the cursor in the world [m]; None outside of the drawing area."""
        return None if self._pixel is None else _point(self._layout(), *self._pixel)

    def new_limits(self) -> tuple[bool, Limits | None]:
        """Return whether the visible part has changed since the last call, and its limits; None for the whole world."""
        changed, self._changed = self._changed, False
        return changed, self._limits

    def _layout(self) -> Layout:
        """Return the layout with any new limits, which the shown frame may not have yet."""
        seen = self._seen()
        return seen if self._limits is None or not self._changed else seen.showing(self._limits)

    def _move(self, event: WindowEvent) -> None:
        self._pixel = event.column, event.row

    def _leave(self, event: WindowEvent) -> None:
        self._pixel = None

    def _press(self, event: WindowEvent) -> None:
        self._move(event)
        if event.button == MIDDLE:
            self._limits, self._changed = None, True
            return
        point = self.position
        if point is not None:
            point = round(point[0], 2), round(point[1], 2)
        if point is not None and event.button == LEFT:
            self.left = point
        if point is not None and event.button == RIGHT:
            self.right = point

    def _scroll(self, event: WindowEvent) -> None:
        """Multiply the ranges by 1/z or z, so that the point under the cursor stays where it is."""
        self._move(event)
        point = self.position
        if point is None or event.steps == 0.0:
            return
        x, y = point
        # Positive steps zoom in: each edge comes nearer to the cursor by the factor.
        share = self.zoom_factor**-event.steps
        x_min, y_min, x_max, y_max = self._layout().limits
        left, low, right, high = ((edge - at) * share for edge, at in ((x_min, x), (y_min, y), (x_max, x), (y_max, y)))
        self._limits = x + left, y + low, x + right, y + high
        self._changed = True


def _point(layout: Layout, column: float, row: float) -> Point | None:
    """Return the world point that a pixel shows [m]; None outside of the drawing area."""
    # Rows of pixels count from the top, y from the bottom.
    right, up = column - layout.left, layout.height - row - layout.bottom
    if not (0.0 <= right <= layout.plot_width and 0.0 <= up <= layout.plot_height):
        return None
    return layout.limits[0] + right / layout.scale, layout.limits[1] + up / layout.scale
