"""Every kind that runs keeps its family's promises; a new one is tested by being registered."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.base import families
from irsim_gym.base.options import option_fields
from irsim_gym.simulator.engine import Shard
from irsim_gym.simulator.engine.shielding import lay_shield
from irsim_gym.simulator.world.model import Model
from irsim_gym.simulator.world.state import State
from irsim_gym.tasks import Episodes, Outcome, load_task

families.load()
ROBOT: dict[str, Any] = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}}
GIVEN = {
    "polygon": {"vertices": [[0, 0], [0.6, 0], [0.3, 0.3], [0.6, 0.6], [0, 0.6]]},
    "linestring": {"vertices": [[0, 0], [0.5, 0.2], [0.5, 0.8]]},
    "image": {"path": "cavern.png"},
    "ros": {"path": str(Path(__file__).with_name("hall.yaml")), "unknown": "occupied"},
    "perlin": {"resolution": 0.25, "fill": 0.25},
    "cellular": {"resolution": 0.25},
    "array": {"cells": [[0, 0, 0], [0, 100, 0], [0, 0, 0], [0, 0, 100]]},
    "compound": {"parts": [{"name": "rectangle"}, {"name": "circle", "radius": 0.4, "pose": [0.5, 0, 0]}]},
}
OWNERS = {
    "kinematics": {"pose", "direction", "twist", "steering", "random"},
    "behavior": {"command", "random"},
    "group_behavior": {"command", "plan", "random"},
    "sensor": {"random"},
}


DISTURBED: dict[str, dict[str, Any]] = {
    "radius": {"offset": [-0.1, 0.1]},
    "lost_commands": {"chance": 0.3},
    "latency": {"time": [0.0, 0.3]},
    "drive_lag": {"tau": [0.0, 0.5], "dead_band": 0.01},
    "slip": {"ahead": [0.0, 0.2], "turn": [-0.2, 0.2]},
    "odometry": {"scale": [-0.1, 0.1], "yaw": 0.1, "fix": {"every": 0.5, "std": 0.1, "angle_std": 0.1}},
    "mount": {"x": [-0.1, 0.1], "y": 0.05, "turn": [-0.1, 0.1]},
    "glass": {"share": 1.0, "seen_within": 0.1},
    "range_bias": {"offset": [-0.1, 0.1], "scale": 0.02},
    "lost_beams": {"chance": [0.0, 0.5]},
    "blind_sector": {"width": [0.5, 2.0]},
    "scan_rate": {"every": [0.1, 0.4]},
}
"""Options with which disturbances show."""


SMALL = {
    "recorded": {"file": "square.txt"},
    "dwa": {"samples": [3, 5], "sim_granularity": 0.5, "path": "straight"},
    "hybrid_astar": {"cell": 2.0},
}
"""Options that behaviours need, or without which they would take long in plain Python."""


RANDOM = [entry.name for entry in families.FOOTPRINTS if "random_shape" in option_fields(entry.kind)]


def running(family: Any) -> list[str]:
    return list(family.names())


def simulation(data: dict[str, Any], n_worlds: int, num_threads: int = 1) -> ig.Simulation:
    sim = ig.compile(ig.load_scenario({"world": {"name": "kinds"}, **data}), n_worlds, num_threads=num_threads)
    sim.reset(seed=1)
    return sim


def drives(name: str) -> list[dict[str, Any]]:
    """Return a drive in each of its modes, with what it needs."""
    kind = families.KINEMATICS.entry(name).kind
    given = {"name": name, **({"wheelbase": 0.5} if getattr(kind, "needs_wheelbase", False) else {})}
    choices = {key: get_args(info.annotation) for key, info in option_fields(kind).items() if is_choice(info)}
    modes = [{**given, key: value} for key, values in choices.items() for value in values]
    return modes or [given]


def is_choice(info: Any) -> bool:
    return get_origin(info.annotation) is Literal


def scene(family: str, name: str) -> dict[str, Any]:
    """Return a small world in which one kind of a family is at work."""
    if family == "shape":
        return {"obstacle": {"shape": {"name": name, **GIVEN.get(name, {})}, "state": [4, 4, 0.3]}}
    if family == "random shape":
        shape = {"name": name, "random_shape": True}
        return {"obstacle": {"number": 3, "shape": shape, "distribution": {"name": "random", "min_distance": 0}}}
    if family == "obstacle map":
        world = {
            "name": "kinds",
            "obstacle_map": {"name": name, **GIVEN.get(name, {})},
            "mdownsample": 2,
            "fog_map": True,
        }
        there = {"name": "random", "reachable": True, "clearance": 0.05, "min_distance": 0}
        driver = {**ROBOT, "behavior": {"name": "dash"}, "sensors": [{"name": "lidar2d"}], "distribution": there}
        return {"world": world, "robot": {**driver, "number": 3}}
    if family == "distribution":
        world = {"name": "kinds", **({"obstacle_map": {"name": "cells"}} if name == "cells" else {})}
        entry = {**ROBOT, "number": 3, "distribution": {"name": name}} if name != "manual" else ROBOT
        return {"world": world, "robot": entry}
    robot = {**ROBOT, "state": [2, 2, 0.4], "goal": [7, 8, 0]}
    if family == "kinematics":
        has_noise = "noise" in option_fields(families.KINEMATICS.entry(name).kind)
        modes = [*drives(name), *({**mode, "noise": True} for mode in drives(name) if has_noise)]
        return {"robot": [{**item, "behavior": {"name": "dash"}} for item in row(robot, modes)]}
    if family in ("behavior", "group_behavior"):
        registry = families.BEHAVIORS if family == "behavior" else families.GROUP_BEHAVIORS
        kinds = getattr(registry.entry(name).kind, "kinematics", families.KINEMATICS.names())
        robots = row(robot, [mode for item in kinds for mode in drives(item)])
        given = {"group": 0, family: {"name": name, **SMALL.get(name, {})}}
        if name == "recorded":
            given |= {"vel_min": [-2, -2], "vel_max": [2, 2]}
        if getattr(registry.entry(name).kind, "reads_scan", False):
            given["sensors"] = [{"name": "lidar2d", "number": 9}]
        return {"robot": [{**item, **given} for item in robots]}
    disc = {"shape": {"name": "circle", "radius": 0.5}, "state": [5, 4, 0]}
    if family == "disturbance":
        given = {"behavior": {"name": "dash"}, "sensors": [{"name": "lidar2d"}]}
        robots = row({**robot, **given}, [mode for item in families.KINEMATICS.names() for mode in drives(item)])
        disturbed = [{"name": name, **DISTURBED.get(name, {})}]
        return {"robot": [{**item, "disturbances": disturbed} for item in robots], "obstacle": disc}
    return {"robot": {**robot, "behavior": {"name": "dash"}, "sensors": [{"name": name}]}, "obstacle": disc}


def row(robot: dict[str, Any], kinematics: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the robot once for each drive, side by side."""
    return [{**robot, "state": [2, 1 + i, 0.4], "kinematics": item} for i, item in enumerate(kinematics)]


