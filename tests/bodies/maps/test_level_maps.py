"""Maps that each level draws anew: what is drawn, and that each world has its own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from scipy import ndimage, sparse
from scipy.sparse import csgraph

import irsim_gym as ig
from irsim_gym.bodies.maps.cells import RandomCells
from irsim_gym.bodies.maps.level import LevelMap
from irsim_gym.bodies.maps.rooms import choose_room
from irsim_gym.errors import PlacementError, ScenarioError
from irsim_gym.simulator.cell_paths.queries import free_path_length
from irsim_gym.simulator.world.group import Shard
from irsim_gym.simulator.world.state import State
from tests.simulator.geometry.cell_maps import area, cell_map

LIDAR = {"name": "lidar2d", "number": 40, "angle_range": "2 * pi", "range_max": 6}
SQUARE = {"name": "rectangle", "length": 0.5, "width": 0.5}
ROBOT = {"kinematics": {"name": "diff"}, "shape": SQUARE, "distribution": {"name": "cells"}, "sensors": [LIDAR]}
DISC = {"kinematics": {"name": "diff"}, "behavior": {"name": "dash"}, "distribution": {"name": "random"}}
ROAMER = {**ROBOT, "distribution": {"name": "random", "reachable": True}}
KINDS: dict[str, dict[str, Any]] = {
    "cells": {"name": "cells", "resolution": 1.0},
    "rooms": {"name": "rooms", "resolution": 0.25, "loops": 0.5},
    "maze": {"name": "maze", "resolution": 0.25, "loops": 0.2},
    "cellular": {"name": "cellular", "resolution": 0.5},
    "shelves": {"name": "shelves", "resolution": 0.5, "missing": [0.3, 0.3]},
    "discs": {"name": "cellular", "resolution": 0.5, "disc_radius": 0.2},
}
MAPS = ("squares", "boxes", "n_boxes", "room")


def simulation(kind: str = "cells", n_worlds: int = 1, seed: int = 0, **options: Any) -> Any:
    world = {"name": "levels", "width": 11, "height": 11, "offset": [-1, 2], "obstacle_map": KINDS[kind]}
    data = {"world": world, "robot": [ROBOT if kind == "cells" else ROAMER], "obstacle": [DISC]}
    sim = ig.compile(ig.load_scenario(data), n_worlds, agents=(0,), **options)
    sim.reset(seed=seed)
    return sim


def occupied_cells(sim: Any, w: int = 0) -> Any:
    return sim.model.map_squares[w, 0] == 0


def everything(sim: Any) -> dict[str, Any]:
    """Return all that differs between worlds: the moment, the maps and the scans."""
    found = {name: getattr(sim.state, name) for name in State.columns() if name not in ("nearby", "bucket_first")}
    found |= {name: getattr(sim.model.cells, name) for name in MAPS}
    return {**found, "ranges": sim.scan(0)[0].arrays["ranges"], "waypoints": sim.model.waypoints}


@pytest.mark.parametrize("kind", KINDS)
def test_batches_threads_and_recorded_steps_are_single_worlds(kind: str) -> None:
    def run(n_worlds: int, seed: int, **options: Any) -> Any:
        sim = simulation(kind, n_worlds, seed, **options)
        for _ in range(4):
            sim.step([1.0, 0.3])
        sim.reset(seed=seed + 50)  # each world draws another map over the first
        for _ in range(4):
            sim.step([1.0, 0.3])
        return everything(sim)

    batch = run(4, 7)
    assert len({occupied.tobytes() for occupied in batch["squares"]}) == 4
    for other in (run(4, 7, num_threads=2), run(4, 7, fused=False)):
        for name, value in batch.items():
            np.testing.assert_array_equal(value, other[name], err_msg=name)
    single = run(1, 9)
    for name, value in batch.items():
        here, there = value[2], single[name][0]
        if name == "boxes":
            n = batch["n_boxes"][2]
            here, there = here[:n], there[:n]
        np.testing.assert_array_equal(here, there, err_msg=name)


@pytest.mark.parametrize("kind", KINDS)
def test_each_thread_draws_in_memory_of_its_own(kind: str) -> None:
    """The second slot draws what the first one drew from the same stream, and writes nothing of the first one's."""
    sim = simulation(kind, 2, num_threads=2)
    (group,) = sim.parts.maps
    drawn = []
    for slot, other in ((0, 1), (1, 0)):
        sim.state.random[:] = 5
        scratch = {name: getattr(group.tables, name) for name in ("occupied", "before", "line", "order")}
        before = {name: array[other].copy() for name, array in scratch.items()}
        LevelMap.draw(group, sim.model, sim.state, Shard(np.array([1]), slot))
        drawn.append(occupied_cells(sim, 1).copy())
        for name, array in scratch.items():
            np.testing.assert_array_equal(array[other], before[name], err_msg=name)
        assert np.array_equal(group.tables.occupied[slot], drawn[-1])
    np.testing.assert_array_equal(*drawn)
    assert (drawn[0] != occupied_cells(sim, 0)).any()


