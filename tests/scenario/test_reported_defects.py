"""Defects of IR-SIM 2.12.0 (d1 to d25), and those that readers of its documentation met before: what happens here.

Some are kept, since files rely on them and the same file should give the same run: their tests say so. Where a
defect has a number in ``test_known_defects.py`` as well, the test here adds what that one leaves open.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from defect_tools import body, problems, run, scenario

import irsim_gym
from irsim_gym.errors import ScenarioError, UnknownNameError
from irsim_gym.scenario import load_scenario
from irsim_gym.tasks.terms.outcome import Outcome

DIFF = "kinematics: {name: diff}"
OMNI = "kinematics: {name: omni}"
ROBOT: dict[str, Any] = {"kinematics": {"name": "diff"}}


def ranges(simulation: Any) -> Any:
    group, k = simulation.sensor(0, "ranges")
    return group.arrays["ranges"][0, k]


def test_d1_world_name_and_d2_angle_range_load_as_documented() -> None:
    file = scenario(f"world: {{name: hall}}\nrobot: {{{DIFF}, angle_range: [-pi, pi]}}")
    assert (file.name, file.bodies[0].angle_range[1]) == ("hall", pytest.approx(np.pi))


def test_d3_random_linestrings_take_every_key_of_theirs() -> None:
    keys = "random_shape: true, is_convex: true, spikeyness_range: [0.1, 0.5], num_vertices_range: [5, 6]"
    simulation = run(f"obstacle: {{shape: {{name: linestring, {keys}}}}}")
    assert 1 <= simulation.model.segment_count[0, 0] <= 4, "an open chain through the corners of the hull of 5 points"


def test_d4_null_is_no_goal() -> None:
    assert body("robot: {goal: null, state: null}").goal == ()


def test_d5_a_wide_body_ahead_is_in_the_field_of_view() -> None:
    text = "robot: {fov: 0.2, fov_radius: 3}\nobstacle: {state: [2, 0], shape: {name: rectangle, width: 5, length: 1}}"
    assert run(text, steps=0).detected(0)[0, 1]


@pytest.mark.parametrize("behavior", ["rvo", "sfm"])
def test_d6_rvo_and_sfm_see_what_is_unobstructed(behavior: str) -> None:
    """Kept: files mark walls so and rely on them to turn walkers away."""
    paths = {}
    for mark in ("state: [3, 5]", "state: [3, 5], unobstructed: true", "state: [90, 90]"):
        text = (
            "world: {collision_mode: unobstructed}\n"
            f"robot: {{{OMNI}, state: [1, 5.1], goal: [9, 5], behavior: {{name: {behavior}}}}}\n"
            f"obstacle: {{shape: {{name: circle, radius: 0.5}}, {mark}}}"
        )
        paths[mark] = [run(text, steps=steps).state.pose[0, 0].tolist() for steps in (1, 10, 30)]
    solid, marked, away = paths.values()
    assert marked == solid
    assert np.abs(np.subtract(marked, away)).max() > 0.2


def test_d7_a_wanderer_still_wanders_after_a_reset() -> None:
    robot = {**ROBOT, "behavior": {"name": "dash", "wander": True, "range_low": [4, 4, 0], "range_high": [6, 6, 0]}}
    with irsim_gym.load({"robot": robot}) as world:
        world.step()
        world.reset()
        goal = world.robot.goal
        assert goal is not None
        assert ((goal[:2] >= 4) & (goal[:2] <= 6)).all()


def test_d8_pause_pauses() -> None:
    with irsim_gym.load({"world": {"status": "Pause"}, "robot": ROBOT}) as world:
        world.step([1.0, 0.0])
        assert world.time == 0.0


def test_d9_the_clock_is_exact() -> None:
    with irsim_gym.load({"world": {"step_time": 0.004}, "robot": {}}) as world:
        times = []
        for _ in range(3):
            world.step()
            times.append(world.time)
    assert times == pytest.approx([0.004, 0.008, 0.012], abs=1e-12)


def test_d10_collisions_hold_and_are_told_apart_from_arrivals() -> None:
    """Kept: what has stopped at a static body cannot back out. What an episode ended in is told apart."""
    text = f"robot: {{{DIFF}, goal: [9, 0]}}\nobstacle: {{state: [0.5, 0]}}"
    simulation = run(text, steps=3, agents=[0], command=[1, 0])
    assert simulation.state.stopped[0, 0]
    stuck = simulation.state.pose[0, 0].copy()
    simulation.step([-1, 0])
    assert simulation.state.pose[0, 0].tolist() == stuck.tolist()
    assert (simulation.state.collided[0, 0], simulation.state.arrived[0, 0]) == (True, False)
    env = irsim_gym.make({"robot": {**ROBOT, "goal": [9, 0]}, "obstacle": {"state": [0.6, 0]}})
    env.reset(seed=0)
    ended = False
    while not ended:
        *_, ended, _, info = env.step(np.array([1.0, 0.0], np.float32))
    assert (info["outcome"], info["is_success"]) == (Outcome.COLLISION, False)


def test_d11_inside_a_block_of_the_map_is_inside() -> None:
    """A disc of 0.05 m at the corner that four occupied cells of 1 m share touches them all."""
    cells = "[[0, 0, 0, 0], [0, 100, 100, 0], [0, 100, 100, 0], [0, 0, 0, 0]]"
    text = (
        f"world: {{width: 4, height: 4, obstacle_map: {{name: array, cells: {cells}}}}}\n"
        "obstacle: [{state: [2, 2], shape: {name: circle, radius: 0.05}, kinematics: {name: omni}},\n"
        "  {state: [0.5, 0.5], shape: {name: circle, radius: 0.05}, kinematics: {name: omni}}]"
    )
    assert run(text).state.collided[0, :2].tolist() == [True, False]


def test_d12_rvo_sees_outlines_not_the_discs_around_them() -> None:
    """A box of 12 m beside the way: IR-SIM's disc around it would hold the robot.

    Kept: a differential drive turns by at most 1.5 rad/s, and the robot's own disc stands on its origin.
    """
    wall = "obstacle: {state: [5, 3], shape: {name: rectangle, length: 12, width: 0.4}}"
    robot = "state: [1, 1, 2], goal: [9, 1], vel_max: [1, 3], vel_min: [-1, -3], behavior: {name: rvo}"
    simulation = run(f"robot: {{{DIFF}, {robot}}}\n{wall}", steps=1)
    assert simulation.state.velocity[0, 0, 1] == pytest.approx(-1.5)
    for _ in range(50):
        simulation.step()
    assert not simulation.state.collided.any()
    assert simulation.state.pose[0, 0, 0] > 4.0


def test_d13_walkers_that_face_each_other_are_pushed_straight_back() -> None:
    """At rest, head on, the sideways force is 0 in one direction of the plane as in any other."""
    for angle in (0.0, 0.3, 1.1, 2.5):
        x, y = np.cos(angle), np.sin(angle)
        walker: dict[str, Any] = {"kinematics": {"name": "omni"}, "behavior": {"name": "sfm"}}
        data = {
            "robot": [
                {**walker, "state": [0, 0], "goal": [-10 * x, -10 * y]},
                {**walker, "state": [x, y], "goal": [10 * x, 10 * y]},
            ]
        }
        simulation = irsim_gym.compile(load_scenario(data))
        simulation.reset()
        simulation.step()
        aside = simulation.state.pose[0, 0, 0] * -y + simulation.state.pose[0, 0, 1] * x
        assert abs(aside) < 0.03


def test_d14_a_cars_wheels_keep_less_than_a_right_angle() -> None:
    """Kept: mode steer follows with a step's delay, and a car circles a goal inside its turning circle."""
    car = "kinematics: {name: acker, mode: angular}, shape: {name: rectangle, wheelbase: 0.5}, vel_max: [1, 50]"
    simulation = run(f"robot: {{{car}}}", steps=20, agents=[0], command=[0.1, 50])
    assert abs(simulation.state.steering[0, 0]) < np.pi / 2
    assert np.isfinite(simulation.state.pose).all()
    steered = "kinematics: {name: acker}, shape: {name: rectangle, wheelbase: 0.5}"
    assert run(f"robot: {{{steered}}}", agents=[0], command=[1, 0.5]).state.pose[0, 0, 2] == 0.0


