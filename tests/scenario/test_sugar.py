"""IR-SIM's shorthand: what a short file means."""

from __future__ import annotations

import copy
import dataclasses
import math
import pickle
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from irsim_gym.scenario import Scenario, load_scenario
from irsim_gym.scenario.specs import library
from irsim_gym.scenario.specs.plot_spec import ROBOT_COLOR

Load = Callable[[str], Scenario]
PI = math.pi
NAN = pytest.approx(math.nan, nan_ok=True)
DRIVE = "kinematics: {name: diff}"


def test_defaults_are_the_documented_ones() -> None:
    scenario = load_scenario({"robot": {"kinematics": {"name": "diff"}}, "obstacle": {}})
    world = scenario.world
    assert (scenario.name, world.name, world.width, world.height, world.offset) == ("world", "world", 10, 10, (0, 0))
    assert (world.step_time, world.sample_time, world.collision_mode, world.status) == (0.1, 0.1, "stop", "None")
    robot, obstacle = scenario.bodies
    assert (robot.name, obstacle.name) == ("robot_0", "obstacle_1")
    assert (robot.group, robot.group_name, obstacle.group, obstacle.group_name) == (0, "robot_0", 1, "obstacle_1")
    assert (robot.state, robot.goal, robot.velocity) == ((0, 0, 0), (), (0, 0))
    assert (robot.vel_min, robot.vel_max, robot.acce) == ((-1, -1), (1, 1), (math.inf, math.inf))
    assert (robot.angle_range, robot.goal_threshold, robot.arrive_mode) == ((-PI, PI), 0.1, "position")
    assert robot.shape.radius == 0.2
    assert (robot.static, obstacle.static, robot.unobstructed, robot.sensors) == (False, True, False, ())
    assert (robot.color, obstacle.color) == ("#009E73", "#475569")
    assert obstacle.kinematics is None
    assert obstacle.behavior is None
    assert (scenario.task, scenario.custom, scenario.robots) == ({}, None, (0,))
    assert scenario.gui.keyboard.key_lv_max == 3.0
    assert scenario.gui.mouse.zoom_factor == 1.1


@pytest.mark.parametrize("text", ["{}", "world:", "robot: []", "world: {}\nrobot:\nobstacle:\ngui:\ntask:\nplot:"])
def test_a_file_may_say_nothing(text: str, load: Load) -> None:
    scenario = load(text)
    assert scenario.bodies == ()
    assert scenario.placements == ()


def test_the_file_names_the_world(load: Load) -> None:
    assert load("world: {width: 3}").name == "my"
    assert load("world:").world.name == "my"
    assert load("world: {name: hall}").name == "hall"


def test_null_means_not_given(load: Load) -> None:
    (body,) = load(
        "robot: {goal: null, state: null, shape: null, behavior: {}, kinematics: {}, sensors: , name: ~}"
    ).bodies
    assert (body.goal, body.state, body.name, body.behavior) == ((), (0, 0, 0), "robot_0", None)


def test_sections_are_lists_or_mappings(load: Load) -> None:
    assert load("robot: {state: [1, 2]}").bodies[0].state == (1, 2, 0)
    assert load("robot: [{state: [1, 2]}]").bodies[0].state == (1, 2, 0)
    assert load("irsim: {robot: {state: [1, 2]}}").bodies[0].state == (1, 2, 0)


def test_robots_come_first(load: Load) -> None:
    scenario = load("obstacle: [{number: 2}, {name: wall}]\nrobot: [{number: 2}, {}]")
    assert [body.name for body in scenario.bodies] == [
        "robot_0", "robot_1", "robot_2", "obstacle_3", "obstacle_4", "wall"
    ]  # fmt: skip
    assert [body.group for body in scenario.bodies] == [0, 0, 1, 2, 2, 3]
    assert [body.entry for body in scenario.bodies] == [0, 0, 1, 2, 2, 3]
    assert [spec.members for spec in scenario.placements] == [(0, 1), (2,), (3, 4), (5,)]
    assert [spec.role for spec in scenario.placements] == ["robot", "robot", "obstacle", "obstacle"]
    assert scenario.robots == (0, 1, 2)