@pytest.mark.parametrize("kind", KINDS)
def test_each_world_is_seen_and_touched_as_its_own_cells_are(kind: str) -> None:
    """Scans, contacts and clearances against shapely; the arrays of a map are those of its cells."""
    sim = simulation(kind, 3, seed=2)
    for _ in range(12):
        sim.step([1.0, 0.4])
    distance = np.zeros((3, 1))
    sim.run(lambda shard: sim.clearance(shard, np.array([0]), distance))
    frame, group = sim.model.map_frame.item()[:4], sim.scan(0)[0]
    for w in range(3):
        occupied = occupied_cells(sim, w)
        cells, radius = sim.model.cells, KINDS[kind].get("disc_radius", 0.0)
        expected = cell_map(occupied, *frame, radius)
        for name in ("squares", "room"):
            np.testing.assert_array_equal(getattr(cells, name)[w], getattr(expected, name))
        n = int(cells.n_boxes[w])
        np.testing.assert_array_equal(cells.boxes[w, :n], expected.boxes[:n])
        x, y, heading = sim.state.pose[w, 0]
        other = shapely.Point(sim.state.pose[w, 1, :2]).buffer(0.2, quad_segs=256)
        seen = shapely.union(area(occupied, *frame, radius), other)
        body = shapely.Polygon(sim.state.segments[w, :4, :2])
        assert bool(sim.state.collided[w, 0]) == seen.intersects(body)
        assert distance[w, 0] == pytest.approx(seen.distance(body), abs=1e-4)
        for angle, found in zip(group.arrays["angles"], group.arrays["ranges"][w, 0], strict=True):
            end = x + 6 * np.cos(heading + angle), y + 6 * np.sin(heading + angle)
            free = shapely.LineString([(x, y), end]).difference(seen)
            first = shapely.get_parts(free)[0]
            assert found == pytest.approx(first.length if first.distance(shapely.Point(x, y)) < 1e-9 else 0, abs=1e-3)


def test_cells_are_filled_to_every_share_and_goals_can_be_reached() -> None:
    """0 to 48 of the 81 inner cells, evenly; start and goal in the middle of two free cells that others join."""
    sim = simulation(n_worlds=800)
    maps = sim.model.map_squares[:, 0] == 0
    assert maps[:, [0, -1]].all()
    assert maps[:, :, [0, -1]].all()
    counts = maps.sum(axis=(1, 2)) - 40
    assert (counts.min(), counts.max()) == (0, 48)
    assert abs(counts.mean() - 24.0) < 3.0 * 14.1 / np.sqrt(800)
    full = maps[counts > 40].mean(axis=0)[1:-1, 1:-1]  # no cell more often than others
    assert abs(full - full.mean()).max() < 4.5 * 0.5 / np.sqrt((counts > 40).sum())
    apart = np.zeros(800)
    for w in range(800):
        places = (np.stack([sim.state.pose[w, 0], sim.model.waypoints[w, 0, 0]])[:, :2] - [-1, 2]).tolist()
        (i, j), (to_i, to_j) = ((int(x), int(y)) for x, y in places)
        assert places == [[i + 0.5, j + 0.5], [to_i + 0.5, to_j + 0.5]]
        regions = ndimage.label(~maps[w])[0]
        assert regions[i, j] == regions[to_i, to_j] > 0
        apart[w] = abs(i - to_i) + abs(j - to_j)
    assert apart.min() == 1
    assert apart.max() > 12


def drawn(n_worlds: int, size: tuple[float, float] = (16, 16), **options: Any) -> Any:
    """Return the maps of some levels, shape ``(n_worlds, columns, rows)``."""
    robot = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.01}, "state": [0, 0, 0]}
    world = {"name": "drawn", "width": size[0], "height": size[1], "obstacle_map": options}
    sim = ig.compile(ig.load_scenario({"world": world, "robot": robot}), n_worlds)
    sim.reset(seed=0)
    return sim.model.map_squares[:, 0] == 0