def test_d15_dash_drives_backwards_at_a_goal_behind() -> None:
    """Kept, as is the curve of an omni drive with unequal limits."""
    behind = run(f"robot: {{{DIFF}, goal: [-5, 0.1], behavior: {{name: dash}}}}")
    assert behind.state.velocity[0, 0, 0] == pytest.approx(-1.0, abs=1e-3)
    curved = run(f"robot: {{{OMNI}, goal: [4, 4], vel_max: [1, 0.5], behavior: {{name: dash}}}}")
    assert curved.state.velocity[0, 0, :2] == pytest.approx([np.sqrt(0.5), 0.5 * np.sqrt(0.5)])


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("robot: {sensors: [{name: lidar2d, rnge_max: 3}]}", "rnge_max: unknown key (did you mean 'range_max'?)"),
        (f"robot: {{{DIFF}, behavior: {{name: dash, wandr: true}}}}", "wandr: unknown key (did you mean 'wander'?)"),
        ("world: {widht: 3}", "world.widht: unknown key (did you mean 'width'?)"),
        ("robot: {gaol: [1, 1]}", "robot.gaol: unknown key (did you mean 'goal'?)"),
    ],
)
def test_d16_unknown_keys_are_told(text: str, told: str) -> None:
    (problem,) = problems(text)
    assert problem.endswith(told)