def test_an_explicit_group_wins(load: Load) -> None:
    scenario = load("robot: [{group: 7}, {}]\nobstacle: [{}, {group: 2, group_name: walls}]")
    assert [(body.group, body.group_name) for body in scenario.bodies] == [
        (7, "robot_7"), (1, "robot_1"), (8, "obstacle_8"), (2, "walls")
    ]  # fmt: skip


def test_no_bodies(load: Load) -> None:
    scenario = load("robot: [{number: 0}, {}]")
    assert len(scenario.bodies) == 1
    assert [spec.members for spec in scenario.placements] == [(0,)]
    assert scenario.bodies[0].entry == 0


def test_number_range(load: Load) -> None:
    (spec,) = load("obstacle: {number_range: [2, 5]}").placements
    assert (spec.members, spec.number_range) == ((0, 1, 2, 3, 4), (2, 5))
    assert load("obstacle: {number: 3}").placements[0].number_range is None


def test_vectors_are_for_all_and_lists_of_vectors_for_each(load: Load) -> None:
    text = (
        f"robot: {{number: 3, {DRIVE}, vel_max: [1.5, 1], vel_min: [[-1, -1], [-2, -2]], state: [[1, 1, 0], [2, 2]]}}"
    )
    bodies = load(text).bodies
    assert [body.vel_max for body in bodies] == [(1.5, 1)] * 3
    assert [body.vel_min for body in bodies] == [(-1, -1), (-2, -2), (-2, -2)]
    assert [body.state for body in bodies] == [(1, 1, 0), (2, 2, 0), (2, 2, 0)]


def test_the_last_one_repeats_and_surplus_is_left_out(load: Load) -> None:
    bodies = load(
        "obstacle: {number: 3, shape: [{name: circle, radius: 1}, {name: rectangle}],\n"
        "  color: [r, g, b, k], name: [a, b, c, d]}"
    ).bodies
    assert [type(body.shape).__name__ for body in bodies] == ["Circle", "Rectangle", "Rectangle"]
    assert [body.color for body in bodies] == ["r", "g", "b"]
    assert [body.name for body in bodies] == ["a", "b", "c"]
    assert bodies[1].shape is bodies[2].shape


def test_surplus_is_not_read(load: Load) -> None:
    assert load("obstacle: {number: 1, shape: [{name: circle}, {name: nonsense}]}").bodies[0].shape.radius == 0.2


def test_one_number_each_for_scalar_keys(load: Load) -> None:
    bodies = load("robot: {number: 2, goal_threshold: [0.1, pi/4], static: [true, false], group: [3, 4]}").bodies
    assert [body.goal_threshold for body in bodies] == [0.1, PI / 4]
    assert [body.group for body in bodies] == [3, 4]
    assert load("robot: {goal_threshold: [0.3]}").bodies[0].goal_threshold == 0.3


def test_3_14_is_half_a_turn(load: Load) -> None:
    low, high = load("robot: {angle_range: [-3.14, 3.14]}").bodies[0].angle_range
    assert (low, high) == (-3.14, pytest.approx(-3.14 + 2 * PI))