def test_rooms_are_as_many_as_asked_for_and_joined_by_doors() -> None:
    """Doors of one cell vanish where 2 x 2 cells have to be free, and each region that is left is a room."""
    maps, counts = drawn(60, name="rooms", resolution=0.25, door=[0.25, 0.25], least_side=1.5), []
    for occupied in maps:
        assert ndimage.label(~occupied)[1] == 1
        counts.append(ndimage.label(ndimage.binary_opening(~occupied, np.ones((2, 2))))[1])
    assert set(counts) == set(range(4, 10))
    maps = drawn(20, (8, 5), name="rooms", resolution=0.25, number=[2, 2], door=[1.0, 1.5], border=False)
    for occupied in maps:  # one wall of 20 or 32 cells, with a door of 4 to 6
        wall = ndimage.label(occupied.any(axis=0) & occupied.any(axis=1).any())[1]
        lines = [int(one.max()) for one in (occupied.sum(axis=0), occupied.sum(axis=1))]
        length, n = (20, lines[1]) if lines[0] == 1 else (32, lines[0])
        assert wall >= 1
        assert occupied.sum() == n
        assert 4 <= length - n <= 6


@pytest.mark.parametrize(("border", "n_across", "n_up"), [(True, 12, 9), (False, 13, 9)])
def test_mazes_are_trees_and_loops_open_more_walls(border: bool, n_across: int, n_up: int) -> None:
    """Corridors of 4 cells of 0.25 m: crossings of 16 cells, and 4 cells of wall for each way between two of them."""
    n, n_ways = n_across * n_up, n_across * (n_up - 1) + n_up * (n_across - 1)
    for loops, ways in ((0.0, n - 1), (1.0, n_ways)):
        maps = drawn(8, (16, 12), name="maze", resolution=0.25, corridor=1.0, loops=loops, border=border)
        for occupied in maps:
            assert (~occupied).sum() == 16 * n + 4 * ways
            assert ndimage.label(~occupied)[1] == 1
    assert (maps == maps[0]).all()  # all walls are open, of which the corners are left
    assert occupied[1:-1, 1:-1].any()


@pytest.mark.parametrize(("fill_from", "clear_to", "border"), [(5, 3, True), (5, 1, False)])
def test_cells_are_smoothed_by_their_neighbours(fill_from: int, clear_to: int, border: bool) -> None:
    given = {"name": "cellular", "resolution": 0.5, "fill_from": fill_from, "clear_to": clear_to, "border": border}
    before = drawn(4, **given, rounds=[0, 0], fill=[0.4, 0.4])
    inside = before[:, 1:-1, 1:-1]
    assert abs(inside.mean() - 0.4) < 4.0 * np.sqrt(0.24 / inside.size)
    for occupied, smooth in zip(before, drawn(4, **given, rounds=[3, 3], fill=[0.4, 0.4]), strict=True):
        for _ in range(3):
            count = ndimage.convolve(occupied.astype(int), np.ones((3, 3), int), mode="constant") - occupied
            occupied = np.where(count >= fill_from, True, np.where(count <= clear_to, False, occupied))
            if border:
                occupied[[0, -1]] = occupied[:, [0, -1]] = True
        np.testing.assert_array_equal(occupied, smooth)


def test_shelves_stand_in_the_middle_with_aisles_between_them() -> None:
    """16 x 12 m with a wall of 1 m: 14 x 10 cells hold 3 x 3 shelves of 3 x 1 with aisles of 1."""
    given = {"name": "shelves", "resolution": 1, "shelf": [3, 1], "aisle": 1, "turn": False}
    expected = np.ones((16, 12), np.bool_)
    expected[1:-1, 1:-1] = False
    for i in (2, 6, 10):
        for j in (2, 4, 6, 8):
            expected[i : i + 3, j] = True
    maps = drawn(40, (16, 12), **given, missing=[0, 0])
    assert (maps == expected).all()
    tiny = {**given, "aisle": 0.2, "shelf": [3, 0.2]}  # one cell each, as it cannot be less
    assert (drawn(2, (16, 12), **tiny, missing=[0, 0]) == expected).all()
    some = drawn(40, (16, 12), **given, missing=[0.5, 0.5])
    assert not (some & ~expected).any()
    assert abs(some[:, 2:13:4, 2:9:2].mean() - 0.5) < 4.0 * 0.5 / np.sqrt(40 * 12)
    turned = drawn(40, (14, 14), **{**given, "turn": True}, missing=[0, 0])
    assert {one.tobytes() for one in turned} == {turned[0].tobytes(), turned[0].T.tobytes()}
    assert (turned[0] != turned[0].T).any()


