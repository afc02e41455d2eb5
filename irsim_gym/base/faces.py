"""How packages show their public names, and where public names of version 0.1 are now."""

import sys
import warnings
from collections.abc import Callable
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from types import ModuleType
from typing import Any

FORMER = {
    "arenas.contest": "arena evaluation.Arena",
    "arenas.standings": "evaluation.Standings",
    "engine": "Simulation compile plugins.Shard",
    "engine.compile": "compile",
    "engine.simulation": "Simulation",
    "envs.batch": "Batch make_batch",
    "envs.batch_step": "BatchStep",
    "envs.description": "envs.Action envs.Block envs.Component "
    "envs.Description envs.Ending envs.Info envs.Part envs.Reward",
    "envs.mirror": "envs.Mirror",
    "envs.moment": "envs.Bodies envs.BodyMoment envs.WorldMoment",
    "envs.parallel": "WorldParallelEnv parallel_env",
    "envs.replays": "RecordReplay",
    "envs.sb3_buffers": "sb3.MaskedDictReplayBuffer sb3.MaskedDictRolloutBuffer sb3.MaskedReplayBuffer "
    "sb3.MaskedRolloutBuffer",
    "envs.sb3_gru": "sb3.DictSequenceBuffer sb3.GruPPO sb3.SequenceBuffer",
    "envs.sb3_memory": "sb3.GruPolicy",
    "envs.sb3_normalize": "sb3.MaskedVecNormalize",
    "envs.single": "WorldEnv",
    "envs.torch_rows": "TorchRows torch_rows",
    "envs.vector": "WorldVectorEnv",
    "envs.worlds": "envs.Worlds",
    "evaluation.behavior_policies": "evaluation.BehaviorPolicy",
    "evaluation.drive_actions": "evaluation.to_actions",
    "evaluation.metrics": "evaluation.EpisodeRow evaluation.Rate evaluation.Summary",
    "evaluation.perception": "evaluation.Perceived",
    "evaluation.policy": "evaluation.Policy evaluation.by_agent",
    "evaluation.reference_policies": "evaluation.ALWAYS_SHOWN evaluation.reference_policy",
    "evaluation.tables": "evaluation.plain evaluation.write_json evaluation.write_text",
    "evaluation.team_metrics": "evaluation.AgentRow evaluation.TeamRow evaluation.TeamSummary",
    "evaluation.teams": "evaluation.top_speed",
    "evaluation.worst_levels": "evaluation.worst_shares",
    "levels.barn": "levels.import_barn",
    "levels.certificate": "levels.Certificate levels.read_certificate",
    "levels.jaxnav": "levels.import_jaxnav",
    "live.body": "Body",
    "live.body_info": "live.HalfPlanes live.ObstacleInfo live.RobotInfo",
    "live.grid_map": "live.GridMap",
    "render": "Renderer=rendering.films.renderer.Renderer",
    "scenario.library": "scenario.configs_folder scenario.find",
    "scenario.load": "load_scenario",
    "scenario.spec": "scenario.BodySpec scenario.Scenario",
    "suite.listing": "suite.reference_figures",
    "suite.members": "suite.Member suite.Suite suite.read_suite suite.shipped_suite",
    "suite.suite_record": "suite.SuiteRecord suite.read_record",
    "tasks.outcome": "tasks.HitKind tasks.Outcome",
    "tasks.task": "tasks.Task tasks.load_task",
    "training.cards": "evaluation.PolicyCard",
    "training.comparison": "evaluate",
    "training.demonstrations": "evaluation.Demonstrations load_demonstrations",
    "training.episode_setup": "evaluation.conditions evaluation.make_episodes",
    "training.evaluate": "evaluation.Evaluation",
    "training.evaluate_teams": "evaluation.TeamEvaluation",
    "training.hyperparameters": "training.Hyperparameters training.Linear training.load_hyperparameters",
    "training.policies": "evaluation.SavedPolicy load_policy=evaluation.as_policy",
    "training.run": "evaluation.machine",
    "training.seed_summary": "training.markdown_table training.seed_cells "
    "training.summarize_seeds training.write_seeds",
    "training.shelf": "evaluation.ShelfPolicy",
    "world.body_readings": "envs.BodyReadings",
    "world.group": "plugins.Group plugins.Shard",
    "world.irsim_readings": "live.IrSimReadings",
    "world.rows": "plugins.row_of",
    "world.sensor_view": "live.SensorView",
}
"""Modules of version 0.1 and the faces that have their public names now. They go with the next release."""


def public(package: str) -> Callable[[str], Any]:
    """Return the ``__getattr__`` of a package with a module ``face``, whose names are loaded when one is used.

    Args:
        package: Its dotted name.
    """

    def load(name: str) -> Any:
        if (name.startswith("__") and name != "__all__") or find_spec(f"{package}.{name}") is not None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(f"{package}.face"), name)

    return load


class FormerModule(ModuleType):
    """A module that is gone: each of its public names warns, and is taken from where it is."""

    def __getattr__(self, name: str) -> Any:
        homes = dict(_homes(FORMER[self.__name__.partition(".")[2]]))
        if name not in homes:
            raise AttributeError(f"module {self.__name__!r} is gone, and with it {name!r}")
        place = f"irsim_gym.{homes[name]}"
        warnings.warn(f"{self.__name__}.{name} is now {place}", DeprecationWarning, stacklevel=2)
        module, _, last = place.rpartition(".")
        return getattr(import_module(module), last)


def _homes(text: str) -> list[tuple[str, str]]:
    """Return names with their places, which end in the same name unless the text says otherwise."""
    parts = [part.partition("=") for part in text.split()]
    return [(first, place) if equals else (first.rpartition(".")[2], first) for first, equals, place in parts]


def keep_former() -> None:
    """Let modules of version 0.1 be imported."""
    for name in FORMER:
        module = FormerModule(f"irsim_gym.{name}")
        module.__spec__ = ModuleSpec(module.__name__, None)
        sys.modules.setdefault(module.__name__, module)