@pytest.mark.parametrize(
    ("number", "goal", "expected"),
    [
        (1, "[3, 4]", [((3, 4, NAN),)]),
        (1, "[3, 4, pi/2]", [((3, 4, PI / 2),)]),
        (2, "[3, 4, 0]", [((3, 4, 0),), ((3, 4, 0),)]),
        (1, "[[3, 4, 0]]", [((3, 4, 0),)]),
        (1, "[[3, 4, 0], [5, 6]]", [((3, 4, 0), (5, 6, NAN))]),
        (3, "[[3, 4, 0], [5, 6, 0]]", [((3, 4, 0),), ((5, 6, 0),), ((5, 6, 0),)]),
        (1, "[[[1, 1, 0], [2, 2, 0]]]", [((1, 1, 0), (2, 2, 0))]),
        (2, "[[[1, 1, 0], [2, 2, 0]]]", [((1, 1, 0), (2, 2, 0))] * 2),
        (2, "[[[1, 1, 0], [2, 2, 0]], [[3, 3, 0]]]", [((1, 1, 0), (2, 2, 0)), ((3, 3, 0),)]),
        (2, "[[[1, 1, 0], [2, 2, 0]], [3, 3, 0]]", [((1, 1, 0), (2, 2, 0)), ((3, 3, 0),)]),
        (1, "[1, 2, 3, 4]", [((1, 2, 3),)]),
        (2, "[null, [3, 4, 0]]", [(), ((3, 4, 0),)]),
    ],
)
def test_goals(number: int, goal: str, expected: list[object], load: Load) -> None:
    bodies = load(f"robot: {{number: {number}, goal: {goal}}}").bodies
    assert [body.goal for body in bodies] == expected


def test_states_are_cut_and_filled(load: Load) -> None:
    bodies = load(
        f"robot: {{number: 4, {DRIVE}, state: [[1], [1, 2], [1, 2, 3], [1, 2, 3, 4]], velocity: [0.5]}}"
    ).bodies
    assert [body.state for body in bodies] == [(1, 0, 0), (1, 2, 0), (1, 2, 3), (1, 2, 3)]
    assert bodies[0].velocity == (0.5, 0)


def test_sensors_for_all_or_for_each(load: Load) -> None:
    shared = load("robot: {number: 2, sensors: [{name: lidar2d, number: 5}, {number: 6}]}").bodies
    assert [[sensor.number for sensor in body.sensors] for body in shared] == [[5, 6], [5, 6]]
    each = load("robot: {number: 3, sensors: [[{number: 5}, {type: lidar2d}], [{number: 6}]]}").bodies
    assert [[sensor.number for sensor in body.sensors] for body in each] == [[5, 100], [6], [6]]
    assert load("robot: {sensors: {number: 7}}").bodies[0].sensors[0].number == 7
    assert load("robot: {sensors: []}").bodies[0].sensors == ()


def test_expressions_stand_for_numbers(load: Load) -> None:
    scenario = load(
        "world: {step_time: 1/10, width: '2 * (3 + 4)', height: 1e1}\n"
        f"robot: {{number: 2*1, {DRIVE}, state: [1, 2, pi/2], angle_range: [0, 2*pi], goal: [1, -pi],\n"
        "  acce: [.inf, 1.5],\n"
        "  sensors: [{angle_range: pi*3/2, number: 2*90, offset: [0, 0, -pi/2]}],\n"
        "  shape: {name: polygon, vertices: [[0, 0], [1/2, 0], [0, 1/2]]}}\n"
    )
    body = scenario.bodies[1]
    assert (scenario.world.step_time, scenario.world.width, scenario.world.height) == (0.1, 14, 10)
    assert (body.state, body.angle_range, body.goal[0][1]) == ((1, 2, PI / 2), (0, 2 * PI), -PI)
    assert body.acce == (math.inf, 1.5)
    assert (body.sensors[0].angle_range, body.sensors[0].number, body.sensors[0].offset[2]) == (1.5 * PI, 180, -PI / 2)
    assert body.shape.vertices == ((0, 0), (0.5, 0), (0, 0.5))


def test_names_are_no_expressions(load: Load) -> None:
    assert [body.name for body in load("robot: {number: 2, name: [pi, 1-2]}").bodies] == ["pi", "1-2"]
    assert load("world: {name: pi}").name == "pi"


