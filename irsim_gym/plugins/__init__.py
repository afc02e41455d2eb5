"""Everything that kinds of one's own are written with: decorators for functions, and what classes need.

A function is called for one body of one world at a time, so that a batch equals single environments bit for bit. A
class treats many worlds at once, with NumPy or with kernels; its family's protocol says what it has to have, and is
checked when the class is registered. docs/plugins.md shows each.
"""

from irsim_gym.base.families import (
    ACTIONS,
    BEHAVIORS,
    DISTURBANCES,
    ENDINGS,
    FOOTPRINTS,
    GROUP_BEHAVIORS,
    KINEMATICS,
    MAPS,
    OBSERVATIONS,
    PLACEMENTS,
    REWARDS,
    SENSORS,
    SHIELDS,
)
from irsim_gym.base.options import Bounds, Drawn
from irsim_gym.base.rng import integer, normal, uniform
from irsim_gym.bodies.behaviors.python.custom import behavior, group_behavior
from irsim_gym.bodies.behaviors.python.views import BodyView, EgoView
from irsim_gym.plugins.body_kinds import drive, placement, sensor
from irsim_gym.plugins.task_kinds import AgentView, action, ending, observation, reward
from irsim_gym.simulator.world.disturbed import Disturbed, whole_steps
from irsim_gym.simulator.world.kinds import (
    Begins,
    BehaviorKind,
    DisturbanceKind,
    Draws,
    DrawsMaps,
    DriveKind,
    FootprintKind,
    MapKind,
    PlacementKind,
    ReadsScan,
    Reports,
    SensorKind,
    ShieldKind,
    Steers,
)
from irsim_gym.simulator.world.names import Group, Model, Shard, State, kernel, kind, option
from irsim_gym.simulator.world.outline import Outline
from irsim_gym.simulator.world.own_scan import OwnScan, find_hits
from irsim_gym.simulator.world.response import Response
from irsim_gym.simulator.world.rows import row_of
from irsim_gym.tasks.terms.episode_state import EpisodeState
from irsim_gym.tasks.terms.mirrored import HasMirrored, Mirrored
from irsim_gym.tasks.terms.outcome import HitKind, Outcome
from irsim_gym.tasks.terms.term import (
    ActionKind,
    EndingKind,
    HasArrays,
    HasBounds,
    HasUnused,
    IsImage,
    MindsClearance,
    ObservationKind,
    Remembers,
    RewardKind,
    Term,
)
from irsim_gym.tasks.terms.words import Columns, TellsActions, TellsColumns, TellsWhen

__all__ = ["ACTIONS", "BEHAVIORS", "ENDINGS", "FOOTPRINTS", "GROUP_BEHAVIORS", "KINEMATICS", "MAPS", "OBSERVATIONS"]
__all__ += ["DISTURBANCES", "Bounds", "DisturbanceKind", "Disturbed", "Drawn", "whole_steps"]
__all__ += ["PLACEMENTS", "REWARDS", "SENSORS", "ActionKind", "AgentView", "Begins", "BehaviorKind", "BodyView"]
__all__ += ["Columns", "Draws", "DrawsMaps", "DriveKind", "EgoView", "EndingKind", "EpisodeState", "FootprintKind"]
__all__ += ["Group", "HasArrays", "HasBounds", "HasMirrored", "HasUnused", "HitKind", "IsImage", "MapKind"]
__all__ += ["MindsClearance", "Mirrored", "Model", "ObservationKind", "Outcome", "Outline", "OwnScan"]
__all__ += ["PlacementKind", "ReadsScan", "Remembers", "Reports", "RewardKind", "SensorKind", "Shard", "State"]
__all__ += ["Steers", "TellsActions", "TellsColumns", "TellsWhen", "Term", "action", "behavior", "drive", "ending"]
__all__ += ["SHIELDS", "Response", "ShieldKind"]
__all__ += ["find_hits", "group_behavior", "integer", "kernel", "kind", "normal", "observation", "option"]
__all__ += ["placement", "reward", "row_of", "sensor", "uniform"]
