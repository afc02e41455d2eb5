"""Many worlds as a ``gymnasium.vector.VectorEnv``, stepped together by the compiled core."""

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.error import ResetNeeded
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Flags, Floats
from irsim_gym.envs.gymnasium.explained import ManyWorlds
from irsim_gym.envs.gymnasium.world_view import WorldView, common_limit
from irsim_gym.envs.gymnasium.worlds import ScenarioSource, TaskSource, Worlds
from irsim_gym.envs.parts.limits import ScenarioSpec, agreed_limit, batch_spec, single_spec
from irsim_gym.envs.parts.pictures import RENDER_MODES
from irsim_gym.envs.parts.spaces import Observation
from irsim_gym.envs.parts.specs import plain_spec
from irsim_gym.simulator.engine.given import LEVELS
from irsim_gym.tasks.definition.task import checked_limit

Step = tuple[Observation, Floats, Flags, Flags, dict[str, Any]]


class WorldVectorEnv(ManyWorlds, VectorEnv[Observation, Any, NDArray[Any]]):  # type: ignore[misc]
    """Worlds of one scenario, each with one robot that learns.

    World ``w`` equals a ``WorldEnv`` that is reset with ``seed + w``, bit for bit, whatever the number of worlds and of
    threads; observations, rewards, flags and infos equal those of ``SyncVectorEnv``. Only ``reset(options=...)``
    says more: ``{"split": "test", "level": 17}`` begins level ``17 + w`` in world ``w``, a sequence one level for each.

    Args:
        scenario: Name of a shipped scenario, id, path of a YAML file, plain data or a loaded scenario.
        num_envs: Number of worlds.
        task: Name of a shipped task, path, or plain data; None for the scenario's own.
        max_steps: Time limit [steps]; None for the task's.
        max_episode_steps: Another time limit, from ``make_vec``, in place of the task's; of it and ``max_steps`` the
            smaller one counts. None or -1 for none.
        autoreset_mode: An ``AutoresetMode`` or its value: ``"NextStep"``, ``"SameStep"``, ``"Disabled"``.
        num_threads: Threads that share the worlds.
        render_mode: ``"rgb_array"``, ``"rgb_array_list"``, ``"human"`` or None, see ``render``.
        strict: False ignores unused keys with an ``IgnoredKeyWarning``; True raises an error.
        **parameters: Values for the scenario's parameters.
    """

    metadata = {  # noqa: RUF012
        "render_modes": list(RENDER_MODES),
        "render_fps": 10,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }
    closed = True  # until it is made: Gymnasium before 1.3 closes one whose arguments were refused
    _spec: ScenarioSpec | None = None

    def __init__(
        self,
        scenario: ScenarioSource | None = None,
        num_envs: int = 1,
        task: TaskSource = None,
        max_steps: int | None = None,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        num_threads: int = 1,
        render_mode: str | None = None,
        strict: bool = True,
        **parameters: object,
    ) -> None:
        self.autoreset_mode = checked_autoreset(autoreset_mode)
        worlds = Worlds(
            scenario,
            num_envs,
            task=task,
            max_steps=max_steps,
            outer_limit=max_episode_steps,
            num_threads=num_threads,
            render_mode=render_mode,
            parameters=parameters,
            strict=strict,
        )
        self.worlds = worlds
        self.num_envs = num_envs
        self.render_mode = render_mode
        self.metadata = {
            "render_modes": list(RENDER_MODES),
            "render_fps": worlds.render_fps,
            "autoreset_mode": self.autoreset_mode,
        }
        self.single_observation_space = worlds.observation_space
        self.single_action_space = worlds.action_space
        self.observation_space = batch_space(worlds.observation_space, num_envs)
        self.action_space = batch_space(worlds.action_space, num_envs)
        self._action_shape = (num_envs, *(worlds.action_space.shape or ()))
        self._max_steps, self._outer_limit = max_steps, max_episode_steps
        self._views: list[WorldView] = []
        self._ended: Flags = np.zeros(num_envs, np.bool_)
        self._all_begun = False
        self._seeds: list[int | None] = [None] * num_envs
        self._generators: list[np.random.Generator | None] = [None] * num_envs
        self.closed = False

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin episodes in all worlds, or in those of ``options["reset_mask"]``.

        Args:
            seed: World ``w`` begins level ``seed + w``; a sequence holds one seed, or None, for each world; None
                goes on with the next levels.
            options: ``reset_mask`` (bool array ``(num_envs,)``), ``split`` and ``level``.
        """
        choices = dict(options or {})
        mask = self._mask(choices.pop("reset_mask")) if "reset_mask" in choices else None
        seeds = self._seed_list(seed)
        levels = self._option_list(choices)
        chosen = list(range(self.num_envs)) if mask is None else np.flatnonzero(mask).tolist()
        self.worlds.begin(chosen, [seeds[w] for w in chosen], [levels[w] for w in chosen], self._draw)
        for w in chosen:
            if seeds[w] is not None:
                self._seeds[w], self._generators[w] = seeds[w], None
        self._ended[chosen] = False
        self._all_begun = bool(self.worlds.begun.all())
        return self.worlds.observation(), self.worlds.infos.batched(mask)

    def step(self, actions: object) -> Step:
        """Advance all worlds by one step; ended ones restart as ``autoreset_mode`` says.

        Raises:
            ResetNeeded: A world has not begun an episode.
            AssertionError: ``DISABLED``, and a world has ended but was not reset.
            TypeError: The actions are a single number or not numbers.
            ValueError: The actions have a wrong shape or are not finite.
        """
        if not self._all_begun:
            raise ResetNeeded("call reset() before step(): a world has not begun an episode")
        rows = self._action_rows(actions)
        if self.autoreset_mode is AutoresetMode.SAME_STEP:
            return self._step_same(rows)
        if self._ended.any():
            if self.autoreset_mode is AutoresetMode.DISABLED:
                worlds = np.flatnonzero(self._ended).tolist()
                raise AssertionError(f"worlds {worlds} have ended: reset them with options['reset_mask']")
            return self._step_next(rows)
        self.worlds.step(rows)
        return self._transition()

    def _step_next(self, rows: NDArray[Any]) -> Step:
        """Step the running worlds and restart those that ended in the previous step."""
        restarted = np.flatnonzero(self._ended)
        going = np.flatnonzero(~self._ended)
        if going.size:
            self.worlds.step(rows, going)
        self.worlds.begin_next(restarted)
        if self.render_mode == "human":
            self.worlds.pictures.refresh()
        return self._transition()

    def _step_same(self, rows: NDArray[Any]) -> Step:
        """Step all worlds and restart those that end."""
        worlds = self.worlds
        worlds.step(rows)
        rewards, terminations, truncations = self._results()
        ended = terminations | truncations
        infos: dict[str, Any] = {}
        restarted = ended.nonzero()[0]
        if len(restarted):
            final = np.full(self.num_envs, None, object)
            for w, observation in zip(restarted.tolist(), worlds.observations_of(restarted), strict=True):
                final[w] = observation
            infos = {"final_obs": final, "_final_obs": ended, "final_info": worlds.infos.batched(ended)}
            infos["_final_info"] = ended.copy()
            worlds.begin_next(restarted)
        infos.update(worlds.infos.batched())
        return worlds.observation(), rewards, terminations, truncations, infos

    def _results(self) -> tuple[Floats, Flags, Flags]:
        """Return fresh copies of rewards, terminations and truncations, shape ``(num_envs,)`` each."""
        view = self.worlds.episodes.view
        return view.reward[:, 0].copy(), view.terminated[:, 0].copy(), view.truncated[:, 0].copy()

    def _transition(self) -> Step:
        """Return fresh copies of what the last step gave, and note which worlds have ended."""
        rewards, terminations, truncations = self._results()
        np.logical_or(terminations, truncations, out=self._ended)
        return self.worlds.observation(), rewards, terminations, truncations, self.worlds.infos.batched()

    def action_masks(self) -> Flags:
        """Return which choices are worth trying, bool ``(num_envs, n_choices)``; for ``action: discrete``."""
        return np.asarray(self.worlds.action_masks()[:, 0])

    @property
    def max_steps(self) -> int:
        """Time limit of all worlds [steps]. It may be set, also in episodes; a smaller ``max_episode_steps`` counts."""
        return self.worlds.task.max_steps

    @max_steps.setter
    def max_steps(self, value: int) -> None:
        self._max_steps = checked_limit(value)
        self.worlds.limit(agreed_limit(value, self._outer_limit) or value)

    @property
    def spec(self) -> ScenarioSpec | None:
        """What ``gymnasium.make_vec`` made it from, with ``max_steps`` as ``max_episode_steps``; None without."""
        if self._spec is not None:
            self._spec.keep(self.max_steps, self._max_steps)
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        self._spec, self._views = None if spec is None else batch_spec(plain_spec(spec)), []

    def call(self, name: str, *args: object, **kwargs: object) -> tuple[Any, ...]:
        """Call the method ``name`` of each world with ``args`` and ``kwargs``, or read an attribute; see ``WorldView``.

        Raises:
            AttributeError: A world of a batch has none of that name.
        """
        if name in ("np_random", "np_random_seed"):
            answers: tuple[Any, ...] = getattr(self, name)
            return answers
        values = [view.get_wrapper_attr(name) for view in self._shown()]
        return tuple(value(*args, **kwargs) if callable(value) else value for value in values)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Return an attribute of each world, as ``SyncVectorEnv`` does; see ``WorldView``."""
        return self.call(name)

    def set_attr(self, name: str, values: object) -> None:
        """Set the attribute ``name`` of each world: a list or tuple of ``values`` has one for each.

        Raises:
            ValueError: There are more or fewer values than worlds, or time limits (``max_steps``) that differ.
            AttributeError: It cannot be set.
        """
        each = list(values) if isinstance(values, list | tuple) else [values] * self.num_envs
        if len(each) != self.num_envs:
            raise ValueError(f"a list of values needs one for each of the {self.num_envs} worlds, got {len(each)}")
        if name == "max_steps":
            self.max_steps = common_limit(each, self.num_envs)
            return
        for view, value in zip(self._shown(), each, strict=True):
            view.set_wrapper_attr(name, value)

    def _shown(self) -> list[WorldView]:
        """Return what there is to see of each world."""
        if not self._views:
            spec = None if self._spec is None else single_spec(self._spec)
            self._views = [WorldView(self.worlds, w, spec=spec) for w in range(self.num_envs)]
        return self._views

    @property
    def time(self) -> Floats:
        """Time since the start of each episode [s], a copy, shape ``(num_envs,)``."""
        return self.worlds.simulation.state.time.copy()

    def close_extras(self, **kwargs: object) -> None:
        """Close the window and free the renderer."""
        self.worlds.close()

    @property  # type: ignore[misc]
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override]
        """The generators of the worlds."""
        return tuple(self._generator(w) for w in range(self.num_envs))

    @property
    def np_random_seed(self) -> tuple[int, ...]:  # type: ignore[override]
        """The seeds of these generators."""
        return tuple(self._generator_seed(w) for w in range(self.num_envs))

    def _generator(self, w: int) -> np.random.Generator:
        generator = self._generators[w]
        if generator is None:
            generator, self._seeds[w] = seeding.np_random(self._seeds[w])
            self._generators[w] = generator
        return generator

    def _generator_seed(self, w: int) -> int:
        self._generator(w)
        seed = self._seeds[w]
        assert seed is not None
        return seed

    def _draw(self, w: int) -> int:
        return int(self._generator(w).integers(LEVELS))

    def _seed_list(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, int | np.integer):
            return [checked_seed(int(seed) + w) for w in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise ValueError(f"a list of seeds needs one for each of the {self.num_envs} worlds, got {len(seed)}")
        return [None if number is None else checked_seed(int(number)) for number in seed]

    def _option_list(self, options: Mapping[str, Any]) -> list[Mapping[str, Any]]:
        """Return the options of each world: a single level counts up over the worlds."""
        level = options.get("level")
        if level is None or isinstance(level, bool):
            return [options] * self.num_envs
        if isinstance(level, int | np.integer):
            return [{**options, "level": int(level) + w} for w in range(self.num_envs)]
        if len(level) != self.num_envs:
            raise ValueError(f"options['level'] needs a level for each of the {self.num_envs} worlds, got {len(level)}")
        return [{**options, "level": value} for value in level]

    def _mask(self, mask: object) -> Flags:
        if not isinstance(mask, np.ndarray):
            raise TypeError(f"options['reset_mask'] must be a numpy array, got {type(mask)}")
        if mask.dtype != np.bool_:
            raise TypeError(f"options['reset_mask'] must have dtype bool, got {mask.dtype}")
        if mask.shape != (self.num_envs,):
            raise ValueError(f"options['reset_mask'] must have shape ({self.num_envs},), got {mask.shape}")
        if not mask.any():
            raise ValueError("options['reset_mask'] must choose at least one world")
        return mask

    def _action_rows(self, actions: object) -> NDArray[Any]:
        """Return the actions with an axis for the one learner, ``(num_envs, 1, ...)``."""
        rows = np.asarray(actions)
        if rows.ndim == 0 or rows.dtype.kind not in "fiu":
            raise TypeError(f"actions must be an array of numbers of shape {self._action_shape}, got {actions!r}")
        if rows.shape != self._action_shape:
            raise ValueError(f"actions must have shape {self._action_shape}, got {rows.shape}")
        return rows[:, None]


def checked_seed(seed: int) -> int:
    """Return a seed, or raise as Gymnasium does for a negative one."""
    if seed < 0:
        raise gymnasium.error.Error(f"a seed must be an integer >= 0, got {seed}")
    return seed


def checked_autoreset(mode: AutoresetMode | str) -> AutoresetMode:
    """Return a mode of autoreset, or raise a ValueError that lists them."""
    try:
        return AutoresetMode(mode)
    except ValueError:
        names = ", ".join(f"'{mode.value}'" for mode in AutoresetMode)
        raise ValueError(f"autoreset_mode must be one of {names}, got {mode!r}") from None
