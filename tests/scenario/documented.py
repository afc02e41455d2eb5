"""The YAML examples of IR-SIM's documentation page, as data. A fragment is put into the smallest frame around it.

``MAP`` stands where the page names a map file that does not come with this package.
"""

from __future__ import annotations

import textwrap

MAP = "cavern.png"

WHOLE = {
    "quick start": """
        world:
          height: 10
          width: 10
          step_time: 0.1
          sample_time: 0.1
          offset: [0, 0]
          collision_mode: 'stop'
          plot:
            show_title: true
            figure_pixels: [1000, 800]
        robot:
          - kinematics: {name: 'diff'}
            shape: {name: 'circle', radius: 0.2}
            state: [1, 1, 0]
            goal: [9, 9, 0]
            behavior: {name: 'dash'}
        obstacle:
          - number: 10
            distribution: {name: 'random'}
            shape:
              - {name: 'circle', radius: 1.0}
              - {name: 'rectangle', length: 1.5, width: 1.2}
            state:
              - [5, 5, 0]
              - [4, 4, 0]
          - shape: {name: 'rectangle', length: 1.5, width: 1.2}
            state: [6, 5, 1]
          - shape: {name: 'linestring', vertices: [[5, 5], [4, 0], [1, 6]] }
            state: [0, 0, 0]
            unobstructed: True
        """,
    "world": f"""
        world:
          name: "world"
          height: 10
          width: 10
          step_time: 0.1
          sample_time: 0.1
          offset: [0, 0]
          control_mode: 'keyboard'
          collision_mode: 'stop'
          obstacle_map: "{MAP}"
          mdownsample: 2
          status: "Running"
          plot:
            show_title: true
            title: "Custom Simulation Title"
            figure_pixels: [1200, 800]
            saved_figure:
              dpi: 150
              format: "png"
        """,
    "number": "robot:\n  - number: 5",
    "name": """
        robot:
          - name: "r1"
            kinematics: {name: 'diff'}
            shape: {name: 'circle', radius: 0.2}
            state: [1, 1, 0]
            goal: [9, 9, 0]
        """,
    "names": """
        robot:
          - number: 3
            name: ["r1", "r2", "r3"]
            distribution: {name: 'circle', center: [5, 5, 0], radius: 4.0}
            kinematics: {name: 'diff'}
            shape: {name: 'circle', radius: 0.2}
        """,
    "keyboard": """
        world:
          control_mode: 'keyboard'
        gui:
          keyboard:
            backend: 'pynput'
            global_hook: true
            key_id: 0
            key_lv_max: 3.0
            key_ang_max: 1.0
        """,
    "mouse": "gui:\n  mouse:\n    zoom_factor: 1.1",
    "multi-robot rvo": """
        robot:
          - number: 10
            distribution: {name: 'circle', radius: 4.0, center: [5, 5]}
            kinematics: {name: 'diff'}
            shape:
              - {name: 'circle', radius: 0.2}
            behavior: {name: 'rvo', vxmax: 1.5, vymax: 1.5, acce: 1.0, factor: 1.0}
            vel_min: [-3, -3.0]
            vel_max: [3, 3.0]
            color: ['royalblue', 'red', 'green', 'orange', 'purple', 'yellow', 'cyan', 'magenta', 'lime', 'pink',
                    'brown']
            arrive_mode: position
            goal_threshold: 0.15
            plot:
              show_trail: true
              show_goal: true
              trail_fill: true
              trail_alpha: 0.2
              show_trajectory: false
        """,
    "mixed obstacles": """
        obstacle:
          - shape: {name: 'circle', radius: 1.0}
            state: [5, 5, 0]
          - shape: {name: 'rectangle', length: 1.5, width: 1.2}
            state: [6, 5, 1]
          - shape: {name: 'linestring', vertices: [[5, 5], [4, 0], [1, 6]] }
            state: [0, 0, 0]
            unobstructed: True
          - shape:
              name: 'polygon'
              vertices:
                - [4.5, 4.5]
                - [5.5, 4.5]
                - [5.5, 5.5]
                - [4.5, 5.5]
        """,
    "ackermann vehicle": """
        robot:
          - kinematics: {name: 'acker'}
            shape: {name: 'rectangle', length: 4.6, width: 1.6, wheelbase: 3}
            state: [1, 1, 0, 0]
            goal: [40, 40, 0]
            vel_max: [4, 1]
            behavior: {name: 'dash'}
            plot:
              show_trajectory: True
        """,
    "sensor integration": """
        robot:
          - kinematics: {name: 'diff'}
            shape: {name: 'circle', radius: 0.3}
            state: [2, 2, 0]
            goal: [8, 8, 0]
            behavior: {name: 'rvo'}
            sensors:
              - name: 'lidar2d'
                range_min: 0.1
                range_max: 8.0
                angle_range: 6.28
                number: 360
                noise: True
                std: 0.1
                offset: [0, 0, 0]
                color: 'red'
            plot:
              show_sensor: True
              show_fov: True
              fov_color: 'lightgreen'
              fov_alpha: 0.3
        """,
}

OF_WORLD = {"map": f"obstacle_map: '{MAP}'"}

