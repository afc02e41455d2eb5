"""The names that most observations, rewards and endings import, from one place."""

from irsim_gym.engine import Simulation
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.tasks.mirrored import IN_WORLD, Mirrored
from irsim_gym.tasks.outcome import Outcome
from irsim_gym.tasks.term import Bound, Needs, Role, Term
from irsim_gym.tasks.words import Columns
from irsim_gym.world.names import Floats, Ints, Model, Rays, Shard, State, Struct, kernel, kind, option, row_of

__all__ = [
    "IN_WORLD",
    "Bound",
    "Columns",
    "EpisodeState",
    "Floats",
    "Ints",
    "Mirrored",
    "Model",
    "Needs",
    "Outcome",
    "Rays",
    "Role",
    "Shard",
    "Simulation",
    "State",
    "Struct",
    "Term",
    "kernel",
    "kind",
    "option",
    "row_of",
]
