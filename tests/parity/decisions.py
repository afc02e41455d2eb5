"""Where irsim_gym differs from ir-sim 2.12.0 on purpose, by name: tests that rely on a difference name it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Decision:
    """A difference on purpose.

    Attributes:
        theirs: What ir-sim 2.12.0 does.
        ours: What irsim_gym does.
        why: The reason.
        source: The documentation's statement or the defect of ir-sim that it answers.
    """

    theirs: str
    ours: str
    why: str
    source: str


DECISIONS = {
    "exact_disc": Decision(
        "a circle is a polygon of 64 corners",
        "a circle is a disc: it may touch one step earlier, and ranges to it are shorter: by 0.0011 r in the "
        "median, less than 0.003 r for 95 and 0.007 r for 99 of 100 beams, up to 0.09 r for grazing beams, and 1 "
        "in 2000 hits only the disc (16,088 beams of ir-sim's own scans of ten discs)",
        "the outline is exact, and cheaper to test",
        "circles are 64-gons",
    ),
    "missing_goal": Decision(
        "a missing goal is [1, 9, 0]",
        "no goal: the body never arrives and dash stands still",
        "the documentation says None",
        "D4",
    ),
    "missing_state": Decision("a missing state is [1, 1, 0]", "it is [0, 0, 0]", "the documentation says so", "D5"),
    "missing_shape": Decision(
        "a missing shape is a circle of radius 1",
        "it is a circle of radius 0.2",
        "the documentation says {name: circle}",
        "D20",
    ),
    "fixed_bodies_do_not_arrive": Decision(
        "static bodies have goals and arrive at them",
        "only bodies that can move have a goal",
        "a wall at (1, 9) did not arrive",
        "D4",
    ),
    "omni_frame": Decision(
        "omni takes forward and lateral velocity in the body frame",
        "[vx, vy] in the world frame; limits apply there, also for behaviours; `frame: body` gives IR-SIM's run",
        "the documentation says 'along the x and y axes'",
        "D6",
    ),
    "yaw_rate": Decision(
        "the second input of acker's mode angular is a steering rate",
        "it is the yaw rate",
        "the documentation says 'linear and angular velocity'",
        "D8",
    ),
    "omni_variances": Decision(
        "omni's noise takes the first two of four numbers in alpha",
        "the first and the last",
        "the documentation gives four numbers, of which two are 0; one direction would be left without noise",
        "section 3.1",
    ),
    "variance_count": Decision(
        "alpha may be longer than the drive needs, and a short one crashes when noise is drawn",
        "it must have as many numbers as the drive needs, none negative",
        "an unused number is a mistake",
        "section 3.1",
    ),
    "python_behaviors": Decision(
        "register_behavior(kinematics, name) passes the simulator's own objects; unknown options are ignored",
        "behaviours get read-only views; commands and the options of irsim_gym.behavior(name) are checked",
        "the results of a behaviour that changes its neighbours depend on the order of the bodies",
        "section 8.6",
    ),
    "unobstructed_is_symmetric": Decision(
        "others drive through an unobstructed body, but they stop it",
        "it touches nothing; behaviours avoid it and sensors miss it, as in IR-SIM",
        "the documentation says 'ignoring collisions with other objects'",
        "D10",
    ),
    "blocked_start": Decision(
        "a robot may start inside an obstacle and is stuck at once",
        "irsim_gym.load warns with the line and runs the file; environments reject a given start inside a static "
        "obstacle, except in collision mode unobstructed",
        "such a run is over before it begins",
        "defect 23",
    ),
    "random_streams": Decision(
        "all objects draw from one generator per environment in turn",
        "each world has its own stream",
        "the same seed gives the same episode alone and in a batch",
        "decision 6",
    ),
    "role_groups": Decision(
        "a section that is a mapping puts its objects into group 0, robots and obstacles alike",
        "each entry is a group; robots and obstacles never share one",
        "avoidance should not depend on how a section is written",
        "D22",
    ),
    "reset_is_a_start": Decision(
        "reset() checks for collisions at once and continues the random stream",
        "reset() returns to the state of the start: flags are set only for bodies that never move and touch each "
        "other, and the noise begins again",
        "the same actions give the same run",
        "section 12.3",
    ),
    "surplus_actions": Decision(
        "actions for no object are dropped with a warning",
        "they are an error",
        "such an action is a mistake, and in a loop a warning is easily missed",
        "section 12.2",
    ),
    "done_modes": Decision(
        "done() returns None for an unknown mode", "an unknown mode is an error", "None is false", "section 12.1"
    ),
    "scattered_obstacles": Decision(
        "random_obstacle_position keeps overlaps if it finds no place, and updates no sensor",
        "it raises an error and moves nothing if there is no place; flags and scans are updated",
        "non_overlapping promises it",
        "defect 18",
    ),
    "orca_walls": Decision(
        "orca sees only the members of its group",
        "it also avoids all bodies that never move, unless they are unobstructed, and the obstacle map; such a member "
        "is always avoided",
        "robots drove into walls",
        "8.4",
    ),
    "orca_commanded": Decision(
        "orca assumes that a member commanded by hand follows its plan",
        "orca sees its actual velocity",
        "it follows its command, not the plan",
        "8.4",
    ),
    "field_of_view": Decision(
        "a body that is wider than the field of view is missed straight ahead",
        "the bearing minus half the width that the body covers must lie within half the view",
        "IR-SIM takes one absolute value too many",
        "D40",
    ),
    "half_a_view": Decision(
        "fov without fov_radius crashes when it is used, fov_radius without fov is ignored",
        "the lidar gives the missing one; without a lidar it is an error",
        "a silently ignored key costs its author hours",
        "section 7",
    ),
    "map_in_view": Decision(
        "the map counts as a disc around the origin",
        "a field of view never detects the map",
        "the map is everywhere, so detection has no meaning",
        "section 7",
    ),
    "angle_noise": Decision(
        "angle_std is 0 unless given", "it is 0.02 rad, when noise is true", "the documentation says 0.02", "D13"
    ),
    "scan_copies": Decision(
        "the arrays of a scan are overwritten by the next one",
        "they are copies",
        "a stored scan would change afterwards",
        "defect 18",
    ),
    "touching_sensor": Decision(
        "a beam that begins on an edge passes through it",
        "it reads 0",
        "a sensor that touches a wall is blocked",
        "section 6",
    ),
    "fmcw_drawing": Decision(
        "drawing options of fmcw_lidar2d may stand under plot or beside it",
        "they must stand under plot",
        "one way to write it",
        "section 6",
    ),
    "map_without_holes": Decision(
        "a body within a block of occupied cells touches nothing; near a cell's corners its bounding box touches",
        "a body touches a map where its outline meets an occupied cell; touching counts",
        "cells are exact, closed rectangles",
        "defect 11",
    ),
    "map_is_no_disc": Decision(
        "rvo and sfm see a map as one disc about its centroid, or not at all when that is far away",
        "they see its walls: rvo those within neighbor_threshold, sfm the nearest on each of four sides, once to "
        "each side",
        "the disc covers the whole world, and a robot near its centre finds no way out",
        "defect 12",
    ),
    "map_flag": Decision(
        "the map's own collision flag checks its boundary lines only",
        "the map collides with every body that collides with it",
        "contact is mutual",
        "section 11",
    ),
    "map_names": Decision(
        "cave.png and hm3d_1.png to hm3d_9.png come with the package",
        "they are read from an installed ir-sim; without one, an error lists the shipped maps",
        "we may not ship them, and another map under the same name would mislead",
        "section 11",
    ),
    "map_zero_one": Decision(
        "a map of the numbers 0 and 1 has no occupied cell, since occupied is above 50",
        "it is an error: use truth values, or 0 to 100",
        "such a map is always a mistake",
        "section 11",
    ),
    "perlin_seed": Decision(
        "a perlin map without a seed is different each time",
        "it follows from the world's name",
        "runs can be repeated",
        "defect 24",
    ),
    "fog_ends": Decision(
        "with `fog_map`, rounding decides whether a beam's end explores the wall or the free cell before it",
        "the wall that a beam hits is explored",
        "walls appear without gaps",
        "section 11",
    ),
    "obstacle_sizes": Decision(
        "rvo and sfm see a standing rectangle or polygon as the disc around it, when its centre is near",
        "they see its outline when its surface is near; for sfm it pushes once, from its nearest point: runs differ",
        "robots drove into large boxes, and kept away from the empty corners of discs",
        "D39",
    ),
    "compound_seams": Decision(
        "a sensor inside a compound sees the boundary of the union",
        "it sees each circle of the compound",
        "circles stay exact discs",
        "compound shapes",
    ),
    "orca_precision": Decision(
        "orca's library computes in single precision",
        "it is computed in double precision: commands agree to 2e-5 m/s, and free runs drift apart",
        "positions far from the origin keep their digits",
        "8.4",
    ),
    "drawing_defaults": Decision(
        "pictures of 1000 x 800 pixels; gold arrows, red or thick beams, black obstacles, half clear goals",
        "the world sets the size; colours of one theme, opaque goals; given values are used as they are",
        "a world without margins, legible at any size",
        "drawing defaults",
    ),
    "drawn_goals": Decision(
        "a goal is an outline of the body's shape",
        "a flag in the circle of the goal's tolerance",
        "it shows when the goal counts as reached",
        "section 13",
    ),
    "drawn_paths": Decision(
        "a path is a band as wide as the body, at the lowest layer",
        "a thin line that fades towards its beginning, above fixed bodies; a band with traj_width",
        "paths of several bodies can be distinguished",
        "section 13",
    ),
    "drawn_images": Decision(
        "images named by `description` come with the package; every acker robot is drawn as car_green.png, "
        "whatever its colour",
        "our own images under these names; car_green.png for rectangular acker robots whose entry gives no colour "
        "and no line style",
        "robots of a fleet can be distinguished by colour",
        "section 13",
    ),
    "drawn_fog": Decision(
        "with `fog_map`, fog has hard edges and covers everything except what is drawn later",
        "it covers the map and bodies that never move, with soft edges; goals, robots, paths and scans lie above it",
        "fog shows what is unknown of the world, not which robots drive in it",
        "section 13",
    ),
    "collision_tint": Decision(
        "a collision changes the title only",
        "the edges of colliding bodies are red, and the world is tinted when a robot collides",
        "a collision is visible in a film",
        "section 13",
    ),
    "drawn_title": Decision(
        "the title shows time and status",
        "the world's name is on the left, status and time on the right; title replaces all three",
        "one line",
        "section 13",
    ),
    "flat_arrays": Decision(
        "states, velocities and goals are columns, state[0, 0], and writing into state moves the body",
        "they are flat, state[0], and read-only, or read-only columns with load(columns=True); set_state, "
        "set_velocity and set_goal change a body; combining a flat one with a column is an error",
        "one index per number, no unnoticed change, and no matrix instead of a difference",
        "section 12.3",
    ),
    "picture_options": Decision(
        "render(show_goal=True) changes nothing, render(obj_color='red') changes one picture, and unknown "
        "arguments pass",
        "keys of plot apply to one picture and to the frames kept until the next; an argument without effect warns",
        "every argument has an effect or a warning",
        "measured with 2.12.0",
    ),
    "random_goals": Decision(
        "set_random_goal draws from the environment's generator, and logs if it finds no place",
        "it draws from the world's stream, and warns",
        "a run can be repeated",
        "section 10.4",
    ),
    "no_window": Decision(
        "make opens a window by default; log_level and others are arguments",
        "a window opens on request (`render_mode='human'`, `display=True`; the latter warns once where there is no "
        "screen); an unsupported name is an error that says what to use",
        "most worlds run without a viewer; a silently ignored call costs its author hours",
        "section 12.5",
    ),
    "goals_of_one": Decision(
        "for one body, `goal: [[5, 1], [5, 5]]` silently means its first goal",
        "both goals, in order",
        "the documentation describes this form as several goals",
        "documentation of goals",
    ),
    "angle_range": Decision(
        "a range not exactly 2 pi wide crashes at the first step",
        "a width within 0.01 of 2 pi, such as [-3.14, 3.14], is a full turn from its lower end; others are rejected",
        "3.14 is a common value, and a narrower range has no meaning for a heading that wraps",
        "section 4",
    ),
    "driveless_behavior": Decision(
        "a body with a behavior but no kinematics stands still; with a mass, the first step is an error",
        "the same, with a warning that names the line; with a mass, the file is refused",
        "documented for static objects, but a behavior for a wall is a likely mistake",
        "documentation of static",
    ),
    "warnings": Decision(
        "degrees in place of radians, steps of more than 1 s, goals and bodies that a step may jump over pass silently",
        "a ScenarioWarning names each with its line when a file is loaded",
        "such a run looks right and is not",
        "reference page",
    ),
}
