"""One scenario with every feature of the language: a batch equals single worlds, shards equal the whole."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest
import yaml

import irsim_gym as ig
from irsim_gym.scenario import Scenario
from irsim_gym.simulator.world.state import State

STEPS = 25

EVERYTHING = """
world:
  name: everything
  width: 24
  height: 24
  offset: [-2, 1]
  step_time: 0.1
  collision_mode: unobstructed_obstacles
  collision_check: swept
  obstacle_map: {name: perlin, resolution: 0.5, fill: 0.06, seed: 4}
  fog_map: true
robot:
  - number: 3
    kinematics: {name: diff, noise: true}
    distribution: {name: random, reachable: true, goals: 2}
    behavior: {name: rvo, mode: hrvo, neighbor_threshold: 5}
    acce: [2, 3]
    sensors:
      - {name: lidar2d, number: 32, angle_range: 2 * pi, range_max: 6, noise: true, std: 0.05, has_velocity: true}
      - {name: fmcw_lidar2d, number: 9, range_min: 0.3, offset: [0.1, 0, 0.2], noise: true}
  - number_range: [1, 3]
    kinematics: {name: omni, noise: true, alpha: [0.01, 0.02]}
    shape: {name: rectangle, length: 0.5, width: 0.3}
    distribution: {name: random}
    group_behavior: {name: orca, neighborDist: 6, sidestep: true}
    arrive_mode: state
  - number: 2
    kinematics: {name: omni, frame: body}
    distribution: {name: random}
    behavior: {name: sfm, target_roles: all}
    fov: 1.5
    fov_radius: 4
  - number: 2
    kinematics: {name: omni}
    distribution: {name: random}
    group_behavior: {name: sfm, social_groups: [[0, 1]]}
  - kinematics: {name: acker, mode: angular, noise: true}
    shape: {name: rectangle, length: 0.8, width: 0.4, wheelbase: 0.5}
    state: [20, 3, 1.5, 0.1]
    goal: [[[20, 10, 0], [18, 15, 1]]]
    behavior: {name: dash, loop: true}
    velocity: [0.3, 0]
  - kinematics: {name: omni_angular, noise: true}
    distribution: {name: random}
    behavior: {name: dash, wander: true, range_low: [0, 2, -3], range_high: [20, 22, 3]}
obstacle:
  - number: 3
    kinematics: {name: diff}
    shape: {name: circle, random_shape: true, radius_range: [0.2, 0.6]}
    distribution: {name: random}
    speed_range: [0.4, 1.2]
    unyielding: 0.4
    party: 2
    seen_by: [robot_0, obstacle]
    behavior:
      name: rvo
      wander: true
      range_low: [0, 2, -3]
      range_high: [20, 22, 3]
      wander_goals: {keep_first: true, radius: 8, jitter: 1, interval: 0.5, chance: 0.5, patience: 0.5}
  - number: 2
    kinematics: {name: omni}
    vel_min: [-2, -2]
    vel_max: [2, 2]
    behavior: {name: recorded, file: square.txt, start_time: 1}
  - {number: 2, shape: {name: polygon, random_shape: true, is_convex: true}, distribution: {name: random}}
  - {shape: {name: linestring, random_shape: true}, distribution: {name: random}, unobstructed: true}
  - shape: {name: compound, parts: [{name: circle, radius: 0.4}, {name: rectangle, length: 1.5, width: 0.2}]}
    distribution: {name: random}
"""


def everything() -> Scenario:
    return ig.load_scenario(yaml.safe_load(EVERYTHING))


def rollout(n_worlds: int, seed: int, num_threads: int = 1) -> ig.Simulation:
    sim = ig.compile(everything(), n_worlds, num_threads=num_threads)
    sim.reset(seed=seed)
    for _ in range(STEPS):
        sim.step()
    return sim


def moment(sim: ig.Simulation, w: int) -> dict[str, Any]:
    """Return all that world w holds."""
    found = {name: getattr(sim.state, name)[w] for name in State.columns()}
    for index, group in enumerate(sim.sensors):
        for name in ("ranges", "velocity", "radial_velocity"):
            if name in group.arrays:
                found[f"{name} {index}"] = group.arrays[name][w]
    return {**found, "explored": sim.explored[w]}


def assert_same(one: ig.Simulation, w: int, other: ig.Simulation, v: int) -> None:
    others = moment(other, v)
    for name, value in moment(one, w).items():
        np.testing.assert_array_equal(value, others[name], err_msg=name)


@pytest.fixture(scope="module")
def batch() -> ig.Simulation:
    return rollout(4, seed=2)


def test_everything_moves_and_stays_finite(batch: ig.Simulation) -> None:
    movers = batch.parts.movers
    here = batch.model.present[:, movers]
    moved = np.hypot(*(batch.state.pose - batch.model.start)[:, movers, :2].transpose(2, 0, 1))
    assert (moved.max(axis=0) > 0.05)[here.any(axis=0)].all()
    assert not here.all()
    assert np.isfinite(batch.state.pose).all()
    assert np.isfinite(batch.state.velocity).all()
    assert batch.explored.any()
    assert (batch.sensors[0].arrays["ranges"] < 6).any()


def test_a_world_of_a_batch_is_a_single_world(batch: ig.Simulation) -> None:
    for w in (0, 3):
        assert_same(batch, w, rollout(1, seed=2 + w), 0)


def test_threads_change_nothing(batch: ig.Simulation) -> None:
    threaded = rollout(4, seed=2, num_threads=3)
    for w in range(4):
        assert_same(batch, w, threaded, w)


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda sim: pickle.loads(pickle.dumps(sim))])
def test_copies_go_on_identically(copied: Any) -> None:
    sim = rollout(2, seed=5)
    twin = copied(sim)
    for _ in range(10):
        sim.step()
        twin.step()
    for w in range(2):
        assert_same(sim, w, twin, w)


def test_turns_matter_to_those_who_look_at_others() -> None:
    data = yaml.safe_load(EVERYTHING)
    data["world"]["update"] = "simultaneous"
    together, in_turn = ig.compile(ig.load_scenario(data)), ig.compile(everything())
    for sim in (together, in_turn):
        sim.reset(seed=2)
        for _ in range(STEPS):
            sim.step()
    assert len(together.parts.turns) == 1 < len(in_turn.parts.turns)
    assert not np.array_equal(together.state.pose, in_turn.state.pose)