def test_d17_wrong_types_are_told_and_short_forms_work(tmp_path: Path) -> None:
    assert len(body("robot: {sensors: {name: lidar2d}}").sensors) == 1
    (problem,) = problems(f"robot: {{{DIFF}, behavior: dash}}")
    assert problem == "1 robot.behavior: must be a mapping such as {name: dash}, got 'dash'"
    assert scenario("world: null").bodies == ()
    empty = tmp_path / "empty.yaml"
    empty.write_text("", encoding="utf-8")
    with pytest.raises(ScenarioError, match="the file is empty"):
        load_scenario(empty)
    with pytest.raises(FileNotFoundError, match="no such file"):
        load_scenario(tmp_path / "missing.yaml")


def test_d18_obstacles_are_scattered_clear_of_each_other_and_scans_are_copies() -> None:
    car = {"kinematics": {"name": "acker", "wheelbase": 0.3}, "state": [5, 5, 0, 0]}
    data = {"robot": {**ROBOT, "state": [9.5, 9.5, np.pi], "sensors": [{}]}, "obstacle": [{"number": 5}, car]}
    data["obstacle"][0]["state"] = [[k, 0.5] for k in range(5)]
    with irsim_gym.load(data) as world:
        first = world.robot.scan()["ranges"]
        kept = first.copy()
        world.random_obstacle_position(non_overlapping=True)
        assert np.array_equal(first, kept)
        assert not np.array_equal(world.robot.scan()["ranges"], kept)
        assert not any(one.collided for one in world.objects)
        with pytest.raises(UnknownNameError):
            world.obstacles[0].scan()


def test_d19_groups_follow_what_is_added() -> None:
    crowd = {"kinematics": {"name": "omni"}, "group_behavior": {"name": "orca"}}
    data = {"robot": {**crowd, "state": [0, 0], "goal": [5, 0]}, "obstacle": {"state": [9, 9]}}
    with irsim_gym.load(data) as world:
        assert world.robot.group != world.obstacles[0].group
        added = world.add("robot", **crowd, state=[0, 3], goal=[5, 3], group=world.robot.group)
        world.step()
        assert added.state[0] > 0.0


