"""RVO: golden vectors, decisions beside IR-SIM's, and what it avoids where IR-SIM does something else on purpose."""

from __future__ import annotations

import copy
import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from beside_ir_sim import SAME, count_ties, crowd, decisions, ours, silent, theirs

from irsim_gym import compile, load_scenario
from irsim_gym.base.arraytypes import MAP_FRAME
from irsim_gym.base.kernels.structs import Struct
from irsim_gym.bodies.behaviors.rvo.penalty import NEVER, time_to_side
from irsim_gym.bodies.behaviors.rvo.velocity_obstacles import lay_samples, order_samples
from irsim_gym.bodies.behaviors.shared.map_parts import map_walls, most_map_walls
from irsim_gym.bodies.behaviors.shared.surroundings import Ego
from irsim_gym.simulator.engine.simulation import Simulation

Description = dict[str, Any]


def robot(state: list[float], goal: list[float], drive: str = "diff", **behavior: Any) -> Description:
    return {
        "kinematics": {"name": drive},
        "shape": {"name": "circle", "radius": 0.2},
        "state": state,
        "goal": goal,
        "behavior": {"name": "rvo", **behavior},
    }


def box(length: float, width: float, state: list[float], **others: Any) -> Description:
    return {"shape": {"name": "rectangle", "length": length, "width": width}, "state": state, **others}


def simulation(robots: list[Description], obstacles: list[Description] | None = None, n: int = 1) -> Simulation:
    made = compile(load_scenario({"robot": robots, "obstacle": obstacles or []}), n_worlds=n)
    made.reset(seed=0)
    return made


def test_golden_pair() -> None:
    sim = simulation([robot([1, 5, 0], [9, 5, 0]), robot([3.2, 5.1, 3.14159], [1, 5, 0])])
    expected = [
        ([1.085, 5.0, -0.1], [0.85, -1.0]),
        ([1.171065374, 4.991364659, -0.185433285], [0.864975012, -0.854332849]),
        ([1.257892118, 4.975076975, -0.240833865], [0.883412253, -0.554005797]),
        ([1.350715612, 4.952279461, -0.240833865], [0.955820475, 0.0]),
    ]
    for pose, velocity in expected:
        sim.step()
        np.testing.assert_allclose(sim.state.pose[0, 0], pose, atol=6e-10)
        np.testing.assert_allclose(sim.state.velocity[0, 0, :2], velocity, atol=6e-10)


def test_a_goal_behind_is_turned_to_when_nothing_is_near() -> None:
    """No sample leads a differential drive back: it turns on the spot, at the fixed limit of 1.5 rad/s."""
    behind = robot([5, 5, 0], [1, 5.5, 0]) | {"vel_max": [1, 2], "vel_min": [-1, -2]}
    sim = simulation([behind])
    sim.step()
    assert sim.state.velocity[0, 0, :2] == pytest.approx([0, 1.5])


@pytest.mark.parametrize("drive", ["diff", "omni"])
@pytest.mark.parametrize("mode", ["rvo", "hrvo", "vo"])
def test_decisions_are_those_of_ir_sim(mode: str, drive: str, tmp_path: Path) -> None:
    """Crowded scenes, so that the penalty decides too; walls, roles and bounding discs of rectangles among them."""
    random = np.random.default_rng(7)
    total = ties = 0
    for roles, sight in (("all", 3.0), ("all", 1.5), ("robot", 3.0), ("obstacle", 2.0)):
        behavior = {"name": "rvo", "mode": mode, "target_roles": roles, "neighbor_threshold": sight, "factor": 2.0}
        compared, tied = count_ties(crowd(random, behavior, drive), tmp_path)
        total, ties = total + compared, ties + tied
    assert total == 24
    assert ties <= 2