CASES = [
    *[("shape", name) for name in running(families.FOOTPRINTS)],
    *[("random shape", name) for name in RANDOM],
    *[("distribution", name) for name in running(families.PLACEMENTS)],
    *[("kinematics", name) for name in running(families.KINEMATICS)],
    *[("behavior", name) for name in running(families.BEHAVIORS)],
    *[("group_behavior", name) for name in running(families.GROUP_BEHAVIORS)],
    *[("sensor", name) for name in running(families.SENSORS)],
    *[("obstacle map", name) for name in running(families.MAPS)],
    *[("disturbance", name) for name in running(families.DISTURBANCES)],
]


def snapshot(sim: ig.Simulation, w: int) -> dict[str, np.ndarray]:
    fields = {name: getattr(sim.state, name)[w].copy() for name in State.columns()}
    for index, group in enumerate(sim.sensors):
        fields[f"reading {index}"] = group.arrays[group.kind.reading][w].copy()
    if sim.told is not sim.state:
        fields["told pose"] = sim.told.pose[w].copy()
    if sim.explored is not None:
        fields["explored"] = sim.explored[w].copy()
    return fields


@pytest.mark.parametrize(("family", "name"), CASES)
def test_single_batch_and_shards_agree_and_stay_finite(family: str, name: str) -> None:
    batch, sharded = simulation(scene(family, name), 4), simulation(scene(family, name), 4, num_threads=3)
    single, plain = ig.compile(batch.scenario, 1), ig.compile(batch.scenario, 1, fused=False)
    for sim in (single, plain):
        sim.reset(seed=1 + 2)
    for _ in range(12):
        for sim in (batch, sharded, single, plain):
            sim.step()
    for field, value in snapshot(single, 0).items():
        np.testing.assert_array_equal(value, snapshot(batch, 2)[field], err_msg=field)
        np.testing.assert_array_equal(value, snapshot(sharded, 2)[field], err_msg=field)
        np.testing.assert_array_equal(value, snapshot(plain, 0)[field], err_msg=field)
        if value.dtype.kind == "f" and field != "goal":
            assert np.isfinite(value).all(), field


