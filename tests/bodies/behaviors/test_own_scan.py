"""Behaviours that read the scan of their own body."""

from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.errors import KindError, ScenarioError
from irsim_gym.evaluation.policies.behavior_policies import BehaviorPolicy, UnfitBehaviorError
from irsim_gym.plugins import BEHAVIORS, GROUP_BEHAVIORS, kernel, kind, option
from irsim_gym.simulator.running.fused import only_kernels
from irsim_gym.simulator.world.own_scan import find_hits

pytestmark = pytest.mark.filterwarnings("ignore:seldom meant:irsim_gym.errors.ScenarioWarning")
HERE = np.array([0])


@kernel
def head_for_hit(worlds: Any, members: Any, scan: Any, limit: float, points: Any, command: Any) -> None:
    """Ask for the coordinates of the first point that is hit, and for the number of points."""
    for w in worlds:
        for k in range(members.shape[0]):
            n = find_hits(scan, w, k, limit, points)
            command[w, members[k], 0] = points[0, 0] if n > 0 else 0.0
            command[w, members[k], 1] = points[1, 0] if n > 0 else 0.0


@kind
class Fetch:
    """Drive to where the first beam ends."""

    kinematics: ClassVar[tuple[str, ...]] = ("omni",)
    reads_neighbors: ClassVar[bool] = False
    reads_scan: ClassVar[bool] = True
    only_kernels: ClassVar[bool] = True

    limit: float = option(5.0, meaning="Farther points do not count.")
    wander: bool = option(False, meaning="As ever.")
    loop: bool = option(False, meaning="As ever.")

    @staticmethod
    def prepare(group: Any, model: Any, n_slots: int) -> None:
        group.arrays["points"] = np.zeros((n_slots, 2, group.scan.ranges.shape[2]))

    @staticmethod
    def decide(group: Any, model: Any, state: Any, shard: Any) -> None:
        limit, points = group.options[0].limit, group.arrays["points"][shard.slot]
        head_for_hit(shard.worlds, group.members, group.scan, limit, points, state.command)


@pytest.fixture(autouse=True)
def registered(monkeypatch: pytest.MonkeyPatch) -> None:
    for family in (BEHAVIORS, GROUP_BEHAVIORS):
        monkeypatch.setattr(family, "_entries", dict(family._entries))
        family.register("fetch", Fetch)


def robot(beams: int, **more: Any) -> dict[str, Any]:
    sensors = [{"name": "lidar2d", "number": beams, "angle_range": np.pi, **more.pop("sensor", {})}]
    body = {"kinematics": {"name": "omni"}, "shape": {"name": "circle", "radius": 0.1}, "vel_min": [-9, -9]}
    return {**body, "vel_max": [9, 9], "behavior": {"name": "fetch"}, "sensors": sensors, **more}


def scene() -> dict[str, Any]:
    """One looks ahead, from 0.5 m before its centre; one to the left, at a wall; the third has nothing in reach."""
    post = {"shape": {"name": "circle", "radius": 1.0}, "state": [6, 2, 0]}
    wall = {"shape": {"name": "linestring", "vertices": [[0, 9], [10, 9]]}, "state": [0, 0, 0]}
    robots = [
        robot(1, state=[2, 2, 0], sensor={"offset": [0.5, 0, 0]}),
        robot(3, state=[2, 6, 0.0], sensor={"offset": [0, 0.25, np.pi / 2]}),
        robot(1, state=[4, 5, 0], sensor={"range_max": 2}),
    ]
    return {"world": {"height": 10, "width": 10, "step_time": 0.1}, "robot": robots, "obstacle": [post, wall]}


@pytest.mark.parametrize(("fused", "threads"), [(True, 1), (True, 2), (False, 1)])
def test_points_are_those_of_the_bodys_own_sensor(fused: bool, threads: int) -> None:
    simulation = ig.compile(ig.load_scenario(scene()), n_worlds=3, fused=fused, num_threads=threads)
    simulation.reset(seed=0)
    assert only_kernels([Fetch])
    simulation.step()
    # (3 - 0.5) m from its mount; 2.75 m to the left of the mount, which is 0.25 m to the left: both in the body frame.
    expected = [[3.0, 0.0], [0.0, 3.0], [0.0, 0.0]]
    np.testing.assert_allclose(simulation.state.command[:, :3, :2], [expected] * 3, atol=1e-6)
    simulation.step()  # 0.3 m nearer
    np.testing.assert_allclose(simulation.state.command[2, :2, :2], [[2.7, 0.0], [0.0, 2.7]], atol=1e-6)


def test_policies_and_worlds_by_hand_read_the_same() -> None:
    data = scene()
    data["robot"] = [{**data["robot"][1], "goal": [9, 1, 0], "goal_threshold": 1}, data["robot"][0]]
    episodes, policy = Worlds(data).episodes, BehaviorPolicy("fetch")
    episodes.begin(HERE, HERE)
    policy.begin(episodes, HERE, HERE)
    np.testing.assert_allclose(policy.command(episodes, HERE)[0], [[0, 3]], atol=1e-6)
    world = ig.load(data)
    world.step()
    np.testing.assert_allclose(world.robot.velocity[:2], [0, 3], atol=1e-6)


def test_a_body_without_a_scanner_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "blind.yaml"
    file.write_text("robot:\n  - kinematics: {name: omni}\n    behavior: {name: fetch}\n    sensors: []\n")
    expected = r":3 +robot\[0\]\.behavior: 'fetch' reads .*; add sensors: \[{name: lidar2d}\]"
    with pytest.raises(ScenarioError, match=expected):
        ig.load_scenario(file)
    blind = {**robot(1, goal=[1, 1]), "sensors": []}
    del blind["behavior"], blind["vel_max"], blind["vel_min"]
    with pytest.raises(UnfitBehaviorError, match="'fetch' reads a scan, but 'robot_0' has no range sensor"):
        BehaviorPolicy("fetch").check(Worlds({"robot": blind}).episodes)


def test_members_of_a_group_have_the_same_beams() -> None:
    pair = [{**robot(n, state=[n, 1, 0]), "group": 0, "group_behavior": {"name": "fetch"}} for n in (1, 2)]
    with pytest.raises(ScenarioError, match="its group reads scans, so the first range sensor"):
        ig.compile(ig.load_scenario({"robot": pair}))


def test_the_declaration_is_checked() -> None:
    wrong = type("Wrong", (), dict(vars(Fetch)))
    wrong.reads_scan = "yes"
    with pytest.raises(KindError, match="'reads_scan' must be True if its members need a range"):
        BEHAVIORS.register("wrong", wrong)
