"""Ids for Gymnasium and PettingZoo: one for each scenario file, and ``irsim_gym/World-v0`` for any file."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium
from wrapt import register_post_import_hook

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.envs.parts.by_hand import Environment
from irsim_gym.envs.parts.limits import ScenarioSpec, batch_spec, scenario_spec
from irsim_gym.scenario.specs.ids import ANY, IDS, NAMESPACE
from irsim_gym.scenario.specs.library import SUFFIXES, every_scenario

if TYPE_CHECKING:
    from irsim_gym.envs.gymnasium.worlds import ScenarioSource, TaskSource

ENTRY_POINT = "irsim_gym:WorldEnv"
VECTOR_ENTRY_POINT = "irsim_gym:WorldVectorEnv"
PARALLEL_ENTRY_POINT = "irsim_gym:parallel_env"
SINGLES = (gymnasium.VectorizeMode.SYNC, gymnasium.VectorizeMode.ASYNC)
DEFAULTS = {**{"strict": True, "autoreset_mode": "NextStep", "num_threads": 1}, **{"numpy_infos": False}}
"""Arguments of whatever makes environments whose default is not None."""


def env_id(name: str, namespace: str = NAMESPACE) -> str:
    """Return the id of a scenario: characters that an id may not hold become ``_``."""
    return f"{namespace}/{re.sub(r'[^A-Za-z0-9_-]', '_', name)}-v0"


def register() -> None:
    """Register the scenarios that come with the package, as importing it does; once more changes nothing.

    Ids are known in a process that has imported the package. Where worker processes begin without it, let each of them
    call this function (``initializer=irsim_gym.register``), or name the package in the id, which imports it:
    ``irsim_gym:irsim_gym/corridor-v0``. No file is read.
    """
    IDS.look_in(gymnasium.registry)
    _register(ANY, {})
    for name in every_scenario():
        _register(env_id(name), {"scenario": name})


def register_scenarios(folder: str | Path, namespace: str = NAMESPACE) -> tuple[str, ...]:
    """Register each YAML file of a folder as ``<namespace>/<file name>-v0``; none is read before it is made.

    The ids are known to ``gymnasium.make``, ``gymnasium.make_vec`` and ``pettingzoo.make("parallel", ...)``, and
    wherever a scenario is named. They are known in this process: a worker process has to call this as well.

    Args:
        folder: The folder; its subfolders are left out.
        namespace: First part of the ids.

    Returns:
        The ids, in alphabetical order.

    Raises:
        NotADirectoryError: There is no such folder.
        IrsimGymError: Two files would get one id.
    """
    folder = Path(folder).resolve()
    if not folder.is_dir():
        raise NotADirectoryError(f"no such folder: {folder}")
    files = sorted(file for file in folder.iterdir() if file.suffix in SUFFIXES and file.is_file())
    ids = tuple(env_id(file.stem, namespace) for file in files)
    for one, file in zip(ids, files, strict=True):
        _register(one, {"scenario": str(file)})
    return ids


def _register(env_id: str, kwargs: dict[str, Any]) -> None:
    """Register an id; a second call with the same scenario does nothing. PettingZoo gets it when it is imported."""
    spec = gymnasium.registry.get(env_id)
    if spec is None:
        gymnasium.register(env_id, ENTRY_POINT, vector_entry_point=VECTOR_ENTRY_POINT, kwargs=kwargs)
        gymnasium.registry[env_id] = scenario_spec(gymnasium.registry[env_id])
        # `import irsim_gym` must not load PettingZoo, which few need and which sets variables of SDL for the process.
        register_post_import_hook(partial(_register_parallel, env_id, kwargs), "pettingzoo")
    elif spec.kwargs != kwargs:
        taken, title = (source.get("scenario", "any file") for source in (spec.kwargs, kwargs))
        raise IrsimGymError(f"the id '{env_id}' is taken by {taken}; rename {title}, or take another namespace")


def _register_parallel(env_id: str, kwargs: dict[str, Any], pettingzoo: Any) -> None:
    """Register an id in the registry of PettingZoo, which it has from version 1.27 on."""
    if hasattr(pettingzoo, "parallel_registry"):
        pettingzoo.parallel_registry.pop(env_id, None)  # it would warn of one that it has already
        pettingzoo.register("parallel", env_id, PARALLEL_ENTRY_POINT, kwargs=kwargs)


def make(
    scenario: ScenarioSource,
    *,
    task: TaskSource = None,
    max_steps: int | None = None,
    max_episode_steps: int | None = None,
    render_mode: str | None = None,
    strict: bool = True,
    numpy_infos: bool = False,
    disable_env_checker: bool | None = None,
    **parameters: object,
) -> gymnasium.Env[Any, Any]:
    """Make a single environment from a shipped name, a YAML file, plain data or an id.

    Args:
        scenario: What to make.
        task: Name of a shipped task, path, or plain data; None for the scenario's own.
        max_steps: Time limit of the task [steps]; None for the task's.
        max_episode_steps: Another time limit [steps]; of it and ``max_steps`` the smaller one counts.
        render_mode: ``"rgb_array"``, ``"rgb_array_list"``, ``"human"`` or None, see ``WorldEnv.render``.
        strict: False ignores unused keys with an ``IgnoredKeyWarning``; True raises an error.
        numpy_infos: Infos hold NumPy scalars, see ``WorldEnv``.
        disable_env_checker: True leaves out Gymnasium's checks of the first steps.
        **parameters: Values for the scenario's parameters.
    """
    options = _given(
        task=task,
        max_steps=max_steps,
        max_episode_steps=max_episode_steps,
        render_mode=render_mode,
        strict=strict,
        numpy_infos=numpy_infos,
        disable_env_checker=disable_env_checker,
    )
    env_id, kwargs = _resolve(scenario, {**options, **parameters})
    return Environment(gymnasium.make(env_id, **kwargs))


def make_vec(
    scenario: ScenarioSource,
    num_envs: int = 1,
    *,
    task: TaskSource = None,
    max_steps: int | None = None,
    max_episode_steps: int | None = None,
    autoreset_mode: gymnasium.vector.AutoresetMode | str = "NextStep",
    num_threads: int = 1,
    render_mode: str | None = None,
    strict: bool = True,
    vectorization_mode: gymnasium.VectorizeMode | str | None = None,
    vector_kwargs: dict[str, Any] | None = None,
    wrappers: Sequence[Callable[[gymnasium.Env[Any, Any]], gymnasium.Env[Any, Any]]] | None = None,
    **parameters: object,
) -> gymnasium.vector.VectorEnv[Any, Any, Any]:
    """Make the native batch of environments from a shipped name, a YAML file, plain data or an id.

    Args:
        scenario: What to make.
        num_envs: Number of worlds.
        task: Name of a shipped task, path, or plain data; None for the scenario's own.
        max_steps: Time limit of the task [steps]; None for the task's.
        max_episode_steps: Another time limit [steps]; the smaller one counts.
        autoreset_mode: ``"NextStep"``, ``"SameStep"`` or ``"Disabled"``.
        num_threads: Threads that share the worlds.
        render_mode: ``"rgb_array"``, ``"rgb_array_list"``, ``"human"`` or None, see ``WorldVectorEnv.render``.
        strict: False ignores unused keys with an ``IgnoredKeyWarning``; True raises an error.
        vectorization_mode: ``"sync"`` or ``"async"`` makes single environments, see ``gymnasium.make_vec``.
        vector_kwargs: With these modes, arguments of Gymnasium's vector environment.
        wrappers: With these modes, wrappers around each single environment.
        **parameters: Values for the scenario's parameters.
    """
    options = _given(
        task=task,
        max_steps=max_steps,
        max_episode_steps=max_episode_steps,
        autoreset_mode=autoreset_mode,
        num_threads=num_threads,
        render_mode=render_mode,
        strict=strict,
        vectorization_mode=vectorization_mode,
        vector_kwargs=vector_kwargs,
        wrappers=wrappers,
    )
    _refuse_for_singles(options)
    env_id, kwargs = _resolve(scenario, {**options, **parameters})
    return gymnasium.make_vec(env_id, num_envs=num_envs, **kwargs)


def _given(**chosen: object) -> dict[str, Any]:
    """Return the arguments that differ from their defaults: what is registered with an id holds for the others."""
    return {name: value for name, value in chosen.items() if not _is_default(name, value)}


def _is_default(name: str, value: object) -> bool:
    return type(value) is type(DEFAULTS.get(name)) and value == DEFAULTS.get(name)


def _refuse_for_singles(kwargs: Mapping[str, object]) -> None:
    """Raise an IrsimGymError for arguments of ``gymnasium.make_vec`` that only single environments support."""
    for name in ("wrappers", "vector_kwargs"):
        if kwargs.get(name) and kwargs.get("vectorization_mode") not in ("sync", "async", *SINGLES):
            raise IrsimGymError(
                f"{name} is for single environments: pass vectorization_mode='sync' or 'async' as "
                "well. The batch takes its own keywords directly, and wrappers of gymnasium.wrappers.vector around it"
            )


def spec_of(scenario: Any, kwargs: dict[str, Any]) -> ScenarioSpec:
    """Return the spec from which ``gymnasium.make`` makes what ``make(scenario, **kwargs)`` does.

    Keywords that say nothing (None, and their defaults) are left out.
    """
    env_id, options = _resolve(scenario, _given(**kwargs))
    spec = copy(scenario_spec(gymnasium.registry[env_id]))
    spec.kwargs = {**spec.kwargs, **options}
    return batch_spec(spec)


def _resolve(scenario: ScenarioSource, kwargs: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    """Return the id to make and its arguments."""
    name = IDS.find(scenario)
    if name is None and isinstance(scenario, str) and scenario in every_scenario():
        name = env_id(scenario)
    if name is not None and name in gymnasium.registry:
        return name, kwargs
    return ANY, {**kwargs, "scenario": str(scenario) if isinstance(scenario, Path) else scenario}