@pytest.mark.parametrize(("family", "name"), [case for case in CASES if case[0] in OWNERS])
def test_a_kind_writes_only_what_it_owns(family: str, name: str) -> None:
    sim = simulation(scene(family, name), 2)
    for _ in range(3):
        sim.step()
    groups = {
        "kinematics": sim.parts.kinematics,
        "behavior": sim.parts.behaviors,
        "group_behavior": sim.parts.group_behaviors,
        "sensor": sim.sensors,
    }[family]
    work = {"kinematics": "move", "sensor": "sense"}.get(family, "decide")
    constants = {field: getattr(sim.model, field).copy() for field in Model.columns()}
    before = [snapshot(sim, w) for w in range(2)]
    for group in groups:
        getattr(group.kind, work)(group, sim.model, sim.state, Shard(np.array([1])))
    after = [snapshot(sim, w) for w in range(2)]
    for field in before[0]:
        np.testing.assert_array_equal(before[0][field], after[0][field], err_msg=f"{field} of another world")
        if field not in OWNERS[family] and not field.startswith("reading"):
            np.testing.assert_array_equal(before[1][field], after[1][field], err_msg=field)
    for field, value in constants.items():
        np.testing.assert_array_equal(value, getattr(sim.model, field), err_msg=field)


@pytest.mark.parametrize("name", running(families.DISTURBANCES))
def test_a_disturbance_shows_and_spares_the_robots_that_have_none(name: str) -> None:
    data = scene("disturbance", name)
    plain = {**data, "robot": [{**robot, "disturbances": []} for robot in data["robot"]]}
    first = data["robot"][0]
    # Only the first robot is disturbed, and bodies do not meet: the others do as they would without it.
    sims = [simulation(one, 8) for one in (plain, {**data, "robot": [first, *plain["robot"][1:]]})]
    for _ in range(8):
        for sim in sims:
            sim.step()
    found = [{**snapshot(sim, w), "told pose": sim.told.pose[w].copy()} for w in range(8) for sim in sims]
    changed = set()
    for one, other in zip(found[::2], found[1::2], strict=True):
        for field in ("pose", "velocity", "command", "told pose", "discs"):
            np.testing.assert_array_equal(one[field][1:], other[field][1:], err_msg=field)
            changed |= {field} if np.any(one[field][0] != other[field][0]) else set()
        changed |= {"reading"} if np.any(one["reading 0"][0] != other["reading 0"][0]) else set()
    assert changed
    assert "command" not in changed or "pose" in changed