@pytest.mark.parametrize(
    ("given", "low"), [("[-pi, pi]", -PI), ("[0, 2*pi]", 0), ("[-3.14159, 3.14159]", -3.14159), ("[pi, 3*pi]", PI)]
)
def test_angle_ranges_of_a_full_turn(given: str, low: float, load: Load) -> None:
    assert load(f"robot: {{angle_range: {given}}}").bodies[0].angle_range == (low, low + 2 * PI)


def test_distributions_draw_states(load: Load) -> None:
    scenario = load(
        "robot: [{distribution: {name: random, 3d: false}, state: [5, 5, 0]}, {distribution: {name: circle}}, {}]"
    )
    assert [body.state for body in scenario.bodies] == [(5, 5, 0), None, (0, 0, 0)]
    assert [type(spec.kind).__name__ for spec in scenario.placements] == [
        "RandomPlacement", "CirclePlacement", "ManualPlacement"
    ]  # fmt: skip


def test_kinematics_in_capitals(load: Load) -> None:
    assert load("robot: {kinematics: {name: Diff}}").bodies[0].kinematics is not None


def test_a_static_body_may_have_a_behaviour(load: Load) -> None:
    assert load("obstacle: {behavior: {name: dash}, static: true}").bodies[0].static


def test_vectors_of_a_body_without_drive_are_not_measured(load: Load) -> None:
    assert load("obstacle: {vel_max: [1, 1, 1], state_dim: 3, role: obstacle}").bodies[0].vel_max == (1, 1)


def test_a_list_may_hold_nothing_for_a_body(load: Load) -> None:
    one, other = load("robot: {number: 2, description: [null, car_red.png], color: [null, red]}").bodies
    assert (one.description, other.description) == (None, "car_red.png")
    assert (one.color, other.color) == (ROBOT_COLOR, "red")


def test_colours_may_be_numbers(load: Load) -> None:
    text = """
robot: {number: 2, color: [[0.2, 0.4, 0.6], [1, 0, 0, 1/2]], plot: {goal_color: [0, 0, 1]},
        sensors: [{color: [1, 1, 1]}]}
"""
    one, other = load(text).bodies
    assert (one.color, other.color) == ("#336699", "#ff000080")
    assert (one.plot.goal_color, one.sensors[0].color) == ("#0000ff", "#ffffff")
    assert load("robot: {number: 3, color: [0.2, 0.4, 0.6]}").bodies[2].color == "#336699"


def test_colours(load: Load) -> None:
    bodies = load("robot: {number: 9, color: cycle}").bodies
    assert len({body.color for body in bodies}) == 8
    assert bodies[0].color == bodies[8].color


def test_plot_for_all_bodies_is_overridden_by_their_own(load: Load) -> None:
    scenario = load("plot: {show_goal: true, goal_alpha: 0.1}\nrobot: [{plot: {goal_alpha: 0.2}}, {}]")
    assert [(body.plot.show_goal, body.plot.goal_alpha) for body in scenario.bodies] == [(True, 0.2), (True, 0.1)]
    bodies = load("robot: {number: 2, plot: [{show_text: true}, {show_trail: true}]}").bodies
    assert [(body.plot.show_text, body.plot.show_trail) for body in bodies] == [(True, False), (False, True)]


def test_images_are_documented_names_or_files(load: Load, tmp_path: Path) -> None:
    assert load("robot: {description: diff_robot1.png}").bodies[0].description == "diff_robot1.png"
    shutil.copy(library.assets("images")["car_red.png"], tmp_path / "mine.png")
    bodies = load(f"robot: {{number: 2, description: [mine.png, {tmp_path / 'mine.png'}]}}").bodies
    assert [body.description for body in bodies] == ["mine.png", str(tmp_path / "mine.png")]


def test_task_and_custom(load: Load) -> None:
    scenario = load("task: navigation\ncustom: {anything: [1, {a: b}]}")
    assert scenario.task == {"name": "navigation"}
    assert scenario.custom == {"anything": [1, {"a": "b"}]}
    assert load("task: {max_steps: 3}").task == {"max_steps": 3}


