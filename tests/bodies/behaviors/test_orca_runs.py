"""Groups that avoid each other and walls: whole runs, some of them side by side with IR-SIM."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from beside_ir_sim import silent, theirs

import irsim_gym as ig

ORCA = {"name": "orca"}
DISC = {"shape": {"name": "circle", "radius": 0.2}}


def simulation(robot: Any, obstacle: Any = None, n_worlds: int = 1, agents: tuple[int, ...] = (), **world: Any) -> Any:
    data = {"world": world, "robot": robot, **({"obstacle": obstacle} if obstacle else {})}
    sim = ig.compile(ig.load_scenario(data), n_worlds, agents=agents)
    sim.reset()
    return sim


def crowd(drive: str, states: list[Any], goals: list[Any], **more: Any) -> dict[str, Any]:
    entry = {"number": len(states), "kinematics": {"name": drive}, "group_behavior": ORCA, **DISC, **more}
    return {**entry, "state": states, "goal": goals}


@pytest.mark.parametrize("drive", ["omni", "diff"])
def test_two_that_meet_head_on_pass(drive: str) -> None:
    limits = {"vel_max": [1, 1.5], "vel_min": [-1, -1.5]}
    sim = simulation(crowd(drive, [[1, 5, 0], [9, 5.01, np.pi]], [[9, 5, 0], [1, 5, 0]], **limits))
    passed = False
    for _ in range(250):
        sim.step()
        assert not sim.state.collided.any()
        passed = passed or bool(sim.state.arrived.all())
    assert passed


@pytest.mark.parametrize(("drive", "steps"), [("omni", 400), ("diff", 700)])
def test_twenty_on_a_circle_change_places(drive: str, steps: int) -> None:
    # Without the side step all wait for each other in the middle for ever, as in IR-SIM.
    robot = {
        **crowd(drive, [], []),
        "number": 20,
        "distribution": {"name": "circle"},
        "group_behavior": {**ORCA, "sidestep": True},
        "vel_max": [1, 1.5],
        "vel_min": [-1, -1.5],
    }
    for key in ("state", "goal"):
        del robot[key]
    sim = simulation(robot)
    arrived = np.zeros(20, np.bool_)
    for _ in range(steps):
        sim.step()
        assert not sim.state.collided.any()
        arrived |= sim.state.arrived[0]
    assert arrived.all()


@pytest.mark.parametrize("drive", ["omni", "diff"])
def test_nobody_enters_a_wall(drive: str) -> None:
    # A room with an inner wall, a box and a pillar; each goal lies behind something.
    rng = np.random.default_rng(2)
    states = [[x, y, 0.0] for x in (1.5, 3.0) for y in (1.5, 3.5, 5.5, 7.5)]
    goals = [[x, y, 0.0] for x, y in rng.uniform([6.5, 1.5], [8.5, 8.5], (8, 2)).tolist()]
    walls = [
        {"shape": {"name": "linestring", "vertices": [[1, 1], [9, 1], [9, 9], [1, 9], [1, 1]]}, "state": [0, 0, 0]},
        {"shape": {"name": "linestring", "vertices": [[4.3, 1], [4.3, 4.2], [5, 5]]}, "state": [0, 0, 0]},
        {"shape": {"name": "rectangle", "length": 1, "width": 1.2}, "state": [6, 7, 0.4]},
        {"shape": {"name": "circle", "radius": 0.5}, "state": [6, 2.5]},
    ]
    sim = simulation(crowd(drive, states, goals, vel_max=[1, 1.5], vel_min=[-1, -1.5]), walls)
    start = sim.state.pose[0, :8, 0].copy()
    for _ in range(300):
        sim.step()
        touched = np.isin(sim.state.hit[0, :8], np.arange(8, 12))
        assert not touched.any()
    assert (sim.state.pose[0, :8, 0] - start).max() > 3.0


@pytest.mark.parametrize(
    ("obstacle", "avoided"),
    [
        ({"shape": {"name": "polygon", "vertices": [[0, 0], [1, 0.4], [1, 1], [0, 0.6]]}, "state": [4, 4.7, 0]}, True),
        ({"shape": {"name": "linestring", "vertices": [[4, 4.9], [6, 6]]}, "state": [0, 0, 0]}, True),
        ({"shape": {"name": "circle", "radius": 0.5}, "state": [5, 5.2, 0]}, True),
        ({"shape": {"name": "circle", "radius": 0.5}, "state": [5, 5.2, 0], "unobstructed": True}, False),
        (
            {
                "shape": {"name": "circle", "radius": 0.5},
                "state": [5, 5.2, 0],
                "kinematics": {"name": "diff"},
                "behavior": {"name": "dash"},
            },
            False,
        ),
    ],
)
def test_what_never_moves_is_avoided(obstacle: dict[str, Any], avoided: bool) -> None:
    sim = simulation(crowd("omni", [[1, 5, 0]], [[9, 5, 0]]), obstacle, collision_mode="unobstructed")
    heights = []
    for _ in range(60):
        sim.step()
        heights.append(sim.state.pose[0, 0, 1])
        assert not (avoided and sim.state.collided.any())
    straight = sim.state.pose[0, 0, 0] == pytest.approx(7) and heights == pytest.approx([5] * 60)
    assert straight != avoided


@pytest.mark.parametrize("static", [False, True])
def test_unobstructed_members_avoid_each_other(static: bool) -> None:
    """As in ir-sim, where a group is all that orca knows; neither gives way to a wall that is marked so."""
    robots = crowd("omni", [[1, 5, 0], [5, 5.1, 0]], [[9, 5, 0], [1, 5.1, 0]], unobstructed=True)
    sim = simulation({**robots, "static": [False, static]}, collision_mode="unobstructed")
    gaps = []
    for _ in range(70):
        sim.step()
        gaps.append(float(np.hypot(*(sim.state.pose[0, 0, :2] - sim.state.pose[0, 1, :2]))))
    assert min(gaps) > 0.4
    assert sim.state.pose[0, 0, 0] > sim.state.pose[0, 1, 0] + 0.5
    assert not sim.state.collided.any()


def test_an_absent_body_is_not_avoided() -> None:
    robots = {**crowd("omni", [], [[9, 5, 0]]), "number_range": [1, 2], "state": [[1, 5, 0], [5, 5.1, 0]]}
    del robots["number"]
    pillar = {"number_range": [0, 1], "shape": {"name": "circle", "radius": 0.5}, "state": [6.5, 5.2, 0]}
    sim = simulation(robots, pillar)
    sim.model.present[0] = [True, False, False]
    for _ in range(60):
        sim.step()
    assert sim.state.pose[0, 0] == pytest.approx([7, 5, 0])
    assert sim.state.plan[0, 1].tolist() == [0, 0]


def test_a_learner_in_the_group_is_avoided_as_it_really_moves() -> None:
    # The learner comes straight at the other, which makes half of the way around it; standing, it is passed wide.
    entry = crowd("omni", [[1, 5, 0], [9, 5.05, 0]], [[9, 5, 0], [1, 5, 0]])
    for speed in (-1.0, 0.0):
        sim = simulation(entry, agents=(1,))
        for _ in range(40):
            sim.step([speed, 0.0])
        assert sim.state.command[0, 1].tolist() == [speed, 0.0, 0.0]
        assert sim.state.pose[0, 1, 0] == pytest.approx(9 + 4 * speed)
        assert sim.state.pose[0, 0, 1] < 4.999
        assert not sim.state.collided.any()


def test_a_body_without_goal_only_gives_way() -> None:
    robots = [
        {**DISC, "kinematics": {"name": "omni"}, "group": 3, "group_behavior": ORCA, "state": [5, 5, 0]},
        {**DISC, "kinematics": {"name": "omni"}, "group": 3, "state": [1, 5.05, 0], "goal": [9, 5, 0]},
    ]
    sim = simulation(robots)
    sim.step()
    assert np.abs(sim.state.command[0, 0, :2]).max() < 0.2
    for _ in range(100):
        sim.step()
        assert not sim.state.collided.any()
    assert sim.state.arrived[0, 1]


def test_batch_threads_and_single_are_the_same() -> None:
    robot = {
        "number": 12,
        "kinematics": {"name": "diff"},
        "group_behavior": ORCA,
        "distribution": {"name": "random"},
        **DISC,
    }
    wall = {"shape": {"name": "polygon", "random_shape": True}, "distribution": {"name": "random"}}
    data = ig.load_scenario({"world": {}, "robot": robot, "obstacle": wall})
    batch = ig.compile(data, 4, num_threads=2)
    single = [ig.compile(data) for _ in range(4)]
    batch.reset(seed=3)
    for w, one in enumerate(single):
        one.reset(seed=3 + w)
    for _ in range(15):
        batch.step()
        for w, one in enumerate(single):
            one.step()
            np.testing.assert_array_equal(batch.state.pose[w], one.state.pose[0])
    assert np.abs(batch.state.pose[0] - batch.state.pose[1]).max() > 0.1


@pytest.mark.parametrize("drive", [{"name": "omni", "frame": "body"}, {"name": "diff"}])
def test_a_free_run_is_ir_sims(drive: dict[str, Any], tmp_path: Path) -> None:
    # ir-sim's velocities are float32, and differences grow where many meet.
    states = [[1, 2, 0.1], [1, 5, 0.2], [1.2, 8, 0.3], [9, 1.5, 2.9], [8.8, 5.2, 3.0], [9, 8.1, -3.0]]
    goals = [[9, 8.5, 0], [9, 5.5, 0], [9, 1, 0], [1, 9, 0], [0.5, 4.7, 0], [1, 1.2, 0]]
    group = {"name": "orca", "timeHorizon": 4.0}
    robots = {**crowd("diff", states, goals, vel_max=[1.2, 0.9]), "kinematics": drive, "group_behavior": group}
    sim, env = simulation(robots), theirs({"robot": [robots]}, tmp_path)
    gaps = []
    for _ in range(100):
        sim.step()
        with silent():
            env.step()
        gaps.append(max(np.abs(sim.state.pose[0, b] - one.state[:3, 0]).max() for b, one in enumerate(env.robot_list)))
    assert max(gaps[:20]) < 1e-5
    assert max(gaps) < 1e-2
    assert np.hypot(*(sim.state.pose[0, :, :2] - np.array(states)[:, :2]).T).min() > 3.0


@pytest.mark.parametrize("drive", ["omni", "diff"])
def test_nobody_enters_an_obstacle_map(drive: str) -> None:
    # A block in the middle, walls around; each goal lies behind the block.
    cells = [[100 if row in (0, 19) or column in (0, 19) else 0 for row in range(20)] for column in range(20)]
    for column in range(8, 12):
        for row in range(7, 13):
            cells[column][row] = 100
    states = [[1.5, y, 0.0] for y in (2.0, 4.0, 6.0, 8.0)] + [[8.5, y, np.pi] for y in (2.2, 4.2, 6.2, 8.2)]
    goals = [[8.5, 8.0, 0], [8.5, 5.9, 0], [8.5, 4.1, 0], [8.5, 2.0, 0]] + [[1.5, y, 0] for y in (8.2, 6.0, 4.0, 1.8)]
    group = {**ORCA, "sidestep": True}
    robots = crowd(drive, states, goals, vel_max=[1, 1.5], vel_min=[-1, -1.5], group_behavior=group)
    sim = simulation(robots, obstacle_map=cells)
    start = sim.state.pose[0, :8, 0].copy()
    for _ in range(300):
        sim.step()
        assert not (sim.state.hit[0, :8] == 8).any()
    assert np.median(np.abs(sim.state.pose[0, :8, 0] - start)) > 5.0


def test_members_that_are_commanded_by_hand_are_seen_as_they_move() -> None:
    # The second wants to go left, but is told to stand: the first goes around a disc that stands.
    robot = crowd("omni", [[2, 5, 0], [4, 5.05, 0]], [[9, 5, 0], [1, 5, 0]])
    ordered, driven = simulation(robot), simulation(robot, agents=(1,))
    for _ in range(40):
        ordered.step([[0.0, 0.0]], bodies=np.array([1]))
        driven.step([[0.0, 0.0]])
        assert ordered.state.plan[0, 1].tolist() == [0.0, 0.0]
    np.testing.assert_array_equal(ordered.state.pose[0, 0], driven.state.pose[0, 0])
    ordered.step([[0.3, -0.2]], bodies=np.array([1]))
    assert ordered.state.plan[0, 1].tolist() == pytest.approx([0.3, -0.2])


def test_two_in_the_same_place_with_the_same_goal_part() -> None:
    robot = crowd("omni", [[2, 5, 0]] * 2, [[9, 5, 0]] * 2)
    sim = simulation(robot, collision_mode="unobstructed")
    for _ in range(3):
        sim.step()
    first, second = sim.state.pose[0, :2, :2]
    assert np.hypot(*(second - first)) > 0.4
    assert first[0] > second[0]


@pytest.mark.parametrize(("x", "y"), [(3.2, 5.0), (3.4, 4.1), (2.6, 7.3)])
def test_a_wall_of_cells_is_kept_away_from_as_a_line_is(x: float, y: float) -> None:
    """The left side of what is occupied is a wall at x = 4, from y = 1 to 9."""
    cells = np.zeros((50, 50), np.bool_)
    cells[20:, 5:45] = True
    line = {"shape": {"name": "linestring", "vertices": [[4, 9], [4, 1]]}, "state": [0, 0, 0]}
    robot = {
        "kinematics": {"name": "omni"},
        "shape": {"name": "circle", "radius": 0.2},
        "state": [x, y, 0],
        "goal": [9, 5, 0],
        "velocity": [0.9, 0.1],
        "group_behavior": {"name": "orca"},
    }
    found = []
    for world, obstacles in (({"obstacle_map": cells}, []), ({}, [line]), ({}, [])):
        data = {"world": {"width": 10, "height": 10, **world}, "robot": robot, "obstacle": obstacles}
        sim = ig.compile(ig.load_scenario(data, warn=False))
        sim.reset(seed=0)
        sim.step()
        found.append(sim.state.command[0, 0, :2].copy())
    np.testing.assert_allclose(found[0], found[1], atol=1e-9)
    assert found[2][0] > found[0][0] + 0.05, "without a wall it drives on"
