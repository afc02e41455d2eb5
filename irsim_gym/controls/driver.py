"""The window on a world, with the keyboard and the mouse that belong to it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from irsim_gym.arraytypes import Bytes
from irsim_gym.controls.keyboard import open_keyboard
from irsim_gym.controls.mouse import Mouse

if TYPE_CHECKING:
    from irsim_gym.render.frame_layout import Layout, Limits


class Driver:
    """Shows pictures to a person and asks what is to be done.

    Args:
        title: What stands above the window.
        picture: What it shows at first, uint8, shape ``(height, width, 3)``.
        gui: The section ``gui``.
        seen: Returns where the world is on the picture that is shown.

    Raises:
        NoWindowError: There is no display, or no toolkit that works.
    """

    def __init__(self, title: str, picture: Bytes, gui: Any, seen: Callable[[], Layout]) -> None:
        from irsim_gym.render.window import Window

        self.window = Window(picture.shape[1], picture.shape[0], title)
        self.keyboard = open_keyboard(gui.keyboard, self.window)
        self.mouse = Mouse(self.window, gui.mouse.zoom_factor, seen)
        self.picture = picture
        self.show(picture)

    @property
    def closed(self) -> bool:
        """The person closed the window."""
        return self.window.closed

    def show(self, picture: Bytes) -> None:
        """Show a picture, and take in what was done."""
        self.picture = picture
        self.window.show(picture)

    def wait(self, seconds: float) -> None:
        """Let a time pass [s], and take in what is done; shorter when the window is closed."""
        self.window.wait(seconds)

    def poll(self, *, drives: bool, turns: bool) -> list[str]:
        """Return what the world is asked to do, in order; a window that was closed asks to quit."""
        asked = self.keyboard.poll(drives=drives, turns=turns)
        return [*asked, "quit"] if self.closed else asked

    def new_limits(self) -> tuple[bool, Limits | None]:
        """Return whether another part of the world is to be shown than before, and which; None for the whole."""
        return self.mouse.new_limits()

    def close(self) -> None:
        """Close the window and listen no longer. May be called twice."""
        self.keyboard.close()
        self.window.close()
