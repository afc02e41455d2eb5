"""Every key of IR-SIM's language can be used: one file holds them all, with values other than the defaults."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from test_scenario_schema import LANGUAGE

from irsim_gym.base import families
from irsim_gym.rendering import Renderer
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.reference.option_tables import option_tables
from irsim_gym.simulator.engine import compile

OUTLINE = (
    "random_shape: true, is_convex: true, number: 1, center_range: [0, 0, 0, 0], avg_radius_range: [0.2, 0.3],\n"
    "        irregularity_range: [0, 0.5], spikeyness_range: [0, 0.5], num_vertices_range: [4, 6], wheelbase: 0.2"
)
LIDAR = (
    "range_min: 0.1, range_max: 4, angle_range: pi, number: 9, scan_time: 0.2, noise: true, std: 0.1,\n"
    "        angle_std: 0.01, offset: [0.1, 0, 0], alpha: 0.2, color: teal"
)
BOUNDS = "range_low: [1, 1, -3], range_high: [9, 9, 3]"
BEHAVIOR = f"wander: true, loop: true, target_roles: robot, {BOUNDS}"
FORCES = (
    "vmax: 1, neighbor_threshold: 5, relaxation_time: 0.4, force_factor_desired: 2, force_factor_social: 2,\n"
    "        force_factor_obstacle: 9, sigma_obstacle: 0.7, lambda_importance: 1.5, gamma: 0.3, n_angular: 2.5,\n"
    "        n_velocity: 2, safety_radius: 0.1, target_roles: obstacle"
)
PLOT = """
      obj_linestyle: '--'
      obj_zorder: 2
      obj_color: teal
      obj_alpha: 0.9
      obj_linewidth: 2
      show_goal: true
      goal_color: red
      goal_alpha: 0.4
      goal_zorder: 0
      show_text: true
      show_goal_text: true
      text_color: navy
      text_size: 8
      text_alpha: 0.9
      text_zorder: 7
      text_position: [0, 1]
      show_arrow: true
      arrow_color: gold
      arrow_length: 0.5
      arrow_width: 0.4
      arrow_alpha: 0.9
      arrow_zorder: 5
      show_trajectory: true
      traj_color: gray
      traj_style: ':'
      traj_width: 0.1
      traj_alpha: 0.4
      traj_zorder: 2
      keep_traj_length: 9
      show_trail: true
      trail_freq: 1
      trail_type: circle
      trail_edgecolor: black
      trail_color: pink
      trail_linewidth: 1
      trail_alpha: 0.3
      trail_fill: true
      trail_zorder: 2
      keep_trail_length: 3
      show_sensor: false
      show_fov: true
      fov_color: lightblue
      fov_edge_color: blue
      fov_alpha: 0.2
      fov_zorder: 2
"""
TEXT = f"""
world:
  name: everything
  height: 20
  width: 30
  step_time: 0.05
  sample_time: 0.2
  offset: [0, 0]
  control_mode: keyboard
  collision_mode: contact
  gravity: 9.8
  friction: 0.4
  restitution: 0.2
  drive_tau: 0.1
  status: Running
  obstacle_map: {{name: perlin, resolution: 1, complexity: 0.2, fill: 0.01, fractal: 2, attenuation: 0.4, seed: 3}}
  mdownsample: 2
  step_mode: internal
  update: simultaneous
  fog_map: true
  fog_map_resolution: 0.5
  plot:
    saved_figure: {{dpi: 50, bbox_inches: standard, format: jpg, pad_inches: 0.2, facecolor: white, transparent: false}}
    figure_pixels: [300, 200]
    show_title: false
    title: Everything
    no_axis: true
    tight: false
    viewpoint: first
