"""Option tables: made from the declarations, so that they cannot be wrong about them."""

from __future__ import annotations

import subprocess
import sys

from irsim_gym.scenario.reference.option_tables import markdown, option_tables

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
        "from irsim_gym.scenario.reference import option_tables; "
        "from irsim_gym.scenario.specs import library, spec; library.scenario_names(); "
        "print([name for name in ('numba', 'matplotlib', 'shapely', 'torch') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
