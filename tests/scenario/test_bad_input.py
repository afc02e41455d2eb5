"""Scenario files with mistakes: each is told with its line, its path, and what would be right."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import irsim_gym
from irsim_gym.errors import ScenarioError, ScenarioWarning
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.checking.validation import MAX_PROBLEMS

NAMES = "'diff', 'omni', 'omni_angular' or 'acker'"
WORLD = {
    "unknown section": ("wrold: {}", "1 wrold: unknown key (did you mean 'world'?)"),
    "unknown key": ("world:\n  step_tme: 0.1", "2 world.step_tme: unknown key (did you mean 'step_time'?)"),
    "far from any key": ("gui:\n  qqq: 0.1", "2 gui.qqq: unknown key; known: keyboard, mouse"),
    "world is a number": ("world: 3", "1 world: must be a mapping of options, got 3"),
    "world is a list": ("world: [1]", "1 world: must be a mapping of options, got [1]"),
    "negative size": ("world:\n  width: -3", "2 world.width: must be > 0, got -3"),
    "no size": ("world:\n  height: 0", "2 world.height: must be > 0, got 0"),
    "nan": ("world:\n  width: .nan", "2 world.width: must be finite, got nan"),
    "inf": ("world:\n  width: .inf", "2 world.width: must be finite, got inf"),
    "text for a number": ("world:\n  width: wide", "2 world.width: must be a number, got 'wide'"),
    "inf without its dot": (
        "world:\n  width: inf",
        "2 world.width: must be a number, got 'inf' (infinity is written .inf)",
    ),
    "bool for a number": ("world:\n  width: true", "2 world.width: must be a number, got true"),
    "mapping for a number": ("world:\n  width: {a: 1}", "2 world.width: must be a number, got a mapping"),
    "huge number": ("world:\n  width: 1" + "0" * 400, f"2 world.width: must be a number, got 1{'0' * 36}..."),
    "number for text": ("world:\n  name: 3", "2 world.name: must be text, got 3"),
    "empty name": ("world:\n  name: ''", "2 world.name: must not be empty"),
    "step time": ("world:\n  step_time: 0", "2 world.step_time: must be > 0, got 0"),
    "offset too long": ("world:\n  offset: [1, 2, 3]", "2 world.offset: must be a list of 2 numbers, got [1, 2, 3]"),
    "offset of text": ("world:\n  offset:\n    - 1\n    - b", "4 world.offset[1]: must be a number, got 'b'"),
    "mode": (
        "world:\n  collision_mode: stpo",
        "2 world.collision_mode: must be 'stop', 'unobstructed', 'unobstructed_obstacles' or 'contact', got 'stpo' "
        "(did you mean 'stop'?)",
    ),
    "mode of a wrong type": (
        "world:\n  control_mode: [auto]",
        "2 world.control_mode: must be 'auto' or 'keyboard', got ['auto']",
    ),
    "plot key": (
        "world:\n  plot: {show_titel: true}",
        "2 world.plot.show_titel: unknown key (did you mean 'show_title'?)",
    ),
    "deep plot key": (
        "world:\n  plot:\n    saved_figure:\n      dpi: 0",
        "4 world.plot.saved_figure.dpi: must be >= 1, got 0",
    ),
    "pixels": ("world:\n  plot: {figure_pixels: [10, 800]}", "2 world.plot.figure_pixels[0]: must be >= 16, got 10"),
    "title": ("world:\n  plot: {show_title: 'yes'}", "2 world.plot.show_title: must be true or false, got 'yes'"),
    "viewpoint": (
        "world:\n  plot: {viewpoint: 3}",
        "2 world.plot.viewpoint: must be text or a list of 2 numbers, got 3",
    ),
    "viewpoint of nobody": (
        "world:\n  plot: {viewpoint: robot_1}\nrobot: {}",
        "2 world.plot.viewpoint: no body named 'robot_1' (did you mean 'robot_0'?)",
    ),
    "gui": ("gui:\n  keybord: {}", "2 gui.keybord: unknown key (did you mean 'keyboard'?)"),
    "key speed": ("gui:\n  keyboard: {key_lv_max: -1}", "2 gui.keyboard.key_lv_max: must be >= 0, got -1"),
    "backend": ("gui: {keyboard: {backend: qt}}", "1 gui.keyboard.backend: must be 'pynput' or 'mpl', got 'qt'"),
    "zoom": ("gui:\n  mouse: {zoom_factor: 1}", "2 gui.mouse.zoom_factor: must be > 1, got 1"),
    "task": ("task: 3", "1 task: must be the name of a task or a mapping, got 3"),
    "wrapper": ("irsim: 3", "1 irsim: must be a mapping with sections such as world and robot, got 3"),
    "inside the wrapper": ("irsim:\n  world:\n    width: -1", "3 irsim.world.width: must be > 0, got -1"),
    "twice with the wrapper": (
        "world: {}\nirsim:\n  world: {}",
        "3 irsim.world: given both inside and outside the wrapper key",
    ),
    "unknown in the wrapper": ("irsim:\n  robt: {}", "2 irsim.robt: unknown key (did you mean 'robot'?)"),
    "plot for all": ("plot: {obj_alpha: 2}", "1 plot.obj_alpha: must be <= 1, got 2"),
}
ENTRIES = {
    "section": ("robot: 3", "1 robot: must be a list of robots or one mapping, got 3"),
    "entry": ("obstacle:\n  - 3", "2 obstacle[0]: must be a mapping of options, got 3"),
    "null entry": ("obstacle:\n  -", "2 obstacle[0]: must be a mapping of options, got nothing"),
    "unknown key": ("robot:\n  - goals: [1, 2]", "2 robot[0].goals: unknown key (did you mean 'goal'?)"),
    "dict form": ("robot:\n  goals: [1, 2]", "2 robot.goals: unknown key (did you mean 'goal'?)"),
    "number": ("robot: {number: two}", "1 robot.number: must be a whole number, got 'two'"),
    "fraction": ("robot: {number: 2.5}", "1 robot.number: must be a whole number, got 2.5"),
    "negative number": ("robot: {number: -1}", "1 robot.number: must be >= 0, got -1"),
    "very many": ("robot: {number: 1000000000}", "1 robot.number: must be <= 100000, got 1000000000"),
    "many in all": ("robot: [{number: 60000}, {number: 60000}]", "1 robot[1]: too many bodies: at most 100000"),
    "range backwards": (
        "obstacle: {number_range: [3, 2]}",
        "1 obstacle.number_range: must be [least, most] with 0 <= least <= most, got [3, 2]",
    ),
    "range and number": (
        "obstacle: {number_range: [1, 2], number: 2}",
        "1 obstacle.number_range: cannot stand beside number",
    ),
    "distribution": (
        "robot:\n  distribution: {name: randm}",
        "2 robot.distribution.name: no distribution named 'randm' (did you mean 'random'?)",
    ),
    "distribution without name": (
        "robot:\n  distribution: {range_low: [0, 0, 0]}",
        "2 robot.distribution.name: is required: 'manual', 'circle', 'random' or 'cells'",
    ),
    "distribution text": (
        "robot:\n  distribution: random",
        "2 robot.distribution: must be a mapping such as {name: random}, got 'random'",
    ),
    "two numbers": (
        "robot:\n  distribution: {name: random, range_low: [0, 0]}",
        "2 robot.distribution.range_low: must be a list of 3 numbers, got [0, 0]",
    ),
    "crossed bounds": (
        "robot:\n  distribution: {name: random, range_low: [5, 0, 0], range_high: [1, 1, 1]}",
        "2 robot.distribution.range_low: must not exceed range_high, got [5, 0, 0] and [1, 1, 1]",
    ),
    "third dimension": (
        "robot:\n  distribution: {name: random, 3d: true}",
        "2 robot.distribution.3d: the world is two-dimensional: only false is allowed",
    ),
    "drive": (
        "robot:\n  - kinematics: {name: dif}",
        "2 robot[0].kinematics.name: no kinematics named 'dif' (did you mean 'diff'?)",
    ),
    "drive without name": ("robot:\n  kinematics: {noise: false}", f"2 robot.kinematics.name: is required: {NAMES}"),
    "drive as text": (
        "robot:\n  kinematics: diff",
        "2 robot.kinematics: must be a mapping such as {name: diff}, got 'diff'",
    ),
    "name of a wrong type": ("robot:\n  kinematics: {name: 3}", f"2 robot.kinematics.name: must be {NAMES}, got 3"),
    "unknown option": (
        "robot:\n  kinematics: {name: diff, nois: true}",
        "2 robot.kinematics.nois: unknown key (did you mean 'noise'?)",
    ),
    "behaviour": (
        "robot:\n  kinematics: {name: diff}\n  behavior: {name: dsh}",
        "3 robot.behavior.name: no behavior named 'dsh' (did you mean 'dash'?)",
    ),
    "behaviour of a group": (
        "robot:\n  kinematics: {name: diff}\n  behavior: {name: orca}",
        "3 robot.behavior.name: 'orca' is a group_behavior: write `group_behavior: {name: orca}`",
    ),
    "group behaviour of one": (
        "robot:\n  kinematics: {name: diff}\n  group_behavior: {name: dash}",
        "3 robot.group_behavior.name: 'dash' is a behavior: write `behavior: {name: dash}`",
    ),
    "behaviour without name": (
        "robot:\n  kinematics: {name: diff}\n  behavior: {wander: true}",
        "3 robot.behavior.name: is required: 'dash', 'dwa', 'hybrid_astar', 'pursuit', 'recorded', 'rvo' or 'sfm'",
    ),
    "wander bounds": (
        "robot:\n  kinematics: {name: diff}\n  behavior: {name: dash, range_low: [11, 0, 0]}",
        "3 robot.behavior.range_low: must not exceed range_high, got [11, 0, 0] and [10, 10, 3.14159]",
    ),
    "negative radius": (
        "robot:\n  - shape:\n      name: circle\n      radius: -0.3",
        "4 robot[0].shape.radius: must be > 0, got -0.3",
    ),
    "zero length": ("obstacle: {shape: {name: rectangle, length: 0}}", "1 obstacle.shape.length: must be > 0, got 0"),
    "nan radius": ("robot: {shape: {name: circle, radius: .nan}}", "1 robot.shape.radius: must be finite, got nan"),
    "shape": ("robot: {shape: {name: circel}}", "1 robot.shape.name: no shape named 'circel' (did you mean 'circle'?)"),
    "shape without name": (
        "robot: {shape: {radius: 2}}",
        "1 robot.shape.name: is required: 'circle', 'rectangle', 'polygon', 'linestring' or 'compound'",
    ),
    "no vertices": (
        "obstacle: {shape: {name: polygon}}",
        "1 obstacle.shape.vertices: is required unless random_shape is true",
    ),
    "no points": (
        "obstacle: {shape: {name: linestring}}",
        "1 obstacle.shape.vertices: is required unless random_shape is true",
    ),
    "two vertices": (
        "obstacle: {shape: {name: polygon, vertices: [[0, 0], [1, 1]]}}",
        "1 obstacle.shape.vertices: a polygon needs three different corners",
    ),
    "same vertices": (
        "obstacle: {shape: {name: polygon, vertices: [[0, 0], [1, 1], [0, 0]]}}",
        "1 obstacle.shape.vertices: a polygon needs three different corners",
    ),
    "crossing sides": (
        "obstacle: {shape: {name: polygon, vertices: [[0, 0], [1, 1], [1, 0], [0, 1]]}}",
        "1 obstacle.shape.vertices: the outline crosses or touches itself (self-intersection[0.5 0.5])",
    ),
    "vertex of text": (
        "obstacle:\n  shape:\n    name: polygon\n    vertices:\n      - [0, 0]\n      - [1, a]\n      - [1, 1]",
        "6 obstacle.shape.vertices[1][1]: must be a number, got 'a'",
    ),
    "vertex in space": (
        "obstacle:\n  shape:\n    name: polygon\n    vertices:\n      - [0, 0]\n      - [1, 0, 2]\n      - [1, 1]",
        "6 obstacle.shape.vertices[1]: must be a list of 2 numbers, got [1, 0, 2]",
    ),
    "infinite vertex": (
        "obstacle:\n  shape:\n    name: polygon\n    vertices:\n      - [0, 0]\n      - [1, 0]\n      - [1, .inf]",
        "7 obstacle.shape.vertices[2][1]: must be finite, got inf",
    ),
    "radius range": (
        "obstacle: {shape: {name: circle, random_shape: true, radius_range: [2, 1]}}",
        "1 obstacle.shape.radius_range: must be [low, high] with low <= high, got [2, 1]",
    ),
    "vertex count": (
        "obstacle: {shape: {name: polygon, random_shape: true, num_vertices_range: [4, 1000000]}}",
        "1 obstacle.shape.num_vertices_range: must be [low, high] with 3 <= low < high <= 1000 (high is excluded), "
        "got [4, 1000000]",
    ),
    "number of outlines": (
        "obstacle:\n  shape:\n    name: polygon\n    random_shape: true\n    number: 3",
        "5 obstacle.shape.number: a body has one outline: write number beside shape, not in it",
    ),
    "state": ("robot: {state: here}", "1 robot.state: must be a list of numbers, got 'here'"),
    "empty state": ("robot: {state: []}", "1 robot.state: must have at least 1 values, got 0"),
    "state with nan": ("robot:\n  state: [1, 2, .nan]", "2 robot.state[2]: must be finite, got nan"),
    "far state": ("robot:\n  state: [1e300, 2]", "2 robot.state[0]: must be <= 1e+07, got 1e+300"),
    "goal": ("robot: {goal: 3}", "1 robot.goal: must be [x, y] or [x, y, heading], got 3"),
    "short goal": ("robot: {goal: [3]}", "1 robot.goal: must be [x, y] or [x, y, heading], got [3]"),
    "goal of text": ("robot:\n  goal: [3, there]", "2 robot.goal[1]: must be a number, got 'there'"),
    "second goal of one body": (
        "robot:\n  goal: [[3, 3], [4]]",
        "2 robot.goal[1]: must be [x, y] or [x, y, heading], got [4]",
    ),
    "one of several goals": (
        "robot:\n  number: 2\n  goal:\n    - [[3, 3], [4]]\n    - [[3, 3]]",
        "4 robot.goal[0][1]: must be [x, y] or [x, y, heading], got [4]",
    ),
    "limits": (
        "robot:\n  kinematics: {name: diff}\n  vel_min: [1, 1]\n  vel_max: [0, 1]",
        "3 robot.vel_min: vel_min must not exceed vel_max, got [1, 1] and [0, 1]",
    ),
    "limit against the default": (
        "robot:\n  kinematics: {name: diff}\n  vel_max: [-2, 1]",
        "3 robot.vel_max: vel_min must not exceed vel_max, got [-1, -1] and [-2, 1]",
    ),
    "option of another part": (
        "obstacle:\n  shape:\n    name: compound\n    parts:\n    - {name: circle, length: 2}\n    - {name: polygon}",
        "5 obstacle.shape.parts[0].length: belongs to a rectangle, not to a circle",
        "6 obstacle.shape.parts[1].vertices: is required for a polygon",
    ),
    "part that crosses itself": (
        "obstacle: {shape: {name: compound, parts: [{name: polygon, vertices: [[0, 0], [1, 1], [1, 0], [0, 1]]}]}}",
        "1 obstacle.shape.parts[0].vertices: the outline crosses or touches itself (self-intersection[0.5 0.5])",
    ),
    "compound without parts": ("obstacle: {shape: {name: compound}}", "1 obstacle.shape.parts: is required"),
    "limits of another drive": (
        "robot:\n  kinematics: {name: diff}\n  vel_max: [1, 1, 1]",
        "3 robot.vel_max: must have 2 numbers (linear, angular) for 'diff', got [1, 1, 1]",
    ),
    "one limit": (
        "robot:\n  kinematics: {name: diff}\n  vel_max: 1",
        "3 robot.vel_max: must be a list of numbers, got 1",
    ),
    "infinite limit": (
        "robot:\n  kinematics: {name: diff}\n  vel_max: [.inf, 1]",
        "3 robot.vel_max[0]: must be finite, got inf",
    ),
    "acceleration": ("robot:\n  kinematics: {name: diff}\n  acce: [-1, .inf]", "3 robot.acce[0]: must be >= 0, got -1"),
    "velocity": (
        "robot:\n  kinematics: {name: diff}\n  velocity: [1, 2, 3]",
        "3 robot.velocity: must have at most 2 numbers (linear, angular) for 'diff', got [1, 2, 3]",
    ),
    "number with a point": ("robot: {number: 100.0}", "1 robot.number: must be a whole number, got 100.0"),
    "part of a number": ("robot: {number: 2.5}", "1 robot.number: must be a whole number, got 2.5"),
    "wide angle range": (
        "robot:\n  angle_range: [0, 6.3]",
        "2 robot.angle_range: must be a full turn wide (2 pi), such as [-pi, pi], got [0, 6.3]",
    ),
    "angle range": (
        "robot:\n  angle_range: [-1, 1]",
        "2 robot.angle_range: must be a full turn wide (2 pi), such as [-pi, pi], got [-1, 1]",
    ),
    "state_dim": (
        "robot:\n  kinematics: {name: diff}\n  state_dim: 4",
        "3 robot.state_dim: must be 3 for 'diff', got 4",
    ),
    "vel_dim": ("robot:\n  kinematics: {name: diff}\n  vel_dim: 3", "3 robot.vel_dim: must be 2 for 'diff', got 3"),
    "role": (
        "obstacle:\n  - role: robot",
        "2 obstacle[0].role: must be 'obstacle' in this section (or left out), got 'robot'",
    ),
    "threshold": ("robot: {goal_threshold: -1}", "1 robot.goal_threshold: must be >= 0, got -1"),
    "thresholds": (
        "robot: {number: 3, goal_threshold: [0.1, 0.2]}",
        "1 robot.goal_threshold: must be one value, or a list of 3 (one per body), got [0.1, 0.2]",
    ),
    "static": ("robot: {static: 'no'}", "1 robot.static: must be true or false, got 'no'"),
    "arrive mode": ("robot: {arrive_mode: pose}", "1 robot.arrive_mode: must be 'position' or 'state', got 'pose'"),
    "group": ("robot: {group: -1}", "1 robot.group: must be >= 0, got -1"),
    "colour": ("robot: {color: blu}", "1 robot.color: no colour named 'blu' (did you mean 'blue'?)"),
    "inside a misspelt key": (
        "robot:\n  shpae: {name: circle, raduis: 1}",
        "2 robot.shpae: unknown key (did you mean 'shape'?)",
        "2 robot.shpae.raduis: unknown key (did you mean 'radius'?)",
    ),
    "inside a misspelt section": (
        "wrold:\n  widht: 0\nrobots:\n  - {kinematics: {name: dif}}",
        "1 wrold: unknown key (did you mean 'world'?)",
        "2 wrold.widht: must be > 0, got 0",
        "2 wrold.widht: unknown key (did you mean 'width'?)",
        "3 robots: unknown key (did you mean 'robot'?)",
        "4 robots[0].kinematics.name: no kinematics named 'dif' (did you mean 'diff'?)",
    ),
    "a colour and more": (
        "robot:\n  plot: {traj_color: nope, show_trajectry: 3, goal_alpha: 2}",
        "2 robot.plot.goal_alpha: must be <= 1, got 2",
        "2 robot.plot.show_trajectry: must be true or false, got 3",
        "2 robot.plot.show_trajectry: unknown key (did you mean 'show_trajectory'?)",
        "2 robot.plot.traj_color: no colour named 'nope'",
    ),
    "colour from 0 to 255": (
        "robot: {color: [255, 0, 0]}",
        "1 robot.color: must be a name, '#rrggbb', or 3 or 4 numbers from 0 to 1, got [255, 0, 0]",
    ),
    "cycle for a sensor": ("robot: {sensors: [{color: cycle}]}", "1 robot.sensors[0].color: no colour named 'cycle'"),
    "second colour": (
        "robot:\n  number: 2\n  color:\n    - red\n    - gren",
        "5 robot.color[1]: no colour named 'gren' (did you mean 'green'?)",
    ),
    "image": (
        "robot: {description: car_blu.png}",
        "1 robot.description: no image 'car_blu.png' (did you mean 'car_blue.png'?)",
    ),
    "image far from any": (
        "robot: {description: tank.svg}",
        "1 robot.description: no image 'tank.svg'; shipped: car_blue.png, car_green.png, car_red.png, diff_robot0.png, "
        "diff_robot1.png; or name a file beside the scenario",
    ),
    "plot": ("robot: {plot: {show_gaol: true}}", "1 robot.plot.show_gaol: unknown key (did you mean 'show_goal'?)"),
    "plot colour": ("robot: {plot: {traj_color: '#12'}}", "1 robot.plot.traj_color: no colour named '#12'"),
    "line style": (
        "robot: {plot: {traj_style: '=='}}",
        "1 robot.plot.traj_style: must be '-', '--', '-.', ':', 'solid', 'dashed', 'dashdot' or 'dotted', got '=='",
    ),
    "sensors": (
        "robot: {sensors: lidar2d}",
        "1 robot.sensors: must be a list of sensors such as [{name: lidar2d}], got 'lidar2d'",
    ),
    "sensor": (
        "robot:\n  sensors:\n    - name: lidr2d",
        "3 robot.sensors[0].name: no sensor named 'lidr2d' (did you mean 'lidar2d'?)",
    ),
    "beams": ("robot:\n  sensors:\n    - number: 0", "3 robot.sensors[0].number: must be >= 1, got 0"),
    "sensor key": (
        "robot:\n  sensors:\n    - type: lidar2d\n      rnge_max: 3",
        "4 robot.sensors[0].rnge_max: unknown key (did you mean 'range_max'?)",
    ),
    "sensor colour": (
        "robot:\n  sensors: [{color: rd}]",
        "2 robot.sensors[0].color: no colour named 'rd' (did you mean 'red'?)",
    ),
    "spread of the sensor's noise": (
        "robot:\n  sensors:\n    - {noise: true, std: -0.1}\n    - {noise: true, angle_std: -1}",
        "3 robot.sensors[0].std: must be >= 0, got -0.1",
        "4 robot.sensors[1].angle_std: must be >= 0, got -1",
    ),
    "contact sensor": (
        "robot: {sensors: [{type: contact2d, force_scale: -1}]}",
        "1 robot.sensors[0].force_scale: must be >= 0, got -1",
    ),
    "sensor drawing": (
        "robot:\n  sensors:\n    - {plot: {colour: red}}\n    - {plot: {color: rd}}",
        "3 robot.sensors[0].plot.colour: unknown key (did you mean 'color'?)",
        "4 robot.sensors[1].plot.color: no colour named 'rd' (did you mean 'red'?)",
    ),
    "fmcw band": (
        "robot:\n  sensors: [{name: fmcw_lidar2d, range_min: 7, range_max: 3}]",
        "2 robot.sensors[0].range_min: must not exceed range_max, got 7 and 3",
    ),
    "field of view without depth": (
        "robot:\n  fov: pi/2",
        "2 robot.fov: needs fov_radius too, or a lidar that defines it",
    ),
    "depth of view without width": (
        "robot:\n  fov_radius: 5",
        "2 robot.fov_radius: needs fov too, or a lidar that defines it",
    ),
    "no field of view": (
        "robot:\n  fov: 0\n  fov_radius: -1",
        "2 robot.fov: must be > 0, got 0",
        "3 robot.fov_radius: must be > 0, got -1",
    ),
    "everything at once": (
        "robot:\n  - kinematics: {name: dif}\n    angle_range: [0, 1]\n    name: a\nobstacle: {name: a, group: x}",
        "2 robot[0].kinematics.name: no kinematics named 'dif' (did you mean 'diff'?)",
        "3 robot[0].angle_range: must be a full turn wide (2 pi), such as [-pi, pi], got [0, 1]",
        "5 obstacle.group: must be a whole number, got 'x'",
        "5 obstacle.name: the name 'a' is given to several bodies (first in line 4)",
    ),
    "sensor band": (
        "robot:\n  sensors: [{range_min: 7, range_max: 3}]",
        "2 robot.sensors[0].range_min: must not exceed range_max, got 7 and 3",
    ),
    "own name twice": (
        "robot:\n  - name: a\n  - name: b\nobstacle:\n  - name: a",
        "5 obstacle[0].name: the name 'a' is given to several bodies (first in line 2)",
    ),
    "one name for three": (
        "robot:\n  number: 3\n  name: a",
        "3 robot.name: the name 'a' is given to several bodies; a list gives each body its own",
    ),
    "automatic name taken": (
        "robot:\n  - name: robot_1\n  - state: [1, 1]",
        "3 robot[1].name: the name 'robot_1' is given to several bodies (first in line 2)",
    ),
}
DRIVES = {
    "option of a drive": (
        "robot:\n  kinematics: {name: acker, mode: ster, wheelbase: 1}",
        "2 robot.kinematics.mode: must be 'steer' or 'angular', got 'ster' (did you mean 'steer'?)",
    ),
    "car without axles": (
        "robot:\n  - state: [1, 1]\n    kinematics: {name: acker}",
        "3 robot[0].kinematics.wheelbase: is required for 'acker', here or in the shape: the axle distance",
    ),
    "three variances for two velocities": (
        "robot: {kinematics: {name: omni, alpha: [0.1, 0.1, 0.1]}}",
        "1 robot.kinematics.alpha: must be 2 numbers, or 4 of which the first and the last count, got 3",
    ),
    "two variances for three velocities": (
        "robot: {kinematics: {name: omni_angular, alpha: [0.1, 0.1]}}",
        "1 robot.kinematics.alpha: must be a list of 3 numbers, got [0.1, 0.1]",
    ),
    "negative variance": (
        "robot: {kinematics: {name: diff, noise: true, alpha: [0.03, 0, -1, 0.03]}}",
        "1 robot.kinematics.alpha: variances must not be negative, got [0.03, 0, -1, 0.03]",
    ),
    "limits of another drive": (
        "robot:\n  kinematics: {name: omni_angular}\n  vel_max: [1, 1]\n  state_dim: 4\n  vel_dim: 2",
        "3 robot.vel_max: must have 3 numbers (forward, left, angular) for 'omni_angular', got [1, 1]",
        "4 robot.state_dim: must be 3 for 'omni_angular', got 4",
        "5 robot.vel_dim: must be 3 for 'omni_angular', got 2",
    ),
}
DRIVE = "robot:\n  kinematics: {name: diff}\n"
HUGE = {
    "speed": (
        "robot:\n  kinematics: {name: diff}\n  vel_max: [1.0e+300, 2]",
        "3 robot.vel_max[0]: must lie between -1e+07 and 1e+07, got 1e+300",
    ),
    "radius": (
        "robot:\n  shape: {name: circle, radius: 1.0e+8}",
        "2 robot.shape.radius: must lie between -1e+07 and 1e+07, got 1e+08",
    ),
    "corner": (
        "obstacle:\n  shape: {name: polygon, vertices: [[0, 0], [1, -1.0e+9], [1, 1]]}",
        "2 obstacle.shape.vertices[1][1]: must lie between -1e+07 and 1e+07, got -1e+09",
    ),
    "range": (
        "robot:\n  sensors: [{range_max: 1.0e+40}]",
        "2 robot.sensors[0].range_max: must lie between -1e+07 and 1e+07, got 1e+40",
    ),
    "noise": (
        "robot:\n  kinematics: {name: diff, noise: true, alpha: [1.0e+99, 0, 0, 0]}",
        "2 robot.kinematics.alpha[0]: must lie between -1e+07 and 1e+07, got 1e+99",
    ),
    "threshold": (
        "robot:\n  goal_threshold: 1e8",
        "2 robot.goal_threshold: must lie between -1e+07 and 1e+07, got 1e+08",
    ),
    "bounds": (
        "robot:\n  distribution: {name: random, range_low: [0, -1.0e+20, 0]}",
        "2 robot.distribution.range_low[1]: must lie between -1e+07 and 1e+07, got -1e+20",
    ),
    "heading": ("robot:\n  state: [1, 1, 1.0e+300]", "2 robot.state[2]: must be <= 1e+07, got 1e+300"),
    "goal": ("robot:\n  goal: [1, 1.0e+300]", "2 robot.goal[1]: must be <= 1e+07, got 1e+300"),
    "acceleration": (
        "robot:\n  kinematics: {name: diff}\n  acce: [.inf, 1.0e+300]",
        "3 robot.acce[1]: must lie between -1e+07 and 1e+07, got 1e+300",
    ),
}
CONTACT = {
    "world": (
        "world:\n  gravity: 0\n  friction: -1\n  restitution: 1.5\n  drive_tau: .inf",
        "2 world.gravity: must be > 0, got 0",
        "3 world.friction: must be >= 0, got -1",
        "4 world.restitution: must be <= 1, got 1.5",
        "5 world.drive_tau: must be finite, got inf",
    ),
    "body": (
        "obstacle:\n  mass: .nan\n  friction: inf\n  inertia: 0\n  restitution: '2'",
        "2 obstacle.mass: must be > 0, got nan",
        "3 obstacle.friction: must be a number, got 'inf' (infinity is written .inf)",
        "4 obstacle.inertia: must be > 0, got 0",
        "5 obstacle.restitution: must be <= 1, got 2",
    ),
    "one of several masses": (
        "obstacle:\n  number: 3\n  mass: [1, -2]\n  friction: []",
        "3 obstacle.mass[1]: must be > 0, got -2",
        "4 obstacle.friction: must be a number, got []",
    ),
    "drive": ("robot:\n  kinematics: {name: diff, tau: -1}", "2 robot.kinematics.tau: must be >= 0, got -1"),
    "a body that coasts decides nothing": (
        "obstacle:\n  mass: 1\n  behavior: {name: dash}",
        "3 obstacle.behavior: a body that coasts (a mass, no drive) decides nothing: add kinematics or remove the "
        "behavior",
    ),
}
CASES = {
    f"{group}: {name}": case
    for group, cases in (("world", WORLD), ("entry", ENTRIES), ("drive", DRIVES), ("huge", HUGE), ("contact", CONTACT))
    for name, case in cases.items()
}


@pytest.mark.parametrize("case", CASES)
def test_problem(case: str, problems: Callable[[str], list[str]]) -> None:
    text, *expected = CASES[case]
    assert problems(text) == expected


def test_text_of_the_error(tmp_path: Path) -> None:
    file = tmp_path / "corridor.yaml"
    file.write_text(
        "\nworld:\n  width: 10\n  step_tme: 0.1\nrobot:\n  - shape: {name: circle, radius: -0.3}\n"
        "    goal: [1, 1]\n    kinematics: {name: dif}\n"
    )
    with pytest.raises(ScenarioError) as caught:
        load_scenario(str(file))
    assert str(caught.value) == (
        f"3 problems in {file}\n"
        f"  {file}:4   world.step_tme: unknown key (did you mean 'step_time'?)\n"
        f"  {file}:6   robot[0].shape.radius: must be > 0, got -0.3\n"
        f"  {file}:8   robot[0].kinematics.name: no kinematics named 'dif' (did you mean 'diff'?)\n"
        "With strict=False, or --lenient in the shell, unknown keys, unknown modes and repeated keys are "
        "warnings."
    )


def test_a_mapping_has_no_lines() -> None:
    with pytest.raises(ScenarioError) as caught:
        load_scenario({"world": {"width": -1}})
    assert str(caught.value) == "1 problem in the given mapping\n  the given mapping   world.width: must be > 0, got -1"


def test_a_mistake_of_fifty_bodies_is_told_once(problems: Callable[[str], list[str]]) -> None:
    text = "robot:\n  - number: 50\n    kinematics: {name: diff}\n    shape: {name: circle, radius: -1}\n"
    text += "    vel_min: [2, 2]\n"
    assert problems(text) == [
        "4 robot[0].shape.radius: must be > 0, got -1",
        "5 robot[0].vel_min: vel_min must not exceed vel_max, got [2, 2] and [1, 1]",
    ]


def test_many_problems_are_cut_off(problems: Callable[[str], list[str]]) -> None:
    told = problems("".join(f"key_{i}: 1\n" for i in range(1000)))
    assert len(told) == MAX_PROBLEMS + 1
    assert told[0] == f"0 more than {MAX_PROBLEMS} problems: the rest is not shown"
    assert told[-1].startswith(f"{MAX_PROBLEMS} key_{MAX_PROBLEMS - 1}: unknown key; known: custom, gui, ")


def test_the_largest_numbers_are_computed_with() -> None:
    """Just within the bounds everything that a learner is told is finite; warnings are errors here."""
    robot = {
        "kinematics": {"name": "diff"},
        "state": [-1e7, 1e7, 1e7],
        "goal": [1e7, -1e7],
        "vel_min": [-1e7, -1e7],
        "vel_max": [1e7, 1e7],
        "goal_threshold": 1e7,
        "sensors": [{"name": "lidar2d", "number": 3, "range_max": 1e7}],
    }
    with pytest.warns(ScenarioWarning, match="a heading of 1e[+]07 is more than a turn"):
        env = irsim_gym.make({"world": {"step_time": 100}, "robot": robot})
    for action in ([1, 1], [-1, 1], [1, 0]):
        env.reset(seed=0)
        observation, reward, *_ = env.step(np.array(action, np.float32))
        assert np.isfinite(observation).all()
        assert np.isfinite(reward)
        assert observation in env.observation_space


def test_problems_of_a_task_get_their_lines(tmp_path: Path) -> None:
    file = tmp_path / "task.yaml"
    file.write_text(
        "irsim:\n  robot: {}\n  task:\n    name: navigation\n    rewards:\n      - {name: time,\n         weight: 1}\n"
    )
    scenario = load_scenario(file)
    problem = scenario.problem(("task", "rewards", 0, "weight"), "must be ...")
    assert (problem.line, problem.path) == (7, "irsim.task.rewards[0].weight")
    assert scenario.problem(("task", "nothing"), "").line == 3
