"""Costs of ways over cells, against SciPy's Dijkstra."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cell_costs import reference_costs

from irsim_gym.arraytypes import Bytes
from irsim_gym.paths.grid import BLOCKED, FREE
from irsim_gym.paths.wavefront import NEVER, TIGHT, block_border, narrow, new_queues, spread_costs, trace_costs


def drawn_levels(seed: int, rows: int = 13, columns: int = 17) -> Bytes:
    """Return random cells, blocked at the border."""
    levels = np.random.default_rng(seed).choice([FREE, BLOCKED, TIGHT], (rows, columns), p=[0.6, 0.25, 0.15])
    levels[0], levels[-1], levels[:, 0], levels[:, -1] = BLOCKED, BLOCKED, BLOCKED, BLOCKED
    return levels.astype(np.uint8)


def spread(levels: Bytes, source: int, target: int = -1, plain: bool = False) -> tuple[int, Any]:
    """Return up to which cost the costs are final, and the costs, inf where there is no way."""
    field = np.zeros(levels.shape, np.int32)
    run = getattr(spread_costs, "py_func", spread_costs) if plain else spread_costs
    final = run(levels, source, target, new_queues(*levels.shape), field)
    return final, np.where(field == NEVER, np.inf, field)


@pytest.mark.parametrize("seed", range(6))
def test_costs_are_those_of_dijkstra(seed: int) -> None:
    levels, source = drawn_levels(seed), 6 * 17 + 8 - seed
    final, field = spread(levels, source)
    assert final == NEVER
    np.testing.assert_array_equal(field, reference_costs(levels, source))
    np.testing.assert_array_equal(field, spread(levels, source, plain=True)[1])
    assert np.isfinite(field).sum() > 30


@pytest.mark.parametrize("seed", range(6))
def test_a_wave_that_ends_early_is_right_up_to_where_it_says(seed: int) -> None:
    levels, source = drawn_levels(seed, 40, 50), 20 * 50 + 25
    levels[20, 25] = FREE
    expected = reference_costs(levels, source)
    target = int(np.argmin(np.where(expected > 40, expected, np.inf)))
    final, field = spread(levels, source, target)
    assert expected.flat[target] + 60 == final < expected[np.isfinite(expected)].max()
    near = field <= final
    np.testing.assert_array_equal(field[near], expected[near])
    np.testing.assert_array_equal(near, expected <= final)


@pytest.mark.parametrize("seed", range(8))
def test_a_way_explains_its_cost_until_something_is_seen_in_it(seed: int) -> None:
    levels, source = drawn_levels(seed), 6 * 17 + 8
    field, way = np.zeros(levels.shape, np.int32), np.zeros(levels.size, np.int32)
    spread_costs(levels, source, -1, new_queues(*levels.shape), field)
    start = int(np.argmax(np.where(field == NEVER, -1, field)))
    count = trace_costs(levels, field, start, way)
    assert (way[0], way[count - 1]) == (start, source)
    for here, there in zip(way[: count - 1].tolist(), way[1:count].tolist(), strict=True):
        apart = sorted(abs(number) for number in (here // 17 - there // 17, here % 17 - there % 17))
        step = {(0, 1): 5, (1, 1): 7}[tuple(apart)] * (8 if levels.flat[here] == TIGHT else 1)
        assert field.flat[here] - field.flat[there] == step
    barred = 0
    for number in way[1 : count - 1].tolist():
        for level in (TIGHT, BLOCKED):
            changed = levels.copy()
            if changed.flat[number] != FREE:
                continue
            changed.flat[number] = level
            found = trace_costs(changed, field, start, way)
            # Another way of the same cost is as good.
            assert found == 0 or reference_costs(changed, source).flat[start] == field.flat[start]
            barred += found == 0
    assert barred


def test_where_a_disc_fits_around_a_point() -> None:
    rng = np.random.default_rng(4)
    for _ in range(40):
        x, y, reach = *rng.uniform(3, 8, 2), rng.uniform(0.2, 3.0)
        levels = np.zeros((11, 12), np.uint8)
        block_border(levels)
        narrow(levels, x, y, reach)
        for row in range(1, 10):
            for column in range(1, 11):
                corners = [(column + i, row + j) for i in (0, 1) for j in (0, 1)]
                holds = column <= x < column + 1 and row <= y < row + 1
                fits_nowhere = holds or max(np.hypot(x - cx, y - cy) for cx, cy in corners) <= reach
                fits = np.hypot(x - column - 0.5, y - row - 0.5) >= reach
                expected = BLOCKED if fits_nowhere else FREE if fits else TIGHT
                assert levels[row, column] == expected
        assert (levels[[0, -1]] == BLOCKED).all()
        assert (levels[:, [0, -1]] == BLOCKED).all()