@pytest.mark.parametrize("border", [True, False])
def test_what_is_occupied_in_every_level_is_the_border_alone(border: bool) -> None:
    """4 by 3 cells, of which two are inside."""
    occupied = RandomCells(resolution=0.5, border=border).occupied(2.0, 1.5, "yard", Path)
    assert occupied.tolist() == [[border] * 3, [border, False, border], [border, False, border], [border] * 3]


def test_worlds_that_go_on_keep_their_maps_and_pictures() -> None:
    data = {"world": {"width": 11, "height": 11, "obstacle_map": KINDS["cells"]}, "robot": ROBOT}
    env = ig.make_vec(data, 3, max_steps=50, render_mode="rgb_array")
    env.reset(seed=4)
    cells, frames = env.unwrapped.worlds.simulation.model.cells, np.array(env.render())
    before = {name: getattr(cells, name).copy() for name in MAPS}
    env.reset(seed=9, options={"reset_mask": np.array([False, True, False])})
    for name in ("squares", "boxes", "room"):
        same = [np.array_equal(before[name][w], getattr(cells, name)[w]) for w in range(3)]
        assert same == [True, False, True]
    again = np.array(env.render())
    assert [np.array_equal(one, other) for one, other in zip(frames, again, strict=True)] == [True, False, True]
    alone = ig.make(data, render_mode="rgb_array")
    alone.reset(seed=10)
    np.testing.assert_array_equal(alone.render(), again[1])
    env.close()
    alone.close()


def test_a_world_by_hand_draws_a_map_for_each_level_and_keeps_it_when_bodies_come() -> None:
    world = ig.load({"world": {"width": 11, "height": 11, "obstacle_map": KINDS["cells"]}, "robot": ROBOT}, seed=1)
    first = occupied_cells(world.simulation)
    world.add(shape={"name": "circle", "radius": 0.1}, state=[5.5, 5.5, 0])
    np.testing.assert_array_equal(occupied_cells(world.simulation), first)
    world.reset()
    np.testing.assert_array_equal(occupied_cells(world.simulation), first)
    world.reset(random=True)
    assert (occupied_cells(world.simulation) != first).any()


@pytest.mark.parametrize(
    ("kind", "given", "said"),
    [
        ("cells", {"fill": [0.5, 0.2]}, "fill.*low <= high"),
        ("cells", {"fill": [0.0, 1.2]}, "fill.*between 0 and 1"),
        ("cells", {"resolution": 0.01}, "resolution.*1100 x 1100 cells, at most 65536"),
        ("cells", {"resolution": 6}, "resolution.*2 x 2 cells, of which the border leaves none free"),
        ("cells", {"resolution": 0.5}, "distribution.*a cell is 0.5 m wide, they reach 0.353"),
        ("rooms", {"number": [30, 40]}, "number.*3 x 3 rooms of least_side fit"),
        ("rooms", {"door": [1, 3]}, "door.*at most least_side 2, got 3"),
        ("rooms", {"number": [4, 999]}, "number.*at most 102, got 999"),
        ("maze", {"corridor": 9}, "corridor.*1 x 1 crossings"),
        ("cellular", {"rounds": [0, 101]}, "rounds.*at most 100, got 101"),
        ("cellular", {"clear_to": 5}, "clear_to.*less than fill_from, got 5 and 5"),
        ("shelves", {"shelf": [9, 1]}, "shelf.*does not fit"),
        ("shelves", {"shelf": [0, 1]}, "shelf.*two lengths > 0"),
        ("cells", {"disc_radius": 0.6}, "disc_radius.*at most half a cell, 0.5 m, got 0.6"),
    ],
)
def test_what_cannot_be_is_refused(kind: str, given: dict[str, Any], said: str) -> None:
    world = {"width": 11, "height": 11, "obstacle_map": {"name": kind, **given}}
    with pytest.raises(ScenarioError, match=said):
        ig.compile(ig.load_scenario({"world": world, "robot": ROBOT}))


