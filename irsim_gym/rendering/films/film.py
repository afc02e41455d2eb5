"""Films of several episodes side by side, to compare policies."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.rendering.films.video import write_video
from irsim_gym.rendering.frames.letters import Masks
from irsim_gym.rendering.looks import theme
from irsim_gym.rendering.looks.colours import colour
from irsim_gym.rendering.looks.tiles import grid
from irsim_gym.rendering.raster.masks import paint_mask
from irsim_gym.rendering.scene.frame_layout import DOTS_PER_INCH, LEFT, POINTS_PER_INCH, REFERENCE_SIDE

CAPTION_HEIGHT = 34
CAPTION_SIZE = 11.0


@dataclass
class EpisodeFilm:
    """A film of the same levels played by several policies, one panel per policy.

    A panel whose episode has ended keeps its last frame until all have ended. Then all frames are held for a moment
    before the next level.

    Attributes:
        captions: Text above each panel; no room is reserved if all are empty.
        fps: Frames per second.
        hold: Time for which the end of a level is shown [s].
        columns: Panels per row; None for up to four.
    """

    captions: Sequence[str]
    fps: float
    hold: float = 1.2
    columns: int | None = None
    _strips: dict[tuple[str, int], Bytes] = field(default_factory=dict, init=False, repr=False)

    def frames(self, episodes: Sequence[Iterable[Bytes]]) -> Iterator[Bytes]:
        """Yield the film of one level.

        Args:
            episodes: The frames of each panel's episode, uint8 ``(height, width, 3)``. They are consumed one by one, so
                generators that step and draw are possible.

        Raises:
            ValueError: If the numbers of episodes and captions differ, or an episode has no frame.
        """
        if len(episodes) != len(self.captions):
            raise ValueError(f"{len(self.captions)} captions for {len(episodes)} episodes")
        sources = [iter(episode) for episode in episodes]
        latest: list[Bytes | None] = [next(source, None) for source in sources]
        shown = [frame for frame in latest if frame is not None]
        if not shown or len(shown) < len(latest):
            raise ValueError("an episode needs at least one frame")
        running = True
        while running:
            picture = self.compose(shown)
            yield picture
            following = [next(source, None) for source in sources]
            running = any(frame is not None for frame in following)
            shown = [old if new is None else new for old, new in zip(shown, following, strict=True)]
        for _ in range(round(self.hold * self.fps)):
            yield picture.copy()

    def write(self, levels: Iterable[Sequence[Iterable[Bytes]]], path: str | Path | Sequence[str | Path]) -> None:
        """Write the film of several levels, one after another, to ``path`` (``.mp4``, ``.gif`` or both)."""
        write_video((frame for episodes in levels for frame in self.frames(episodes)), path, self.fps)

    def compose(self, panels: Sequence[Bytes]) -> Bytes:
        """Return one frame: the panels with their captions, in rows."""
        captioned = [self._captioned(frame, caption) for frame, caption in zip(panels, self.captions, strict=True)]
        return grid(captioned, self.columns)

    def _captioned(self, frame: Bytes, caption: str) -> Bytes:
        if not any(self.captions):
            return frame
        key = caption, frame.shape[1]
        if key not in self._strips:
            self._strips[key] = caption_strip(caption, frame.shape[1])
        return np.vstack([self._strips[key], frame])


def caption_strip(caption: str, width: int) -> Bytes:
    """Draw a caption on a strip, uint8, shape ``(height, width, 3)``.

    The height is even and grows with the width of the frame below [pixel].
    """
    enlargement = max(width / REFERENCE_SIDE, 0.4)
    height = 2 * round(CAPTION_HEIGHT * enlargement / 2.0)
    strip, masks = np.empty((height, width, 3), np.uint8), Masks()
    strip[:] = np.rint(colour(theme.PAPER, 1.0)[:3])
    word = masks.word(caption, CAPTION_SIZE * DOTS_PER_INCH / POINTS_PER_INCH * enlargement, bold=True)
    row = round(0.6 * height + 0.5 * word.height - word.foot)
    ink, box = np.array(colour(theme.INK, 1.0)), np.array([0, 0, width, height])
    paint_mask(strip, box, masks.levels, masks.rows, word.mask, round(LEFT * enlargement), row, ink)
    return strip
