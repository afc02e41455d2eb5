"""How a body decides."""

from irsim_gym.behaviors.dash import Dash
from irsim_gym.families import BEHAVIORS

BEHAVIORS.register("dash", Dash)