robot:
  - name: first
    number: 1
    distribution: {{name: manual}}
    kinematics: {{name: diff, noise: true, alpha: [0.01, 0.01, 0.01, 0.01], tau: 0.2}}
    shape: {{name: circle, radius: 0.3, center: [0.1, 0], random_shape: true, radius_range: [0.2, 0.3], wheelbase: 0.1}}
    state: [10, 2, 0]
    velocity: [0.1, 0]
    goal: [14, 2]
    behavior: {{name: dash, angle_tolerance: 0.2, {BEHAVIOR}}}
    role: robot
    color: green
    static: false
    vel_min: [-0.5, -1]
    vel_max: [0.5, 1]
    acce: [1, 2]
    angle_range: [0, 2*pi]
    goal_threshold: 0.2
    arrive_mode: state
    description: diff_robot0.png
    group: 3
    group_name: leaders
    unobstructed: true
    state_dim: 3
    vel_dim: 2
    fov: 1.5
    fov_radius: 3
    sensors:
      - {{name: lidar2d, has_velocity: true, {LIDAR}}}
      - {{name: contact2d, force_scale: 0.1, marker_size: 5, linewidth: 1, alpha: 0.5, color: red, plot: {{alpha: 1}}}}
      - {{name: fmcw_lidar2d, motion_compensate: true, velocity_noise_std: 0.1, {LIDAR}}}
    plot: {PLOT}
  - distribution: {{name: random, min_distance: 0.5, {BOUNDS}}}
    kinematics: {{name: omni, frame: body, noise: true, alpha: [0.01, 0.01]}}
    behavior: {{name: rvo, vxmax: 1, vymax: 1, acce: 0.5, factor: 2, mode: hrvo, neighbor_threshold: 4, {BEHAVIOR}}}
  - distribution: {{name: circle, center: [15, 10], radius: 3}}
    number: 2
    kinematics: {{name: omni}}
    group_behavior: {{name: orca, neighborDist: 9, maxNeighbors: 5, timeHorizon: 3, timeHorizonObst: 2,
        safe_radius: 0.2, maxSpeed: 0.5}}
  - kinematics: {{name: omni_angular, noise: true, alpha: [0.1, 0.1, 0.1]}}
    state: [20, 5]
  - kinematics: {{name: acker, noise: true, alpha: [0.1, 0, 0, 0.1], mode: angular, wheelbase: 0.5}}
    shape: {{name: rectangle, length: 0.8, width: 0.4, wheelbase: 0.5}}
    state: [22, 9, 0, 0.1]
  - kinematics: {{name: diff}}
    behavior: {{name: sfm, {FORCES}}}
    state: [24, 12]
    goal: [28, 12]
  - number: 2
    kinematics: {{name: omni}}
    group_behavior: {{name: sfm, social_groups: [[0, 1]], vmax: 1}}
    state: [[24, 15], [24, 16]]
    goal: [28, 15]
obstacle:
  - shape: {{name: polygon, {OUTLINE}}}
    state: [3, 15]
  - shape: {{name: linestring, {OUTLINE}}}
    state: [6, 15]
  - shape: {{name: polygon, vertices: [[0, 0], [1, 0], [0, 1]]}}
    state: [9, 15]
    mass: 2
    inertia: 0.1
    friction: 0.3
    restitution: 0.5
    velocity: [1, 0, 0.5]
  - shape: {{name: compound, parts: [{{name: circle, radius: 0.2, pose: [0.2, 0, 0]}}, {{name: rectangle}}]}}
    state: [12, 17]
gui:
  keyboard: {{backend: mpl, global_hook: true, key_lv_max: 2, key_ang_max: 2, key_lv: 0.1, key_ang: 0.1, key_id: 1}}
  mouse: {{zoom_factor: 1.5}}
custom: {{mine: 1}}
"""


def test_the_file_holds_every_key() -> None:
    keys = {key for keys in LANGUAGE.values() for key in keys.split()} - {"path"}
    assert [key for key in sorted(keys) if f"{key}:" not in TEXT] == []


@pytest.mark.parametrize("wrapper", [False, True])
def test_every_key_runs_and_is_drawn(wrapper: bool) -> None:
    data = yaml.safe_load(TEXT)
    scenario = load_scenario({"irsim": data} if wrapper else data)
    simulation = compile(scenario)
    simulation.reset(seed=0)
    for _ in range(5):
        simulation.step()
    assert np.isfinite(simulation.state.pose).all()
    assert scenario.custom == {"mine": 1}
    renderer = Renderer(scenario, simulation.model, simulation.state, simulation.sensors)
    assert renderer.frame().shape == (200, 300, 3)


def test_every_kind_is_a_table() -> None:
    titles = {title for title, _ in option_tables()}
    kinds = {f"{registry.family} {entry.name}" for registry in families.every() for entry in registry}
    assert kinds <= titles
    assert set(LANGUAGE) <= titles