@pytest.mark.parametrize("placement", [pytest.param("random", marks=pytest.mark.slow), "cells"])
def test_ways_are_as_long_as_asked_for(placement: str) -> None:
    """None is longer than SciPy's shortest way from cell to cell through their sides."""
    limits = {"min_way_length": 9.0, "max_way_length": 13.0}
    robot = {
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": 0.3},
        "distribution": {"name": placement, **limits},
    }
    world = {"name": "ways", "width": 11, "height": 11, "obstacle_map": {"name": "maze", "loops": 0.5}}
    sim = ig.compile(ig.load_scenario({"world": world, "robot": robot}), 12, agents=(0,))
    sim.reset(seed=0)
    lengths = []
    for w in range(12):
        start, goal = sim.state.pose[w, 0, :2], sim.model.waypoints[w, 0, 0, :2]
        lengths.append(free_path_length(sim.model, sim.state, w, 0.3, start, goal, cell=0.05))
        cells = [tuple(int(value) for value in np.floor(place)) for place in (start, goal)]
        slack = 0.0 if placement == "cells" else 2.0 * np.sqrt(0.5)  # from anywhere in a cell to its middle
        assert lengths[-1] <= way_over_cells(~occupied_cells(sim, w), *cells) + slack + 1e-9
    assert min(lengths) > 9.0 / 1.03
    assert max(lengths) <= 13.0 + 1e-6
    assert max(lengths) - min(lengths) > 1.0


def way_over_cells(free: Any, start: tuple[int, ...], goal: tuple[int, ...]) -> float:
    """Return the length of the shortest way from the middle of a cell to that of the next, in cells."""
    number = np.arange(free.size).reshape(free.shape)
    pairs = [(number[:-1], number[1:]), (number[:, :-1], number[:, 1:])]
    joined = [np.stack([a.ravel(), b.ravel()])[:, free.ravel()[a.ravel()] & free.ravel()[b.ravel()]] for a, b in pairs]
    rows, columns = np.concatenate(joined, axis=1)
    graph = sparse.coo_array((np.ones(len(rows)), (rows, columns)), shape=(free.size, free.size))
    return float(csgraph.shortest_path(graph, directed=False, indices=number[start])[number[goal]])


@pytest.mark.parametrize("placement", ["random", "cells"])
def test_ways_that_cannot_be_are_refused(placement: str) -> None:
    world = {"width": 5, "height": 5, "obstacle_map": {"name": "cells", "fill": [0, 0]}}
    robot = {"kinematics": {"name": "diff"}, "distribution": {"name": placement, "min_way_length": 20}}
    with pytest.raises(PlacementError, match="no place found for 'robot_0'"):
        ig.compile(ig.load_scenario({"world": world, "robot": robot})).reset(seed=0)
    crossed = {**robot, "distribution": {"name": placement, "min_way_length": 5, "max_way_length": 4}}
    with pytest.raises(ScenarioError, match=r"max_way_length.*must not be less than min_way_length, got 4 and 5"):
        ig.load_scenario({"world": world, "robot": crossed})


def test_rooms_are_chosen_by_their_areas() -> None:
    """Of two rooms of one cell, an undividable one of 98, and one of two, each gets its share of the draws."""
    rooms = np.array([[0, 1, 0, 1, 0], [1, 2, 0, 1, 0], [2, 9, 0, 14, 1], [9, 11, 0, 1, 0]])
    state = simulation("rooms").state
    counts = np.bincount([choose_room(rooms, 4, 0, state) for _ in range(4000)], minlength=4)
    assert counts[2] == 0
    assert np.abs(counts / 4000 - [0.25, 0.25, 0.0, 0.5]).max() < 0.04  # five standard deviations


@pytest.mark.parametrize("kind", KINDS)
def test_a_thread_draws_maps_in_its_own_scratch_memory(kind: str) -> None:
    sim = simulation(kind, 2, num_threads=2)
    (group,) = sim.parts.maps
    tables = [table for table in vars(group.tables).values() if isinstance(table, np.ndarray) and len(table) == 2]
    assert len(tables) >= 4
    for own, other in ((0, 1), (1, 0)):
        for table in tables:
            table[other] = 1
        group.kind.draw(group, sim.model, sim.state, Shard(np.array([0]), own))
        assert all((table[other] == 1).all() for table in tables)
