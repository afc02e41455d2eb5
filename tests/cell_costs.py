"""Costs of ways over cells, by SciPy on a graph that is built step by step."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from irsim_gym.base.arraytypes import Bytes, Floats
from irsim_gym.simulator.cell_paths.wavefront import TIGHT
from irsim_gym.simulator.paths.grid import BLOCKED

STEPS = [(dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if (dy, dx) != (0, 0)]


def reference_costs(levels: Bytes, source: int) -> Floats:
    """Return the cost of each cell's cheapest way to a cell: 5 for a step, 7 across a corner, eightfold from TIGHT."""
    columns = levels.shape[1]
    start, end, cost = [], [], []
    for row, column in np.argwhere(levels != BLOCKED).tolist():
        for dy, dx in STEPS:
            to = (row + dy) * columns + column + dx
            if levels[row + dy, column + dx] == BLOCKED and to != source:
                continue
            if dy and dx and BLOCKED in (levels[row, column + dx], levels[row + dy, column]):
                continue
            start.append(row * columns + column)
            end.append(to)
            cost.append((7 if dy and dx else 5) * (8 if levels[row, column] == TIGHT else 1))
    graph = csr_array((cost, (end, start)), shape=(levels.size, levels.size))
    return np.asarray(dijkstra(graph, indices=source)).reshape(levels.shape)
