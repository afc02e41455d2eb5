"""The names that most observations, rewards and endings import, from one place.

Only what several terms share.
"""

from irsim_gym.base.options import kind, option
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.world.names import Floats, Ints, Model, Rays, Shard, State, Struct, kernel, row_of
from irsim_gym.tasks.terms.episode_state import EpisodeState
from irsim_gym.tasks.terms.mirrored import IN_WORLD, Mirrored
from irsim_gym.tasks.terms.outcome import Outcome
from irsim_gym.tasks.terms.term import Bound, Needs, RewardDefaults, Role, Term
from irsim_gym.tasks.terms.words import Columns
