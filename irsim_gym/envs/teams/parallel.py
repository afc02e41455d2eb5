"""One world in which several robots learn, as a ``pettingzoo.ParallelEnv``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import Space
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Box
from gymnasium.utils.seeding import np_random
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from irsim_gym.base.arraytypes import Bytes, Rays
from irsim_gym.base.errors import UnknownNameError, suggestion
from irsim_gym.envs.described.description import Description
from irsim_gym.envs.gymnasium.explained import OneWorld
from irsim_gym.envs.gymnasium.worlds import ScenarioSource, TaskSource, Worlds
from irsim_gym.envs.parts import spaces
from irsim_gym.envs.parts.observations import on_each
from irsim_gym.envs.parts.pictures import RENDER_MODES, render_warning
from irsim_gym.envs.parts.spaces import Observation, ObservationLayout
from irsim_gym.simulator.engine.given import LEVELS
from irsim_gym.tasks.episodes.levels import CHAIN

Step = tuple[
    dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]
]  # fmt: skip


def parallel_env(
    scenario: ScenarioSource | None = None,
    *,
    task: TaskSource = None,
    max_steps: int | None = None,
    max_cycles: int | None = None,
    padded: bool = False,
    black_death: bool = False,
    render_mode: str | None = None,
    strict: bool = True,
    **parameters: object,
) -> WorldParallelEnv:
    """Make the parallel environment of a scenario.

    Args:
        scenario: Name of a shipped scenario, id, path of a YAML file, plain data or a loaded scenario.
        task: Name of a shipped task, path, or plain data; None for the scenario's own.
        max_steps: Time limit [steps]; None for the task's.
        max_cycles: The same under PettingZoo's name.
        padded: True gives all agents the same spaces, those of the richest one; see ``WorldParallelEnv``.
        black_death: True keeps agents that have ended until all have; see ``WorldParallelEnv``.
        render_mode: ``"rgb_array"``, ``"rgb_array_list"``, ``"human"`` or None, see ``WorldEnv.render``.
        strict: False ignores unused keys with an ``IgnoredKeyWarning``; True raises an error.
        **parameters: Values of the scenario's own parameters.

    Raises:
        ValueError: ``max_steps`` and ``max_cycles`` differ.
    """
    if max_steps is not None and max_cycles not in (None, max_steps):
        raise ValueError(f"max_steps and max_cycles are the same limit, got {max_steps} and {max_cycles}")
    worlds = Worlds(
        scenario,
        task=task,
        max_steps=max_cycles if max_steps is None else max_steps,
        render_mode=render_mode,
        team=True,
        parameters=parameters,
        strict=strict,
    )
    return WorldParallelEnv(worlds, padded=padded, black_death=black_death)


class WorldParallelEnv(OneWorld, ParallelEnv[str, Observation, Any]):  # type: ignore[misc]
    """A scenario in which several robots learn, all of them unless the task names some.

    Agents have the names of the robots: ``robot_0`` and so on, or those that the file gives. Of names that are no word
    with a number PettingZoo's ``api_test`` warns; nothing depends on that.

    ``reset(seed=s)`` begins level ``s`` of the split ``train``; ``reset()`` continues with the next level of the chain
    that follows from the last seed. ``options={"split": "test", "level": 17}`` begins exactly that level, and later
    resets without seed stay in that split.

    A step takes an action from each agent in ``agents`` and answers these. An agent whose own episode ends is in that
    answer for the last time: it is terminated by what became of it, or truncated by the time limit, never both, and is
    gone from ``agents``. What its body does then is the task's choice (``ended``). Actions for agents that have ended
    are ignored, whatever they are, as PettingZoo's conversions ignore them. When ``agents`` is empty, a step returns
    five empty dicts.

    With ``black_death`` nobody leaves before all have ended, for libraries that take the team to be whole (TorchRL
    without masks, skrl, SuperSuit). An agent that has ended stays in ``agents`` with observations of zeros, rewards of
    0 and ``idle`` in its infos; the others of its infos stay as they were, so ``outcome`` says in the step of its end
    what became of it. Like in SuperSuit's ``black_death_v3`` it is terminated only in the step in which the last agent
    ends, when all are, each by its own end, and ``agents`` is empty: PettingZoo allows no agent that is terminated and
    stays, and libraries that restart as soon as one agent is done would cut the others short. To a learner the zeros
    are a state in which nothing is ever paid, so their value is 0, as it is after a termination.

    Infos hold the same keys at each call, all Python numbers, as those of ``WorldEnv``; with ``black_death`` also
    ``idle``, which is True where the agent had ended before the step. Two of them are codes, which
    ``Outcome(info["outcome"]).name`` and ``HitKind(info["hit_kind"]).name`` of ``irsim_gym.tasks`` turn into words:
    ``outcome`` is 0 while the episode is under way, 1 success, 2 collision, 3 time limit, 4 left the world, 5 deadlock,
    6 misplaced; ``hit_kind`` says what the robot touches: 0 nothing, 1 a standing obstacle still, 2 one that moves,
    3 a robot, 4 the map.

    Where actions are choices (``action: discrete``), infos also hold ``action_mask``, int8 ``(n_choices,)``, as
    ``Discrete.sample`` takes it: 0 for a choice that commands what another one with a smaller number does.

    Attributes:
        possible_agents: Names of all agents, in the order of the scenario, or of the task's ``agents``.
        agents: Names of those whose episodes are under way, or with ``black_death`` of all until the last one ends, in
            the same order; a new list at each reset and step.
        observation_spaces: Space of each agent. Agents with different drives have different ones; where ``padded``,
            each has the columns of the richest agent, and those that mean nothing to an agent are 0.
        action_spaces: Space of each agent; where ``padded``, each has the components of the largest drive, and an
            agent's surplus ones are ignored.
        state_space: Space of ``state()``.
        black_death: Agents that have ended stay until all have.
        worlds: The world, a batch of one.
    """

    metadata = {  # noqa: RUF012
        "name": "irsim_gym_v0",
        "render_modes": list(RENDER_MODES),
        "render_fps": 10,
        "is_parallelizable": True,
    }

    def __init__(self, worlds: Worlds, *, padded: bool = False, black_death: bool = False) -> None:
        """Play in a batch of one world that was made with ``team=True``."""
        self.worlds = worlds
        self.black_death = black_death
        self.render_mode = worlds.render_mode
        self.metadata = {
            "name": f"{worlds.scenario.name}_v0",
            "render_modes": list(RENDER_MODES),
            "render_fps": worlds.render_fps,
            "is_parallelizable": True,
        }
        self.possible_agents: list[str] = list(worlds.agent_names)
        self.agents: list[str] = []
        self._indices = {name: a for a, name in enumerate(self.possible_agents)}
        self._layouts: dict[str, ObservationLayout] = {}
        self.observation_spaces: dict[str, Space[Any]] = {}
        self.action_spaces: dict[str, Space[Any]] = {}
        for name, a in self._indices.items():
            agent = None if padded else a
            self._layouts[name] = spaces.observation_layout(worlds.episodes, agent)
            self.observation_spaces[name] = spaces.observation_space(worlds.episodes, agent)
            self.action_spaces[name] = spaces.action_space(worlds.episodes, agent)
        self.state_space = Box(-1.0, 1.0, (worlds.episodes.team_state_size,), np.float32)
        self._padded = padded
        self._np_random: np.random.Generator | None = None
        self._np_random_seed: int | None = None
        self._begun = False

    def __repr__(self) -> str:
        scenario = self.worlds.scenario
        return f"<{type(self).__name__} {scenario.label}: {len(self.possible_agents)} agents>"

    @property
    def max_cycles(self) -> int:
        """Time limit [steps]. It may be set: the environment then is as if it had been made with it."""
        return self.worlds.task.max_steps

    @max_cycles.setter
    def max_cycles(self, value: int) -> None:
        self.worlds.limit(value)

    @property
    def np_random(self) -> np.random.Generator:
        """The generator that levels come from where no seed is given, as in ``gymnasium.Env``; it may be set."""
        if self._np_random is None:
            self._np_random, self._np_random_seed = np_random()
        return self._np_random

    @np_random.setter
    def np_random(self, generator: np.random.Generator) -> None:
        self._np_random, self._np_random_seed = generator, -1

    @property
    def np_random_seed(self) -> int:
        """The seed of ``np_random``; -1 if the generator was replaced."""
        if self._np_random_seed is None:
            self._np_random, self._np_random_seed = np_random()
        return self._np_random_seed

    def observation_space(self, agent: str) -> Space[Any]:
        """Return the space of an agent's observations, the same object each time."""
        return self._of(self.observation_spaces, agent)

    def action_space(self, agent: str) -> Space[Any]:
        """Return the space of an agent's actions, the same object each time."""
        return self._of(self.action_spaces, agent)

    def reset(
        self, seed: int | None = None, options: Mapping[str, object] | None = None
    ) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        """Begin an episode for all agents; see the class for what seeds and options choose.

        Args:
            seed: Level of the split; None for the next level.
            options: ``split`` and ``level``, both may be absent. A key ``options`` is passed over, because PettingZoo's
                tests give it to every environment; other keys are errors.
        """
        if seed is not None:
            self._np_random, self._np_random_seed = np_random(seed)
        chosen = {key: value for key, value in (options or {}).items() if key != "options"}
        self.worlds.begin([0], [seed], [chosen], lambda _: int(self.np_random.integers(LEVELS)))
        self._begun = True
        self.agents = list(self.possible_agents)
        return self._observations(self.agents), self._infos(self.agents)

    def step(self, actions: Mapping[str, object]) -> Step:
        """Advance the world by one step.

        Args:
            actions: An action for each agent whose episode is under way. Those of agents that have ended are ignored.

        Returns:
            Observations, rewards, terminations, truncations and infos of all in ``agents``.

        Raises:
            ResetNeeded: No episode has begun.
            UnknownNameError: An action for a name that is no agent.
            ValueError: An agent's action is missing, has the wrong shape or type, is not finite or is no choice.
                Nothing has moved then.
        """
        if not self._begun:
            raise ResetNeeded("no episode has begun: call reset() before step()")
        rows = self._taken(actions)
        if not self.agents:
            return {}, {}, {}, {}, {}
        self.worlds.step(rows)
        view = self.worlds.episodes.view
        before = self.agents
        rewards = dict(self._each(before, view.reward))
        terminations = dict(self._each(before, view.terminated))
        truncations = dict(self._each(before, view.truncated))
        if self.black_death and view.live.any():
            terminations, truncations = dict.fromkeys(before, False), dict.fromkeys(before, False)
        self.agents = [name for name in before if not (terminations[name] or truncations[name])]
        return self._observations(before), rewards, terminations, truncations, self._infos(before)

    def choose_level(self, level: int | None) -> None:
        """Choose the level that the next ``reset()`` without seed and options begins, see ``WorldEnv.choose_level``."""
        self.worlds.choose_levels([CHAIN if level is None else level])

    def state(self) -> Rays:
        """Return a fresh view of the whole team, float32 in [-1, 1], of the same shape also when agents have gone."""
        state: Rays = self.worlds.episodes.team_state()[0]
        return state

    def render(self) -> Bytes | list[Bytes] | None:
        """Return what the render mode asks for, as ``WorldEnv.render`` does.

        Raises:
            ResetNeeded: No episode has begun.
        """
        render_warning(self.render_mode)
        if self.render_mode is not None and not self._begun:
            raise ResetNeeded("no episode has begun: call reset() before render()")
        return self.worlds.pictures.of(0)

    def describe(self, agent: str | None = None) -> Description:
        """Return what observations, actions, rewards, endings and infos mean to an agent; it prints as tables.

        Args:
            agent: Its name; the first by default. The description names those that observe and act alike.

        Raises:
            UnknownNameError: There is no such agent.
        """
        first = self.possible_agents[0]
        return self.worlds.describe(agent or 0, of_agent=not self._padded, more=self._infos([first])[first])

    def _of(self, every: Mapping[str, Space[Any]], agent: str) -> Space[Any]:
        if agent not in every:
            raise UnknownNameError(f"no agent named {agent!r}{suggestion(str(agent), self.possible_agents)}")
        return every[agent]

    def _taken(self, actions: Mapping[str, object]) -> NDArray[Any]:
        """Return the actions as the batch of one takes them; those of agents that have ended are 0."""
        if not isinstance(actions, Mapping):
            raise TypeError(f"actions must be a dict with one action per agent name, got {type(actions).__name__}")
        for name in actions:
            self._of(self.action_spaces, name)
        acting = self._acting()
        missing = [name for name in acting if name not in actions]
        if missing:
            raise ValueError(f"no action for {', '.join(missing)}: each agent in env.agents needs one")
        n_choices, sizes = self.worlds.episodes.n_discrete, self.worlds.episodes.action_sizes.tolist()
        rows = np.zeros((1, len(sizes), 1 if n_choices else max(sizes)), np.int64 if n_choices else np.float64)
        for name in acting:
            a = self._indices[name]
            row = self._checked(name, np.asarray(actions[name]), n_choices)
            rows[0, a, : sizes[a]] = row if n_choices else row[: sizes[a]]
        if not np.isfinite(rows).all():
            culprit = self.possible_agents[np.argwhere(~np.isfinite(rows))[0, 1]]
            raise ValueError(f"the action of '{culprit}' is not finite: {actions[culprit]}")
        return rows[..., 0] if n_choices else rows

    def _acting(self) -> list[str]:
        """Return the agents whose episodes are under way."""
        if not self.black_death:
            return self.agents
        return [name for name, live in self._each(self.agents, self.worlds.episodes.view.live) if live]

    def _checked(self, name: str, row: NDArray[Any], n_choices: int) -> NDArray[Any]:
        """Return an agent's action, or refuse it."""
        shape = self.action_spaces[name].shape
        if row.shape != shape:
            raise ValueError(f"the action of '{name}' must have shape {shape}, got {row.shape}")
        if row.dtype.kind not in ("iu" if n_choices else "fiu"):
            expected = "a whole number" if n_choices else "numbers"
            raise ValueError(f"the action of '{name}' must be {expected}, got an array of {row.dtype}")
        if n_choices and not 0 <= row < n_choices:
            raise ValueError(f"the action of '{name}' is not a choice from 0 to {n_choices - 1}: {row}")
        return row

    def _each(self, names: list[str], values: NDArray[Any]) -> zip[tuple[str, Any]]:
        """Return the agents' values ``(1, n_agents)`` as Python numbers."""
        row = values[0].tolist()
        return zip(names, [row[self._indices[name]] for name in names], strict=True)

    def _observations(self, names: list[str]) -> dict[str, Observation]:
        seen = self.worlds.episodes.view
        seen_by = {name: self._layouts[name].fresh(seen, (0, self._indices[name])) for name in names}
        if self.black_death:
            for name, over in self._each(names, seen.over):
                if over:
                    seen_by[name] = on_each(seen_by[name], np.zeros_like)
        return seen_by

    def _infos(self, names: list[str]) -> dict[str, dict[str, Any]]:
        rows = self.worlds.infos.rows(np.array([self._indices[name] for name in names], np.int64))
        infos = {name: self.worlds.infos.of_row(row) for name, row in zip(names, rows, strict=True)}
        if self.black_death:
            for name, over in self._each(names, self.worlds.episodes.view.over):
                infos[name]["idle"] = over
        if self.worlds.episodes.n_discrete:
            masks = self.worlds.action_masks()[0].astype(np.int8)
            for name, info in infos.items():
                info["action_mask"] = masks[self._indices[name]].copy()
        return infos
