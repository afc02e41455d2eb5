"""What to use in place of IR-SIM's names that are not supported."""

from collections.abc import Iterable

from irsim_gym.simulator.readings.irsim_names import advice, missing

WINDOW = "load(..., render_mode='human') opens a window; without it nothing is drawn until render() or save_figure()"
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


def unsettable(name: str, names: Iterable[str]) -> str:
    """Return what to do instead of ``body.name = value``."""
    setter = f"set_{name}"
    if setter in names:
        return f"a body's {name} cannot be assigned: use {setter}(...)"
    if name in names:
        return f"a body's {name} cannot be assigned; set_state, set_velocity and set_goal change a body"
    return missing("a body", name, advice("body", "script"), names)
