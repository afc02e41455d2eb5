"""What to use in place of IR-SIM's names that are not here."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping

WINDOW = "load(..., render_mode='human') opens a window; without it nothing is drawn until render() or save_figure()"
DRAWN = "render() draws bodies as their section `plot` says; for drawings of your own take the array that it returns"
CONTACTS = "contact mode is not simulated"
IN_FILE = "it stands in the scenario: world.scenario"

BODY: dict[str, str] = {
    "lidar": "scan() is its scan, scan_points() its points, lidar_offset its mount",
    "geometry": "use vertices, radius, length, width",
    "original_geometry": "use spec.shape",
    "original_vertices": "use spec.shape; vertices are those of the moment",
    "centroid": "use position, the origin of its own frame",
    "max_speed": "use vel_max",
    "get_vel_range": "use vel_min, vel_max, acce: the step keeps to them",
    "beh_config": "use spec.behavior",
    "obj_behavior": "use spec.behavior",
    "gen_behavior_vel": "the step asks its behaviour",
    "desired_omni_vel": "use goal and position",
    "get_desired_omni_vel": "use goal and position",
    "rvo_state": "use position, twist, radius",
    "rvo_neighbors": "use external_objects",
    "rvo_neighbor_state": "use external_objects",
    "collision_obj": "use hit",
    "possible_collision_objects": "use external_objects",
    "check_collision": "use collided after step() or refresh()",
    "check_collision_status": "flags follow with step() or refresh()",
    "check_arrive_status": "flags follow with step() or refresh()",
    "check_status": "flags follow with step() or refresh()",
    "get_Gh": "use info.G, info.h, info.cone_type, info.convex_flag",
    "get_init_Gh": "use info.G, info.h: they are in its own frame",
    "gf": "use shape, vertices, spec.shape",
    "kf": "use kinematics, spec.kinematics",
    "init_state": "use trajectory[0]",
    "original_state": "use trajectory[0]",
    "set_random_goal": "use set_goal(); a wandering body (behavior: {wander: true}) draws its own",
    "memory": "a behaviour's memory is its own; a script has variables",
    "uniform": "a behaviour draws from the world's stream; a script has NumPy's generators",
    "normal": "a behaviour draws from the world's stream; a script has NumPy's generators",
    "step": "use world.step(action, body.name)",
    "reset": "use world.reset()",
    "refresh": "use world.refresh()",
    "remove": "use world.remove(body.name)",
    "state_dim": "use len(body.state)",
    "state_shape": "use body.state.shape",
    "vel_dim": "use len(body.velocity)",
    "vel_shape": "use body.velocity.shape",
    "abbr": "use name; the shown text is plot: {text: ...}",
    "set_text": DRAWN,
    "set_goal_text": DRAWN,
    "set_laser_color": DRAWN,
    "logger": "use Python's own logging",
    "plot": "use spec.plot; render() draws",
    "check_arrive": "use arrived after step() or refresh()",
    "original_centroid": "use position, the origin of its own frame",
    "part_vertices": "use vertices",
    "set_original_geometry": "a shape stays: remove the body and add another one",
    "env_param": "it stands in the scenario: world.scenario",
    "world_param": "it stands in the scenario: world.scenario",
    "mass": CONTACTS,
    "inertia": CONTACTS,
    "friction": CONTACTS,
    "restitution": CONTACTS,
    "contact": CONTACTS,
    "pushable": CONTACTS,
    "z": "all bodies are in the plane",
}

WORLD: dict[str, str] = {
    "set_title": "the title stands in the file: world: {plot: {title: ...}}",
    "set_status": "status follows from the robots; pause() and resume() change it",
    "quit": "leave the loop, then close(); quit_flag tells whether the person wants to",
    "pause_flag": "use status == 'Pause'",
    "headless": WINDOW,
    "disable_all_plot": WINDOW,
    "save_ani": "load(..., record=True) keeps frames",
    "keyboard": "use key_vel, key_id, control_mode; the options stand in the file: gui: {keyboard: ...}",
    "mouse": "use mouse_pos, mouse_left_pos, mouse_right_pos",
    "reset_plot": "render() draws anew each time",
    "draw_trajectory": DRAWN,
    "draw_points": DRAWN,
    "draw_box": DRAWN,
    "draw_quiver": DRAWN,
    "draw_quivers": DRAWN,
    "random_polygon_shape": "add(shape={'name': 'polygon', 'random_shape': True}) draws an outline; "
    "with random_shape in the file, reset(random=True) draws all of them anew",
    "validate_unique_names": "names are always unique",
    "logger": "use Python's own logging",
    "contacts": CONTACTS,
    "config": IN_FILE,
    "env_config": IN_FILE,
    "world_param": IN_FILE,
    "env_param": IN_FILE,
    "path_param": "paths of files are yours; path() is a way through the world",
    "step_mode": "use world.scenario.world.step_mode",
    "object_factory": "use create_robot() and create_obstacle()",
    "build_tree": "the step looks for neighbours by itself",
    "get_msg": "use objects and their states",
    "receive_msg": "use set_state() and refresh()",
    "id": "use name; several worlds know nothing of each other",
}

LOAD: dict[str, tuple[tuple[object, ...], str]] = {
    "display": ((True, False), "True opens a window, False does not"),
    "headless": ((True, False), "True opens no window, and neither does False without render_mode='human'"),
    "disable_all_plot": ((True, False), WINDOW),
    "full": ((False,), "the window is as large as the picture: plot: {figure_pixels: [1000, 800]}"),
    "ani_kwargs": ((None,), "name and rate of a film are arguments of save_animation()"),
    "log_level": ((), "leave it out: nothing is logged, warnings are Python's own"),
    "log_file": ((None,), "nothing is logged, warnings are Python's own"),
    "step_mode": ((None,), "it stands in the file: world: {step_mode: external}"),
    "projection": ((None,), "all bodies are in the plane"),
    "world_name": ((), "give the file as the first argument: load('my_world.yaml')"),
}
"""For each argument of IR-SIM's that is not one here: values that ask for what is so anyway, and what to do else."""


