"""The names that most kinds and phases of a step import, from one place."""

from irsim_gym.base.arraytypes import (
    BodyOutline,
    Bytes,
    CellMaps,
    Cells,
    Flags,
    Floats,
    Ints,
    Labels,
    Point,
    Pose,
    Rays,
    Record,
    Records,
    Spans,
    Vector,
    Words,
)
from irsim_gym.base.kernels import kernel
from irsim_gym.base.kernels.structs import Struct, record_type
from irsim_gym.base.options import kind, option
from irsim_gym.base.rng import integer, mix, next_bits, normal, uniform
from irsim_gym.simulator.world.group import Group, Shard, WorldContext, find_sensor
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL, OMNI_ANGULAR, OMNI_BODY, OMNI_WORLD, ROBOT, Model
from irsim_gym.simulator.world.outline import Outline, chain, outline_of, own_outline, place_outline
from irsim_gym.simulator.world.own_scan import OwnScan, find_hits
from irsim_gym.simulator.world.rows import row_of
from irsim_gym.simulator.world.state import State
