"""Maps from gradient noise that are drawn for each level; ``perlin`` makes one map for all levels."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import CellMaps, Flags, Floats, Ints
from irsim_gym.base.rng import integer
from irsim_gym.simulator.cell_maps.world_maps import lay_cells
from irsim_gym.simulator.world.names import Model, State, Struct, kernel

_Q = np.sqrt(0.5)
GRADIENTS = np.array([[1, 0], [-1, 0], [0, 1], [0, -1], [_Q, _Q], [-_Q, _Q], [_Q, -_Q], [-_Q, -_Q]])
"""Eight unit vectors, every eighth of a turn."""
N = 256
"""Period of the table of gradients."""


@dataclass(repr=False)
class NoiseTables(Struct):
    """Memory for drawing noise; the first axis is the slot.

    Attributes:
        occupied: Occupied cells, shape ``(n_slots, columns, rows)``.
        line: Scratch for ``lay_cells``, shape ``(n_slots, columns)``.
        noise: Noise of each cell, shape ``(n_slots, columns, rows)``.
        ranked: Scratch, shape ``(n_slots, columns * rows)``.
        gradients: The numbers from 0 to N - 1 in random order, twice in a row, so that the sum of an index and such a
            number, plus 1, is an index again; shape ``(n_slots, 2 * N)``.
    """

    occupied: Flags
    line: Floats
    noise: Floats
    ranked: Floats
    gradients: Ints


def noise_tables(model: Model, n_slots: int) -> NoiseTables:
    """Return memory for maps of the model's size."""
    columns, rows = model.map_room.shape[1:]
    return NoiseTables(
        occupied=np.zeros((n_slots, columns, rows), np.bool_),
        line=np.zeros((n_slots, columns)),
        noise=np.zeros((n_slots, columns, rows)),
        ranked=np.zeros((n_slots, columns * rows)),
        gradients=np.zeros((n_slots, 2 * N), np.int64),
    )


@kernel
def draw_noise_maps(worlds: Ints, slot: int, options: Any, tables: NoiseTables, cells: CellMaps, state: State) -> None:
    """Occupy the cells with the highest noise, as many as ``fill`` says.

    Reads: tables (gradients, line, noise, occupied, ranked), state (random).
    Writes: tables (gradients, line, noise, occupied, ranked), cells, state (random).
    """
    occupied, noise, ranked = tables.occupied[slot], tables.noise[slot], tables.ranked[slot]
    gradients, given = tables.gradients[slot], options[0]
    columns, rows = occupied.shape
    # The rank of the highest noise that stays free.
    place = min(int((1.0 - given["fill"]) * ranked.shape[0]), ranked.shape[0] - 1)
    for w in worlds:
        for k in range(N):
            gradients[k] = k
        # A Fisher-Yates shuffle.
        for k in range(N - 1):
            chosen = integer(state.random, w, k, N)
            gradients[k], gradients[chosen] = gradients[chosen], gradients[k]
        for k in range(N):
            gradients[N + k] = gradients[k]
        for i in range(columns):
            for j in range(rows):
                total, scale = 0.0, given.complexity
                for octave in range(given.fractal):
                    # Without dividing by the sum of weights, as perlin does: only the order of the numbers counts.
                    total += given.attenuation / (octave + 1) * noise_at(scale * i, scale * j, gradients)
                    scale *= 2.0
                noise[i, j] = ranked[i * rows + j] = total
        least = nth_smallest(ranked, place)
        for i in range(columns):
            for j in range(rows):
                occupied[i, j] = noise[i, j] > least
        lay_cells(cells, w, occupied, tables.line[slot])


@kernel
def noise_at(x: float, y: float, gradients: Ints) -> float:
    """Return gradient noise at a point whose coordinates are not negative."""
    i, j = int(x), int(y)
    u, v = x - i, y - j
    across, up = fade(u), fade(v)
    # Perlin's hash of a corner is p[p[i] + j], with the permutation p; its lowest three bits choose the gradient.
    i, j = i & (N - 1), j & (N - 1)
    left, right = gradients[i] + j, gradients[i + 1] + j
    # Between the corners below, then between those above, then between both.
    low = slope(gradients[left], u, v)
    low += across * (slope(gradients[right], u - 1.0, v) - low)
    high = slope(gradients[left + 1], u, v - 1.0)
    high += across * (slope(gradients[right + 1], u - 1.0, v - 1.0) - high)
    return low + up * (high - low)


@kernel
def slope(chosen: int, u: float, v: float) -> float:
    """Return what the gradient at a corner contributes at a distance from it."""
    return float(GRADIENTS[chosen & 7, 0] * u + GRADIENTS[chosen & 7, 1] * v)


@kernel
def fade(t: float) -> float:
    """Return a smooth step from 0 to 1."""
    # Perlin (2002): first and second derivatives are 0 at both ends.
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0)


@kernel
def nth_smallest(values: Floats, n: int) -> float:
    """Return the number that has n before it in ascending order, and put values in another order (Hoare 1961)."""
    low, high = 0, values.shape[0] - 1
    while low < high:
        pivot, i, j = values[(low + high) // 2], low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while values[j] > pivot:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i, j = i + 1, j - 1
        # Numbers up to j are at most the pivot, from i on at least; between the two stands the pivot itself.
        if n <= j:
            high = j
        elif n >= i:
            low = i
        else:
            break
    return float(values[n])
