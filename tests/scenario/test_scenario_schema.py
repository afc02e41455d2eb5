"""JSON Schema and option tables: made from the declarations, so that they cannot be wrong about them."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

import jsonschema
import pytest
import yaml

from irsim_gym.base import families
from irsim_gym.base.options import kind, option
from irsim_gym.base.registry import Entry
from irsim_gym.scenario.reference.option_tables import markdown, option_tables
from irsim_gym.scenario.reference.schema import json_schema
from irsim_gym.scenario.specs import library

# Every key of IR-SIM's language, with its documented default where it has one of its own.
LANGUAGE: dict[str, str] = {
    "world": (
        "name height width step_time sample_time offset control_mode collision_mode status obstacle_map "
        "mdownsample plot step_mode fog_map fog_map_resolution"
    ),
    "world.plot": "saved_figure figure_pixels show_title title no_axis tight viewpoint",
    "world.plot.saved_figure": "dpi bbox_inches format pad_inches facecolor transparent",
    "robot, obstacle": (
        "name number distribution kinematics shape state velocity goal behavior group_behavior role color "
        "static vel_min vel_max acce angle_range goal_threshold sensors arrive_mode description group "
        "group_name unobstructed plot state_dim vel_dim fov fov_radius"
    ),
    "distribution random": "range_low range_high min_distance",
    "distribution circle": "center radius",
    "kinematics diff": "noise alpha",
    "kinematics omni": "noise alpha frame",
    "kinematics omni_angular": "noise alpha",
    "kinematics acker": "noise alpha mode wheelbase",
    "shape circle": "radius center random_shape radius_range wheelbase",
    "shape rectangle": "length width wheelbase",
    "shape polygon": (
        "vertices random_shape is_convex number center_range avg_radius_range irregularity_range spikeyness_range "
        "num_vertices_range wheelbase"
    ),
    "shape linestring": (
        "vertices random_shape is_convex number center_range avg_radius_range irregularity_range spikeyness_range "
        "num_vertices_range wheelbase"
    ),
    "shape compound": "parts",
    "behavior dash": "wander loop target_roles range_low range_high angle_tolerance",
    "behavior rvo": ("wander loop target_roles range_low range_high vxmax vymax acce factor mode neighbor_threshold"),
    "behavior sfm": (
        "vmax neighbor_threshold relaxation_time force_factor_desired force_factor_social "
        "force_factor_obstacle sigma_obstacle lambda_importance gamma n_angular n_velocity safety_radius "
        "target_roles"
    ),
    "group behavior orca": ("neighborDist maxNeighbors timeHorizon timeHorizonObst safe_radius maxSpeed"),
    "group behavior sfm": "social_groups vmax",
    "obstacle map image": "path",
    "obstacle map perlin": "resolution complexity fill fractal attenuation seed",
    "sensor lidar2d": (
        "range_min range_max angle_range number scan_time noise std angle_std offset alpha color has_velocity"
    ),
    "sensor fmcw_lidar2d": (
        "range_min range_max angle_range number scan_time noise std angle_std offset alpha color motion_compensate "
        "velocity_noise_std"
    ),
    "gui.keyboard": "backend global_hook key_lv_max key_ang_max key_lv key_ang key_id",
    "gui.mouse": "zoom_factor",
    "plot": (
        "obj_linestyle obj_zorder obj_color obj_alpha obj_linewidth show_goal goal_color goal_alpha "
        "goal_zorder show_text text_color text_size text_alpha text_zorder text_position show_goal_text "
        "show_arrow arrow_color arrow_length arrow_width arrow_alpha arrow_zorder show_trajectory traj_color "
        "traj_style traj_width traj_alpha traj_zorder keep_traj_length show_trail trail_freq trail_type "
        "trail_edgecolor trail_color trail_linewidth trail_alpha trail_fill trail_zorder keep_trail_length "
        "show_sensor show_fov fov_color fov_edge_color fov_alpha fov_zorder"
    ),
}
DEFAULTS = {
    ("world", "sample_time"): "0.1",
    ("world", "status"): "'None'",
    ("world.plot", "figure_pixels"): "",
    ("robot, obstacle", "goal_threshold"): "0.1",
    ("robot, obstacle", "angle_range"): "[-3.14159, 3.14159]",
    ("sensor lidar2d", "angle_range"): "3.14159",
    ("sensor lidar2d", "number"): "100",
    ("sensor lidar2d", "angle_std"): "0.02",
    ("behavior rvo", "neighbor_threshold"): "3",
    ("gui.keyboard", "backend"): "'pynput'",
    ("plot", "arrow_zorder"): "",
    ("plot", "trail_linewidth"): "0.8",
}


@pytest.fixture(scope="module")
def schema() -> dict[str, Any]:
    return json_schema()


def accepts(schema: dict[str, Any], text: str) -> bool:
    return bool(jsonschema.Draft202012Validator(schema).is_valid(yaml.safe_load(text)))


def test_is_a_schema_and_is_json(schema: dict[str, Any]) -> None:
    jsonschema.Draft202012Validator.check_schema(schema)
    assert json.loads(json.dumps(schema, allow_nan=False)) == schema


@pytest.mark.parametrize("name", library.scenario_names())
def test_shipped_scenarios_fit(name: str, schema: dict[str, Any]) -> None:
    assert accepts(schema, library.names()[name].read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    "text",
    [
        "{}",
        "world:",
        "robot: {kinematics: {name: diff}, goal: [1, 2], vel_max: [[1, 1], [2, 2]]}",
        "robot: [{number: 2, goal_threshold: [0.1, 0.2], name: [a, b]}]",
        "world: {step_time: 1/10, offset: [pi, 0]}",
        "robot: {sensors: [{number: 3}, {type: lidar2d}]}",
        "robot: {sensors: [[{number: 3}], [{name: lidar2d}]]}",
        "obstacle: {shape: [{name: circle, radius: 2*3}, {name: rectangle}]}",
        "irsim: {world: {name: a}}",
        "custom: [1, 2]",
        "task: navigation",
        "task: {agents: [ann, bob], max_steps: 100 * $n, ended: vanish, team_reward: 1/2, audit: false}",
        "task: {name: blank, action: discrete, rewards: [time, {name: progress, use: false}], endings: [arrived]}",
        "plot: {show_goal: true}",
        "world: {plot: {saved_figure: {dpi: 3}}}",
        "world: {obstacle_map: cavern.png, mdownsample: 2, fog_map: true}",
        "world: {obstacle_map: {name: perlin, resolution: 1/10, seed: 3}}",
        "world: {obstacle_map: [[0, 100], [true, false]]}",
        "parameters: {n: {default: 4, min: pi, choices: [a, 2], meaning: Some.}}",
        "robot: {number: $n, kinematics: {name: $drive, noise: $noise}, vel_max: [$v, 'max(2, $w_2)'], static: $s}",
    ],
)
def test_accepts(text: str, schema: dict[str, Any], tmp_path: Any) -> None:
    assert accepts(schema, text)


@pytest.mark.parametrize(
    "text",
    [
        "wrld: {}",
        "world: {width: -1}",
        "world: {width: wide}",
        "world: {control_mode: mouse}",
        "robot: {kinematics: {name: dif}}",
        "robot: {kinematics: {name: omni, frame: map}}",
        "robot: {kinematics: {nme: diff}}",
        "robot: {shape: {name: circle, radius: 0}}",
        "robot: {shape: {name: circle, length: 1}}",
        "robot: {role: obstacle}",
        "robot: {sensors: [{number: 0}]}",
        "robot: {sensors: [{name: camera}]}",
        "world: {plot: {saved_figure: {dpy: 3}}}",
        "gui: {keyboard: {backend: qt}}",
        "world: {obstacle_map: {name: perlin}}",
        "world: {obstacle_map: 3}",
        "world: {width: $}",
        "task: {max_step: 100}",
        "task: {team_reward: 2}",
        "task: {ended: go}",
        "task: {max_steps: 0}",
        "task: {agents: {ann: 1}}",
        "task: {rewards: {name: time}}",
        "parameters: {n: {default: 4}}",
        "parameters: {2n: {default: 4, meaning: Some.}}",
        "parameters: {n: 4}",
    ],
)
def test_refuses(text: str, schema: dict[str, Any]) -> None:
    assert not accepts(schema, text)


def test_user_kinds_are_in_it(monkeypatch: pytest.MonkeyPatch) -> None:
    @kind
    class Sonar:
        """A sonar."""

        reach: float = option(2.0, gt=0.0, unit="m", meaning="Reach.")

    monkeypatch.setattr(families.SENSORS, "_entries", dict(families.SENSORS._entries))
    families.SENSORS._entries["sonar"] = Entry("sonar", Sonar)
    assert accepts(json_schema(), "robot: {sensors: [{name: sonar, reach: 3}]}")
    assert not accepts(json_schema(), "robot: {sensors: [{name: sonar, reach: -3}]}")


def test_every_key_of_the_language_is_declared() -> None:
    declared = {title: {row.key for row in rows} for title, rows in option_tables()}
    missing = {title: set(keys.split()) - declared[title] for title, keys in LANGUAGE.items()}
    assert {title: keys for title, keys in missing.items() if keys} == {}


def test_defaults_in_the_tables() -> None:
    rows = {(title, row.key): row for title, rows in option_tables() for row in rows}
    assert {key: rows[key].default for key in DEFAULTS} == DEFAULTS
    radius = rows["shape circle", "radius"]
    assert (radius.default, radius.unit, radius.allowed) == ("0.2", "m", "a number, > 0")


def test_every_option_has_a_meaning() -> None:
    assert [(title, row.key) for title, rows in option_tables() for row in rows if not row.meaning.endswith(".")] == []


def test_tables_as_markdown() -> None:
    text = markdown()
    assert "| `radius` | 0.2 | m | a number, > 0 | Radius. |  |" in text


def test_the_package_reads_without_compiling() -> None:
    code = (
        "import sys; from irsim_gym.scenario.reading import load; "
        "from irsim_gym.scenario.reference import schema; "
        "from irsim_gym.scenario.specs import library, spec; library.scenario_names(); "
        "print([name for name in ('numba', 'matplotlib', 'shapely', 'torch') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
