"""The names that most kinds and phases of a step import, from one place."""

from irsim_gym.arraytypes import Flags, Floats, Ints, Rays
from irsim_gym.jit import kernel
from irsim_gym.scenario.options import kind, option
from irsim_gym.structs import Struct
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import ACKERMANN, DIFFERENTIAL, OMNI_ANGULAR, OMNI_BODY, OMNI_WORLD, ROBOT, Model
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import State

__all__ = [
    "ACKERMANN",
    "DIFFERENTIAL",
    "OMNI_ANGULAR",
    "OMNI_BODY",
    "OMNI_WORLD",
    "ROBOT",
    "Flags",
    "Floats",
    "Group",
    "Ints",
    "Model",
    "Rays",
    "Shard",
    "State",
    "Struct",
    "kernel",
    "kind",
    "option",
    "row_of",
]