# Fragments of an entry, by the other keys that it needs around it.
DRIVE = "kinematics: {name: 'diff'}"
OF_ENTRY = {
    DRIVE: {
        "random distribution": "distribution: {name: 'random', range_low: [0, 0, -3.14], range_high: [10, 10, 3.14]}",
        "circle distribution": "distribution: {name: 'circle', center: [5, 5, 0], radius: 4.0}",
        "state": "state: [1.0, 1.0, 0.2]",
        "velocity": "velocity: [1.0, 0.5]",
        "goal": "goal: [10.0, 10.0, 0.2]",
        "goals": "goal:\n  - [[10.0, 10.0, 0.2], [5.0, 4.0, 1.0], [3.0, 3.0, 2.0]]",
        "state_dim": "state_dim: 3",
        "vel_dim": "vel_dim: 2",
        "group": "group: 1",
        "limits": ("vel_min: [-1, -1]\nvel_max: [1, 1]\nacce: [0.5, 0.1]\nangle_range: [-pi, pi]\ngoal_threshold: 0.1"),
        "circle": "shape: {name: 'circle', radius: 0.2, center: [0, 0]}",
        "rectangle": "shape: {name: 'rectangle', length: 1.0, width: 0.5}",
        "polygon": (
            "shape:\n  name: 'polygon'\n  vertices:\n    - [4.5, 4.5]\n    - [5.5, 4.5]\n    - [5.5, 5.5]\n"
            "    - [4.5, 5.5]"
        ),
        "linestring": (
            "shape:\n  name: 'linestring'\n  vertices:\n    - [4.5, 4.5]\n    - [5.5, 4.5]\n    - [5.5, 5.5]\n"
            "    - [4.5, 5.5]"
        ),
        "random polygon": (
            "shape:\n  - {name: 'polygon', random_shape: true, center_range: [5, 10, 40, 30], "
            "avg_radius_range: [0.5, 2], irregularity_range: [0, 1], spikeyness_range: [0, 1], "
            "num_vertices_range: [4, 5]}"
        ),
        "random linestring": (
            "shape:\n  - {name: 'linestring', random_shape: true, center_range: [5, 10, 40, 30], "
            "avg_radius_range: [0.5, 2], irregularity_range: [0, 1], spikeyness_range: [0, 1], "
            "num_vertices_range: [4, 5]}"
        ),
        "dash": (
            "behavior: {name: 'dash', wander: True, range_low: [0, 0, -3.14], range_high: [10, 10, 3.14], "
            "angle_tolerance: 0.1}"
        ),
        "rvo": "behavior: {name: 'rvo', vxmax: 1.5, vymax: 1.5, acce: 1.0, factor: 1.0, mode: 'rvo', wander: False}",
        "static": "static: True",
        "sensors": (
            "sensors:\n  - name: 'lidar2d'\n    range_min: 0\n    range_max: 5\n    angle_range: 3.14\n"
            "    number: 200\n    noise: False\n    std: 0.2\n    angle_std: 0.2\n    offset: [0, 0, 0]\n    alpha: 0.3"
        ),
        "field of view": "fov: 1.57\nfov_radius: 5.0",
        "arrive_mode": "arrive_mode: 'position'",
        "unobstructed": "unobstructed: True",
        "color": "color: 'r'",
        "description": "description: 'car_blue.png'",
        "plot": (
            "plot:\n  obj_linestyle: '--'\n  obj_zorder: 3\n  obj_color: 'blue'\n  obj_alpha: 0.8\n"
            "  obj_linewidth: 2.0\n"
            "  show_goal: True\n  goal_color: 'red'\n  goal_alpha: 0.7\n  goal_zorder: 2\n"
            "  show_text: True\n  text_color: 'black'\n  text_size: 12\n  text_alpha: 0.9\n  text_zorder: 5\n"
            "  show_arrow: True\n  arrow_color: 'gold'\n  arrow_length: 0.5\n  arrow_width: 0.8\n  arrow_alpha: 0.9\n"
            "  arrow_zorder: 4\n"
            "  show_trajectory: True\n  traj_color: 'green'\n  traj_style: '-'\n  traj_width: 0.6\n  traj_alpha: 0.6\n"
            "  traj_zorder: 1\n"
            "  show_trail: True\n  trail_freq: 3\n  trail_edgecolor: 'purple'\n  trail_linewidth: 1.0\n"
            "  trail_alpha: 0.5\n  trail_fill: False\n  trail_color: 'purple'\n  trail_zorder: 0\n"
            "  show_sensor: True\n  show_fov: True\n  fov_color: 'lightblue'\n  fov_edge_color: 'blue'\n"
            "  fov_alpha: 0.3\n"
            "  fov_zorder: 1"
        ),
    },
    f"number: 3\n{DRIVE}": {
        "manual distribution": (
            "distribution: {name: 'manual'}\nstate: [[1, 1, 0], [2, 2, 0], [3, 3, 0]]\n"
            "goal: [[9, 9, 0], [8, 8, 0], [7, 7, 0]]"
        )
    },
    "state: [5, 5, 0]": {
        "diff": "kinematics: {name: 'diff', noise: True, alpha: [0.03, 0, 0, 0.03]}",
        "omni": "kinematics: {name: 'omni', noise: True, alpha: [0.03, 0, 0, 0.03]}",
    },
    "shape: {name: rectangle, wheelbase: 0.6}": {
        "acker": "kinematics: {name: 'acker', noise: True, alpha: [0.03, 0, 0, 0.03], mode: 'steer'}"
    },
}


def _entry(frame: str, fragment: str) -> str:
    keys = textwrap.indent(f"{frame}\n{fragment}", "    ")
    return f"robot:\n  -{keys[3:]}\n"


EXAMPLES = {
    **{name: textwrap.dedent(text) for name, text in WHOLE.items()},
    **{name: f"world:\n  {text}\n" for name, text in OF_WORLD.items()},
    **{name: _entry(frame, text) for frame, texts in OF_ENTRY.items() for name, text in texts.items()},
}
