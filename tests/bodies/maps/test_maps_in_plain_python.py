"""Compiled kernels of maps do what they do as plain Python."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

import irsim_gym as ig
from irsim_gym.simulator.cell_paths.queries import free_path_length, has_free_path

CELLS = [[0, 0, 0, 0], [0, 100, 0, 0], [0, 0, 0, 100], [0, 100, 0, 0], [0, 0, 0, 0]]
LIDAR = {"name": "lidar2d", "number": 24, "angle_range": 6.0}


def rollout() -> dict[str, Any]:
    """Return what some robots see, touch and explore on their ways through a small map."""
    robot = {"kinematics": {"name": "diff"}, "behavior": {"name": "dash"}, "sensors": [LIDAR]}
    shapes = [{"name": "circle"}, {"name": "rectangle", "length": 0.5, "width": 0.3}]
    robots = [{**robot, "shape": shape, "state": [1, 1 + k, 0], "goal": [9, 9, 0]} for k, shape in enumerate(shapes)]
    world = {"obstacle_map": CELLS, "fog_map": True, "fog_map_resolution": 0.5}
    sim = ig.compile(ig.load_scenario({"world": world, "robot": robots}))
    sim.reset(seed=0)
    rows: dict[str, list[Any]] = {"ranges": [], "pose": [], "hit": [], "clearance": []}
    group, _ = sim.scan(0) or (None, 0)
    assert group is not None
    distance = np.zeros((1, 2))
    for _ in range(30):
        sim.step()
        sim.run(lambda shard: sim.clearance(shard, np.array([0, 1]), distance))
        for key, value in zip(rows, (group.arrays["ranges"], sim.state.pose, sim.state.hit, distance), strict=True):
            rows[key].append(value.copy())
    way = sim.model, sim.state, 0, 0.3, (1.0, 5.0), (9.0, 9.5)
    nobody = np.zeros(3, np.bool_)
    length = free_path_length(*way, blocks=nobody, cell=0.5)
    found = {"explored": sim.explored, "way": [has_free_path(*way, blocks=nobody, cell=0.5), length]}
    return {**{key: np.array(value) for key, value in rows.items()}, **found}


def test_compiled_maps_do_what_plain_python_does(tmp_path: Path) -> None:
    file = tmp_path / "plain.npz"
    plain = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    subprocess.run([sys.executable, __file__, str(file)], env=plain, check=True, timeout=120)
    expected, found = np.load(file), rollout()
    assert (found["hit"] >= 0).any()
    assert np.isfinite(found["way"]).all()
    for key, value in found.items():
        np.testing.assert_allclose(value, expected[key], rtol=0, atol=1e-5 if key == "ranges" else 1e-12, err_msg=key)


if __name__ == "__main__":
    np.savez(sys.argv[1], **rollout())
