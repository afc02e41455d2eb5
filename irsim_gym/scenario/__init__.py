"""Scenario files.

The names are loaded on first use, so that listing the shipped files needs no validation library.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from irsim_gym.scenario.gui_spec import GuiSpec
    from irsim_gym.scenario.library import configs_folder, find
    from irsim_gym.scenario.load import load_scenario
    from irsim_gym.scenario.source import MissingFileError
    from irsim_gym.scenario.spec import BodySpec, PlacementSpec, Scenario, WorldSpec

__all__ = ["BodySpec", "GuiSpec", "MissingFileError", "PlacementSpec", "Scenario", "WorldSpec", "configs_folder"]
__all__ += ["find", "load_scenario"]

_HOMES = {"MissingFileError": "source", "GuiSpec": "gui_spec", "configs_folder": "library", "find": "library"} | {
    "load_scenario": "load"
}


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'irsim_gym.scenario' has no attribute {name!r}")
    return getattr(import_module(f"irsim_gym.scenario.{_HOMES.get(name, 'spec')}"), name)
