"""Maps that each level draws anew: what is drawn, and that each world has its own."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely
from scipy import ndimage

import irsim_gym as ig
from irsim_gym.errors import ScenarioError
from irsim_gym.world.state import WorldState
from tests.geometry.cell_maps import area, cell_map

LIDAR = {"name": "lidar2d", "number": 40, "angle_range": "2 * pi", "range_max": 6}
SQUARE = {"name": "rectangle", "length": 0.5, "width": 0.5}
ROBOT = {"kinematics": {"name": "diff"}, "shape": SQUARE, "distribution": {"name": "cells"}, "sensors": [LIDAR]}
DISC = {"kinematics": {"name": "diff"}, "behavior": {"name": "dash"}, "distribution": {"name": "random"}}
KINDS: dict[str, dict[str, Any]] = {"cells": {"name": "cells", "resolution": 1.0}}
MAPS = ("squares", "boxes", "n_boxes", "room")


def simulation(kind: str = "cells", n_worlds: int = 1, seed: int = 0, **options: Any) -> Any:
    world = {"name": "levels", "width": 11, "height": 11, "offset": [-1, 2], "obstacle_map": KINDS[kind]}
    data = {"world": world, "robot": [ROBOT], "obstacle": [DISC]}
    sim = ig.compile(ig.load_scenario(data), n_worlds, agents=(0,), **options)
    sim.reset(seed=seed)
    return sim


def occupied_cells(sim: Any, w: int = 0) -> Any:
    return sim.model.map_squares[w, 0] == 0


def everything(sim: Any) -> dict[str, Any]:
    """Return all that differs between worlds: the moment, the maps and the scans."""
    found = {name: getattr(sim.state, name) for name in WorldState.columns() if name not in ("nearby", "bucket_first")}
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
        expected, cells = cell_map(occupied, *frame), sim.model.cells
        for name in ("squares", "room"):
            np.testing.assert_array_equal(getattr(cells, name)[w], getattr(expected, name))
        n = int(cells.n_boxes[w])
        np.testing.assert_array_equal(cells.boxes[w, :n], expected.boxes[:n])
        x, y, heading = sim.state.pose[w, 0]
        other = shapely.Point(sim.state.pose[w, 1, :2]).buffer(0.2, quad_segs=256)
        seen = shapely.union(area(occupied, *frame), other)
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
    ("world", "robot", "said"),
    [
        ({"fill": [0.5, 0.2]}, ROBOT, "fill.*low <= high"),
        ({"fill": [0.0, 1.2]}, ROBOT, "fill.*between 0 and 1"),
        ({"resolution": 0.01}, ROBOT, "resolution.*1100 x 1100 cells, at most 65536"),
        ({"resolution": 6}, ROBOT, "resolution.*2 x 2 cells, of which the border leaves none free"),
        ({"resolution": 0.5}, ROBOT, "distribution.*a cell is 0.5 m wide, they reach 0.353"),
    ],
)
def test_what_cannot_be_is_refused(world: dict[str, Any], robot: dict[str, Any], said: str) -> None:
    with pytest.raises(ScenarioError, match=said):
        ig.compile(
            ig.load_scenario(
                {"world": {"width": 11, "height": 11, "obstacle_map": {"name": "cells", **world}}, "robot": robot}
            )
        )