@pytest.mark.parametrize("drive", ["diff", "omni"])
@pytest.mark.parametrize(("mode", "factor", "gap"), [("rvo", 1.0, 0.75), ("hrvo", 3.0, 0.9), ("vo", 0.3, 1.1)])
def test_where_no_velocity_is_free_the_least_penalty_is_that_of_ir_sim(
    mode: str, factor: float, gap: float, drive: str, tmp_path: Path
) -> None:
    """Six that close in on a seventh between two walls: the one in the middle finds every velocity forbidden."""
    random = np.random.default_rng(17)
    around = np.arange(6) * np.pi / 3 + random.uniform(-0.2, 0.2, 6)
    places = [[5.0, 5.0], *(5.0 + gap * np.stack([np.cos(around), np.sin(around)], axis=1)).tolist()]
    headings = [random.uniform(-3, 3), *np.angle(-np.exp(1j * (around + random.uniform(-0.3, 0.3, 6))))]
    behavior = {"mode": mode, "factor": factor, "neighbor_threshold": 4.0, "acce": 0.4}
    robots = [
        robot([*place, float(heading)], (10 - np.array(place)).tolist(), drive, **behavior)
        | {"velocity": [0.9, 0.1], "vel_max": [1.5, 1.5], "vel_min": [-1.5, -1.5]}
        for place, heading in zip(places, headings, strict=True)
    ]
    for one in robots:
        one["kinematics"] |= {"frame": "body"} if drive == "omni" else {}
    walls = [
        {"shape": {"name": "linestring", "vertices": [[3, y], [7, y + 0.2]]}, "state": [0, 0, 0]}
        for y in (5 - gap - 0.6, 5 + gap + 0.6)
    ]
    total, ties = count_ties({"robot": robots, "obstacle": walls}, tmp_path)
    assert total == 7
    assert ties <= 1


def test_samples_are_those_of_arange() -> None:
    random = np.random.default_rng(3)
    for current, change, limit in [*random.uniform([-2, 0, 0], [2, 2, 2], (300, 3)), (0, 1, 1.5), (0.25, 0.3, 0.5)]:
        first, step, count, _ = lay_samples(float(current), float(change), float(limit), 0.0)
        low, high = max(current - change, -limit), min(current + change, limit)
        expected = np.arange(low, high, 0.05) if high > low else np.clip([current], -limit, limit)
        assert [first + k * step for k in range(count)] == expected.tolist()


@pytest.mark.parametrize("place", [[5.0, 5.0, 0.0], [5.6, 4.7, 1.0]])
def test_a_standing_compound_of_discs_is_avoided_as_the_discs_are(place: list[float]) -> None:
    mover = robot([3.2, 5.0, 0.0], [8, 5, 0], "omni") | {"velocity": [0.8, 0.1]}
    turn = np.array([[np.cos(place[2]), -np.sin(place[2])], [np.sin(place[2]), np.cos(place[2])]])
    offsets, radii = [np.array([0.0, 0.3]), np.array([0.5, -0.6])], [0.5, 0.3]
    parts = [{"name": "circle", "radius": r, "pose": [*o, 0]} for o, r in zip(offsets, radii, strict=True)]
    whole = {"shape": {"name": "compound", "parts": parts}, "state": place}
    apart = [
        {"shape": {"name": "circle", "radius": r}, "state": [*(np.array(place[:2]) + turn @ o), 0]}
        for o, r in zip(offsets, radii, strict=True)
    ]
    found = []
    for obstacles in ([whole], apart):
        sim = simulation([mover], obstacles)
        commands = []
        for _ in range(8):
            sim.step()
            commands.append(sim.state.command[0, 0, :2].copy())
        found.append(np.array(commands))
    np.testing.assert_allclose(found[0], found[1], atol=1e-9)
    assert np.abs(found[0][:, 1]).max() > 0.05, "they are in the way"


def test_the_most_walls_of_a_map_that_can_be_near() -> None:
    """Each of the cells' borders at most, those of one more row and column, and one: the rows that are set aside."""
    for count, threshold, most in ((4, 100.0, 2 * 5 * 5 + 1), (40, 1.0, 2 * 11 * 11 + 1)):
        world = {"width": count / 4, "height": count / 4, "obstacle_map": np.ones((count, count), np.bool_)}
        model = compile(load_scenario({"world": world})).model
        assert most_map_walls(model, threshold) == most
    world = {"width": 1, "height": 2, "obstacle_map": np.ones((4, 8), np.bool_)}
    assert most_map_walls(compile(load_scenario({"world": world})).model, 100.0) == 2 * 5 * 9 + 1


