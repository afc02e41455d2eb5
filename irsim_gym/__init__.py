"""Gymnasium environments for mobile robots, written in IR-SIM's YAML, stepped in batches by compiled kernels.

Importing the package registers the shipped scenarios as ``irsim_gym/<name>-v0``, with Gymnasium at once and with
PettingZoo when somebody imports that; everything else is loaded when used.
"""

from __future__ import annotations

import importlib
import os
import signal
import sys
from typing import TYPE_CHECKING, Any

if (
    sys.orig_argv[1:3] == ["-m", "irsim_gym"] or os.path.basename(sys.argv[0]) == "irsim-gym"  # noqa: PTH119
) and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    # While a command loads its packages, Ctrl-C ends it without a traceback, until ``cli.main`` takes over.
    signal.signal(signal.SIGINT, signal.SIG_DFL)

from irsim_gym import errors
from irsim_gym.envs.registration import make, make_vec, register, register_scenarios

if TYPE_CHECKING:
    from irsim_gym import irsim, plugins, sb3
    from irsim_gym.arenas.contest import arena
    from irsim_gym.engine.compile import compile
    from irsim_gym.envs.batch import make_batch
    from irsim_gym.envs.parallel import parallel_env
    from irsim_gym.envs.replays import RecordReplay
    from irsim_gym.envs.torch_rows import torch_rows
    from irsim_gym.live import load, plan
    from irsim_gym.plugins import (
        action,
        behavior,
        drive,
        ending,
        group_behavior,
        observation,
        placement,
        reward,
        sensor,
    )
    from irsim_gym.scenario import load_scenario
    from irsim_gym.training.comparison import evaluate
    from irsim_gym.training.demonstrations import load_demonstrations
    from irsim_gym.training.from_python import train
    from irsim_gym.training.loading import load_policy
    from irsim_gym.training.recorder import record_demonstrations

_DECORATORS = (
    *("action", "behavior", "drive", "ending", "group_behavior"),
    *("observation", "placement", "reward", "sensor"),
)

_LAZY: dict[str, tuple[str, str | None]] = {
    **{name: ("irsim_gym.plugins", name) for name in _DECORATORS},
    "RecordReplay": ("irsim_gym.envs.replays", "RecordReplay"),
    "arena": ("irsim_gym.arenas.contest", "arena"),
    "compile": ("irsim_gym.engine", "compile"),
    "evaluate": ("irsim_gym.training.comparison", "evaluate"),
    "irsim": ("irsim_gym.irsim", None),
    "load": ("irsim_gym.live", "load"),
    "load_demonstrations": ("irsim_gym.training.demonstrations", "load_demonstrations"),
    "load_policy": ("irsim_gym.training.loading", "load_policy"),
    "load_scenario": ("irsim_gym.scenario", "load_scenario"),
    "parallel_env": ("irsim_gym.envs.parallel", "parallel_env"),
    "make_batch": ("irsim_gym.envs.batch", "make_batch"),
    "plan": ("irsim_gym.live", "plan"),
    "plugins": ("irsim_gym.plugins", None),
    "record_demonstrations": ("irsim_gym.training.recorder", "record_demonstrations"),
    "rllib": ("irsim_gym.rllib", None),  # not in __all__: most installations lack Ray
    "sb3": ("irsim_gym.sb3", None),
    "torch_rows": ("irsim_gym.envs.torch_rows", "torch_rows"),
    "train": ("irsim_gym.training.from_python", "train"),
}

_OF_IRSIM = (
    *("AStarPlanner", "JPSPlanner", "ObjectBase", "EnvBase", "EnvBase3D", "EnvGridMap", "Map", "GeometryFactory"),
    *("AckerDash", "DiffDash", "OmniDash", "OmniAngularDash", "DiffRVO", "OmniRVO", "reciprocal_vel_obs"),
    *("register_behavior", "register_behavior_class", "register_group_behavior", "register_group_behavior_class"),
    *("ClipTo2Pi", "WrapTo2Pi", "WrapToPi", "WrapToRegion", "relative_position", "distance", "dist_hypot"),
    *("get_transform", "get_affine_transform", "geometry_transform", "vertices_transform", "to_numpy", "is_2d_list"),
    *("transform_point_with_state", "diff_to_omni", "omni_to_diff", "vel_diff2world", "vel_omni2world"),
    *("vel_world2diff", "vel_world2omni", "cross_product", "is_convex_and_ordered", "gen_inequal_from_vertex"),
)

__version__ = "0.2.0"

__all__ = ["RecordReplay", "__version__", "action", "arena", "behavior", "compile", "drive", "ending", "errors"]
__all__ += ["evaluate", "group_behavior", "irsim", "load", "load_demonstrations", "load_policy", "load_scenario"]
__all__ += ["make", "make_batch", "make_vec", "observation", "parallel_env", "placement", "plan", "plugins"]
__all__ += ["record_demonstrations", "register", "register_scenarios", "reward", "sb3", "sensor", "torch_rows"]
__all__ += ["train"]


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'irsim_gym' has no attribute {name!r}{_elsewhere(name)}")
    module, attribute = _LAZY[name]
    found = importlib.import_module(module)
    value = found if attribute is None else getattr(found, attribute)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)


def _elsewhere(name: str) -> str:
    """Return where a name is that is not here."""
    return f": use irsim_gym.irsim.{name}" if name in _OF_IRSIM else errors.suggestion(name, __all__)


register()
