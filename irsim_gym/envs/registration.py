"""Ids for Gymnasium and PettingZoo: one for each scenario file, and ``irsim_gym/World-v0`` for any file."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium
from wrapt import register_post_import_hook

from irsim_gym.errors import IrsimGymError, UnknownNameError, suggestion
from irsim_gym.scenario.library import scenario_names

if TYPE_CHECKING:
    from irsim_gym.envs.worlds import ScenarioSource, TaskSource

NAMESPACE = "irsim_gym"
ANY = f"{NAMESPACE}/World-v0"
ENTRY_POINT = "irsim_gym.envs.single:WorldEnv"
VECTOR_ENTRY_POINT = "irsim_gym.envs.vector:WorldVectorEnv"
PARALLEL_ENTRY_POINT = "irsim_gym.envs.parallel:parallel_env"
SUFFIXES = (".yaml", ".yml")
DEFAULTS = {"render_backend": "matplotlib", "strict": True, "autoreset_mode": "NextStep", "num_threads": 1}
"""Arguments of ``make`` and ``make_vec`` whose default is not None."""


def env_id(name: str, namespace: str = NAMESPACE) -> str:
    """Return the id of a scenario: characters that an id may not hold become ``_``."""
    return f"{namespace}/{re.sub(r'[^A-Za-z0-9_-]', '_', name)}-v0"


def register_shipped() -> None:
    """Register the scenarios that come with the package. No file is read."""
    _register(ANY, {})
    for name in scenario_names():
        _register(env_id(name), {"scenario": name})


def register_scenarios(folder: str | Path, namespace: str = NAMESPACE) -> tuple[str, ...]:
    """Register each YAML file of a folder as ``<namespace>/<file name>-v0``; none is read before it is made.

    The ids are known to ``gymnasium.make``, ``gymnasium.make_vec`` and ``pettingzoo.make("parallel", ...)``.

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


def _register(one: str, kwargs: dict[str, Any]) -> None:
    """Register an id once; twice with the same scenario is once. PettingZoo gets it when somebody imports it."""
    known = gymnasium.registry.get(one)
    if known is None:
        gymnasium.register(one, ENTRY_POINT, vector_entry_point=VECTOR_ENTRY_POINT, kwargs=kwargs)
        register_post_import_hook(partial(_register_parallel, one, kwargs), "pettingzoo")
    elif known.kwargs != kwargs:
        taken, wanted = (source.get("scenario", "any file") for source in (known.kwargs, kwargs))
        raise IrsimGymError(
            f"the id '{one}' is taken by {taken}; rename {wanted} or register it under another namespace"
        )


def _register_parallel(one: str, kwargs: dict[str, Any], pettingzoo: Any) -> None:
    """Register an id in the registry of PettingZoo, which it has from version 1.27 on."""
    if hasattr(pettingzoo, "parallel_registry"):
        pettingzoo.parallel_registry.pop(one, None)  # it would warn of one that it has already
        pettingzoo.register("parallel", one, PARALLEL_ENTRY_POINT, kwargs=kwargs)