@pytest.mark.parametrize("drive", drives("diff") + drives("omni") + drives("omni_angular") + drives("acker"), ids=str)
@pytest.mark.parametrize("name", running(families.SHIELDS))
def test_a_shield_is_alike_in_batch_single_and_shards_and_writes_commands_alone(
    name: str, drive: dict[str, Any]
) -> None:
    sensors = [{"name": "lidar2d", "number": 61, "angle_range": "2 * pi"}]
    disc = {"shape": {"name": "circle", "radius": 0.5}, "state": [5, 4, 0]}
    robot = {**ROBOT, "kinematics": drive, "state": [4.2, 4, 0.0], "goal": [7, 8, 0], "sensors": sensors}
    loaded = ig.load_scenario({"world": {"name": "kinds"}, "robot": robot, "obstacle": disc}, {"shield": name})
    task = load_task(loaded)
    played = [
        Episodes(ig.compile(loaded, n, agents=task.agents, num_threads=threads), task)
        for n, threads in ((4, 1), (4, 3), (1, 1))
    ]
    for one, levels in zip(played, (range(4), range(4), (2,)), strict=True):
        one.begin(np.arange(len(levels)), np.array(levels), "test")
    rng = np.random.default_rng(0)
    for _ in range(12):
        actions = rng.uniform(-1.0, 1.0, (4, 1, int(played[0].action_sizes[0])))
        actions[:, :, 0] = 1.0
        for one in played:
            one.step(actions if one.n_worlds == 4 else actions[[2]])
        for field in ("pose", "velocity", "command"):
            values = [getattr(one.simulation.state, field) for one in played]
            np.testing.assert_array_equal(values[0], values[1], err_msg=field)
            np.testing.assert_array_equal(values[0][2], values[2][0], err_msg=field)
            assert np.isfinite(values[0]).all()
    assert played[0].state.extra[:, 0, 0].min() > 0
    assert not np.any(played[0].state.outcome == Outcome.COLLISION)
    sim = played[0].simulation
    sim.state.command[:, 0, 0] = sim.model.velocity_max[0, 0, 0]
    before, constants = [snapshot(sim, w) for w in range(2)], {f: getattr(sim.model, f).copy() for f in Model.columns()}
    lay_shield(sim, task.shield, np.array(task.agents)).act(sim, Shard(np.array([1])))
    for w, fields in enumerate(before):
        for field, value in snapshot(sim, w).items():
            if (w, field) != (1, "command"):
                np.testing.assert_array_equal(value, fields[field], err_msg=field)
    for field, value in constants.items():
        np.testing.assert_array_equal(value, getattr(sim.model, field), err_msg=field)


@pytest.mark.parametrize("name", running(families.SENSORS))
def test_readings_have_the_declared_axes(name: str) -> None:
    sim = simulation(scene("sensor", name), 5)
    for group in sim.sensors:
        assert group.arrays[group.kind.reading].shape[:2] == (5, len(group.members))


def rollouts() -> dict[str, np.ndarray]:
    """Return poses, twists and steering angles of a short run of each drive and behaviour."""
    found = {}
    for family, name in CASES:
        if family in ("kinematics", "behavior", "group_behavior", "disturbance"):
            sim = simulation(scene(family, name), 2)
            rows = []
            for _ in range(20 if family in ("kinematics", "disturbance") else 3):
                sim.step()
                told = [sim.told.pose] if family == "disturbance" else []
                rows.append(np.dstack([sim.state.pose, sim.state.twist, sim.state.steering[..., None], *told]))
            found[f"{family} {name}"] = np.array(rows)
    return found


def test_compiled_kernels_do_what_plain_python_does(tmp_path: Path) -> None:
    file = tmp_path / "plain.npz"
    plain = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    subprocess.run([sys.executable, __file__, str(file)], env=plain, check=True, timeout=120)
    expected = np.load(file)
    for case, found in rollouts().items():
        np.testing.assert_allclose(found, expected[case], rtol=0, atol=1e-12, err_msg=case)


if __name__ == "__main__":
    np.savez(sys.argv[1], **rollouts())
