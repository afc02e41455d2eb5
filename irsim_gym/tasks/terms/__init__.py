"""The names that most observations, rewards and endings import, from one place.

Only what several terms share.
"""

from irsim_gym.base.options import kind, option
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.world.names import Floats, Ints, Model, Rays, Shard, State, Struct, kernel, row_of
from irsim_gym.tasks.terms.episode_state import EpisodeState
from irsim_gym.tasks.terms.graph import HasGraph, RobotValues, Value
from irsim_gym.tasks.terms.mirrored import IN_WORLD, Mirrored, command_exchanged, signed, unchanged
from irsim_gym.tasks.terms.outcome import RUNNING, HitKind, Outcome
from irsim_gym.tasks.terms.scaling import diagonal, unit
from irsim_gym.tasks.terms.term import Bound, HasArrays, IsImage, Needs, RewardDefaults, Role, Term, forget
from irsim_gym.tasks.terms.words import Columns, TellsActions, TellsColumns, TellsWhen, coded
