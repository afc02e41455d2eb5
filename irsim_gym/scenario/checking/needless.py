"""Keys that IR-SIM 2.12.0 accepts and ignores; they are ignored here too, and reported."""

from collections.abc import Mapping

from irsim_gym.scenario.text.source import ROLES, WRAPPER, Place

_OF_RVO = "only rvo reads it, here and in IR-SIM 2.12.0"
_OLD = "neither IR-SIM 2.12.0 nor irsim_gym reads it"

NEEDLESS: Mapping[str, Mapping[str, str]] = {
    "gui.keyboard": {"vel_max": f"{_OLD}: key_lv_max and key_ang_max are the greatest velocities"},
    "body.behavior": {
        **dict.fromkeys(("vxmax", "vymax", "acce", "factor", "mode", "neighbor_threshold"), _OF_RVO),
        "accer": f"{_OLD}: rvo has acce",
        "angle_tolerance": "only dash reads it, here and in IR-SIM 2.12.0",
    },
    "body.distribution": {"non_overlapping": "random placement never overlaps"},
    "body.plot": {"show_goals": f"{_OLD}: show_goal draws the goal"},
    "plot": {"show_goals": f"{_OLD}: show_goal draws the goal"},
    "body.sensors": {"reso": f"{_OLD}: angle_range and number set the beams"},
}
"""Message about each such key, by its mapping. If a kind has an option of this name, the option counts."""

UNOBSTRUCTED_MODES = ("reactive", "react", "unobstructed2")
"""Values of ``collision_mode`` that mean ``unobstructed`` in IR-SIM, as do all values that it does not know."""


def mapping_of(place: Place) -> str:
    """Return the name of the mapping at a path, such as ``world.plot`` or ``body.sensors``."""
    names = [part for part in place if isinstance(part, str)]
    names = names[1:] if names[:1] == [WRAPPER] else names
    return ".".join("body" if i == 0 and name in ROLES else name for i, name in enumerate(names))
