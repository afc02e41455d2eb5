"""Every kind that runs keeps its family's promises; a new one is tested by being registered."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym import families
from irsim_gym.engine import Shard
from irsim_gym.scenario.validation import option_fields
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState

families.load()
ROBOT: dict[str, Any] = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}}
GIVEN = {
    "polygon": {"vertices": [[0, 0], [0.6, 0], [0.3, 0.3], [0.6, 0.6], [0, 0.6]]},
    "linestring": {"vertices": [[0, 0], [0.5, 0.2], [0.5, 0.8]]},
    "compound": {"parts": [{"name": "rectangle"}, {"name": "circle", "radius": 0.4, "pose": [0.5, 0, 0]}]},
}
OWNERS = {
    "kinematics": {"pose", "twist", "steering", "random"},
    "behavior": {"command"},
    "sensor": set(),
}


RANDOM = [entry.name for entry in families.FOOTPRINTS if "random_shape" in option_fields(entry.kind)]


def running(family: Any) -> list[str]:
    return list(family.names())


def simulation(data: dict[str, Any], n_worlds: int, num_threads: int = 1) -> ig.Simulation:
    sim = ig.compile(ig.load_scenario({"world": {"name": "kinds"}, **data}), n_worlds, num_threads=num_threads)
    sim.reset(seed=1)
    return sim


def drive(name: str) -> dict[str, Any]:
    """Return the drive with what it needs."""
    needs_wheelbase = getattr(families.KINEMATICS.entry(name).kind, "needs_wheelbase", False)
    return {"name": name, "wheelbase": 0.5} if needs_wheelbase else {"name": name}


def scene(family: str, name: str) -> dict[str, Any]:
    """Return a small world in which one kind of a family is at work."""
    if family == "shape":
        return {"obstacle": {"shape": {"name": name, **GIVEN.get(name, {})}, "state": [4, 4, 0.3]}}
    if family == "random shape":
        shape = {"name": name, "random_shape": True}
        return {"obstacle": {"number": 3, "shape": shape, "distribution": {"name": "random", "min_distance": 0}}}
    if family == "distribution":
        return (
            {"robot": {**ROBOT, "number": 3, "distribution": {"name": name}}} if name != "manual" else {"robot": ROBOT}
        )
    robot = {**ROBOT, "state": [2, 2, 0.4], "goal": [7, 8, 0]}
    if family == "kinematics":
        drives = [drive(name), {**drive(name), "noise": True}]
        return {"robot": [{**robot, "kinematics": item, "behavior": {"name": "dash"}} for item in drives]}
    if family == "behavior":
        kind = families.BEHAVIORS.entry(name).kind
        drives = [drive(item) for item in getattr(kind, "kinematics", families.KINEMATICS.names())]
        robots = [{**robot, "state": [2, 2 + i, 0.4], "kinematics": item} for i, item in enumerate(drives)]
        return {"robot": [{**item, "behavior": {"name": name}} for item in robots]}
    disc = {"shape": {"name": "circle", "radius": 0.5}, "state": [5, 4, 0]}
    return {"robot": {**robot, "behavior": {"name": "dash"}, "sensors": [{"name": name}]}, "obstacle": disc}


CASES = [
    *[("shape", name) for name in running(families.FOOTPRINTS)],
    *[("random shape", name) for name in RANDOM],
    *[("distribution", name) for name in running(families.PLACEMENTS)],
    *[("kinematics", name) for name in running(families.KINEMATICS)],
    *[("behavior", name) for name in running(families.BEHAVIORS)],
    *[("sensor", name) for name in running(families.SENSORS)],
]


def snapshot(sim: ig.Simulation, w: int) -> dict[str, np.ndarray]:
    fields = {name: getattr(sim.state, name)[w].copy() for name in WorldState.columns()}
    for index, group in enumerate(sim.sensors):
        fields[f"reading {index}"] = group.arrays[group.kind.reading][w].copy()
    return fields


@pytest.mark.parametrize(("family", "name"), CASES)
def test_single_batch_and_shards_agree_and_stay_finite(family: str, name: str) -> None:
    batch, sharded = simulation(scene(family, name), 4), simulation(scene(family, name), 4, num_threads=3)
    single = ig.compile(batch.scenario, 1)
    single.reset(seed=1 + 2)
    for _ in range(12):
        for sim in (batch, sharded, single):
            sim.step()
    for field, value in snapshot(single, 0).items():
        np.testing.assert_array_equal(value, snapshot(batch, 2)[field], err_msg=field)
        np.testing.assert_array_equal(value, snapshot(sharded, 2)[field], err_msg=field)
        if value.dtype.kind == "f" and field != "goal":
            assert np.isfinite(value).all(), field


@pytest.mark.parametrize(("family", "name"), [case for case in CASES if case[0] in OWNERS])
def test_a_kind_writes_only_what_it_owns(family: str, name: str) -> None:
    sim = simulation(scene(family, name), 2)
    for _ in range(3):
        sim.step()
    groups = {"kinematics": sim.parts.kinematics, "behavior": sim.parts.behaviors, "sensor": sim.sensors}[family]
    work = {"kinematics": "move", "behavior": "decide", "sensor": "sense"}[family]
    constants = {field: getattr(sim.model, field).copy() for field in WorldModel.columns()}
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


@pytest.mark.parametrize("name", running(families.SENSORS))
def test_readings_have_the_declared_axes(name: str) -> None:
    sim = simulation(scene("sensor", name), 5)
    for group in sim.sensors:
        assert group.arrays[group.kind.reading].shape[:2] == (5, len(group.members))