def test_d20_first_and_last_beam_of_a_full_turn_coincide() -> None:
    """Kept. The increment is the angle between two beams."""
    with irsim_gym.load({"robot": {**ROBOT, "sensors": [{"number": 5, "angle_range": 2 * np.pi}]}}) as world:
        scan = world.robot.scan()
    assert scan["angle_max"] - scan["angle_min"] == pytest.approx(2 * np.pi)
    assert scan["angle_increment"] == pytest.approx(np.pi / 2)


def test_d21_a_thousand_bodies_step_faster_than_its_154_ms() -> None:
    text = (
        "world: {width: 100, height: 100, collision_mode: unobstructed}\n"
        f"robot: {{number: 1000, {DIFF}, distribution: {{name: random, min_distance: 0}}, behavior: {{name: dash}}}}"
    )
    simulation = run(text)
    begin = time.process_time()
    for _ in range(5):
        simulation.step()
    assert (time.process_time() - begin) / 5 < 0.154


def test_d22_noise_is_in_the_motion_not_in_the_reported_velocity() -> None:
    """Kept: velocity is what was commanded."""
    simulation = run("robot: {kinematics: {name: diff, noise: true}}", agents=[0], command=[1, 0])
    assert simulation.state.velocity[0, 0, :2].tolist() == [1, 0]
    assert simulation.state.pose[0, 0, 0] != pytest.approx(0.1, abs=1e-6)


def test_d23_nothing_random_overlaps_anything() -> None:
    text = (
        f"robot: {{{DIFF}, distribution: {{name: random}}}}\n"
        "obstacle: [{state: [5, 5], shape: {name: rectangle, length: 6, width: 6}},\n"
        "  {number: 6, distribution: {name: random}, shape: {name: circle, radius: 0.6}},\n"
        "  {number: 4, distribution: {name: random}, shape: {name: rectangle}}]"
    )
    assert not run(text, steps=0).state.collided.any()


def test_d24_a_perlin_map_without_seed_is_the_same_again() -> None:
    text = "world: {name: cave, obstacle_map: {name: perlin, resolution: 0.5}}"
    one, two = (run(text, steps=0).model.map_squares for _ in range(2))
    assert np.array_equal(one, two)
    other = run(text.replace("cave", "hall"), steps=0).model.map_squares
    assert not np.array_equal(one, other)


def test_d25_outlines_that_cross_themselves_are_refused() -> None:
    (problem,) = problems("obstacle: {shape: {name: polygon, vertices: [[0, 0], [1, 1], [1, 0], [0, 1]]}}")
    assert "crosses or touches itself" in problem


def test_every_number_has_its_test() -> None:
    names = "_".join(name for name in globals() if name.startswith("test_d")) + "_"
    assert [k for k in range(1, 26) if f"d{k}_" not in names] == []


def test_before_numbers_of_bodies_begin_anew_in_each_world() -> None:
    for _ in range(2):
        with irsim_gym.load({"robot": [ROBOT, {**ROBOT, "state": [3, 3]}]}) as world:
            assert [one.id for one in world.objects] == [0, 1]
            assert world.names == ["robot_0", "robot_1"]


def test_before_a_group_in_a_list_entry_loads() -> None:
    assert scenario("robot: [{group: 2}]").bodies[0].group == 2


def test_before_a_flat_list_is_one_action() -> None:
    with irsim_gym.load({"robot": ROBOT}) as world:
        world.step([1.0, 0.5])
        assert world.robot.state.tolist() == pytest.approx([0.1, 0.0, 0.05])


def test_before_beams_inside_an_obstacle_do_not_shift() -> None:
    """From the middle of a square of 2 m the beams at -45, 0, 45 degrees read sqrt 2, 1, sqrt 2."""
    text = (
        "robot: {unobstructed: true, sensors: [{number: 3, angle_range: pi/2}]}\n"
        "obstacle: {shape: {name: rectangle, length: 2, width: 2}}"
    )
    assert ranges(run(text)) == pytest.approx([np.sqrt(2.0), 1.0, np.sqrt(2.0)], rel=1e-6)


