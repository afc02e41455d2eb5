"""Contact sheets and pictures of ways."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from irsim_gym.rendering.films.sheet import WIDEST, Moments, contact_sheet, save_sheet, spaced


def numbered(count: int, wanted: int) -> tuple[list[int], int]:
    """Return which of ``count`` moments are shown, and how many were drawn."""
    moments, drawn = Moments(wanted), []

    def draw(k: int) -> np.ndarray:
        drawn.append(k)
        return np.full((2, 2, 3), k % 251, np.uint8)

    for k in range(count):
        moments.offer(lambda k=k: draw(k))
    return [int(frame[0, 0, 0]) for frame in moments.frames()], len(drawn)


@pytest.mark.parametrize("count", [1, 2, 5, 12, 13, 61, 200])
def test_moments_are_evenly_spaced_from_the_first_to_the_last(count: int) -> None:
    shown, _ = numbered(count, 12)
    assert len(shown) == min(count, 12)
    assert (shown[0], shown[-1]) == (0, count - 1)
    gaps = np.diff(shown)
    assert not len(gaps) or gaps.max() - gaps.min() <= max(0.5 * (count - 1) / 11, 1)


def test_a_long_episode_needs_few_frames() -> None:
    _, drawn = numbered(100_000, 12)
    assert drawn < 12 * 8 + 12 * 4 * 11  # then half as many for each doubling of its length


def test_what_cannot_be_shown() -> None:
    with pytest.raises(ValueError, match="at least 2 moments, got 1"):
        Moments(1)
    with pytest.raises(ValueError, match="at least one frame"):
        Moments().frames()


def test_spaced() -> None:
    assert spaced(11, 3).tolist() == [0, 5, 10]
    assert spaced(2, 12).tolist() == [0, 1]


def test_a_sheet_holds_its_frames_in_order() -> None:
    frames = [np.full((40, 60, 3), shade, np.uint8) for shade in (10, 60, 110, 160, 210)]
    sheet = contact_sheet([frames, frames[:2]], ["", ""], columns=3)
    assert sheet.shape == (3 * 40, 3 * 60, 3)
    middles = sheet[20::40, 30::60, 0]
    assert middles[:2].tolist() == [[10, 60, 110], [160, 210, 246]]  # 246: the paper
    assert middles[2].tolist() == [10, 60, 246]


def test_a_sheet_is_reduced_and_bears_captions(tmp_path: Path) -> None:
    frames = [np.full((600, 900, 3), 255, np.uint8)] * 12
    sheet = contact_sheet([frames], ["dash, level 0: collision"])
    assert sheet.shape[1] <= WIDEST
    assert sheet[:20].min() < 100  # words
    path = save_sheet(sheet, tmp_path / "new" / "sheet.png")
    with Image.open(path) as image:
        assert np.array_equal(np.asarray(image), sheet)
    assert [file.name for file in path.parent.iterdir()] == ["sheet.png"]


@pytest.mark.parametrize(
    ("size", "count", "shape"),
    [
        ((600, 600), 12, (4 * 600, 3 * 600)),  # on a screen of 1440 pixels each is 480 wide
        ((600, 600), 4, (2 * 600, 2 * 600)),
        (
            (300, 1200),
            12,
            (12 * 300, 1200),
        ),  # as large as 600 x 600, so 0.8 * 1200 = 960 wide at least: no room for two
        ((1200, 1200), 12, (4 * 600, 3 * 600)),
        ((200, 240), 5, (200, 5 * 240)),
    ],
)
def test_moments_are_large_enough_to_read(size: tuple[int, int], count: int, shape: tuple[int, int]) -> None:
    frames = [np.full((*size, 3), 255, np.uint8)] * count
    assert contact_sheet([frames], [""]).shape[:2] == shape
