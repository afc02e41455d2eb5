"""The registries of all families. A family's package fills its own when it is imported."""

from __future__ import annotations

import importlib

from irsim_gym.registry import Registry

_OWN = "; your own is registered by @irsim_gym.{}, on the command line from --import FILE.py"

_CONTRACT = "irsim_gym.tasks.contract"

KINEMATICS = Registry("kinematics")
BEHAVIORS = Registry("behavior", _OWN.format("behavior"))
GROUP_BEHAVIORS = Registry("group behavior", _OWN.format("group_behavior"))
FOOTPRINTS = Registry("shape")
PLACEMENTS = Registry("distribution")
SENSORS = Registry("sensor")
MAPS = Registry("obstacle map")
ACTIONS = Registry("action", contract=_CONTRACT)
OBSERVATIONS = Registry("observation", contract=_CONTRACT)
REWARDS = Registry("reward", contract=_CONTRACT)
ENDINGS = Registry("ending", contract=_CONTRACT)
SECTIONS = Registry("section")
"""Sections of a scenario file whose keys a package beyond ``scenario`` declares: for the reference and the schema."""

_PACKAGES = ("kinematics", "behaviors", "footprints", "placements", "sensors", "maps", "tasks")


def load() -> None:
    """Import the packages that fill the registries. By name, so that nothing here depends on a kind."""
    for package in _PACKAGES:
        importlib.import_module(f"irsim_gym.{package}")


def every() -> tuple[Registry, ...]:
    """Return the registries of all families of kinds."""
    return (
        KINEMATICS,
        BEHAVIORS,
        GROUP_BEHAVIORS,
        FOOTPRINTS,
        PLACEMENTS,
        SENSORS,
        MAPS,
        ACTIONS,
        OBSERVATIONS,
        REWARDS,
        ENDINGS,
    )
