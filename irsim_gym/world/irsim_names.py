"""What to use in place of IR-SIM's names that bodies and sensors do not have."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from irsim_gym.errors import suggestion

DRAWN = "render() draws bodies as their section `plot` says; world.draw draws over them"
CONTACTS = "contact mode is not simulated"
_ALONE = "the step of the world moves bodies; behaviors of your own are registered by register_behavior"
_HANDLED = "use shape, kinematics, geometry, get_Gh(), spec"

BODY: dict[str, str] = {
    **dict.fromkeys(
        (
            *("mass", "inertia", "friction", "restitution", "contact", "pushable", "passive", "gyration", "inv_mass"),
            *("inv_inertia", "drive_tau", "drive_velocity_xy", "friction_force"),
            *("apply_contact_displacement", "apply_contact_velocity"),
        ),
        CONTACTS,
    ),
    **dict.fromkeys(("pre_process", "mid_process", "post_process", "input_state_check"), _ALONE),
    **dict.fromkeys(("gf", "kf"), _HANDLED),
    "gen_behavior_vel": "the step asks its behaviour",
    "obj_behavior": "use beh_config, spec.behavior",
    "group_behavior_dict": "use spec.group_behavior",
    "rl": "use spec.behavior.range_low",
    "rh": "use spec.behavior.range_high",
    "collision_obj": "use hit, the first body that it touches",
    "possible_collision_objects": "use external_objects",
    "check_collision": "use geometry.intersects(other.geometry), or collided after step() or refresh()",
    "check_arrive": "use arrived after step() or refresh()",
    "part_vertices": "use geometry, vertices",
    "original_part_vertices": "use original_geometry",
    "goal_abbr": "use abbr",
    "vel_world2body": "use irsim_gym.irsim.vel_world2omni(heading, velocity)",
    "set_original_geometry": "a shape stays: remove the body and add another one",
    "reset_id_iter": "numbers of bodies begin at 0 in each world",
    "z": "all bodies are in the plane",
    "_goal": "use goal, goals, set_goal()",
    "_velocity": "use velocity, set_velocity()",
    "_geometry": "use geometry",
    "_init_state": "use init_state, set_state(..., init=True)",
    "_init_goal": "set_goal(..., init=True) sets the goals of the start",
}
"""What is said of names of IR-SIM's bodies, in scripts and in behaviours."""

SENSOR: dict[str, str] = {
    **dict.fromkeys(
        (
            *("negative_velocity_color", "positive_velocity_color", "zero_velocity_color", "velocity_color"),
            *("velocity_color_max", "velocity_linewidth", "velocity_marker_edge_color", "velocity_marker_edge_width"),
            *("velocity_marker_size", "no_hit_alpha", "no_hit_color", "no_hit_linewidth", "show_velocity_markers"),
        ),
        "its options in the file, plot: {...}, say how it is drawn",
    ),
    "has_velocity": "it always reports radial_velocity",
    "step": "the step of the world takes scans, and so does sensor_step() of the body",
    "init_geometry": "use lidar_origin, angle_list, range_data",
    "velocity": "use radial_velocity",
    "cast_angles": "use angle_list, the directions without noise",
    "origin_state": "use offset",
    "set_laser_color": "use set_laser_color() of the body",
    "step_plot": DRAWN,
}
"""What is said of names of IR-SIM's sensors."""


def missing(what: str, name: str, elsewhere: Mapping[str, str], known: Iterable[str]) -> str:
    """Return the message for a missing name, with what to use instead.

    Args:
        what: Owner of the name, such as ``a body``.
        name: The name.
        elsewhere: What to use for names of IR-SIM.
        known: The existing names.
    """
    if name.startswith("plot_"):
        return f"{what} has no '{name}': {DRAWN}"
    if name in elsewhere:
        return f"{what} has no '{name}': {elsewhere[name]}"
    return f"{what} has no '{name}'{suggestion(name, [one for one in known if not one.startswith('_')])}"