@pytest.mark.parametrize(
    ("place", "velocity", "expected"),
    [
        ([0, 0], [1, 0], 1.5),
        ([0, 0], [2, 0], 0.75),
        ([4, 0], [-1, 0], 1.5),  # from the other side
        ([0, 0], [-1, 0], NEVER),
        ([0, 0], [0, 1], NEVER),
        ([0, 2.4], [1, 0], 1.5),  # beside its end, by less than the radius
        ([0, 2.6], [1, 0], NEVER),
        ([0, -2.4], [1, 0], 1.5),
        ([0, -2.6], [1, 0], NEVER),
        ([0, 5], [1, -2], 1.5),  # meets its line at y = 2
        ([1.7, 0], [1, 0], 0.0),  # overlaps already
    ],
)
def test_when_a_disc_meets_a_wall(place: list[float], velocity: list[float], expected: float) -> None:
    """A disc of 0.5 m, and a wall from (2, -2) to (2, 2)."""
    for wall in ([2.0, -2.0, 2.0, 2.0], [2.0, 2.0, 2.0, -2.0]):
        x, y, vx, vy = (float(value) for value in [*place, *velocity])
        assert time_to_side(Ego(x, y, 0.0, 0.0, 0.5), (vx, vy), np.array(wall)) == pytest.approx(expected)
    assert time_to_side(Ego(0.0, 0.0, 0.0, 0.0, 0.5), (1.0, 0.0), np.array([2.0, 0.0, 2.0, 0.0])) == NEVER


def test_samples_are_visited_outwards() -> None:
    samples, order = np.array([-1.0, -0.5, 0.0, 0.5]), np.zeros(4, np.int64)
    for wanted in (-3.0, -0.6, 0.1, 0.5, 2.0):
        order_samples(samples, 4, wanted, order)
        assert sorted(order.tolist()) == [0, 1, 2, 3]
        assert (np.diff(np.abs(samples[order] - wanted)) >= 0).all()


def test_a_standing_box_is_its_four_sides(tmp_path: Path) -> None:
    """Beside it, IR-SIM with a linestring along the box's outline decides the same."""
    corners = [[2, 1], [2, -1], [-2, -1], [-2, 1], [2, 1]]
    line = {"shape": {"name": "linestring", "vertices": corners}, "state": [5, 5, 0.4]}
    starts = [[1.5, 4.5, 0.2], [3.0, 7.0, -1.0], [7.6, 4.0, 3.0]]
    robots = [robot(start, [10 - start[0], 10 - start[1]], "omni") for start in starts]
    boxed = ours({"robot": robots, "obstacle": [box(4, 2, [5, 5, 0.4])]})
    found = boxed.state.command[0, :3, :2]
    for turned in robots:
        turned["kinematics"]["frame"] = "body"
    with silent():
        expected = decisions(theirs({"robot": robots, "obstacle": [line]}, tmp_path))
    for command, body, start in zip(found, expected, starts, strict=True):
        cosine, sine = np.cos(start[2]), np.sin(start[2])
        assert command == pytest.approx(
            [cosine * body[0] - sine * body[1], sine * body[0] + cosine * body[1]], abs=SAME
        )


def test_a_box_is_seen_by_its_outline() -> None:
    """3 m from its side, though its centre is 7 m away; and not from farther."""
    for distance, swerves in ((2.9, True), (3.1, False)):
        sim = simulation([robot([1, 5, 0], [9, 5, 0], "omni")], [box(8, 2, [1 + distance + 4, 5, 0])])
        sim.step()
        assert (abs(sim.state.command[0, 0, 1]) > 0.1) == swerves


