"""Costs of ways over cells, against SciPy's Dijkstra."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from cell_costs import reference_costs

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.simulator.cell_paths.wavefront import (
    NEVER,
    TIGHT,
    begin_costs,
    begin_wave,
    block_border,
    follow_costs,
    narrow,
    new_queues,
    next_cell,
    offer_neighbours,
    spread_costs,
)
from irsim_gym.simulator.paths.grid import BLOCKED, FREE


def drawn_levels(seed: int, rows: int = 13, columns: int = 17) -> Bytes:
    """Return random cells, blocked at the border."""
    levels = np.random.default_rng(seed).choice([FREE, BLOCKED, TIGHT], (rows, columns), p=[0.6, 0.25, 0.15])
    levels[0], levels[-1], levels[:, 0], levels[:, -1] = BLOCKED, BLOCKED, BLOCKED, BLOCKED
    return levels.astype(np.uint8)


def spread(levels: Bytes, source: int, plain: bool = False) -> Any:
    """Return the costs, inf where there is no way."""
    least = np.zeros(levels.shape, np.int32)
    run = getattr(spread_costs, "py_func", spread_costs) if plain else spread_costs
    run(levels, source, new_queues(*levels.shape), least)
    return np.where(least == NEVER, np.inf, least)


@pytest.mark.parametrize("seed", range(6))
def test_costs_are_those_of_dijkstra(seed: int) -> None:
    levels, source = drawn_levels(seed), 6 * 17 + 8 - seed
    costs = spread(levels, source)
    np.testing.assert_array_equal(costs, reference_costs(levels, source))
    np.testing.assert_array_equal(costs, spread(levels, source, plain=True))
    assert np.isfinite(costs).sum() > 30


@pytest.mark.parametrize("seed", range(3))
def test_cells_of_a_wave_come_in_the_order_of_their_costs(seed: int) -> None:
    levels, source = drawn_levels(seed), 6 * 17 + 8
    queues, costs, order = new_queues(*levels.shape), np.zeros(levels.size, np.int32), []
    begin_wave(source, queues, costs)
    while (here := next_cell(queues, costs)) >= 0:
        order.append((here, int(costs[here])))
        offer_neighbours(levels.reshape(-1), levels.shape[1], here, queues, costs)
    expected = reference_costs(levels, source).reshape(-1)
    assert sorted(here for here, _ in order) == np.flatnonzero(np.isfinite(expected)).tolist()
    assert [cost for _, cost in order] == [expected[here] for here, _ in order] == sorted(cost for _, cost in order)


def test_costs_begin_with_those_among_free_cells() -> None:
    free, least = np.zeros((9, 12), np.uint8), np.zeros((9, 12), np.int32)
    begin_costs(5 * 12 + 3, least)
    assert (least[5, 3], least[5, 7], least[2, 5], least[8, 0]) == (0, 20, 3 * 5 + 2 * 2, 3 * 7)
    block_border(free)
    np.testing.assert_array_equal(least[1:-1, 1:-1], reference_costs(free, 5 * 12 + 3)[1:-1, 1:-1])


def cost_of(way: list[int], levels: Bytes) -> int:
    """Return what a way costs, after a check that each step may be taken."""
    total, columns = 0, levels.shape[1]
    for here, there in itertools.pairwise(way):
        (y, x), (to_y, to_x) = divmod(here, columns), divmod(there, columns)
        assert (abs(y - to_y), abs(x - to_x)) in [(0, 1), (1, 0), (1, 1)]
        assert there == way[-1] or levels[to_y, to_x] != BLOCKED
        across = y != to_y and x != to_x
        assert not across or BLOCKED not in (levels[y, to_x], levels[to_y, x])
        total += (7 if across else 5) * (8 if levels[y, x] == TIGHT else 1)
    return total


@pytest.mark.parametrize("seed", range(8))
def test_a_way_is_a_cheapest_one_wherever_it_begins_while_levels_rise(seed: int) -> None:
    rng, levels = np.random.default_rng(seed), np.zeros((13, 17), np.uint8)
    block_border(levels)
    source, way = int(rng.integers(2, 11)) * 17 + int(rng.integers(2, 15)), np.zeros(levels.size, np.int32)
    least, queues, outcomes = np.zeros(levels.shape, np.int32), new_queues(*levels.shape), set()
    begin_costs(source, least)
    for _ in range(60):
        row, column = rng.integers(1, 12), rng.integers(1, 16)
        levels[row, column] = rng.choice([TIGHT, BLOCKED]) if levels[row, column] == FREE else BLOCKED
        expected, start = reference_costs(levels, source), int(rng.choice(np.flatnonzero(levels != BLOCKED)))
        count = follow_costs(levels, least, start, way)
        if count == 0 and least.flat[start] < NEVER:
            spread_costs(levels, source, queues, least)
            count = follow_costs(levels, least, start, way)
            outcomes.add("given up")
        if count > 0:
            assert (way[0], way[count - 1]) == (start, source)
            assert cost_of(way[:count].tolist(), levels) == expected.flat[start]
            left = [cost_of(way[n:count].tolist(), levels) for n in range(count)]
            assert least.flat[way[:count]].tolist() == left
        else:
            assert expected.flat[start] == np.inf
        outcomes.add("found" if count > 0 else "none")
        open_cells = levels != BLOCKED
        assert (np.where(least >= NEVER, np.inf, least) <= expected)[open_cells].all()
    assert "found" in outcomes


def test_a_large_trap_is_left_by_a_wave() -> None:
    levels, way = np.zeros((40, 40), np.uint8), np.zeros(1600, np.int32)
    block_border(levels)
    levels[5:35, 30], levels[5, 3:31], levels[34, 3:31] = BLOCKED, BLOCKED, BLOCKED
    start, source = 20 * 40 + 28, 20 * 40 + 36
    least = np.zeros(levels.shape, np.int32)
    begin_costs(source, least)
    assert least.flat[start] == 8 * 5
    assert follow_costs(levels, least, start, way) == 0
    assert 8 * 5 < least.flat[start] < NEVER
    spread_costs(levels, source, new_queues(40, 40), least)
    count = follow_costs(levels, least, start, way)
    assert cost_of(way[:count].tolist(), levels) == reference_costs(levels, source).flat[start]


def test_a_cell_without_a_way_is_known_from_then_on() -> None:
    levels, way = np.zeros((12, 12), np.uint8), np.zeros(144, np.int32)
    block_border(levels)
    levels[3:6, 3:6] = BLOCKED
    levels[4, 4] = FREE
    least = np.zeros(levels.shape, np.int32)
    begin_costs(8 * 12 + 8, least)
    for start in (4 * 12 + 4, 4 * 12 + 4):
        assert follow_costs(levels, least, start, way) == 0
        assert least.flat[start] == NEVER


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