def unsettable(name: str, known: Iterable[str]) -> str:
    """Return what to do in place of ``body.name = value``."""
    setter = f"set_{name}"
    if setter in known:
        return f"a body's {name} cannot be assigned: use {setter}(...)"
    if name in known:
        return f"a body's {name} cannot be assigned; set_state, set_velocity and set_goal change a body"
    return missing("a body", name, BODY, known)


def missing(what: str, name: str, elsewhere: Mapping[str, str], known: Iterable[str]) -> str:
    """Return what is wrong with a name that is not here, with what to use in its place.

    Args:
        what: Whose name it would be, e.g. ``a body``.
        name: The name.
        elsewhere: What to use for names of IR-SIM's.
        known: The names that are here.
    """
    if name.startswith("plot_"):
        return f"{what} has no '{name}': {DRAWN}"
    if name in elsewhere:
        return f"{what} has no '{name}': {elsewhere[name]}"
    near = difflib.get_close_matches(name, [one for one in known if not one.startswith("_")], n=1, cutoff=0.6)
    return f"{what} has no '{name}'" + (f" (did you mean '{near[0]}'?)" if near else "")


def check_arguments(render_mode: str | None, others: Mapping[str, object]) -> tuple[str | None, dict[str, object]]:
    """Let arguments of IR-SIM's pass that ask for what is so anyway.

    Returns:
        The render mode, and the rest of the arguments, meant for the scenario.

    Raises:
        TypeError: One of them asks for something else; the message tells what to do.
        ValueError: Another render mode.
    """
    if render_mode not in (None, "rgb_array", "human"):
        raise ValueError(f"render_mode must be None, 'rgb_array' or 'human', got {render_mode!r}")
    for name, value in others.items():
        harmless, advice = LOAD.get(name, ((), ""))
        if advice and not any(value is one for one in harmless):
            raise TypeError(f"load() takes no {name}={value!r}: {advice}")
    hidden = next((name for name, no in (("display", False), ("headless", True)) if others.get(name) is no), None)
    wanted = render_mode == "human" or others.get("display") is True
    if wanted and hidden is not None:
        raise TypeError(f"load() takes no {hidden}={others[hidden]!r} where a window is asked for as well")
    rest = {name: value for name, value in others.items() if name not in LOAD}
    return ("human" if wanted else render_mode), rest


def check_rendering(others: Mapping[str, object]) -> None:
    """Let arguments of IR-SIM's ``render`` pass that ask for what is so anyway: everything is drawn, as the file says.

    Raises:
        TypeError: One of them asks for something else.
    """
    for name, value in others.items():
        if (name, value) not in (("mode", "dynamic"), ("mode", "all"), ("figure_kwargs", None), ("figure_kwargs", {})):
            raise TypeError(
                f"render() takes no {name}={value!r}: what is drawn, and how, stands in the sections `plot` of the file"
            )
