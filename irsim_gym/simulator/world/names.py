"""The names that most kinds and phases of a step import, from one place."""

from irsim_gym.base.arraytypes import Flags, Floats, Ints, Rays
from irsim_gym.base.kernels import kernel
from irsim_gym.base.kernels.structs import Struct
from irsim_gym.base.options import kind, option
from irsim_gym.simulator.world.group import Group, Shard
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL, OMNI_ANGULAR, OMNI_BODY, OMNI_WORLD, ROBOT, Model
from irsim_gym.simulator.world.rows import row_of
from irsim_gym.simulator.world.state import State
