"""What scripts and behaviours import from IR-SIM, under its names.

``irsim`` becomes ``irsim_gym.irsim`` wherever it is imported; the rest of a file stays as it is. Each of IR-SIM's
modules is another name of this one: ``from irsim_gym.irsim.util.util import WrapToPi`` and ``from irsim_gym.irsim
import WrapToPi`` are the same. A name of IR-SIM that is not here raises an ``ImportError`` that says what to use.
"""

import sys
from typing import Any

from irsim_gym.base.errors import suggestion
from irsim_gym.base.version import __version__ as __version__
from irsim_gym.bodies.behaviors.python.by_drive import (
    register_behavior,
    register_behavior_class,
    register_group_behavior,
    register_group_behavior_class,
)
from irsim_gym.bodies.behaviors.python.views import BodyView as ObjectBase
from irsim_gym.irsim.avoidance import DiffRVO, OmniRVO, reciprocal_vel_obs
from irsim_gym.irsim.base_world import EnvBase
from irsim_gym.irsim.dashing import AckerDash, DiffDash, OmniAngularDash, OmniDash
from irsim_gym.irsim.drives import (
    DifferentialKinematics,
    KinematicsHandler,
    differential_kinematics,
    register_kinematics,
)
from irsim_gym.irsim.factory import GeometryFactory
from irsim_gym.irsim.rotations import (
    ClipTo2Pi,
    WrapTo2Pi,
    WrapToPi,
    WrapToRegion,
    cross_product,
    diff_to_omni,
    dist_hypot,
    distance,
    gen_inequal_from_vertex,
    geometry_transform,
    get_affine_transform,
    get_transform,
    is_2d_list,
    is_convex_and_ordered,
    omni_to_diff,
    relative_position,
    to_numpy,
    transform_point_with_state,
    vel_diff2world,
    vel_omni2world,
    vel_world2diff,
    vel_world2omni,
    vertices_transform,
)
from irsim_gym.live.planning.grid_map import GridMap
from irsim_gym.live.planning.planners import AStarPlanner, JPSPlanner
from irsim_gym.live.planning.samplers import RRT, InformedRRTStar, PRMPlanner, RRTStar
from irsim_gym.live.session.level_source import ScenarioSource
from irsim_gym.simulator.readings import messages
from irsim_gym.simulator.readings.irsim_names import advice

__all__ = ["AStarPlanner", "AckerDash", "ClipTo2Pi", "DiffDash", "DiffRVO", "EnvBase", "EnvBase3D", "EnvGridMap"]
__all__ += ["GeometryFactory", "JPSPlanner", "Map", "ObjectBase", "OmniAngularDash", "OmniDash", "OmniRVO", "WrapTo2Pi"]
__all__ += ["WrapToPi", "WrapToRegion", "cross_product", "diff_to_omni", "dist_hypot", "distance"]
__all__ += ["gen_inequal_from_vertex", "geometry_transform", "get_affine_transform", "get_transform", "is_2d_list"]
__all__ += ["is_convex_and_ordered", "make", "omni_to_diff", "reciprocal_vel_obs", "register_behavior"]
__all__ += ["register_behavior_class", "register_group_behavior", "register_group_behavior_class", "relative_position"]
__all__ += ["to_numpy", "transform_point_with_state", "vel_diff2world", "vel_omni2world", "vel_world2diff"]
__all__ += ["vel_world2omni", "vertices_transform"]
__all__ += ["RRT", "InformedRRTStar", "PRMPlanner", "RRTStar"]
__all__ += ["DifferentialKinematics", "KinematicsHandler", "differential_kinematics", "register_kinematics"]

EnvBase3D = EnvBase
"""The same class: pictures show a world from above."""

EnvGridMap = Map = GridMap

MESSAGES = frozenset({"ContactState", "Header", "LaserScan", "Message", "ObjectState", "Odometry", "Point", "Pose"})
MESSAGES |= {"PoseWithCovariance", "Quaternion", "Twist", "TwistWithCovariance", "Vector3", "WorldState"}
"""Classes of ``irsim.msg``, which can be imported from here, too."""

MODULES = tuple(advice("modules"))
"""IR-SIM's modules. Each of them can be imported, with all names in it."""

# `import irsim_gym.irsim.lib.behavior` finds these entries, as `import os.path` finds that of `os`.
for _name in MODULES:
    sys.modules[f"{__name__}.{_name}"] = sys.modules[__name__]


def __getattr__(name: str) -> Any:
    if name in {part for path in MODULES for part in path.split(".")}:  # as in irsim.util.util.WrapToPi
        return sys.modules[__name__]
    if name in MESSAGES:
        return getattr(messages, name)
    instead = advice("import")
    if name in instead:  # an AttributeError would lose its message in `from irsim_gym.irsim import ...`
        raise ImportError(f"irsim_gym.irsim has no '{name}': {instead[name]}", name=__name__)
    raise AttributeError(f"module 'irsim_gym.irsim' has no attribute '{name}'{suggestion(name, __all__)}")


def make(world_name: ScenarioSource | None = None, **options: Any) -> EnvBase:
    """Load a world as ``irsim_gym.load(..., columns=True)`` does: a script for IR-SIM then changes its import alone.

    Args:
        world_name: The file; by default the YAML file beside the running script that is named as the script is.
        **options: As for ``irsim_gym.load``. A window opens with ``display=True`` only.
    """
    return EnvBase(world_name, **options)
