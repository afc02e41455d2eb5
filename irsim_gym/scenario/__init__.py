"""What a scenario file says."""

from irsim_gym.scenario.load import load_scenario
from irsim_gym.scenario.source import MissingFileError
from irsim_gym.scenario.spec import BodySpec, GuiSpec, PlacementSpec, Scenario, WorldSpec

__all__ = [
    "BodySpec",
    "GuiSpec",
    "MissingFileError",
    "PlacementSpec",
    "Scenario",
    "WorldSpec",
    "load_scenario",
]
