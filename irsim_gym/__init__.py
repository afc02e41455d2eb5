"""Gymnasium environments for mobile robots, written in IR-SIM's YAML, stepped in batches by compiled kernels.

Importing the package registers the shipped scenarios as ``irsim_gym/<name>-v0``, with Gymnasium at once and with
PettingZoo when somebody imports that; everything else is loaded when used.
"""

from __future__ import annotations

import importlib
import os
import signal
import sys
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if (
    sys.orig_argv[1:3] == ["-m", "irsim_gym"] or os.path.basename(sys.argv[0]) == "irsim-gym"  # noqa: PTH119
) and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    # While a command loads its packages, Ctrl-C ends it without a traceback, until ``cli.main`` takes over.
    signal.signal(signal.SIGINT, signal.SIG_DFL)

from irsim_gym import errors
from irsim_gym.base.errors import suggestion
from irsim_gym.base.faces import keep_former
from irsim_gym.base.version import __version__
from irsim_gym.envs.gymnasium.registration import make, make_vec, register, register_scenarios

if TYPE_CHECKING:
    from irsim_gym import irsim, plugins, sb3
    from irsim_gym.cli.work.from_python import train
    from irsim_gym.envs.gymnasium.single import WorldEnv
    from irsim_gym.envs.gymnasium.vector import WorldVectorEnv
    from irsim_gym.envs.teams.batch import Batch, make_batch
    from irsim_gym.envs.teams.batch_step import BatchStep
    from irsim_gym.envs.teams.parallel import WorldParallelEnv, parallel_env
    from irsim_gym.envs.teams.torch_rows import TorchRows, torch_rows
    from irsim_gym.evaluation.arena.contest import arena
    from irsim_gym.evaluation.comparison.comparison import evaluate
    from irsim_gym.evaluation.comparison.demonstrations import load_demonstrations
    from irsim_gym.evaluation.comparison.recorder import record_demonstrations
    from irsim_gym.live.plan_ways import plan
    from irsim_gym.live.population.body import Body
    from irsim_gym.live.world import World, load
    from irsim_gym.plugins import action, behavior, drive, ending, group_behavior, observation, placement, reward
    from irsim_gym.plugins import sensor as sensor
    from irsim_gym.scenario import load_scenario
    from irsim_gym.simulator.engine.compile import compile
    from irsim_gym.simulator.engine.simulation import Simulation
    from irsim_gym.training.export.loading import load_policy

_HOMES = {
    "irsim_gym.evaluation.arena.contest": "arena",
    "irsim_gym.simulator.engine.compile": "compile",
    "irsim_gym.simulator.engine.simulation": "Simulation",
    "irsim_gym.envs.teams.batch": "Batch make_batch",
    "irsim_gym.envs.teams.batch_step": "BatchStep",
    "irsim_gym.envs.teams.parallel": "WorldParallelEnv parallel_env",
    "irsim_gym.envs.gymnasium.single": "WorldEnv",
    "irsim_gym.envs.teams.torch_rows": "TorchRows torch_rows",
    "irsim_gym.envs.gymnasium.vector": "WorldVectorEnv",
    "irsim_gym.live.population.body": "Body",
    "irsim_gym.live.plan_ways": "plan",
    "irsim_gym.live.world": "World load",
    "irsim_gym.plugins": "action behavior drive ending group_behavior observation placement reward sensor",
    "irsim_gym.scenario": "load_scenario",
    "irsim_gym.evaluation.comparison.comparison": "evaluate",
    "irsim_gym.evaluation.comparison.demonstrations": "load_demonstrations",
    "irsim_gym.cli.work.from_python": "train",
    "irsim_gym.training.export.loading": "load_policy",
    "irsim_gym.evaluation.comparison.recorder": "record_demonstrations",
}
_LAZY = {name: module for module, names in _HOMES.items() for name in names.split()}
_FACES = ("evaluation", "irsim", "levels", "live", "plugins", "rllib", "sb3", "suite", "tasks", "training")

__all__ = ["Batch", "BatchStep", "Body", "Simulation", "TorchRows", "World", "WorldEnv", "WorldParallelEnv"]
__all__ += ["WorldVectorEnv", "__version__", "action", "arena", "behavior", "compile", "drive", "ending", "errors"]
__all__ += ["evaluate", "group_behavior", "irsim", "load", "load_demonstrations", "load_policy", "load_scenario"]
__all__ += ["make", "make_batch", "make_vec", "observation", "parallel_env", "placement", "plan", "plugins"]
__all__ += ["record_demonstrations", "register", "register_scenarios", "reward", "sb3", "sensor", "torch_rows", "train"]


def __getattr__(name: str) -> Any:
    if name in _FACES:
        return importlib.import_module(f"irsim_gym.{name}")
    if name not in _LAZY:
        raise AttributeError(f"module 'irsim_gym' has no attribute {name!r}{_elsewhere(name)}")
    globals()[name] = value = getattr(importlib.import_module(_LAZY[name]), name)
    return value


def __dir__() -> list[str]:
    return sorted(__all__)


def _elsewhere(name: str) -> str:
    """Return where a name is that is not here."""
    if name.startswith("_") or find_spec(f"irsim_gym.{name}"):  # Python itself asks, before it imports a module
        return ""
    of_irsim = importlib.import_module("irsim_gym.irsim").__all__
    return f": use irsim_gym.irsim.{name}" if name in of_irsim else suggestion(name, __all__)


register()
keep_former()
