"""Scans, velocities and fields of view in random scenes, beside ir-sim 2.12.0."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ir_sim_peer import ir_sim_world

import irsim_gym as ig
from irsim_gym.envs.described.moment import BodyMoment

STEPS = 4
SENSORS: list[dict[str, Any]] = [
    {"name": "lidar2d", "number": 181, "angle_range": 6.2831853, "range_max": 6, "has_velocity": True},
    {"type": "fmcw_lidar2d", "number": 90, "angle_range": 3.0, "range_max": 5, "range_min": 1.5},
    {"name": "lidar2d", "number": 1, "offset": [0.0, 0.1, 0.7]},
    {"name": "fmcw_lidar2d", "number": 60, "angle_range": 7.5, "offset": [0.1, -0.05, 0.3], "motion_compensate": True},
    {"number": 40, "angle_range": 4, "range_min": 2, "range_max": 4, "offset": [-0.1, 0, -2], "has_velocity": True},
]
SHAPES: list[dict[str, Any]] = [
    {"name": "rectangle", "length": 1.2, "width": 0.4},
    {"name": "polygon", "vertices": [[0, 0], [1, 0], [0.3, 0.3], [0.2, 0.9]]},
    {"name": "linestring", "vertices": [[0, 0], [0.8, 0.3], [1.2, -0.4]]},
]
DIFF = {"kinematics": {"name": "diff"}}


def scene(seed: int, shapes: list[dict[str, Any]]) -> dict[str, Any]:
    """Return a robot with several sensors among moving and standing bodies; it may begin inside one."""
    random = np.random.default_rng(seed)

    def place() -> list[float]:
        return [*random.uniform(0.5, 9.5, 2).tolist(), float(random.uniform(-3, 3))]

    moving = {**DIFF, "behavior": {"name": "dash"}}
    obstacles = [
        {"shape": shapes[i % len(shapes)], "state": place(), "goal": place(), **(moving if i % 2 else DIFF)}
        for i in range(11)
    ]
    robot = {**moving, "shape": {"name": "circle", "radius": 0.2}, "state": place(), "goal": place()}
    return {
        "world": {"width": 10, "height": 10, "collision_mode": "unobstructed"},
        "robot": [{**robot, "sensors": SENSORS}],
        "obstacle": obstacles,
    }


def both(data: dict[str, Any], folder: Path) -> list[tuple[dict[str, Any], dict[str, Any], Any, Any]]:
    """Return the reports and points of all sensors after some steps: ours, theirs."""
    sim = ig.compile(ig.load_scenario(data, warn=False))
    sim.reset()
    with ir_sim_world(data, folder) as world:
        for _ in range(STEPS):
            world.step()
            sim.step()
        sensors = world.robot.sensors
        theirs = [(sensor.get_scan(), sensor.get_points()) for sensor in sensors]
    ours = [(BodyMoment(sim, 0).scan(i), BodyMoment(sim, 0).scan_points(i)) for i in range(len(sensors))]
    return [(mine[0], other[0], mine[1], other[1]) for mine, other in zip(ours, theirs, strict=True)]


def test_ranges_validity_and_velocities_agree(tmp_path: Path) -> None:
    apart, n_beams, n_moving, n_cut = 0, 0, 0, 0
    for seed in range(12):
        for ours, theirs, points, their_points in both(scene(seed, SHAPES), tmp_path):
            assert list(ours) == list(theirs)
            for key in set(ours) - {"ranges", "velocity", "radial_velocity", "valid"}:
                assert ours[key] == pytest.approx(theirs[key]), key
            same = np.abs(ours["ranges"] - theirs["ranges"]) <= 1e-4
            apart, n_beams = apart + int((~same).sum()), n_beams + len(same)
            assert (ours["valid"] == theirs["valid"])[same].all()
            for key in {"velocity", "radial_velocity"} & set(ours):
                np.testing.assert_allclose(ours[key][..., same], theirs[key][..., same], rtol=0.0, atol=1e-7)
                n_moving += int((np.abs(ours[key]) > 0.01).sum())
            n_cut += int((ours["ranges"] == ours["range_min"]).sum())
            if same.all():
                assert (points is None) == (their_points is None)
                assert points is None or np.abs(points - their_points).max() <= 1e-4
    assert apart <= 0.001 * n_beams
    assert n_moving > 300
    assert n_cut > 50


def test_ranges_to_discs_agree_within_the_depth_of_a_64_gon(tmp_path: Path) -> None:
    radius, n_discs = 0.8, 0
    data = scene(1, [{"name": "circle", "radius": radius}])
    data["robot"][0]["sensors"] = [{"number": 720, "angle_range": 2 * np.pi, "has_velocity": True}]
    sim = ig.compile(ig.load_scenario(data, warn=False))
    sim.reset()
    with ir_sim_world(data, tmp_path) as world:
        theirs = world.robot.lidar.get_scan()["ranges"]
    ours, table = BodyMoment(sim, 0, 0).scan()["ranges"], sim.sensors[0].arrays
    x, y, heading = sim.state.pose[0, 0]
    for beam, b in enumerate(table["hit"][0, 0]):
        if b < 0:
            assert ours[beam] == theirs[beam]
            continue
        dx, dy = sim.state.pose[0, b, :2] - [x, y]
        angle = heading + table["angles"][beam]
        aside = abs(dx * np.sin(angle) - dy * np.cos(angle)) / radius
        if aside < 0.99:
            # The gap between polygon and disc is crossed aslant, so it is longer along the beam.
            slant = np.sqrt(1.0 - aside * aside)
            assert (ours[beam] - theirs[beam]) * slant == pytest.approx(0.0, abs=0.0013 * radius + 1e-4)
            n_discs += 1
    assert n_discs > 200


def test_fields_of_view_agree_but_for_wide_bodies(tmp_path: Path) -> None:
    n_seen = 0
    for seed in range(5):
        data = scene(seed, [*SHAPES, {"name": "circle", "radius": 0.4}])
        data["robot"][0] |= {"fov": 2.0, "fov_radius": 4.0}
        sim = ig.compile(ig.load_scenario(data, warn=False))
        sim.reset()
        found = sim.detected(0)[0]
        with ir_sim_world(data, tmp_path) as world:
            eye = world.robot
            x, y, heading = eye.state[:3, 0]
            for b, other in enumerate(world.objects[1:], start=1):
                away = other.state[:2, 0] - [x, y]
                bearing = abs((np.arctan2(away[1], away[0]) - heading + np.pi) % (2 * np.pi) - np.pi)
                covered = np.arcsin(min(other.radius / np.hypot(*away), 1.0)) - bearing > 1.0
                # IR-SIM overlooks what covers the whole sector (D40).
                assert found[b] == (eye.fov_detect_object(other) or (covered and bool(found[b])))
                n_seen += int(found[b])
    assert 5 < n_seen < 40
