"""Pictures side by side, and how large they are drawn for it."""

from __future__ import annotations

import numpy as np
import pytest

from irsim_gym.rendering.looks.tiles import fitting, grid


def test_a_grid_fills_row_by_row() -> None:
    frames = [np.full((2, 3, 3), value, np.uint8) for value in (1, 2, 3, 4, 5)]
    picture = grid(frames, 3)
    assert picture.shape == (4, 9, 3)
    assert picture[0, ::3, 0].tolist() == [1, 2, 3]
    assert picture[2, ::3].tolist() == [[4] * 3, [5] * 3, [0xF6, 0xF7, 0xF9]]
    assert grid(frames[:4]).shape == (4, 6, 3)


@pytest.mark.parametrize(
    ("count", "size", "columns", "expected"),
    [
        (1, (600, 600), None, (1, (600, 600))),  # fits as it is
        (2, (600, 600), None, (2, (600, 600))),
        (3, (600, 600), None, (3, (426, 426))),  # 1280 / 3
        (4, (600, 600), None, (2, (380, 380))),  # 760 / 2
        (6, (600, 600), None, (3, (380, 380))),
        (16, (600, 600), None, (4, (190, 190))),  # six in a row would be 213 high, but leave two places empty
        (4, (1200, 200), None, (1, (1140, 190))),  # long ones lie above each other: 760 / 4 = 190
        (4, (200, 100), None, (2, (200, 100))),  # never enlarged
        (6, (600, 600), 2, (2, (252, 252))),  # 760 / 3 = 253.3
        (3, (600, 600), 7, (3, (426, 426))),
        (400, (600, 600), None, (25, (96, 96))),  # 25 x 16 would fit at 47, but no smaller than this
        (4000, (90, 80), 40, (40, (90, 80))),
    ],
)
def test_pictures_are_as_large_as_a_screen_allows(
    count: int, size: tuple[int, int], columns: int | None, expected: tuple[int, tuple[int, int]]
) -> None:
    found, shown = fitting(count, size, columns, (1280, 760))
    assert (found, shown) == expected
