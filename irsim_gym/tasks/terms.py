"""The names that most observations, rewards and endings import, from one place."""

from irsim_gym.engine import Simulation
from irsim_gym.scenario.options import kind, option
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.tasks.mirrored import IN_WORLD, Mirrored
from irsim_gym.tasks.outcome import Outcome
from irsim_gym.tasks.term import Bound, Role, Term
from irsim_gym.tasks.words import Columns
from irsim_gym.world.names import Model, Shard, State, Struct, kernel

__all__ = [
    "IN_WORLD",
    "Bound",
    "Columns",
    "EpisodeState",
    "Mirrored",
    "Model",
    "Outcome",
    "Role",
    "Shard",
    "Simulation",
    "State",
    "Struct",
    "Term",
    "kernel",
    "kind",
    "option",
]
