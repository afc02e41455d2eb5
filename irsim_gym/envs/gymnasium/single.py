"""One world as a ``gymnasium.Env``."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.error import ResetNeeded

from irsim_gym.base.arraytypes import Bytes, Flags
from irsim_gym.envs.described.moment import BodyMoment
from irsim_gym.envs.gymnasium.explained import OneWorld
from irsim_gym.envs.gymnasium.worlds import ScenarioSource, TaskSource, Worlds
from irsim_gym.envs.parts.infos import Infos
from irsim_gym.envs.parts.limits import ScenarioSpec, agreed_limit, outer_limit, scenario_spec
from irsim_gym.envs.parts.pictures import RENDER_MODES, render_warning
from irsim_gym.envs.parts.spaces import Observation
from irsim_gym.envs.parts.specs import plain_spec
from irsim_gym.simulator.engine.given import LEVELS
from irsim_gym.tasks.definition.task import checked_limit
from irsim_gym.tasks.episodes.levels import CHAIN


class WorldEnv(OneWorld, gymnasium.Env[Observation, Any]):
    """A scenario in which one robot learns.

    ``reset(seed=s)`` begins level ``s`` of the split ``train``; ``reset()`` continues with the next level of the chain
    that follows from the last seed. ``options={"split": "test", "level": 17}`` begins exactly that level, and
    later resets without seed stay in that split. A scenario in which nothing is random has but one level, so each
    reset begins the same episode.

    Infos hold the same keys at each call, Python numbers: ``outcome`` (``tasks.Outcome``), ``hit`` (the body
    touched, -1 for none), ``hit_kind`` (what that is, ``tasks.terms.outcome.HitKind``), ``path_length`` [m],
    ``min_clearance`` [m], ``goal_distance`` [m], ``is_success``, ``steps``, ``stalled`` [s] (how long it has hardly
    moved away from its goal), ``deadlocked``, ``level``, and each term of the reward as ``reward/`` and its name, such
    as ``reward/progress``.

    Args:
        scenario: Name of a shipped scenario, id, path of a YAML file, plain data or a loaded scenario.
        task: Name of a shipped task, path, or plain data; None for the scenario's own.
        max_steps: Time limit [steps]; None for the task's.
        render_mode: ``"rgb_array"``, ``"rgb_array_list"``, ``"human"`` or None, see ``render``.
        strict: False ignores unused keys with an ``IgnoredKeyWarning``; True raises an error.
        numpy_infos: Infos hold NumPy scalars, and flags as arrays without axes, in place of Python numbers: what the
            info readers of TorchRL need. Such a step takes half as long again.
        **parameters: Values for the scenario's parameters.
    """

    metadata = {"render_modes": list(RENDER_MODES), "render_fps": 10}  # noqa: RUF012
    _spec: ScenarioSpec | None = None

    def __init__(
        self,
        scenario: ScenarioSource | None = None,
        task: TaskSource = None,
        max_steps: int | None = None,
        render_mode: str | None = None,
        strict: bool = True,
        numpy_infos: bool = False,
        **parameters: object,
    ) -> None:
        self.worlds = Worlds(
            scenario, task=task, max_steps=max_steps, render_mode=render_mode, parameters=parameters, strict=strict
        )
        if numpy_infos:
            self.worlds.infos = Infos(self.worlds.episodes, in_numpy=True)
        self.render_mode = render_mode
        self.metadata = {"render_modes": list(RENDER_MODES), "render_fps": self.worlds.render_fps}
        self.observation_space = self.worlds.observation_space
        self.action_space = self.worlds.action_space
        self._shape = self.action_space.shape
        self._going = False
        self._max_steps = max_steps
        self._task_limit = self.worlds.task.max_steps
        self._outer_limit: int | None = None

    @property
    def max_steps(self) -> int:
        """Time limit [steps]. It may be set, also in an episode; a smaller one of a ``TimeLimit`` counts first."""
        return self.worlds.task.max_steps

    @max_steps.setter
    def max_steps(self, value: int) -> None:
        self._max_steps = checked_limit(value)
        self._agree()

    @property
    def spec(self) -> ScenarioSpec | None:
        """What ``gymnasium.make`` made it from, with ``max_steps`` as ``max_episode_steps``; None without ``make``."""
        if self._spec is not None:
            self._spec.keep(self.max_steps, self._max_steps)
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        self._spec = None if spec is None else scenario_spec(plain_spec(spec))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; see the class for what seeds and options choose."""
        super().reset(seed=seed)
        outer = outer_limit(self)
        if outer != self._outer_limit or (outer is not None and outer < self.max_steps):
            self._outer_limit = outer
            self._agree()
        worlds = self.worlds
        worlds.begin([0], [seed], [options or {}], lambda _: int(self.np_random.integers(LEVELS)))
        self._going = True
        return worlds.observation_alone(), worlds.infos.of(0)

    def step(self, action: object) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Advance the world by one step.

        Raises:
            ResetNeeded: The episode has ended, or none has begun.
            ValueError: The action has a wrong shape or is not finite.
        """
        if not self._going:
            raise ResetNeeded("the episode has ended or has not begun: call reset() before step()")
        rows = np.asarray(action)
        if rows.shape != self._shape:
            raise ValueError(f"an action must have shape {self._shape}, got {rows.shape}")
        worlds = self.worlds
        worlds.step_alone(rows)
        reward, terminated, truncated, info = worlds.infos.alone()
        self._going = not (terminated or truncated)
        return worlds.observation_alone(), reward, terminated, truncated, info

    def choose_level(self, level: int | None) -> None:
        """Choose the level that the next ``reset()`` without seed and options begins; None for that of the chain.

        It is a level of the split that is played, by its number in the infos. See ``WorldVectorEnv.choose_levels``.
        """
        self.worlds.choose_levels([CHAIN if level is None else level])

    def action_masks(self) -> Flags:
        """Return which choices are worth trying, bool ``(n_choices,)``; for ``action: discrete``."""
        return np.asarray(self.worlds.action_masks()[0, 0])

    def render(self) -> Bytes | list[Bytes] | None:  # type: ignore[override]
        """Return what the render mode asks for.

        Returns:
            ``"rgb_array"``: a fresh picture of the present moment, uint8, ``(height, width, 3)``.
            ``"rgb_array_list"``: the pictures since the last call or reset: one of the beginning, one each
            ``sample_time``, one of the end. ``"human"``: None; ``reset`` and ``step`` show these same moments in a
            window, not faster than in real time. Without a mode None, with a warning. Gymnasium's ``RecordVideo``
            asks after each step: give it ``"rgb_array"``.
        """
        render_warning(self.render_mode)
        return self.worlds.pictures.of(0)

    @property
    def robot(self) -> BodyMoment:
        """The robot that learns, as it is now, to be read: ``pose``, ``velocity``, ``goal``, ``scan()`` and so on."""
        return self.worlds.moment().robot

    def _agree(self) -> None:
        """Keep to the limit that its own and a ``TimeLimit`` around it agree to."""
        self.worlds.limit(agreed_limit(self._max_steps, self._outer_limit) or self._task_limit)
