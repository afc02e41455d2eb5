"""What a scenario file says: its text becomes typed, frozen models.

No array of a simulation, and no kind: kinds declare their options with ``base.options``.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from irsim_gym.scenario.reading.load import load_scenario
    from irsim_gym.scenario.specs.gui_spec import GuiSpec
    from irsim_gym.scenario.specs.library import configs_folder, find
    from irsim_gym.scenario.specs.spec import BodySpec, PlacementSpec, Scenario
    from irsim_gym.scenario.specs.world_spec import WorldSpec
    from irsim_gym.scenario.text.source import MissingFileError

__all__ = ["BodySpec", "GuiSpec", "MissingFileError", "PlacementSpec", "Scenario", "WorldSpec", "configs_folder"]
__all__ += ["find", "load_scenario"]

_HOMES = {"MissingFileError": "text.source", "GuiSpec": "specs.gui_spec", "configs_folder": "specs.library"}
_HOMES |= {"find": "specs.library", "WorldSpec": "specs.world_spec", "load_scenario": "reading.load"}


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'irsim_gym.scenario' has no attribute {name!r}")
    return getattr(import_module(f"irsim_gym.scenario.{_HOMES.get(name, 'specs.spec')}"), name)
