"""Levels of crowd_nav as the code of CrowdNav++ draws them: robot first, each axis of a start shifted by itself.

    irsim-gym levels draw crowd_nav --split test --count 500 --out drawn.npz
    python agents/studies/crowd_nav_levels.py drawn.npz paper.npz --shift -0.5 0.5
    python agents/studies/crowd_nav_levels.py drawn.npz code.npz --shift 0 2

The published code shifts starts by 0 to 2 m, its paper's text and benchmarks.md by -0.5 to 0.5 m. A copy of
``crowd_nav.yaml`` with ``levels: paper.npz`` plays them.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

RADIUS, SQUARE, FARTHER, APART = 6.0 * np.sqrt(2.0), 6.0, 8.0, 0.85
"""Circle of the people, half the side of the robot's square, its least way, and what starts keep from others [m]."""


def main() -> None:
    """Rewrite the starts and goals of a file of levels."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("drawn", type=Path, help="levels of crowd_nav, from irsim-gym levels draw")
    parser.add_argument("out", type=Path, help="file to write")
    parser.add_argument("--shift", type=float, nargs=2, default=(-0.5, 0.5), metavar=("LEAST", "MOST"))
    given = parser.parse_args()
    levels = dict(np.load(given.drawn))
    rng = np.random.default_rng(1)
    for start, goal in zip(levels["start"], levels["goal"], strict=True):
        start[:, :2], goal[:, :2] = draw_level(len(start), given.shift, rng)
    np.savez(given.out, **levels)


def draw_level(n_bodies: int, shift: tuple[float, float], rng: np.random.Generator) -> NDArray[np.float64]:
    """Return starts and goals of the robot and of people who cross a circle [m], shape ``(2, n_bodies, 2)``."""
    ends = np.zeros((2, n_bodies, 2))
    while np.hypot(*(ends[1, 0] - ends[0, 0])) < FARTHER:
        ends[:, 0] = rng.uniform(-SQUARE, SQUARE, (2, 2))
    for b in range(1, n_bodies):
        near = 0.0
        while near < APART:
            angle = rng.uniform(0.0, 2.0 * np.pi)
            place = RADIUS * np.array([np.cos(angle), np.sin(angle)]) + rng.uniform(*shift, 2)
            near = np.linalg.norm(ends[:, :b] - place, axis=-1).min()
        ends[:, b] = place, -place
    return ends


if __name__ == "__main__":
    main()
