"""Every drawing option of the documentation: what is changed, and where alone the picture may change.

The world is 4 x 4 m on 160 x 160 pixels. A disc-shaped robot stands at (1.4, 1.3), or has driven a curve from there;
its goal is at (3.0, 3.1), and a box stands at (3.1, 1.0).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]
Colour = tuple[int, int, int]
Point = tuple[float, float]

RED, BLUE, LIME, WHITE = (255, 0, 0), (0, 0, 255), (0, 255, 0), (255, 255, 255)
GREEN, SLATE, FOG = (0, 158, 115), (71, 85, 105), (195, 202, 211)
START, RADIUS, GOAL, TOLERANCE = (1.4, 1.3, 0.4), 0.35, (3.0, 3.1), 0.25
BOX = (3.1, 1.0)
DRIVEN = (1.584, 1.388)
"""A point of the path: after 0.2 m straight ahead, a little on the left since the robot turns."""
FAR = 1.1
"""Range of the sensor [m]."""


@dataclass(frozen=True)
class Moment:
    """Where things are in a picture.

    Attributes:
        x: Abscissa of each pixel's centre [m], shape ``(height, width)``.
        y: Its ordinate [m].
        poses: The robot's poses so far, the last one now, shape ``(n, 3)``.
    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    poses: NDArray[np.float64]

    def disc(self, x: float, y: float, radius: float) -> Mask:
        return (self.x - x) ** 2 + (self.y - y) ** 2 < radius * radius

    def box(self, x_min: float, y_min: float, x_max: float, y_max: float) -> Mask:
        return (self.x > x_min) & (self.x < x_max) & (self.y > y_min) & (self.y < y_max)

    def along(self, radius: float, first: int = 0) -> Mask:
        return np.any([self.disc(x, y, radius) for x, y, _ in self.poses[first:]], axis=0)

    @property
    def here(self) -> tuple[float, float]:
        return float(self.poses[-1, 0]), float(self.poses[-1, 1])


Area = Callable[[Moment], Mask]


def everywhere(moment: Moment) -> Mask:
    return np.ones_like(moment.x, np.bool_)


def body(moment: Moment) -> Mask:
    return moment.disc(*moment.here, RADIUS + 0.08)


def edge(moment: Moment) -> Mask:
    return body(moment) & ~moment.disc(*moment.here, RADIUS - 0.1)


def ahead(moment: Moment) -> Mask:
    """Where an arrow of 1 x 0.5 m is."""
    (x, y), heading = moment.here, moment.poses[-1, 2]
    forth = (moment.x - x) * np.cos(heading) + (moment.y - y) * np.sin(heading)
    aside = (moment.y - y) * np.cos(heading) - (moment.x - x) * np.sin(heading)
    return np.asarray((forth > -0.06) & (forth < 1.06) & (np.abs(aside) < 0.31))


def goal(moment: Moment) -> Mask:
    return moment.disc(*GOAL, TOLERANCE + 0.08)


def goal_arrow(moment: Moment) -> Mask:
    """From the goal to the lower right."""
    forth = (moment.x - GOAL[0]) * np.cos(-0.67) + (moment.y - GOAL[1]) * np.sin(-0.67)
    aside = (moment.y - GOAL[1]) * np.cos(-0.67) - (moment.x - GOAL[0]) * np.sin(-0.67)
    return np.asarray((forth > -0.06) & (forth < TOLERANCE + 0.3) & (np.abs(aside) < 0.15))


def box(moment: Moment) -> Mask:
    return moment.disc(*BOX, 0.55)


def path(moment: Moment) -> Mask:
    return moment.along(0.2)


def trail(moment: Moment) -> Mask:
    return moment.along(RADIUS + 0.08)


def sensed(moment: Moment) -> Mask:
    return moment.disc(*moment.here, FAR + 0.1)


def beyond_sight(moment: Moment) -> Mask:
    return ~moment.disc(*moment.here, FAR - 0.3)


def label(moment: Moment) -> Mask:
    """Above the robot, where its name stands in large letters."""
    x, y = moment.here
    return moment.box(x - 0.35, y + RADIUS, x + 0.35, y + RADIUS + 0.5)


