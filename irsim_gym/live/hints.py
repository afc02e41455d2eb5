"""What to use in place of IR-SIM's names that are not supported."""

from __future__ import annotations

from collections.abc import Iterable

from irsim_gym.world import irsim_names
from irsim_gym.world.irsim_names import CONTACTS, DRAWN, missing

WINDOW = "load(..., render_mode='human') opens a window; without it nothing is drawn until render() or save_figure()"
IN_FILE = "it stands in the scenario: world.scenario; create_robot() and create_obstacle() add bodies"

BODY: dict[str, str] = {
    **irsim_names.BODY,
    "memory": "a behaviour's memory is its own; a script has variables",
    **dict.fromkeys(
        ("uniform", "normal"), "a behaviour draws from the world's stream; a script has NumPy's generators"
    ),
    **dict.fromkeys(("set_text", "set_goal_text"), DRAWN),
    **dict.fromkeys(("G", "h", "cone_type", "convex_flag"), "use get_Gh(), get_init_Gh(), whose fields these are"),
    "plot": "use spec.plot; render() draws",
    "original_state": "use init_state",
    "reset": "use world.reset()",
    "refresh": "use world.refresh()",
    "remove": "use world.remove(body.name)",
    "logger": "use world.logger",
    "env_param": IN_FILE,
    "world_param": "use world.world_param",
    "_world_param": "use world.world_param",
    "_env_param": IN_FILE,
    "_env": "use the world",
}

WORLD: dict[str, str] = {
    **dict.fromkeys(("config", "env_config", "env_param", "_env_param", "object_factory"), IN_FILE),
    **dict.fromkeys(("get_msg", "receive_msg"), "there are no messages: use objects and their states, set_state()"),
    **dict.fromkeys(("debug_flag", "debug_count"), "use pause(), step_status(), resume()"),
    **dict.fromkeys(("reset_flag", "reload_flag", "save_figure_flag"), "use reset(), reload(), save_figure()"),
    "ani_kwargs": "give end() its options, or load(..., ani_kwargs={...})",
    "keyboard": "use key_vel, key_id, control_mode; the options stand in the file: gui: {keyboard: ...}",
    "mouse": "use mouse_pos, mouse_left_pos, mouse_right_pos",
    "contacts": CONTACTS,
    "path_param": "paths of files are yours; path() is a way through the world",
    "_env_plot": "render() returns pictures; save_figure() writes them",
    "id": "use name; several worlds know nothing of each other",
}

PARAM: dict[str, str] = dict.fromkeys(("drive_tau", "friction", "gravity", "restitution"), CONTACTS)
"""Names of IR-SIM's ``world_param``."""

WORLD_RECORD: dict[str, str] = {
    **dict.fromkeys(
        ("gen_grid_map", "grid_map", "reso", "obstacle_index", "obstacle_positions"),
        "use get_map() of the world itself",
    ),
    **dict.fromkeys(("step", "reset"), "use that of the world itself, which moves its bodies too"),
    "sample_steps": "use sample_time, step_time",
    "fog_map": "use simulation.explored of the world itself",
    "plot_parse": IN_FILE,
}
"""Names of IR-SIM's private ``_world``."""

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
