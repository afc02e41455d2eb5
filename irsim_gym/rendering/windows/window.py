"""A window that shows pictures and reports events of keyboard and mouse."""

import gc
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from matplotlib.artist import Artist
from matplotlib.backend_bases import RendererBase
from matplotlib.figure import Figure
from PIL import Image

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.base.errors import NoWindowError
from irsim_gym.rendering.looks import theme
from irsim_gym.rendering.windows.toolkits import INSTEAD, event_time, new_manager

EventName = Literal["key_press", "key_release", "mouse_press", "mouse_release", "mouse_move", "mouse_leave", "scroll"]
NAMES: dict[EventName, str] = {name: f"{name}_event" for name in ("key_press", "key_release")}
NAMES |= {"mouse_press": "button_press_event", "mouse_release": "button_release_event", "scroll": "scroll_event"}
NAMES |= {"mouse_move": "motion_notify_event", "mouse_leave": "figure_leave_event"}
DOTS_PER_INCH = 100.0
PAUSE_S = 0.005
FINE_SCREEN = 1.5
"""Ratio of screen pixels to window pixels from which pictures are enlarged."""


@dataclass(frozen=True)
class WindowEvent:
    """An event of the user.

    Attributes:
        key: For keys, matplotlib's name, e.g. ``w``, ``alt+1``, ``escape``; empty otherwise.
        column: Position of the mouse on the picture in pixels from the left; may lie outside.
        row: Position in pixels from the top.
        button: For mouse buttons, 1 left, 2 middle, 3 right; 0 otherwise.
        steps: For the wheel, the number of steps, positive away from the user.
        time: Time of the event by the toolkit's clock [s].
    """

    key: str = ""
    column: float = 0.0
    row: float = 0.0
    button: int = 0
    steps: float = 0.0
    time: float = 0.0


class Window:
    """A window of matplotlib, without pyplot.

    Pictures are scaled to fit the window. matplotlib's own keys (s saves, q quits) are disabled. A window must be
    created and used in one thread; most toolkits require the main thread.

    Args:
        width: Width of the area for pictures in pixels.
        height: Its height.
        title: Title of the window.

    Raises:
        NoWindowError: If there is no display or no working toolkit, or if this process was forked from one with a
            window, whose connection to the display would break.
    """

    _process: ClassVar[int] = 0
    """Id of the process that opened the first window; a fork inherits it along with the toolkit's connection."""

    def __init__(self, width: int, height: int, title: str = "irsim_gym") -> None:
        if Window._process not in (0, os.getpid()):
            raise NoWindowError(
                "no window can be opened: this process was forked from one that had opened a window, and they would "
                "share its connection to the display. Start processes with 'spawn', or open windows in them alone. "
                f"{INSTEAD}"
            )
        self._figure: Any = Figure(
            figsize=(width / DOTS_PER_INCH, height / DOTS_PER_INCH), dpi=DOTS_PER_INCH, facecolor=theme.PAPER
        )
        self._picture: Any = _Picture(width, height)
        self._figure.add_artist(self._picture)
        self._manager: Any = new_manager(self._figure)
        Window._process = os.getpid()
        self._canvas: Any = self._manager.canvas
        for handler in ("key_press_handler_id", "button_press_handler_id", "scroll_handler_id"):
            if getattr(self._manager, handler, None) is not None:
                self._canvas.mpl_disconnect(getattr(self._manager, handler))
        self._closed = False
        self._canvas.mpl_connect("close_event", self._on_close)
        self._manager.set_window_title(title)
        self._manager.show()
        self.wait(0.0)
        if self._canvas.device_pixel_ratio < FINE_SCREEN:  # map picture pixels to screen pixels: fast and sharp
            self._manager.resize(width, height)
        self._canvas.draw()
        self.wait(0.0)

    @property
    def closed(self) -> bool:
        """Whether the program or the user has closed the window."""
        return self._closed

    def show(self, picture: Bytes) -> None:
        """Show a picture and process pending events. Do nothing if the window is closed.

        Args:
            picture: The picture, uint8, shape ``(height, width, 3)``; it is copied.
        """
        if self._closed:
            return
        self._picture.set(picture)
        buffer = np.asarray(self._canvas.buffer_rgba()) if hasattr(self._canvas, "renderer") else None
        if buffer is not None and buffer.shape == self._picture.rgba.shape:
            buffer[...] = self._picture.rgba
            self._canvas.blit(self._figure.bbox)
        else:
            self._canvas.draw()
        self.wait(0.0)

    def wait(self, seconds: float) -> None:
        """Process events for a time [s]; return at once if the window is closed."""
        until = time.perf_counter() + seconds
        while not self._closed:
            try:
                self._canvas.flush_events()
            except Exception:
                if not self._closed:  # Tk raises if the window was closed meanwhile
                    raise
            left = until - time.perf_counter()
            if left <= 0.0:
                break
            time.sleep(min(left, PAUSE_S))
        if self._closed:
            self._release()

    def connect(self, name: EventName, callback: Callable[[WindowEvent], None]) -> None:
        """Call a function at each event of a type, while the window shows, waits or closes.

        Args:
            name: Type of the event.
            callback: Function that gets the event.
        """
        if not self._closed:
            self._canvas.mpl_connect(NAMES[name], lambda event: callback(self._plain(event)))

    def close(self) -> None:
        """Close the window. Calling it again has no effect."""
        if not self._closed:
            self._closed = True
            self._manager.destroy()
        self._release()

    def _release(self) -> None:
        """Free the toolkit's objects at once, since Tk fails if another thread's garbage collection frees them."""
        if self._canvas is not None:
            self._figure = self._manager = self._canvas = self._picture = None
            gc.collect()

    def _on_close(self, event: object) -> None:
        self._closed = True

    def _plain(self, event: Any) -> WindowEvent:
        """Convert an event of matplotlib, with its position on the picture."""
        width, height = self._canvas.get_width_height(physical=True)
        column, row = self._picture.place(event.x or 0.0, height - (event.y or 0.0), width, height)
        button = getattr(event, "button", None)
        key, steps = getattr(event, "key", None) or "", float(getattr(event, "step", 0.0) or 0.0)
        number, time = int(button) if isinstance(button, int) else 0, event_time(event.guiEvent)
        return WindowEvent(key=key, column=column, row=row, button=number, steps=steps, time=time)


