"""Draw the shipped obstacle maps: run ``python configs/maps/make_maps.py`` to write them again, pixel for pixel.

Each is an array of truth values by row from the top: True is free, and white in the picture.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Cells = NDArray[np.bool_]


def cavern(side: int = 240, seed: int = 7, rounds: int = 7) -> Cells:
    """Return a cave from a cellular automaton: rock grows where most of the eight neighbours are rock.

    Only the largest connected hollow is kept.
    """
    coarse = side // 2
    rock = np.random.default_rng(seed).random((coarse, coarse)) < 0.455
    for _ in range(rounds):
        padded = np.pad(rock, 1, constant_values=True)
        around = sum(padded[a : a + coarse, b : b + coarse].astype(int) for a in range(3) for b in range(3))
        rock = (around - rock) >= np.where(rock, 4, 5)
    rock[[0, 1, -1, -2], :], rock[:, [0, 1, -1, -2]] = True, True
    return np.kron(largest(~rock), np.ones((2, 2), np.bool_))


def largest(free: Cells) -> Cells:
    """Return the largest part of the free cells that is connected by sides."""
    best, left = np.zeros_like(free), free.copy()
    while left.any():
        part = np.zeros_like(free)
        part[tuple(np.argwhere(left)[0])] = True
        size = 0
        while part.sum() > size:
            size = int(part.sum())
            for axis in (0, 1):
                for step in (-1, 1):
                    part |= np.roll(part, step, axis) & left
        left &= ~part
        best = part if part.sum() > best.sum() else best
    return best


def floor_plan() -> Cells:
    """Return a floor of rooms along two corridors, 1 pixel = 5 cm on 20 x 15 m."""
    free = np.ones((300, 400), np.bool_)
    walls = [(0, 0, 300, 4), (0, 396, 300, 400), (0, 0, 4, 400), (296, 0, 300, 400)]
    walls += [(92, 0, 96, 400), (132, 0, 136, 400), (136, 254, 296, 258), (136, 294, 296, 298)]
    walls += [(0, x, 92, x + 4) for x in (98, 196, 298)]
    walls += [(136, x, 300, x + 4) for x in (126,)]
    walls += [(214, 4, 218, 254), (214, 298, 218, 396)]
    doors = [(92, 40, 96, 62), (92, 140, 96, 162), (92, 236, 96, 258), (92, 336, 96, 358)]
    doors += [(132, 50, 136, 72), (132, 180, 136, 202), (132, 258, 136, 294), (132, 330, 136, 352)]
    doors += [
        (214, 56, 218, 78),
        (214, 190, 218, 212),
        (214, 330, 218, 352),
        (250, 254, 272, 258),
        (160, 294, 182, 298),
    ]
    doors += [(30, 98, 52, 102), (30, 298, 52, 302)]
    desks = [(20, 20, 36, 60), (60, 120, 76, 160), (14, 214, 30, 280), (60, 320, 76, 380), (156, 20, 172, 60)]
    desks += [(180, 90, 200, 110), (156, 150, 170, 170), (180, 214, 196, 244), (240, 20, 280, 36), (262, 70, 280, 110)]
    desks += [
        (236, 150, 250, 236),
        (276, 150, 290, 236),
        (150, 360, 200, 380),
        (240, 316, 256, 340),
        (270, 350, 290, 390),
    ]
    for top, left, bottom, right in walls:
        free[top:bottom, left:right] = False
    for top, left, bottom, right in doors:
        free[top:bottom, left:right] = True
    for top, left, bottom, right in desks:
        free[top:bottom, left:right] = False
    return free


def warehouse() -> Cells:
    """Return a hall of shelves with aisles, pillars and a packing area, 1 pixel = 10 cm on 30 x 20 m."""
    free = np.ones((200, 300), np.bool_)
    free[[0, 1, -1, -2], :], free[:, [0, 1, -1, -2]] = False, False
    for left in range(24, 220, 26):
        free[20:84, left : left + 10] = False
        free[112:176, left : left + 10] = False
    for top in range(30, 180, 34):
        free[top : top + 12, 250:274] = False
    for top in (96, 100):
        for left in range(50, 230, 60):
            free[top : top + 3, left : left + 3] = False
    return free


def draw() -> dict[str, Cells]:
    """Return all maps by file name."""
    return {"cavern.png": cavern(), "floor_plan.png": floor_plan(), "warehouse.png": warehouse()}


def main() -> None:
    """Write the files beside this one."""
    for name, free in draw().items():
        Image.fromarray(np.where(free, 255, 0).astype(np.uint8)).save(Path(__file__).parent / name, optimize=True)


if __name__ == "__main__":
    main()
