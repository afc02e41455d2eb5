"""Time limits: what the spec of an id says, and what a ``TimeLimit`` around an environment asks for."""

import sys
import warnings
from collections.abc import Mapping
from copy import copy
from dataclasses import fields
from typing import Any

import gymnasium
from gymnasium import wrappers
from gymnasium.envs import registration
from gymnasium.envs.registration import EnvSpec
from gymnasium.wrappers import TimeLimit

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.envs.parts.by_hand import Environment

OF_BATCHES = {"num_envs", "num_threads", "autoreset_mode", "vectorization_mode"}
STEP_FOR_STEP = {
    kind.step
    for kind in (
        *(gymnasium.Wrapper, gymnasium.ObservationWrapper, gymnasium.ActionWrapper, gymnasium.RewardWrapper),
        *(wrappers.OrderEnforcing, wrappers.PassiveEnvChecker, wrappers.RecordEpisodeStatistics, TimeLimit),
        *(wrappers.DelayObservation, wrappers.FrameStackObservation, wrappers.TimeAwareObservation),
        *(wrappers.NormalizeReward, wrappers.RecordVideo, wrappers.RenderCollection, wrappers.StickyAction),
        Environment,
    )
}
"""What ``step`` is in wrappers of which one step is surely one step of what they wrap."""


class ScenarioSpec(EnvSpec):
    """A spec whose ``max_episode_steps`` is the time limit of the environments that are made from it.

    The limit is read from the scenario and its task on access, and is None where these cannot be read. Gymnasium's own
    ``make`` sees only a limit that was set explicitly: the environment enforces its task's limit itself and reports it
    in ``outcome``, so a ``TimeLimit`` around it would be a second limit.
    """

    @property
    def max_episode_steps(self) -> int | None:
        """Steps after which an episode is truncated."""
        reader = sys._getframe(1)
        if reader.f_globals.get("__name__") == registration.__name__ and reader.f_code.co_name in ("make", "make_vec"):
            return self._set
        outer = self.kwargs.get("max_episode_steps", self._set)
        limit, max_steps = self.kept or (None, self.kwargs.get("max_steps"))
        if outer is not None and outer != -1:
            return agreed_limit(max_steps, outer)
        limit = limit or max_steps
        return task_limit(self.kwargs) if limit is None else limit

    @max_episode_steps.setter
    def max_episode_steps(self, value: int | None) -> None:
        self._set = value

    def keep(self, limit: int, max_steps: int | None) -> None:
        """Take limit and ``max_steps`` of the environment that was made from it, until ``kwargs`` is another dict."""
        self._kept = self.kwargs, (limit, max_steps)

    @property
    def kept(self) -> tuple[int, int | None] | None:
        """Limit and ``max_steps`` of the environment that was made from it; None where that is not known."""
        kwargs, limits = self.__dict__.get("_kept", (None, None))
        return limits if kwargs is self.kwargs else None

    def to_json(self) -> str:
        """Return it as JSON; TypeError where it holds a loaded scenario, an object."""
        from irsim_gym.envs.parts.specs import refuse_loaded

        refuse_loaded(self)
        return super().to_json()

    def __eq__(self, other: object) -> bool:
        names = [field.name for field in fields(EnvSpec)]
        return isinstance(other, EnvSpec) and all(getattr(self, name) == getattr(other, name) for name in names)

    __hash__ = None  # type: ignore[assignment]


def scenario_spec(spec: EnvSpec) -> ScenarioSpec:
    """Return the same spec as one that knows its time limit."""
    if isinstance(spec, ScenarioSpec):
        return spec
    return ScenarioSpec(**{field.name: getattr(spec, field.name) for field in fields(spec) if field.init})


def batch_spec(spec: EnvSpec) -> ScenarioSpec:
    """Return the spec of a batch as ``make_vec`` sets it, with ``max_episode_steps`` where a single one has it."""
    batch = scenario_spec(spec)
    batch.max_episode_steps = batch.kwargs.pop("max_episode_steps", None)
    return batch


def single_spec(spec: ScenarioSpec) -> ScenarioSpec:
    """Return the spec of a single environment like those of a batch."""
    single = copy(spec)
    single.kwargs = {name: value for name, value in spec.kwargs.items() if name not in OF_BATCHES}
    return single


def task_limit(kwargs: Mapping[str, Any]) -> int | None:
    """Return the time limit of a task [steps]; None where scenario or task cannot be read.

    Args:
        kwargs: Those of an environment: ``scenario``, ``task``, ``strict`` and values for parameters count.
    """
    scenario = kwargs.get("scenario")
    from irsim_gym.scenario import Scenario, load_scenario
    from irsim_gym.scenario.reading.parameters import is_free
    from irsim_gym.tasks import load_task

    if scenario is None:
        return None
    parameters = {name: value for name, value in kwargs.items() if is_free(name)}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # making the environment warns of ignored keys
            if not isinstance(scenario, Scenario):
                scenario = load_scenario(scenario, parameters, strict=bool(kwargs.get("strict", True)))
            return load_task(scenario, kwargs.get("task")).max_steps
    except (IrsimGymError, OSError, TypeError, ValueError):
        return None


def agreed_limit(max_steps: int | None, outer: int | None) -> int | None:
    """Return the time limit [steps] where ``max_steps`` and ``max_episode_steps`` may be given; None for the task's.

    Args:
        max_steps: What replaces the task's limit.
        outer: What replaces it from outside, as ``max_episode_steps`` or by a ``TimeLimit``; None or -1 for nothing.

    Returns:
        The one that is given, the smaller one of two.
    """
    if outer is None or outer == -1:
        return max_steps
    if isinstance(outer, bool) or not isinstance(outer, int) or outer < 1:
        raise ValueError(f"max_episode_steps must be a whole number >= 1, or -1 for the task's own, got {outer!r}")
    return outer if max_steps is None else min(max_steps, outer)


def outer_limit(env: gymnasium.Env[Any, Any]) -> int | None:
    """Return the least limit of the ``TimeLimit`` wrappers through which ``env.reset`` is called now; None without one.

    ``gymnasium.make(id, max_episode_steps=...)`` adds such a wrapper without informing the environment, so the wrapper
    is searched for among the callers. A wrapper with another one in between that may take several steps at a time
    (not in ``STEP_FOR_STEP``) counts different steps and is ignored.
    """
    # No plainer way leads there: Gymnasium gives the limit to the wrapper alone, refuses additional wrappers for
    # native batches, and without the limit a cut episode would be RUNNING, with its costs spread over another length.
    least: int | None = None
    frame = sys._getframe(1)
    while frame is not None:
        if frame.f_code is TimeLimit.reset.__code__:
            wrapper = frame.f_locals["self"]
            if _is_step_for_step(wrapper, env):
                limit = wrapper._max_episode_steps
                least = limit if least is None else min(least, limit)
        frame = frame.f_back  # type: ignore[assignment]
    return least


def _is_step_for_step(wrapper: gymnasium.Env[Any, Any], env: gymnasium.Env[Any, Any]) -> bool:
    while isinstance(wrapper, gymnasium.Wrapper) and type(wrapper).step in STEP_FOR_STEP:
        wrapper = wrapper.env
    return wrapper is env