@pytest.mark.parametrize("drive", ["diff", "omni"])
def test_robots_pass_beside_and_between_long_walls(drive: str) -> None:
    sim = simulation([robot([1, 5, 0], [9, 5, 0], drive)], [box(8, 0.4, [5, 4.3, 0]), box(8, 0.4, [5, 6, 0])])
    for _ in range(90):
        sim.step()
    assert sim.state.arrived[0, 0]
    assert not sim.state.collided.any()


def test_a_large_box_is_driven_around() -> None:
    sim = simulation([robot([1, 5.2, 0], [9, 5.3, 0], "omni")], [box(4, 4, [5, 5, 0])])
    for _ in range(150):
        sim.step()
    assert sim.state.arrived[0, 0]
    assert not sim.state.collided.any()


@pytest.mark.parametrize("drive", ["diff", "omni"])
def test_a_map_is_driven_around(drive: str) -> None:
    """A block of 1 x 2 m in the middle of the way; what is meant to see robots alone runs into it."""
    cells = np.zeros((100, 100), np.bool_)
    cells[45:55, 40:60] = True
    for roles, passes in (("all", True), ("robot", False)):
        driver = robot([1, 5.2, 0], [9, 5.3, 0], drive, target_roles=roles)
        world = {"width": 10, "height": 10, "obstacle_map": cells}
        sim = compile(load_scenario({"world": world, "robot": [driver]}), n_worlds=1)
        sim.reset(seed=0)
        for _ in range(120):
            sim.step()
        assert (sim.state.arrived[0, 0], sim.state.collided[0, 0]) == (passes, not passes)


def test_a_wall_across_the_way_is_not_run_into() -> None:
    wall = {"shape": {"name": "linestring", "vertices": [[0, -1], [0, 1]]}, "state": [5, 5, 0]}
    sim = simulation([robot([2, 5.1, 0], [8, 5, 0], "omni")], [wall])
    for _ in range(120):
        sim.step()
    assert sim.state.arrived[0, 0]
    assert not sim.state.collided.any()


def test_what_is_of_another_role_is_driven_through_and_what_is_unobstructed_is_avoided() -> None:
    straight = [1, 0]
    ghost = {"shape": {"name": "circle", "radius": 0.4}, "state": [2.5, 5, 0], "unobstructed": True}
    disc = {key: value for key, value in ghost.items() if key != "unobstructed"}
    for obstacle, roles, swerves in ((disc, "all", True), (ghost, "all", True), (disc, "robot", False)):
        sim = simulation([robot([1, 5, 0], [9, 5, 0], "omni", target_roles=roles)], [obstacle])
        sim.step()
        assert (np.abs(sim.state.command[0, 0, :2] - straight).max() > 0.06) == swerves


def swap(n: int, drive: str) -> Description:
    """Robots on a slightly uneven circle (an even one is full of ties), each with the opposite place as its goal."""
    angles = 2 * np.pi * np.arange(n) / n + 0.05 * np.sin(np.arange(n))
    robots = []
    for angle in angles.tolist():
        x, y = 4 * np.cos(angle), 4 * np.sin(angle)
        heading = float((angle + 2 * np.pi) % (2 * np.pi) - np.pi)
        goal = [float(5 - x), float(5 - y), 0]
        robots.append(robot([float(5 + x), float(5 + y), heading], goal, drive, neighbor_threshold=4.0))
    return {"world": {"width": 10, "height": 10}, "robot": robots}


def test_ten_robots_swap_places_as_in_ir_sim(tmp_path: Path) -> None:
    """Not one tie in 150 steps of ten robots: the poses stay equal, and nobody collides."""
    scenario = swap(10, "diff")
    env, sim = theirs(scenario, tmp_path), simulation(scenario["robot"])
    for _ in range(150):
        with silent():
            env.step()
        sim.step()
        expected = np.array([one.state[:3, 0] for one in env.robot_list])
        np.testing.assert_allclose(sim.state.pose[0], expected, atol=SAME)
    assert not sim.state.collided.any()
    assert sim.state.arrived[0].sum() >= 9


