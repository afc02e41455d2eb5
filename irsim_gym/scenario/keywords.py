"""Hints about keywords that an environment does not take."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from irsim_gym.errors import nearest

EVERYWHERE = ("task", "max_steps", "render_mode", "strict")
"""Keywords of all functions that make an environment."""

_ITSELF = "pass its contents as keywords of this function"
_LIMIT = "the time limit is 'max_steps'"
_THREADS = "use 'num_threads' of make_vec, make_batch and the functions of sb3 to step worlds on several threads"
_COUNT = (
    "the number of worlds is 'num_envs' of make_vec, make_batch and sb3.make_multi_agent_vec_env, 'n_envs' of "
    "sb3.make_vec_env"
)
_AROUND = "wrap the returned environment instead"

ELSEWHERE = {
    **dict.fromkeys(("env_kwargs", "kwargs", "vector_kwargs", "env_config", "config", "options"), _ITSELF),
    **dict.fromkeys(("parameters", "scenario_kwargs", "task_kwargs"), "pass parameters and the task as keywords"),
    **dict.fromkeys(("max_cycles", "max_episode_steps", "max_episode_length", "episode_length", "horizon"), _LIMIT),
    **dict.fromkeys(("max_timesteps", "time_limit", "timeout", "outer_limit", "episode_steps"), _LIMIT),
    **dict.fromkeys(("vec_env_cls", "vec_env_kwargs", "vectorization_mode", "asynchronous", "shared_memory"), _THREADS),
    **dict.fromkeys(("num_workers", "n_workers", "n_jobs", "num_cpus", "threads", "n_threads"), _THREADS),
    **dict.fromkeys(("wrapper_class", "wrapper_kwargs", "wrappers", "env_wrapper", "additional_wrappers"), _AROUND),
    **dict.fromkeys(("num_envs", "n_envs", "n_worlds", "num_env", "n_env", "num_worlds", "n_world"), _COUNT),
    **dict.fromkeys(("name", "id", "env_id", "env", "env_name", "scenario"), "the scenario is the first argument"),
    **dict.fromkeys(
        ("frame_skip", "frameskip", "skip", "dt"), "'world.step_time' in the file sets the duration of a step"
    ),
    **dict.fromkeys(("obs_type", "observation_type"), "the task's 'observations' set the observation"),
    **dict.fromkeys(("continuous", "continuous_actions"), "the task's 'action' sets the action"),
    "render_backend": "there is one renderer, formerly 'raster': leave it out; matplotlib writes figures",
    **dict.fromkeys(("apply_api_compatibility", "new_step_api"), "it belongs to old releases of gym"),
}
"""Advice for keywords of other libraries, and of other functions of this one."""

RETIRED = {"render_backend": "raster"}
"""Removed keywords, with the values that are still accepted because they match the present behaviour."""


def meant(name: str, declared: Iterable[str], taken_by: Mapping[str, str]) -> str:
    """Return a hint in parentheses about an unknown keyword; empty if there is none.

    Args:
        declared: Parameters of the scenario.
        taken_by: Keywords that only some functions take, and the names of these functions.
    """
    hints = [f"an argument of {taken_by[name]}"] if name in taken_by else []
    near = nearest(name, [*declared, *EVERYWHERE, *taken_by])
    if name in ELSEWHERE:
        hints.append(ELSEWHERE[name])
    elif near is not None and not hints:
        owner = f", an argument of {taken_by[near]}" if near in taken_by else ""
        hints.append(f"did you mean '{near}'{owner}?")
    return f" ({'; '.join(hints)})" if hints else ""
