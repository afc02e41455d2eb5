"""The same worlds in IR-SIM: what the lidar sees, who touches the map, what is explored."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import irsim
import numpy as np
import pytest
import shapely
import yaml

import irsim_gym as ig
from irsim_gym.simulator.step.step import refresh
from tests.simulator.geometry.cell_maps import area

WORLD = {"width": 9, "height": 6, "offset": [2, -1], "collision_mode": "unobstructed"}
LIDAR = {"name": "lidar2d", "number": 91, "angle_range": 6.0, "range_max": 4, "offset": [0.1, 0.05, 0.3]}
SHAPES = {
    "circle": {"name": "circle", "radius": 0.3},
    "rectangle": {"name": "rectangle", "length": 0.7, "width": 0.4},
    "line": {"name": "linestring", "vertices": [[-0.4, 0], [0.2, 0.3], [0.5, 0]]},
}


def both(folder: Path, world: dict[str, Any], robot: dict[str, Any]) -> tuple[Any, Any]:
    """Return the world in IR-SIM and here."""
    robot = {"kinematics": {"name": "diff"}, "state": [2.5, -0.5, 0], "goal": [5, 5, 0], **robot}
    file = folder / "world.yaml"
    file.write_text(yaml.safe_dump({"world": {**WORLD, **world}, "robot": [robot]}))
    sim = ig.compile(ig.load_scenario(file), agents=(0,))
    sim.reset(seed=0)
    return irsim.make(str(file), headless=True, log_level="ERROR"), sim


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("shape", SHAPES)
def test_scans_and_contacts(tmp_path: Path, seed: int, shape: str) -> None:
    """Random maps of oblong cells and random poses.

    Named: a body with all of its outline in an occupied block is in contact here (IR-SIM has holes there), and
    IR-SIM reports contacts with cells that only the upright box around the body overlaps.
    """
    spec = {"name": "perlin", "resolution": 0.25, "complexity": 0.3, "fill": 0.25, "seed": seed}
    world = {"obstacle_map": spec, "mdownsample": 1 + seed % 2}
    start = {"state": [-50, -50, 0], "shape": SHAPES[shape], "sensors": [LIDAR]}
    there, here = both(tmp_path, world, start)
    occupied = area(here.scenario.occupied, *here.model.map_frame.item()[:4])
    rng, grazing, phantom, holes, contacts = np.random.default_rng(seed), 0, 0, 0, 0
    poses = rng.uniform([2, -1, -3], [11, 5, 3], (150, 3))
    for pose in poses:
        there.robot.set_state(pose.tolist())
        there.refresh()
        here.state.pose[0, 0] = pose
        here.run(lambda shard: refresh(here.parts, here.model, here.state, shard))
        touching = bool(here.state.collided[0, 0])
        contacts += touching
        if touching != there.robot.collision_flag:
            true = there.robot.geometry.intersects(occupied)
            holes += touching and true
            phantom += not touching and not true
            assert touching == true
        expected, found = there.get_lidar_scan()["ranges"], here.scan(0)[0].arrays["ranges"][0, 0]
        grazing += int(np.sum(np.abs(found - expected) > 1e-4))
    assert 30 < contacts < 140
    assert grazing <= 0.001 * len(poses) * LIDAR["number"]
    assert holes + phantom < 0.1 * len(poses)
    there.end()


@pytest.mark.parametrize("resolution", [None, 0.3])
def test_what_is_explored(tmp_path: Path, resolution: float | None) -> None:
    spec = {"name": "perlin", "resolution": 0.2, "complexity": 0.3, "fill": 0.2, "seed": 4}
    fog = {"fog_map": True, **({"fog_map_resolution": resolution} if resolution else {})}
    robot = {"state": [1.0, 2.1, 0.3], "shape": SHAPES["circle"], "sensors": [LIDAR]}
    there, here = both(tmp_path, {"obstacle_map": spec, **fog}, robot)
    occupied = area(here.scenario.occupied, *here.model.map_frame.item()[:4])
    assert not here.explored.any()
    for _ in range(15):
        there.step(np.array([[1.0], [0.4]]))
        here.step([1.0, 0.4])
        expected = there._world.fog_map.explored
        assert here.explored.shape == (1, *expected.shape)
        assert np.sum(expected & ~here.explored[0]) <= 2
        # At the end of a beam rounding decides in IR-SIM whether the wall counts; here it does.
        for i, j in np.argwhere(here.explored[0] & ~expected):
            cells = here.parts.fog.cells
            x, y = cells.x + (i + 0.5) * cells.width, cells.y + (j + 0.5) * cells.height
            assert occupied.distance(shapely.Point(x, y)) < 0.5 * np.hypot(cells.width, cells.height) + 1e-3
    assert 0.05 < here.explored.mean() < 0.9
    here.reset(seed=0)
    assert not here.explored.any()
    there.end()


def test_what_a_field_of_view_explores(tmp_path: Path) -> None:
    for fov in (1.0, 4.0, 2.0 * np.pi):
        robot = {"shape": SHAPES["circle"], "state": [4.03, 1.02, 0.5], "fov": fov, "fov_radius": 2.5}
        there, here = both(tmp_path, {"fog_map": True}, robot)
        there.step(np.array([[0.0], [0.0]]))
        here.step([0.0, 0.0])
        assert np.array_equal(here.explored[0], there._world.fog_map.explored)
        assert here.explored.any()
        there.end()