def test_batches_and_shards_decide_as_single_worlds() -> None:
    robots = swap(6, "omni")["robot"]
    placed = [{"name": "random", "range_low": [0, 0, -3], "range_high": [9, 9, 3]}] * 6
    scattered = [body | {"distribution": where} for body, where in zip(robots, placed, strict=True)]
    for body in scattered:
        del body["state"], body["goal"]
    description = {"robot": scattered, "obstacle": [box(1, 0.5, [5, 5, 0.3])]}
    batch = compile(load_scenario(copy.deepcopy(description)), n_worlds=4, num_threads=2)
    batch.reset(seed=5)
    single = compile(load_scenario(copy.deepcopy(description)), n_worlds=1)
    single.reset(seed=7)
    for _ in range(15):
        batch.step()
        single.step()
    assert batch.state.pose[2].tolist() == single.state.pose[0].tolist()


def test_plain_python_decides_as_compiled() -> None:
    code = "import json, sys; sys.path.insert(0, sys.argv[1]); import test_rvo; print(json.dumps(test_rvo.decided()))"
    command = [sys.executable, "-c", code, str(Path(__file__).parent)]
    plain = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(command, env=plain, capture_output=True, text=True, check=True)
    np.testing.assert_allclose(decided(), json.loads(done.stdout), atol=1e-12)


def decided() -> list[list[list[float]]]:
    """Return where robots are after four steps, one in each mode."""
    modes = zip(("rvo", "hrvo", "vo"), ([1, 5, 0], [3, 5.2, 3], [2, 6, -1]), ("diff", "omni", "diff"), strict=True)
    robots = [robot(state, [5, 5, 0], drive, mode=mode) for mode, state, drive in modes]
    sim = simulation(robots, [box(1, 1, [5, 7, 0])])
    for _ in range(4):
        sim.step()
    return sim.state.pose.tolist()


@dataclass
class Chart(Struct):
    """What ``map_walls`` reads of the model."""

    map_frame: Any
    map_squares: Any
    map_disc: Any


def test_map_walls_are_the_borders_of_occupied_cells() -> None:
    """Cells of 1 x 2 m from (10, 20); an L of three is occupied: its six sides, free cells to the left of each."""
    occupied = np.zeros((4, 3), bool)
    occupied[1, 1] = occupied[2, 1] = occupied[2, 2] = True
    squares = np.where(occupied, 0, 1).astype(np.uint8)[None].repeat(4, axis=0)[None]
    chart: Any = Chart(np.array([(10.0, 20.0, 1.0, 2.0, 0)], MAP_FRAME), squares, np.zeros(1))
    sides = np.zeros((50, 4))
    count = map_walls(chart, 0, 12.0, 23.0, 50.0, sides, 0)
    expected = {
        (13.0, 22.0, 11.0, 22.0),
        (11.0, 24.0, 12.0, 24.0),
        (12.0, 26.0, 13.0, 26.0),
        (11.0, 22.0, 11.0, 24.0),
        (12.0, 24.0, 12.0, 26.0),
        (13.0, 26.0, 13.0, 22.0),
    }
    assert {tuple(side) for side in sides[:count].tolist()} == expected
    assert count == 6
    near = map_walls(chart, 0, 10.5, 23.0, 0.6, sides, 0)
    assert sides[:near].tolist() == [[11.0, 22.0, 11.0, 24.0]]


def test_map_walls_end_with_the_rows_for_them() -> None:
    squares = np.where(np.indices((9, 9)).sum(axis=0) % 2, 0, 1).astype(np.uint8)[None].repeat(4, axis=0)[None]
    sides = np.full((8, 4), -1.0)
    chart: Any = Chart(np.array([(0.0, 0.0, 1.0, 1.0, 0)], MAP_FRAME), squares, np.zeros(1))
    assert map_walls(chart, 0, 4.5, 4.5, 9.0, sides[:7], 0) == 7
    assert (sides[:7] >= 0).all()
    assert (sides[7] == -1).all()
