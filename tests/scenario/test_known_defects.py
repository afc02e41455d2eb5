"""Where IR-SIM's documentation and its program disagree (D1 to D40): what happens here.

One test for each, named by its number. Expected values are the documentation's, or worked out by hand.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from defect_tools import body, problems, run, scenario

import irsim_gym
from irsim_gym.rendering import Renderer
from irsim_gym.rendering.looks.styles import body_style
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.specs.plot_spec import ObjectPlot

DIFF = "kinematics: {name: diff}"


def test_d1_a_world_may_be_named() -> None:
    assert scenario("world: {name: hall}").name == "hall"
    assert scenario("world: {}").name == "world"


def test_d2_pi_may_be_written() -> None:
    assert body(f"robot: {{{DIFF}, angle_range: [-pi, pi]}}").angle_range == pytest.approx((-np.pi, np.pi))
    run(f"robot: {{{DIFF}, angle_range: [-pi, pi]}}")


def test_d3_a_full_turn_wraps_and_anything_else_is_refused() -> None:
    simulation = run(f"robot: {{{DIFF}, state: [0, 0, 0.05], angle_range: [0, 2*pi]}}", agents=[0], command=[0, -1])
    assert simulation.state.pose[0, 0, 2] == pytest.approx(2.0 * np.pi - 0.05)
    (problem,) = problems("robot: {angle_range: [-3.0, 3.0]}")
    assert "full turn" in problem


def test_d4_without_a_goal_a_body_stands_still_and_never_arrives() -> None:
    simulation = run(f"robot: {{{DIFF}, state: [1, 9, 0], behavior: {{name: dash}}}}", steps=5)
    assert simulation.state.pose[0, 0].tolist() == [1, 9, 0]
    assert not simulation.state.arrived.any()
    assert body(f"robot: {{{DIFF}, goal: null}}").goal == ()


def test_d5_a_missing_state_is_zero() -> None:
    assert body("obstacle: {shape: {name: polygon, vertices: [[4, 4], [5, 4], [5, 5]]}}").state == (0, 0, 0)


def test_d6_omni_moves_along_the_axes_of_the_world() -> None:
    moved = run("robot: {kinematics: {name: omni}, state: [0, 0, pi/2]}", agents=[0], command=[0.5, 0.2])
    assert moved.state.pose[0, 0] == pytest.approx([0.05, 0.02, np.pi / 2])
    own = run("robot: {kinematics: {name: omni, frame: body}, state: [0, 0, pi/2]}", agents=[0], command=[0.5, 0.2])
    assert own.state.pose[0, 0] == pytest.approx([-0.02, 0.05, np.pi / 2])


def test_d7_acceleration_is_per_second() -> None:
    simulation = run(f"robot: {{{DIFF}, acce: [2, 3]}}", agents=[0], command=[1, 1])
    assert simulation.state.velocity[0, 0, :2] == pytest.approx([0.2, 0.3])


def test_d8_a_car_in_mode_angular_turns_at_the_yaw_rate() -> None:
    car = "kinematics: {name: acker, mode: angular}, shape: {name: rectangle, wheelbase: 0.5}"
    simulation = run(f"robot: {{{car}}}", agents=[0], command=[1, 0.5])
    assert simulation.state.pose[0, 0, 2] == pytest.approx(0.05)
    assert simulation.state.steering[0, 0] == pytest.approx(np.arctan(0.5 * 0.5 / 1.0))


def test_d9_a_car_needs_a_wheelbase() -> None:
    (problem,) = problems("robot: {kinematics: {name: acker}}")
    assert "robot.kinematics.wheelbase" in problem
    assert "shape" in problem


def test_d10_an_unobstructed_body_touches_nobody() -> None:
    text = (
        f"robot: [{{{DIFF}, unobstructed: true}}, {{{DIFF}, state: [0, 3, 0]}}]\n"
        "obstacle: [{state: [0.6, 0]}, {state: [0.6, 3]}]"
    )
    simulation = run(text, steps=8, agents=[0, 1], command=[1, 0])
    assert simulation.state.pose[0, 0, 0] == pytest.approx(0.8)
    assert simulation.state.collided[0].tolist() == [False, True, False, True]
    assert simulation.state.stopped[0, :2].tolist() == [False, True]


def test_d11_status_pause_begins_paused() -> None:
    with irsim_gym.load({"world": {"status": "Pause"}, "robot": {"kinematics": {"name": "diff"}}}) as world:
        world.step([1, 0])
        assert (world.status, world.count) == ("Pause", 0)
        world.resume()
        world.step([1, 0])
        assert (world.status, world.count) == ("Running", 1)


def test_d12_arrived_and_collision_are_texts_and_stop_nothing() -> None:
    for status in ("Arrived", "Collision"):
        with irsim_gym.load({"world": {"status": status}, "robot": {"kinematics": {"name": "diff"}}}) as world:
            assert world.status == status
            world.step([1, 0])
            assert (world.status, world.count) == ("Running", 1)


def test_d13_directions_of_beams_are_noisy_with_the_documented_deviation() -> None:
    assert body("robot: {sensors: [{name: lidar2d}]}").sensors[0].angle_std == 0.02
    text = "robot: {sensors: [{number: 400, angle_range: 1.0, noise: true, std: 0}]}\nobstacle: {state: [3, 0], "
    simulation = run(text + "shape: {name: linestring, vertices: [[0, -9], [0, 9]]}}")
    group, k = simulation.sensor(0, "ranges")
    ranges, angles = group.arrays["ranges"][0, k], group.arrays["angles"]
    cast = np.arccos(np.clip(3.0 / ranges, -1.0, 1.0)) - np.abs(angles)
    aside = np.abs(angles) > 0.1  # nearer the middle the range does not tell the sign
    assert np.std(cast[aside]) == pytest.approx(0.02, rel=0.15)


def test_d14_ranges_below_range_min_read_as_it() -> None:
    text = "robot: {sensors: [{number: 1, range_min: 1.0}]}\nobstacle: {state: [0.9, 0]}"
    simulation = run(text)
    group, k = simulation.sensor(0, "ranges")
    assert group.arrays["ranges"][0, k, 0] == 1.0


def test_d15_a_polygon_needs_vertices_or_chance() -> None:
    (problem,) = problems("obstacle: {shape: {name: polygon}}")
    assert problem == "1 obstacle.shape.vertices: is required unless random_shape is true"
    run("obstacle: {shape: {name: polygon, random_shape: true}}")


def test_d16_a_random_linestring_needs_no_vertices() -> None:
    simulation = run("obstacle: {shape: {name: linestring, random_shape: true}}")
    assert simulation.model.segment_count[0, 0] >= 3


def test_d17_linestrings_are_not_convex_unless_asked() -> None:
    shape = body("obstacle: {shape: {name: linestring, random_shape: true, spikeyness_range: [0.5, 1]}}").shape
    assert shape.is_convex is False


def test_d18_convex_means_convex() -> None:
    text = (
        "obstacle: {number: 20, shape: {name: polygon, random_shape: true, is_convex: true, spikeyness_range: [1, 1]}}"
    )
    simulation = run(text)
    for b in range(20):
        first, count = simulation.model.segment_start[b], simulation.model.segment_count[0, b]
        sides = simulation.model.local_segments[0, first : first + count]
        along = sides[:, 2:] - sides[:, :2]
        after = np.roll(along, -1, axis=0)
        assert (along[:, 0] * after[:, 1] - along[:, 1] * after[:, 0] >= -1e-12).all()


def test_d19_a_series_of_random_outlines_is_one_for_each_body() -> None:
    simulation = run("obstacle: {number: 3, shape: {name: polygon, random_shape: true}}")
    firsts = simulation.model.local_segments[0, simulation.model.segment_start]
    assert len(np.unique(firsts[:, 0])) == 3
    (problem,) = problems("obstacle: {shape: {name: polygon, random_shape: true, number: 3}}")
    assert "write number beside shape" in problem


def test_d20_a_missing_shape_is_the_documented_circle() -> None:
    assert body("robot: {}").shape == body("robot: {shape: {name: circle}}").shape
    assert body("robot: {}").shape.radius == 0.2


@pytest.mark.parametrize("key", ["kinematics", "shape", "behavior", "distribution", "group_behavior"])
def test_d21_a_mapping_without_a_name_is_told(key: str) -> None:
    (problem,) = problems(f"robot: {{{key}: {{noise: true}}}}")
    assert problem.startswith(f"1 robot.{key}.name: is required: '")


def test_d22_an_explicit_group_wins_and_roles_never_share_one() -> None:
    assert [one.group for one in scenario("robot: {}\nobstacle: {}").bodies] == [0, 1]
    assert [one.group for one in scenario("robot: [{group: 4}, {}]\nobstacle: [{}]").bodies] == [4, 1, 5]


def test_d23_plot_stands_in_an_entry_or_at_the_top() -> None:
    bodies = scenario("plot: {show_goal: true}\nrobot: [{plot: {show_text: true}}, {}]").bodies
    assert [(one.plot.show_goal, one.plot.show_text) for one in bodies] == [(True, True), (True, False)]


def test_d24_numbers_may_differ_from_body_to_body() -> None:
    bodies = scenario(
        "robot: {number: 3, goal_threshold: [0.1, 0.2, 0.3], vel_max: [[1, 1], [2, 1]], " + DIFF + "}"
    ).bodies
    assert [one.goal_threshold for one in bodies] == [0.1, 0.2, 0.3]
    assert [one.vel_max for one in bodies] == [(1, 1), (2, 1), (2, 1)]


def test_d25_random_places_keep_a_distance_within_the_world() -> None:
    text = "world: {width: 6, height: 5, offset: [10, 0]}\nobstacle: {number: 8, distribution: {name: random}}"
    places = run(text).state.pose[0, :, :2]
    assert places.min(axis=0) == pytest.approx([10.5, 0.5], abs=2.0)
    assert (places >= [10.5, 0.5]).all()
    assert (places <= [15.5, 4.5]).all()
    apart = np.linalg.norm(places[:, None] - places[None], axis=2) + 9 * np.eye(8)
    assert apart.min() >= 1.0


def test_d26_a_circle_fits_the_world() -> None:
    text = (
        "world: {width: 12, height: 8, offset: [2, 0]}\nrobot: {number: 2, distribution: {name: circle}, " + DIFF + "}"
    )
    simulation = run(text, steps=0)
    assert simulation.state.pose[0, :, :2] == pytest.approx(np.array([[11.5, 4.0], [4.5, 4.0]]))
    assert simulation.state.goal[0, :, :2] == pytest.approx(np.array([[4.5, 4.0], [11.5, 4.0]]))


def test_d27_a_role_must_be_that_of_its_section() -> None:
    assert body("obstacle: {role: obstacle}").role == "obstacle"
    assert problems("obstacle: {role: robot}") == [
        "1 obstacle.role: must be 'obstacle' in this section (or left out), got 'robot'"
    ]


def test_d28_states_are_cut_and_filled_and_their_size_is_checked() -> None:
    assert body(f"robot: {{{DIFF}, state: [1, 2, 3, 4, 5]}}").state == (1, 2, 3)
    assert body(f"robot: {{{DIFF}, state: [1]}}").state == (1, 0, 0)
    assert problems(f"robot: {{{DIFF}, state_dim: 5}}") == ["1 robot.state_dim: must be 3 for 'diff', got 5"]


def test_d29_the_number_of_velocities_is_checked() -> None:
    assert problems(f"robot: {{{DIFF}, vel_dim: 3}}") == ["1 robot.vel_dim: must be 2 for 'diff', got 3"]


def test_d30_a_goal_is_not_drawn_unless_asked_or_learned() -> None:
    robot = body(f"robot: {{{DIFF}, goal: [1, 1]}}")
    assert not body_style(robot).show_goal
    assert body_style(robot, learner=True).show_goal
    assert body_style(body(f"robot: {{{DIFF}, plot: {{show_goal: true}}}}")).show_goal


def test_d31_headings_are_marked_where_there_is_one() -> None:
    car = "kinematics: {name: acker, wheelbase: 0.3}"
    shown = [
        body_style(body(text)).show_arrow
        for text in (f"robot: {{{DIFF}}}", f"robot: {{{car}}}", "robot: {kinematics: {name: omni_angular}}")
    ]
    assert shown == [True, True, True]
    assert not body_style(body("robot: {kinematics: {name: omni}}")).show_arrow
    assert body_style(body(f"obstacle: {{{DIFF}}}")).show_arrow
    assert not body_style(body("obstacle: {}")).show_arrow


def test_d32_the_layer_of_arrows_is_that_of_robots() -> None:
    plot = ObjectPlot()
    assert plot.arrow_zorder is None
    assert body_style(body(f"robot: {{{DIFF}}}")).order == 3


def test_d33_the_format_of_saved_figures_is_a_default(tmp_path: Path) -> None:
    data = {"world": {"plot": {"saved_figure": {"format": "svg"}}}, "robot": {}}
    with irsim_gym.load(data) as world:
        assert world.save_figure(tmp_path / "one").suffix == ".svg"
        assert world.save_figure(tmp_path / "two.png").suffix == ".png"


def test_d34_d35_d36_keys_of_the_keyboard_are_known_and_the_behaviours_go_on() -> None:
    """Without a window a file that asks for a keyboard runs by its behaviours; with one, see tests/gui."""
    keyboard = scenario("gui: {keyboard: {key_id: 1}}").gui.keyboard
    assert (keyboard.backend, keyboard.key_lv_max, keyboard.key_ang_max, keyboard.key_id) == ("pynput", 3.0, 1.0, 1)
    robot = {"kinematics": {"name": "diff"}, "goal": [5, 0], "behavior": {"name": "dash"}}
    with pytest.warns(UserWarning, match="behaviours drive"):
        world = irsim_gym.load({"world": {"control_mode": "keyboard"}, "robot": robot})
    world.step()
    assert world.robot.state[0] > 0.0


def test_d37_frames_come_after_whole_steps() -> None:
    with irsim_gym.load({"world": {"step_time": 0.1, "sample_time": 0.3}, "robot": {}}) as world:
        sampled = []
        for _ in range(9):
            world.step()
            sampled.append(world.sampling)
    assert sampled == [False, False, True] * 3


def test_d38_offset_moves_axes_and_default_places_but_no_given_states() -> None:
    file = scenario("world: {offset: [20, 10]}\nrobot: [{state: [21, 11, 0]}, {distribution: {name: random}}]")
    simulation = irsim_gym.compile(file)
    simulation.reset()
    assert simulation.model.bounds.tolist() == [20, 10, 30, 20]
    assert simulation.state.pose[0, 0, :2].tolist() == [21, 11]
    assert (simulation.state.pose[0, 1, :2] >= [20.5, 10.5]).all()
    layout = Renderer(file, simulation.model, simulation.state).layout
    assert layout.bounds == (20, 10, 30, 20)


def test_d39_rvo_sees_surfaces() -> None:
    """A box of 8 m, whose centre is never within neighbor_threshold: IR-SIM's robots drive into it."""
    text = (
        "world: {width: 20}\n"
        "robot: {kinematics: {name: omni}, state: [1, 5.3], goal: [19, 5.3], behavior: {name: rvo}}\n"
        "obstacle: {shape: {name: rectangle, length: 8, width: 8}, state: [8, 5]}"
    )
    simulation = run(text, steps=60)
    assert not simulation.state.collided.any()
    assert simulation.state.pose[0, 0, 0] > 2.0


def test_d40_wide_bodies_straight_ahead_are_seen() -> None:
    text = "robot: {fov: 0.6, fov_radius: 5}\nobstacle: {state: [1.2, 0], shape: {name: circle, radius: 1.0}}"
    simulation = run(text.replace("{fov", "{unobstructed: true, fov"), steps=0)
    assert simulation.detected(0)[0].tolist() == [False, True]


def test_every_row_has_its_test() -> None:
    names = " ".join(name for name in globals() if name.startswith("test_d"))
    assert [k for k in range(1, 41) if f"d{k}_" not in names] == []


def test_examples_of_the_rows_are_files_too(tmp_path: Path) -> None:
    """The same from a file: names come from it where it gives none."""
    file = tmp_path / "hall.yaml"
    file.write_text("robot: {}", encoding="utf-8")
    assert load_scenario(file).name == "hall"
