"""perlin: a map from gradient noise (Perlin, "Improving noise", 2002), with the grids of IR-SIM for the same seed."""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

import numpy as np

from irsim_gym.bodies.maps.level import MOST_CELLS, CellsKind, map_size
from irsim_gym.simulator.world.names import Flags, Floats, Ints, kind, option

_Q = np.sqrt(0.5)
GRADIENTS = np.array([[1, 0], [-1, 0], [0, 1], [0, -1], [_Q, _Q], [-_Q, _Q], [_Q, -_Q], [-_Q, -_Q]])
"""Eight unit vectors, every eighth of a turn."""


@kind
class PerlinMap(CellsKind):
    """Caves and islands from smooth noise, with a given share of occupied cells."""

    is_random: ClassVar[bool] = False

    resolution: float = option(gt=0.0, unit="m", meaning="Cell size, rounded so that whole cells fill the world.")
    complexity: float = option(0.142857, gt=0.0, meaning="Bumps per cell: larger is finer.")
    fill: float = option(0.38, ge=0.0, le=1.0, meaning="Share of occupied cells.")
    fractal: int = option(1, ge=1, le=32, meaning="Number of octaves, each twice as fine as the previous one.")
    attenuation: float = option(0.5, gt=0.0, meaning="Octave k has this weight divided by k + 1.")
    seed: int | None = option(None, ge=0, meaning="Seed of the map; default: derived from the world's name.")

    def occupied(self, width: float, height: float, name: str, find: Callable[[str], Path]) -> Flags:
        """Return the occupied cells, shape ``(columns, rows)``.

        Raises:
            OptionError: If there would be too many cells.
        """
        columns, rows = map_size(self.resolution, width, height, MOST_CELLS)
        noise = self.noise(columns, rows, seed_of(name) if self.seed is None else self.seed)
        place = min(int((1.0 - self.fill) * noise.size), noise.size - 1)
        return np.asarray(noise > np.sort(noise, axis=None)[place])

    def noise(self, columns: int, rows: int, seed: int) -> Floats:
        """Return noise from 0 to 1, shape ``(columns, rows)``."""
        order = np.arange(256, dtype=np.int32)
        np.random.default_rng(seed).shuffle(order)
        # Twice, so that sums of two indices need no modulo.
        table = np.concatenate([order, order])
        total, weights = np.zeros((columns, rows)), 0.0
        for octave in range(self.fractal):
            scale, weight = self.complexity * 2.0**octave, self.attenuation / (octave + 1)
            total += weight * _octave(
                scale * np.arange(columns, dtype=np.float64), scale * np.arange(rows, dtype=np.float64), table
            )
            weights += weight
        # The weighted mean of noise from -1 to 1, mapped to 0 to 1.
        return np.asarray(np.clip((total / weights + 1.0) / 2.0, 0.0, 1.0))


def seed_of(name: str) -> int:
    """Return the default seed of a scenario's map, which depends only on the scenario's name."""
    return int.from_bytes(hashlib.blake2b(name.encode(), digest_size=4).digest(), "little")


def _octave(x: Floats, y: Floats, table: Ints) -> Floats:
    """Return gradient noise at the points of a grid, shape ``(len(x), len(y))``."""
    i, j = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    u, v = x - i, y - j
    corners = [[_slope(i, j, u, v, a, b, table) for b in range(2)] for a in range(2)]
    across, up = _fade(u)[:, None], _fade(v)[None, :]
    low = corners[0][0] + across * (corners[1][0] - corners[0][0])
    high = corners[0][1] + across * (corners[1][1] - corners[0][1])
    return np.asarray(low + up * (high - low))


def _slope(i: Ints, j: Ints, u: Floats, v: Floats, a: int, b: int, table: Ints) -> Floats:
    """Return the contribution of the gradient at one corner of each point's cell."""
    # The gradient at corner (i + a, j + b), and its scalar product with the offset from there.
    chosen = GRADIENTS[table[table[(i & 255) + a][:, None] + (j & 255)[None, :] + b] % 8]
    return np.asarray(chosen[..., 0] * (u - a)[:, None] + chosen[..., 1] * (v - b)[None, :])


def _fade(t: Floats) -> Floats:
    return np.asarray(t * t * t * (t * (t * 6.0 - 15.0) + 10.0))