class _Picture(Artist):
    """The picture of a figure, as large as fits.

    ``imshow`` resamples each picture, which takes 20 ms for 600 x 600, and ``figimage`` does not scale.
    """

    def __init__(self, width: int, height: int) -> None:
        super().__init__()
        self.rgba = np.full((height, width, 4), 255, np.uint8)

    def set(self, picture: Bytes) -> None:  # type: ignore[override]
        """Set the picture, shape ``(height, width, 3)``."""
        if picture.shape[:2] != self.rgba.shape[:2]:
            self.rgba = np.full((*picture.shape[:2], 4), 255, np.uint8)
        for channel in range(3):  # four times as fast as one assignment
            self.rgba[..., channel] = picture[..., channel]

    def place(self, x: float, y: float, width: float, height: float) -> tuple[float, float]:
        """Return column and row on the picture of a point in a window of the given size."""
        scale, left, top = self._fit(width, height)
        return (x - left) / scale, (y - top) / scale

    def draw(self, renderer: RendererBase) -> None:
        """Draw the picture in the middle of the figure."""
        assert self.figure is not None
        width, height = renderer.get_canvas_width_height()
        scale, left, top = self._fit(width, height)
        shown = self.rgba
        if scale != 1.0:
            size = max(round(scale * shown.shape[1]), 1), max(round(scale * shown.shape[0]), 1)
            shown = np.asarray(Image.fromarray(shown).resize(size, Image.Resampling.BILINEAR))
        # Rows of images in matplotlib begin at the lower edge.
        renderer.draw_image(renderer.new_gc(), left, round(height - top - len(shown)), shown[::-1])

    def _fit(self, width: float, height: float) -> tuple[float, int, int]:
        """Return the scale and the left and upper edge of the picture in a window of the given size."""
        rows, columns = self.rgba.shape[:2]
        scale = min(width / columns, height / rows)
        return scale, round(0.5 * (width - scale * columns)), round(0.5 * (height - scale * rows))