def test_aliases_share_text_not_meaning(load: Load) -> None:
    scenario = load("robot: {shape: &s {name: circle, radius: 0.5}}\nobstacle: {shape: {<<: *s, radius: 0.6}}")
    assert [body.shape.radius for body in scenario.bodies] == [0.5, 0.6]


def test_an_example_in_irsim_style(load: Load) -> None:
    scenario = load(
        """
        world: {height: 10, width: 10, step_time: 0.1, sample_time: 0.1, offset: [0, 0], control_mode: 'auto',
                collision_mode: 'stop', obstacle_map: null, mdownsample: 1, status: Running,
                plot: {show_title: true, figure_pixels: [1200, 800], saved_figure: {dpi: 150, format: png}}}
        robot:
          - kinematics: {name: 'diff', noise: False, alpha: [0.03, 0, 0, 0.03]}
            shape: {name: 'circle', radius: 0.2, center: [0, 0]}
            state: [1, 1, 0]
            goal: [9, 9, 0]
            acce: [3, .inf]
            behavior: {name: 'dash', wander: True, range_low: [0, 0, -3.14], range_high: [10, 10, 3.14]}
            sensors:
              - {name: 'lidar2d', range_min: 0.1, range_max: 8.0, angle_range: 6.28, number: 360, color: 'red'}
            plot: {obj_linestyle: '--', show_trajectory: True, traj_width: 0.6, trail_color: purple, fov_alpha: 0.3}
        obstacle:
          - number: 10
            distribution: {name: 'random'}
            shape:
              - {name: 'circle', radius: 1.0}
              - {name: 'rectangle', length: 1.5, width: 1.2}
            state:
              - [5, 5, 0]
              - [4, 4, 0]
          - shape: {name: 'linestring', vertices: [[5, 5], [4, 0], [1, 6]]}
            state: [0, 0, 0]
            unobstructed: True
          - shape: {name: polygon, random_shape: true, center_range: [5, 10, 40, 30], avg_radius_range: [0.5, 2],
                    irregularity_range: [0, 1], spikeyness_range: [0, 1], num_vertices_range: [4, 5]}
        gui: {keyboard: {backend: 'pynput', global_hook: true, key_id: 0, key_lv_max: 3.0}, mouse: {zoom_factor: 1.1}}
        """
    )
    assert len(scenario.bodies) == 13
    assert [type(body.shape).__name__ for body in scenario.bodies[1:4]] == ["Circle", "Rectangle", "Rectangle"]
    assert scenario.bodies[11].unobstructed


def test_a_scenario_is_frozen_and_can_be_copied() -> None:
    scenario = load_scenario("cluttered_room")
    assert pickle.loads(pickle.dumps(scenario)) == scenario
    assert copy.deepcopy(scenario) == scenario
    with pytest.raises(dataclasses.FrozenInstanceError):
        scenario.name = "other"  # type: ignore[misc]


@pytest.mark.parametrize("name", library.scenario_names())
def test_shipped_scenarios_load_by_name_and_by_path(name: str) -> None:
    file = library.names()[name]
    assert load_scenario(name) == load_scenario(file) == load_scenario(str(file))
    assert load_scenario(name).name == name


def test_a_file_without_suffix_is_found_unless_a_shipped_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine").write_text("world: {width: 3}")
    Path("empty_goal").write_text("world: {width: 3}")
    assert load_scenario("mine").world.width == 3
    assert load_scenario("empty_goal").file != "empty_goal"


def test_many_bodies_share_their_options(load: Load) -> None:
    bodies = load(f"robot: {{number: 2000, {DRIVE}, shape: {{name: circle}}, sensors: [{{number: 3}}]}}").bodies
    assert len({id(body.shape) for body in bodies}) == len({id(body.sensors) for body in bodies}) == 1
