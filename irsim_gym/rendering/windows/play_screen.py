"""The screen of manual play: the world, the status of the episode, and the keys."""

from collections.abc import Sequence
from dataclasses import dataclass

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.rendering.films.renderer import Renderer
from irsim_gym.rendering.frames.panel import Panel, Told, Word
from irsim_gym.rendering.looks import theme
from irsim_gym.rendering.scene.frame_layout import Layout, Limits

DRIVE = {
    2: (("w s", "ahead, back"), ("a d", "turn"), ("q e", "speed"), ("z c", "turn rate")),
    3: (("w s", "ahead, back"), ("a d", "sideways"), ("q e", "turn"), ("shift z c", "speed"), ("z c", "turn rate")),
}
SIDEWAYS = (("w s", "along x"), ("a d", "along y"), ("q e", "speed"))
WORLD = (
    ("space", "pause"),
    ("F5", "one step"),
    ("r", "again"),
    ("n", "next level"),
    ("x", "by itself"),
    ("v", "picture"),
    ("wheel", "zoom"),
    ("esc", "leave"),
)
SEVERAL = (("alt 0-9", "robot"),)


@dataclass(frozen=True)
class Standing:
    """The status of an episode, as text; ``recorded`` counts the episodes in the file, None without one."""

    level: str
    robot: str
    steps: str
    paid: str
    speeds: str
    recorded: int | None = None
    paused: bool = False
    by_itself: str | None = None
    message: str = ""


class PlayScreen:
    """Shows the only world of an environment, with a strip of words and keys below.

    Args:
        renderer: Draws the world.
        command_names: Names of the components of the robot's command.
        several: Whether there are other robots to select.
    """

    def __init__(self, renderer: Renderer, command_names: Sequence[str], *, several: bool) -> None:
        self._renderer = renderer
        driving = SIDEWAYS if tuple(command_names) == ("x", "y") else DRIVE[len(command_names)]
        keys = (*driving, *WORLD[:4], *(SEVERAL if several else ()), *WORLD[4:])
        self._panel = Panel(renderer.layout.width, keys, renderer.layout.enlargement)

    def frame(self, status: str) -> Bytes:
        """Return a picture of the world alone, ``(height, width, 3)``."""
        return self._renderer.frame(0, status)

    def picture(self, status: str, standing: Standing) -> Bytes:
        """Return the content of the window, ``(height, width, 3)``."""
        return self._panel.below(self.frame(status), _status_words(standing))

    def seen(self) -> Layout:
        """Return the layout of the picture."""
        return self._renderer.seen()

    def look_at(self, limits: Limits | None) -> None:
        """Show another part of the world; None for the whole world."""
        self._renderer.look_at(limits)

    def clear(self) -> None:
        """Clear the paths at the start of an episode."""
        self._renderer.clear()


def _status_words(standing: Standing) -> Told:
    """Return the words for the strip."""
    if standing.message:
        return Told(((standing.message, theme.INK),))
    left: list[Word] = [(standing.robot, theme.INK)]
    left += [(text, theme.INK_LIGHT) for text in (standing.level, standing.steps, standing.paid, standing.speeds)]
    right: list[Word] = []
    if standing.paused:
        right.append(("paused", theme.OUTCOMES["timeout"]))
    if standing.by_itself is not None:
        right.append((f"driven by {standing.by_itself}", theme.RUNNING))
    if standing.recorded is not None:
        right.append((f"\N{BLACK CIRCLE} recording: {standing.recorded}", theme.IMPACT))
    return Told(tuple(left), tuple(right))