def make(
    scenario: ScenarioSource,
    *,
    task: TaskSource = None,
    max_steps: int | None = None,
    max_episode_steps: int | None = None,
    render_mode: str | None = None,
    render_backend: str = "matplotlib",
    strict: bool = True,
    disable_env_checker: bool | None = None,
    **parameters: Any,
) -> gymnasium.Env[Any, Any]:
    """Make a single environment from a shipped name, a YAML file, plain data or an id.

    Args:
        scenario: What to make.
        task: Name of a shipped task, path, or plain data; None for the scenario's own.
        max_steps: Time limit of the task [steps]; None for the task's.
        max_episode_steps: Time limit of ``gymnasium.make`` [steps], by a wrapper around the environment.
        render_mode: ``"rgb_array"``, ``"rgb_array_list"``, ``"human"`` or None, see ``WorldEnv.render``.
        render_backend: Who draws: ``"matplotlib"`` or ``"raster"``.
        strict: False ignores keys that nobody reads, with an ``IgnoredKeyWarning``; else they are errors.
        disable_env_checker: True leaves out Gymnasium's checks of the first steps.
        **parameters: Values for the scenario's parameters.
    """
    given = _given(
        task=task,
        max_steps=max_steps,
        max_episode_steps=max_episode_steps,
        render_mode=render_mode,
        render_backend=render_backend,
        strict=strict,
        disable_env_checker=disable_env_checker,
    )
    one, kwargs = _resolve(scenario, {**given, **parameters})
    return gymnasium.make(one, **kwargs)


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
    render_backend: str = "matplotlib",
    strict: bool = True,
    vectorization_mode: gymnasium.VectorizeMode | str | None = None,
    vector_kwargs: dict[str, Any] | None = None,
    wrappers: Sequence[Callable[[gymnasium.Env[Any, Any]], gymnasium.Env[Any, Any]]] | None = None,
    **parameters: Any,
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
        render_backend: Who draws: ``"matplotlib"`` or ``"raster"``.
        strict: False ignores keys that nobody reads, with an ``IgnoredKeyWarning``; else they are errors.
        vectorization_mode: ``"sync"`` or ``"async"`` makes single environments, see ``gymnasium.make_vec``.
        vector_kwargs: With these modes, arguments of Gymnasium's vector environment.
        wrappers: With these modes, wrappers around each single environment.
        **parameters: Values for the scenario's parameters.
    """
    given = _given(
        task=task,
        max_steps=max_steps,
        max_episode_steps=max_episode_steps,
        autoreset_mode=autoreset_mode,
        num_threads=num_threads,
        render_mode=render_mode,
        render_backend=render_backend,
        strict=strict,
        vectorization_mode=vectorization_mode,
        vector_kwargs=vector_kwargs,
        wrappers=wrappers,
    )
    one, kwargs = _resolve(scenario, {**given, **parameters})
    return gymnasium.make_vec(one, num_envs=num_envs, **kwargs)


def _given(**chosen: Any) -> dict[str, Any]:
    """Return the arguments that differ from their defaults: what is registered with an id holds for the others."""
    return {name: value for name, value in chosen.items() if not _is_default(name, value)}


def _is_default(name: str, value: Any) -> bool:
    return type(value) is type(DEFAULTS.get(name)) and value == DEFAULTS.get(name)


def scenario_behind(name: Any) -> Any:
    """Return the scenario that an id stands for; anything that is no id comes back as it is."""
    if isinstance(name, str):
        spec = gymnasium.registry.get(name.removeprefix(f"{NAMESPACE}:"))
        if spec is not None and "scenario" in spec.kwargs:
            return spec.kwargs["scenario"]
        _refuse_unknown_id(name)
    return name


def _refuse_unknown_id(name: str) -> None:
    """Raise an UnknownNameError for what is written as an id of ours, but is none."""
    if re.fullmatch(rf"({NAMESPACE}:)?{NAMESPACE}/[^/.]+", name) and not Path(name).exists():
        known = [one for one in gymnasium.registry if one.startswith(f"{NAMESPACE}/")]
        near = suggestion(name.removeprefix(f"{NAMESPACE}:"), known)
        raise UnknownNameError(f"no environment '{name}'{near or '; `irsim-gym list` shows what is shipped'}")


def _resolve(scenario: ScenarioSource, kwargs: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    """Return the id to make and its arguments."""
    if isinstance(scenario, str):
        for one in (scenario.removeprefix(f"{NAMESPACE}:"), env_id(scenario)):
            if one in gymnasium.registry and (one != env_id(scenario) or scenario in scenario_names()):
                return one, kwargs
        _refuse_unknown_id(scenario)
    return ANY, {**kwargs, "scenario": str(scenario) if isinstance(scenario, Path) else scenario}