def goal_label(moment: Moment) -> Mask:
    """Below the goal's circle."""
    return moment.box(GOAL[0] - 0.35, GOAL[1] - TOLERANCE - 0.55, GOAL[0] + 0.35, GOAL[1] - TOLERANCE)


def both(*areas: Area) -> Area:
    return lambda moment: np.any([area(moment) for area in areas], axis=0)


@dataclass(frozen=True)
class Case:
    """One option.

    Attributes:
        change: What is changed: dotted keys and values.
        area: Where alone the picture may change.
        given: What is also there in the picture that it is compared with.
        shows: Colours that points [m] have afterwards, from the robot where ``relative``.
        steps: Steps that the robot has driven.
        changes: The picture changes at all.
        name: Of its reference picture; by default the last changed key.
    """

    change: Mapping[str, Any]
    area: Area
    given: Mapping[str, Any] = field(default_factory=dict)
    shows: Mapping[Point, Colour] = field(default_factory=dict)
    steps: int = 0
    changes: bool = True
    name: str = ""

    @property
    def label(self) -> str:
        return self.name or list(self.change)[-1].rpartition(".")[2]


def robot(**options: Any) -> dict[str, Any]:
    """Return drawing options of the robot with their dotted keys."""
    return {f"robot.plot.{key}": value for key, value in options.items()}


def lidar(**options: Any) -> dict[str, Any]:
    """Return the robot with a lidar all around, and options of that lidar."""
    return {"robot.sensors": [{"name": "lidar2d", "range_max": FAR, "number": 60, "angle_range": 6.2831, **options}]}


def fmcw(**options: Any) -> dict[str, Any]:
    """Return the robot with a scanner that sees velocities, and options of how these are drawn."""
    plot = {"velocity_color_max": 1.0, **options}
    sensor = {"name": "fmcw_lidar2d", "range_max": 2.2, "number": 40, "angle_range": 3.14, "plot": plot}
    return {"robot.sensors": [sensor], "robot.state": [1.4, 1.3, -0.15], "obstacle.state": [3.1, 1.2, 0.2]}


def seen_velocities(moment: Moment) -> Mask:
    return moment.disc(*moment.here, 2.3)


OVERLAPPING = {"robot.state": [*BOX, 0], "obstacle.unobstructed": True}
GOAL_ON = robot(show_goal=True)
TEXT_ON = robot(show_text=True, text_size=26)
ARROW_ON = robot(show_arrow=True, arrow_length=1.0, arrow_width=0.5)
PATH_ON = robot(show_trajectory=True, traj_width=0.2, traj_alpha=1.0, obj_alpha=0.0)
TRAIL_ON = robot(show_trail=True, trail_freq=4, obj_alpha=0.0)
FILLED = robot(show_trail=True, trail_freq=4, obj_alpha=0.0, trail_fill=True, trail_alpha=1.0)
FOV_ON = {"robot.fov": 1.5, "robot.fov_radius": FAR, **robot(show_fov=True)}
TITLE_ON = {"world.plot.show_title": True}

