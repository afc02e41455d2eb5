"""What scripts and behaviours import from IR-SIM beside the world itself, under its names.

``import irsim`` becomes ``import irsim_gym.irsim as irsim``, ``from irsim.lib import register_behavior`` becomes ``from
irsim_gym.irsim import register_behavior``, and likewise for planners and the small functions about angles; the rest of
such a file stays as it is.
"""

from __future__ import annotations

import math
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.behaviors.by_drive import (
    register_behavior,
    register_behavior_class,
    register_group_behavior,
    register_group_behavior_class,
)
from irsim_gym.behaviors.views import BodyView as ObjectBase
from irsim_gym.errors import suggestion
from irsim_gym.live.level_source import ScenarioSource
from irsim_gym.live.planners import AStarPlanner, JPSPlanner
from irsim_gym.live.world import World, load

__all__ = [
    "AStarPlanner",
    "JPSPlanner",
    "ObjectBase",
    "WrapTo2Pi",
    "WrapToPi",
    "make",
    "register_behavior",
    "register_behavior_class",
    "register_group_behavior",
    "register_group_behavior_class",
    "relative_position",
]

_SAMPLING = (
    "planners that sample are not here: world.path(start, goal) is the shortest way for a disc, AStarPlanner the "
    "shortest one over the cells of world.get_map()"
)
_INSTEAD = {
    **dict.fromkeys(["RRT", "RRTStar", "InformedRRTStar", "PRMPlanner"], _SAMPLING),
    "env_param": "a behaviour gets its own body and the others as arguments",
    "world_param": "a behaviour's own body has time and step_time",
}


def __getattr__(name: str) -> NoReturn:
    if name in _INSTEAD:  # an AttributeError would lose its message in `from irsim_gym.irsim import ...`
        raise ImportError(f"irsim_gym.irsim has no '{name}': {_INSTEAD[name]}", name=__name__)
    raise AttributeError(f"module 'irsim_gym.irsim' has no attribute '{name}'{suggestion(name, __all__)}")


def make(world_name: ScenarioSource | None = None, **options: Any) -> World:
    """Load a world as ``irsim_gym.load(..., columns=True)`` does: a script for IR-SIM then changes its import alone.

    Args:
        world_name: The file; by default the YAML file beside the running script that is named as the script is.
        **options: As for ``irsim_gym.load``. A window opens with ``display=True`` only.
    """
    return load(world_name, **{"columns": True, **options})


def WrapToPi(rad: float, positive: bool = False) -> float:  # noqa: N802
    """Return an angle in [-pi, pi) [rad]; 0 for one that is not finite.

    Args:
        rad: The angle [rad].
        positive: Without its sign.
    """
    wrapped = (rad + math.pi) % (2.0 * math.pi) - math.pi if math.isfinite(rad) else 0.0
    return abs(wrapped) if positive else wrapped


def WrapTo2Pi(rad: float) -> float:  # noqa: N802
    """Return an angle in [0, 2 pi) [rad]; 0 for one that is not finite.

    Args:
        rad: The angle [rad].
    """
    return rad % (2.0 * math.pi) if math.isfinite(rad) else 0.0


def relative_position(position1: ArrayLike, position2: ArrayLike, topi: bool = True) -> tuple[float, float]:
    """Return how far [m] and in which direction [rad] one point is from another.

    Args:
        position1: From where: x, y and perhaps more [m], flat or a column.
        position2: To where.
        topi: Straight back is -pi, not pi.
    """
    x, y = np.asarray(position2, np.float64).reshape(-1)[:2] - np.asarray(position1, np.float64).reshape(-1)[:2]
    bearing = math.atan2(y, x)
    return math.hypot(x, y), WrapToPi(bearing) if topi else bearing
