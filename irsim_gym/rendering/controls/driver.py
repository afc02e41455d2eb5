"""A window that shows a world, with its keyboard and mouse."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.rendering.controls.keyboard import Keyboard
from irsim_gym.rendering.controls.keys_window import WindowKeys
from irsim_gym.rendering.controls.mouse import Mouse

if TYPE_CHECKING:
    from irsim_gym.rendering.scene.frame_layout import Layout, Limits


class Driver:
    """Show frames to a user and return their commands.

    Args:
        title: Title of the window.
        picture: The first frame, uint8, shape ``(height, width, 3)``.
        gui: The section ``gui``.
        seen: Returns the layout of the frame that is shown.

    Raises:
        NoWindowError: If there is no display or no working toolkit.
    """

    def __init__(self, title: str, picture: Bytes, gui: Any, seen: Callable[[], Layout]) -> None:
        from irsim_gym.rendering.windows.window import Window

        self.window = Window(picture.shape[1], picture.shape[0], title)
        self.keyboard = Keyboard(gui.keyboard, WindowKeys(self.window))
        self.mouse = Mouse(self.window, gui.mouse.zoom_factor, seen)
        self.picture = picture
        self.show(picture)

    @property
    def closed(self) -> bool:
        """Whether the user closed the window."""
        return self.window.closed

    def show(self, picture: Bytes) -> None:
        """Show a frame, and process the user's input."""
        self.picture = picture
        self.window.show(picture)

    def wait(self, seconds: float) -> None:
        """Wait for a time [s] while processing the user's input; return early if the window is closed."""
        self.window.wait(seconds)

    def execute(
        self, command: Callable[[str], object], look_at: Callable[[Limits | None], object], *, drives: bool, turns: bool
    ) -> None:
        """Execute the user's commands in order, see ``Keyboard.poll``; a closed window adds ``quit``.

        Args:
            command: Executes one of them.
            look_at: Shows another part of the world; None for the whole world. It is called after the commands.
            drives: Whether the keys drive.
            turns: Whether the robot has a third component of its command.
        """
        for name in [*self.keyboard.poll(drives=drives, turns=turns), *(["quit"] if self.closed else [])]:
            command(name)
        changed, limits = self.mouse.new_limits()
        if changed:
            look_at(limits)

    def close(self) -> None:
        """Close the window. Calling it again has no effect."""
        self.window.close()