CASES = (
    Case({"robot.color": "red"}, body, shows={START[:2]: RED}),
    Case({"robot.color": [0.0, 0.0, 1.0, 0.5]}, body, shows={START[:2]: (127, 127, 255)}, name="color_with_opacity"),
    Case({"robot.color": "none"}, body, shows={START[:2]: WHITE}, name="color_none"),
    Case(robot(obj_color="blue"), body, {"robot.color": "red"}, shows={START[:2]: BLUE}),
    Case(robot(obj_alpha=0.5), body, shows={START[:2]: (127, 206, 185)}),
    Case(robot(obj_linestyle="--"), edge, robot(obj_linewidth=8)),
    Case(robot(obj_linestyle=":"), edge, robot(obj_linewidth=8), name="obj_linestyle_dotted"),
    Case(robot(obj_linewidth=8), edge, shows={START[:2]: GREEN}),
    Case(robot(obj_zorder=0), box, OVERLAPPING, shows={BOX: SLATE}),
    Case({"obstacle.plot.obj_color": "red"}, box, shows={BOX: RED}, name="obstacle_color"),
    Case(robot(show_goal=True), goal),
    Case(robot(goal_color="red"), goal, GOAL_ON),
    Case(robot(goal_alpha=0.3), goal, GOAL_ON),
    Case(robot(goal_zorder=0), box, {**GOAL_ON, "robot.goal": [*BOX]}, shows={BOX: SLATE}),
    Case({"robot.goal": [[[3.0, 3.1], [1.0, 3.0], [2.0, 3.5]]]}, lambda m: m.y > 2.6, GOAL_ON, name="several_goals"),
    Case(robot(show_text=True), label, robot(text_size=26)),
    Case(robot(text_color="red"), label, TEXT_ON),
    Case(robot(text_size=14), label, TEXT_ON),
    Case(robot(text_alpha=0.3), label, TEXT_ON),
    Case(robot(text_zorder=0), body, {**TEXT_ON, **robot(text_position=[0, -0.2])}, shows={START[:2]: GREEN}),
    Case(robot(text_position=[0.4, 0.6]), lambda m: m.box(1.0, 1.6, 2.3, 2.4), TEXT_ON),
    Case(
        {"robot.goal": [3.0, 3.1, -0.67]},
        goal_arrow,
        {**GOAL_ON, "robot.arrive_mode": "state", "robot.goal": [3.0, 3.1]},
        name="goal_heading",
    ),
    Case(robot(show_goal_text=True), goal_label, {**GOAL_ON, **robot(text_size=26)}),
    Case(robot(show_arrow=True), body, shows={(1.45, 1.32): WHITE}),
    Case(robot(arrow_color="blue"), ahead, ARROW_ON, shows={(1.8, 1.47): BLUE}),
    Case(robot(arrow_length=0.6), ahead, ARROW_ON),
    Case(robot(arrow_width=0.25), ahead, ARROW_ON),
    Case(robot(arrow_alpha=0.4), ahead, {**ARROW_ON, **robot(arrow_color="blue")}),
    Case(robot(obj_alpha=0.0), body, ARROW_ON, shows={(1.8, 1.47): (255, 215, 0)}, name="arrow_of_an_unseen_body"),
    Case(
        robot(obj_alpha=0.0), body, robot(show_arrow=True), shows={(1.45, 1.32): WHITE}, name="mark_of_an_unseen_body"
    ),
    Case(robot(arrow_zorder=2), body, ARROW_ON, shows={START[:2]: GREEN}),
    Case(robot(show_trajectory=True), path, robot(obj_alpha=0.0), steps=14),
    Case(robot(traj_color="red"), path, PATH_ON, shows={DRIVEN: RED}, steps=14),
    Case(robot(traj_style="--"), path, PATH_ON, steps=14),
    Case(robot(traj_style=":"), path, robot(show_trajectory=True, obj_alpha=0.0), steps=14, name="traj_style_dotted"),
    Case(robot(traj_width=0.08), path, PATH_ON, shows={DRIVEN: GREEN}, steps=14),
    Case(robot(traj_alpha=0.5), path, PATH_ON, shows={DRIVEN: (127, 206, 185)}, steps=14),
    Case(robot(traj_zorder=5), path, robot(show_trajectory=True, traj_width=0.2, traj_color="red"), steps=14),
    Case(robot(keep_traj_length=6), lambda m: m.along(0.2) & ~m.along(0.03, -4), PATH_ON, steps=14),
    Case(robot(show_trail=True), trail, robot(obj_alpha=0.0), steps=14),
    Case(robot(trail_freq=7), trail, TRAIL_ON, steps=14),
    Case(robot(trail_type="rectangle"), lambda m: m.along(1.5 * RADIUS), FILLED, steps=14),
    Case(robot(trail_edgecolor="red"), trail, TRAIL_ON, steps=14),
    Case(robot(trail_linewidth=6), trail, TRAIL_ON, steps=14),
    Case(robot(trail_alpha=0.2), trail, TRAIL_ON, steps=14),
    Case(robot(trail_fill=True), trail, TRAIL_ON, steps=14),
    Case(robot(trail_color="red"), trail, FILLED, shows={START[:2]: RED}, steps=14),
    Case(robot(trail_zorder=5), trail, {**FILLED, **robot(obj_alpha=1.0, trail_color="red")}, steps=12),
    Case(robot(keep_trail_length=1), trail, FILLED, shows={START[:2]: WHITE}, steps=14),
    Case({**lidar(), **robot(show_sensor=False)}, sensed, lidar(), shows={(1.4, 2.0): WHITE}),
    Case(lidar(color="blue"), sensed, lidar(), name="lidar_color"),
    Case(lidar(alpha=0.9), sensed, lidar(), name="lidar_alpha"),
    Case(lidar(plot={"color": "blue", "alpha": 0.9}), sensed, lidar(color="red"), name="lidar_plot"),
    Case(fmcw(), seen_velocities, fmcw(velocity_color=False), steps=2, name="velocity_color"),
    Case(fmcw(negative_velocity_color="lime"), seen_velocities, fmcw(), steps=2, name="negative_velocity_color"),
    Case(fmcw(zero_velocity_color="lime"), seen_velocities, fmcw(), steps=0, name="zero_velocity_color"),
    Case(fmcw(velocity_color_max=3.0), seen_velocities, fmcw(), steps=2, name="velocity_color_max"),
    Case(fmcw(velocity_linewidth=5.0), seen_velocities, fmcw(), steps=2, name="velocity_linewidth"),
    Case(fmcw(no_hit_color="red", no_hit_alpha=0.6), seen_velocities, fmcw(), steps=2, name="no_hit_color"),
    Case(fmcw(no_hit_linewidth=5.0), seen_velocities, fmcw(no_hit_alpha=1.0), steps=2, name="no_hit_linewidth"),
    Case(fmcw(show_velocity_markers=False), seen_velocities, fmcw(), steps=2, name="show_velocity_markers"),
    Case(fmcw(velocity_marker_size=120.0), seen_velocities, fmcw(), steps=2, name="velocity_marker_size"),
    Case(
        fmcw(velocity_marker_edge_color="red", velocity_marker_edge_width=3.0),
        seen_velocities,
        fmcw(velocity_marker_size=120.0),
        steps=2,
        name="velocity_marker_edge",
    ),
    Case(robot(show_fov=True), sensed, {"robot.fov": 1.5, "robot.fov_radius": FAR}),
    Case(robot(fov_color="red"), sensed, FOV_ON, shows={(2.2, 1.6): (255, 127, 127)}),
    Case(robot(fov_edge_color="red"), sensed, FOV_ON),
    Case(robot(fov_alpha=1.0), sensed, {**FOV_ON, **robot(fov_color="red")}, shows={(2.2, 1.6): RED}),
    Case(robot(fov_zorder=5), body, FOV_ON),
    Case({"robot.description": "diff_robot0.png"}, body, name="image_of_a_robot"),
    Case({"obstacle.description": "car_red.png"}, box, name="image_of_a_car"),
    Case({"robot.plot.obj_alpha": 0.4}, body, {"robot.description": "diff_robot1.png"}, name="image_alpha"),
    Case({"world.plot.no_axis": False}, everywhere),
    Case({"world.plot.show_title": True}, everywhere),
    Case({"world.plot.title": "Title"}, lambda m: m.y > 4.0, TITLE_ON),
    Case({"world.plot.tight": False}, everywhere),
    Case({"world.plot.viewpoint": "robot_0"}, everywhere),
    Case({"world.plot.viewpoint": [3.1, 1.0]}, everywhere, name="viewpoint_point"),
    Case({"world.plot.figure_pixels": [200, 120]}, everywhere),
    Case(
        {"world.obstacle_map": {"name": "array", "cells": [[False, True], [False, False]]}},
        lambda m: m.box(-0.1, 1.9, 2.1, 4.1),
    ),
    Case({"world.fog_map": True}, beyond_sight, lidar(), shows={(3.5, 3.5): FOG}, steps=2),
    Case({"world.fog_map_resolution": 0.4}, everywhere, {**lidar(), "world.fog_map": True}, steps=2),
)