@pytest.mark.parametrize("angle", ["2*pi", "6.2832", "6.5"])
def test_before_a_full_turn_of_beams_is_a_full_turn(angle: str) -> None:
    simulation = run(f"robot: {{sensors: [{{number: 5, angle_range: {angle}}}]}}\nobstacle: {{state: [-2, 0]}}")
    assert ranges(simulation) == pytest.approx([1.8, 10, 10, 10, 1.8], rel=1e-5)


def test_before_noise_leaves_misses_alone() -> None:
    simulation = run("robot: {sensors: [{number: 20, noise: true, range_max: 4}]}", steps=3)
    assert (ranges(simulation) == 4.0).all()


def test_before_velocities_of_beams_are_not_stale() -> None:
    """The obstacle drives out of the beam: what was measured before is gone."""
    text = f"robot: {{sensors: [{{number: 1, has_velocity: true}}]}}\nobstacle: {{{OMNI}, state: [3, -0.15]}}"
    simulation = run(text, agents=[1], command=[0, 1], steps=1)
    group, k = simulation.sensor(0, "ranges")
    velocity = next(array for name, array in group.arrays.items() if "velocit" in name)
    before = np.abs(velocity[0, k]).max()
    for _ in range(5):
        simulation.step([0, 1])
    assert before == pytest.approx(1.0)
    assert np.abs(velocity[0, k]).max() == 0.0


def test_before_the_map_lies_where_its_pixels_are() -> None:
    """Cells of 1 m from the offset on: cell (1, 2) covers x 11 to 12, y 22 to 23."""
    cells = "[[0, 0, 0], [0, 0, 100], [0, 0, 0]]"
    text = (
        f"world: {{width: 3, height: 3, offset: [10, 20], obstacle_map: {{name: array, cells: {cells}}}}}\n"
        "robot: {state: [10.2, 22.5], sensors: [{number: 1}]}"
    )
    assert ranges(run(text)) == pytest.approx([0.8], rel=1e-5)


def test_before_rvo_starts_from_rest_and_with_its_goal_behind() -> None:
    for mode in ("rvo", "hrvo", "vo"):
        text = f"robot: {{{DIFF}, state: [5, 5, 0], goal: [1, 5], behavior: {{name: rvo, mode: {mode}}}}}"
        simulation = run(text, steps=80)
        assert simulation.state.goal_distance[0, 0] < 3.0


def test_before_rvo_sees_walls_as_lines() -> None:
    """A wall whose middle is far away, and whose bounding disc the robot stands in from the beginning."""
    text = (
        f"robot: {{{OMNI}, state: [1, 1], goal: [9, 1], behavior: {{name: rvo}}}}\n"
        "obstacle: {shape: {name: linestring, vertices: [[0, 3], [20, 3]]}}"
    )
    simulation = run(text, steps=40)
    assert simulation.state.pose[0, 0, 0] > 4.0
    assert not simulation.state.collided.any()


def test_before_dash_does_not_swing() -> None:
    """With a limited angular acceleration the turn rate goes back to 0 once, without a change of sign."""
    text = f"robot: {{{DIFF}, goal: [0, 9], acce: [1, 0.5], behavior: {{name: dash}}}}"
    simulation = run(text, steps=0)
    rates = []
    for _ in range(60):
        simulation.step()
        rates.append(simulation.state.velocity[0, 0, 1])
    assert min(rates) > -0.1
    assert max(rates) > 0.3


def test_before_seeds_make_runs_the_same() -> None:
    text = "robot: {kinematics: {name: diff, noise: true}, distribution: {name: random}, behavior: {name: dash}}"
    one, two = (run(text, steps=10).state.pose for _ in range(2))
    assert np.array_equal(one, two)
