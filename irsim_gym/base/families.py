"""The registries of all families. A family's package fills its own when it is imported."""

import importlib
from typing import Any

from irsim_gym.base.registry import Registry

_OWN = "; your own is registered by @irsim_gym.{}, on the command line from --import FILE.py"

_WORLD, _TASK = "irsim_gym.simulator.world.kinds", "irsim_gym.tasks.plugin_checks.term_contract"

KINEMATICS = Registry("kinematics", _OWN.format("drive"), (_WORLD, "DRIVE"))
BEHAVIORS = Registry("behavior", _OWN.format("behavior"), (_WORLD, "BEHAVIOR"))
GROUP_BEHAVIORS = Registry("group behavior", _OWN.format("group_behavior"), (_WORLD, "BEHAVIOR"))
FOOTPRINTS = Registry("shape", contract=(_WORLD, "FOOTPRINT"))
PLACEMENTS = Registry("distribution", _OWN.format("placement"), (_WORLD, "PLACEMENT"))
SENSORS = Registry("sensor", _OWN.format("sensor"), (_WORLD, "SENSOR"))
MAPS = Registry("obstacle map", contract=(_WORLD, "MAP"))
DISTURBANCES = Registry("disturbance", contract=(_WORLD, "DISTURBANCE"))
SHIELDS = Registry("shield", contract=(_WORLD, "SHIELD"))
ACTIONS = Registry("action", _OWN.format("action"), (_TASK, "ACTION"))
OBSERVATIONS = Registry("observation", _OWN.format("observation"), (_TASK, "OBSERVATION"))
REWARDS = Registry("reward", _OWN.format("reward"), (_TASK, "REWARD"))
ENDINGS = Registry("ending", _OWN.format("ending"), (_TASK, "ENDING"))
SECTIONS = Registry("section")
"""Sections of a scenario file whose keys a package beyond ``scenario`` declares: for the reference and the schema."""

BY_KEY = {
    "kinematics": KINEMATICS,
    "behavior": BEHAVIORS,
    "group_behavior": GROUP_BEHAVIORS,
    "shape": FOOTPRINTS,
    "distribution": PLACEMENTS,
    "sensors": SENSORS,
    "disturbances": DISTURBANCES,
    "obstacle_map": MAPS,
    "shield": SHIELDS,
    "action": ACTIONS,
    "observations": OBSERVATIONS,
    "rewards": REWARDS,
    "endings": ENDINGS,
}
"""The registry of the kinds that stand at a key of a scenario file."""
KINDS_OF_BODIES = ("kinematics", "behavior", "group_behavior", "shape")
"""Keys of entries whose value is one kind, for all bodies or for each of them."""

_PACKAGES = (
    *("bodies.drives", "bodies.behaviors", "bodies.shapes", "bodies.placements", "bodies.sensors", "bodies.maps"),
    *("bodies.disturbances", "bodies.shields", "tasks"),
)


def load() -> None:
    """Import the packages that fill the registries. By name, so that nothing here depends on a kind."""
    for package in _PACKAGES:
        importlib.import_module(f"irsim_gym.{package}")


def every() -> tuple[Registry, ...]:
    """Return the registries of all families of kinds."""
    return tuple(BY_KEY.values())


def kind_named(family: str, name: str) -> Any:
    """Return the kind of a family that is registered under a name.

    Raises:
        UnknownNameError: Nothing is; the message says how one's own is registered.
    """
    load()
    return next(registry for registry in every() if registry.family == family).entry(name).kind


def commands(behavior: object, drive: type[Any]) -> bool:
    """Return whether a behaviour, or its kind, commands a kind of drive: it names it, or names none."""
    return not hasattr(behavior, "kinematics") or KINEMATICS.name_of(drive) in behavior.kinematics


def steers(behavior: Any, drive: type[Any]) -> bool:
    """Return whether a behaviour commands a drive by way of velocities: it is for ``omni``, and the drive steers."""
    return hasattr(drive, "steer") and not commands(behavior, drive) and "omni" in behavior.kinematics
