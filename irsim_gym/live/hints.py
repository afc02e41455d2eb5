"""What to use in place of IR-SIM's names that are not supported."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping

WINDOW = "load(..., render_mode='human') opens a window; without it nothing is drawn until render() or save_figure()"
DRAWN = "render() draws bodies as their section `plot` says; world.draw draws over them"
CONTACTS = "contact mode is not simulated"
IN_FILE = "it stands in the scenario: world.scenario"

BODY: dict[str, str] = {
    "lidar": "scan() is its scan, scan_points() its points, lidar_offset its mount",
    "geometry": "use vertices, radius, length, width",
    "original_geometry": "use spec.shape",
    "original_vertices": "use spec.shape; vertices are those of the moment",
    "beh_config": "use spec.behavior",
    "obj_behavior": "use spec.behavior",
    "gen_behavior_vel": "the step asks its behaviour",
    "collision_obj": "use hit",
    "possible_collision_objects": "use external_objects",
    "check_collision": "use collided after step() or refresh()",
    "check_collision_status": "flags follow with step() or refresh()",
    "check_arrive_status": "flags follow with step() or refresh()",
    "check_status": "flags follow with step() or refresh()",
    "gf": "use shape, vertices, spec.shape",
    "kf": "use kinematics, spec.kinematics",
    "original_state": "use init_state",
    "memory": "a behaviour's memory is its own; a script has variables",
    "uniform": "a behaviour draws from the world's stream; a script has NumPy's generators",
    "normal": "a behaviour draws from the world's stream; a script has NumPy's generators",
    "step": "use world.step(action, body.name)",
    "reset": "use world.reset()",
    "refresh": "use world.refresh()",
    "remove": "use world.remove(body.name)",
    "set_text": DRAWN,
    "set_goal_text": DRAWN,
    "logger": "use world.logger",
    "plot": "use spec.plot; render() draws",
    "check_arrive": "use arrived after step() or refresh()",
    "original_centroid": "use position, the origin of its own frame",
    "part_vertices": "use vertices",
    "set_original_geometry": "a shape stays: remove the body and add another one",
    "env_param": "it stands in the scenario: world.scenario",
    "world_param": "use world.world_param",
    "mass": CONTACTS,
    "inertia": CONTACTS,
    "friction": CONTACTS,
    "restitution": CONTACTS,
    "contact": CONTACTS,
    "pushable": CONTACTS,
    "z": "all bodies are in the plane",
}

WORLD: dict[str, str] = {
    "keyboard": "use key_vel, key_id, control_mode; the options stand in the file: gui: {keyboard: ...}",
    "mouse": "use mouse_pos, mouse_left_pos, mouse_right_pos",
    "reset_plot": "render() draws anew each time; draw.clear() takes away what was drawn by hand",
    "random_polygon_shape": "add(shape={'name': 'polygon', 'random_shape': True}) draws an outline; "
    "with random_shape in the file, reset(random=True) draws all of them anew",
    "validate_unique_names": "names are always unique",
    "contacts": CONTACTS,
    "config": IN_FILE,
    "env_config": IN_FILE,
    "env_param": IN_FILE,
    "path_param": "paths of files are yours; path() is a way through the world",
    "object_factory": "use create_robot() and create_obstacle()",
    "build_tree": "the step looks for neighbours by itself",
    "get_msg": "use objects and their states",
    "receive_msg": "use set_state() and refresh()",
    "_world": "use x_range, y_range, world_param, scenario.world",
    "_objects": "use objects",
    "_env_plot": "render() returns pictures; save_figure() writes them",
    "id": "use name; several worlds know nothing of each other",
}

LOAD: dict[str, tuple[tuple[object, ...], str]] = {
    "display": ((True, False), "True opens a window, False does not"),
    "headless": ((True, False), "True opens no window, and neither does False without render_mode='human'"),
    "disable_all_plot": ((True, False), WINDOW),
    "log_file": ((None,), "give world.logger a handler: logging.FileHandler(...)"),
    "projection": ((None, "2d", "3d"), "bodies are in the plane, and pictures show it from above"),
}
"""Arguments of IR-SIM without effect here: values that match the behaviour, and what to do for others."""

TAKEN = ("full", "ani_kwargs", "log_level", "step_mode", "world_name")
"""Arguments of IR-SIM that ``load`` accepts, too."""

LARGE = "the window is as large as the picture: plot: {figure_pixels: [1000, 800]}"


def unsettable(name: str, known: Iterable[str]) -> str:
    """Return what to do instead of ``body.name = value``."""
    setter = f"set_{name}"
    if setter in known:
        return f"a body's {name} cannot be assigned: use {setter}(...)"
    if name in known:
        return f"a body's {name} cannot be assigned; set_state, set_velocity and set_goal change a body"
    return missing("a body", name, BODY, known)


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
    near = difflib.get_close_matches(name, [one for one in known if not one.startswith("_")], n=1, cutoff=0.6)
    return f"{what} has no '{name}'" + (f" (did you mean '{near[0]}'?)" if near else "")
