"""What all adapters share: worlds with one learner each, their levels, infos and pictures."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from irsim_gym.base import errors
from irsim_gym.base.arraytypes import Flags, Ints, Rays
from irsim_gym.base.errors import Problem, ScenarioWarning, several, suggestion, warn_caller
from irsim_gym.envs.described.description import Description, describe
from irsim_gym.envs.described.moment import WorldMoment
from irsim_gym.envs.parts.action_masks import ActionMasks
from irsim_gym.envs.parts.infos import Infos
from irsim_gym.envs.parts.level_options import checked_choice, read_options
from irsim_gym.envs.parts.limits import agreed_limit
from irsim_gym.envs.parts.mirror import Mirror, mirror_of
from irsim_gym.envs.parts.pictures import Pictures
from irsim_gym.envs.parts.spaces import Observation, action_space, observation_layout, observation_space
from irsim_gym.scenario import Scenario, load_scenario
from irsim_gym.scenario.reading.parameters import given_as_keywords
from irsim_gym.scenario.specs.ids import ANY, SOURCES
from irsim_gym.simulator.engine import compile
from irsim_gym.simulator.engine.given import LEVELS, check_worlds
from irsim_gym.tasks import Episodes, Task, load_task
from irsim_gym.tasks.definition.sight import all_of, idle_robots

TaskSource = str | Path | Mapping[str, Any] | None
ScenarioSource = str | Path | Mapping[str, Any] | Scenario
FIRST_AGENTS = slice(None), 0


class Worlds:
    """Independent worlds of one scenario with the same learners each.

    Args:
        scenario: Shipped name, id, path of a YAML file, plain data or a loaded scenario.
        task: Name of a shipped task, path, plain data; None for the scenario's own.
        max_steps: Time limit [steps]; None for the task's.
        outer_limit: Another time limit [steps], in place of the task's; of it and ``max_steps`` the smaller one counts.
            None or -1 for none.
        num_threads: Threads that share the worlds.
        render_mode: One of ``RENDER_MODES`` or None, see ``Pictures``; with it each step notes the poses of bodies
            whose paths are drawn.
        team: All robots learn, unless the task names some; else there has to be one learner.
        parameters: Values for the scenario's parameters; a loaded scenario has them already.
        strict: A key that nobody reads, in the scenario's file or its section ``task``, is an error; False: it is
            ignored, with an ``IgnoredKeyWarning``.
        worlds_are: What the caller calls the number of worlds, for messages.

    Raises:
        MemoryError: There is too little memory for so many worlds.
        UnknownKeywordError: The scenario has no such parameter; the message lists those that it has.
        MissingScenarioError: There is no scenario.
        ScenarioError: The scenario or its task cannot be used, or a parameter cannot have such a value.
    """

    def __init__(
        self,
        scenario: ScenarioSource | None,
        n_worlds: int = 1,
        *,
        task: TaskSource = None,
        max_steps: int | None = None,
        outer_limit: int | None = None,
        num_threads: int = 1,
        render_mode: str | None = None,
        team: bool = False,
        parameters: Mapping[str, object] | None = None,
        strict: bool = True,
        worlds_are: str = "num_envs",
    ) -> None:
        self.scenario = _loaded(scenario, parameters or {}, strict)
        self.task = load_task(self.scenario, task, agreed_limit(max_steps, outer_limit), team=team)
        check_worlds(n_worlds, worlds_are)
        self.simulation = compile(self.scenario, n_worlds, agents=self.task.agents, num_threads=num_threads)
        self.episodes = Episodes(self.simulation, self.task)
        self.infos = Infos(self.episodes)
        if self.episodes.n_agents != 1 and not team:
            raise errors.SeveralAgentsError(
                f"a single-agent environment needs one learner, but task '{self.task.name}' has "
                f"{self.episodes.n_agents}: name one robot in 'task.agents', or use parallel_env, make_batch or "
                "sb3.make_multi_agent_vec_env, on the command line --team"
            )
        if not team:
            _warn_of_idle_robots(self.scenario, self.task)
        self.n_worlds = n_worlds
        self.pictures = Pictures(self.scenario, self.episodes, render_mode)
        self.observation_space = observation_space(self.episodes)
        self.action_space = action_space(self.episodes)
        self.layout = observation_layout(self.episodes)
        self.begun: Flags = np.zeros(n_worlds, np.bool_)
        self.agent_names = self.episodes.agent_names
        self._splits = ["train"] * n_worlds
        self._row: Rays | None = None
        self._masks: ActionMasks | None = None
        self._mirror: Mirror | None = None

    def __repr__(self) -> str:
        return f"<Worlds {self.summary}>"

    @property
    def summary(self) -> str:
        """What these are, in a line: scenario, worlds, learners."""
        return f"{self.scenario.label}: {several(self.n_worlds, 'world')}, {several(self.episodes.n_agents, 'agent')}"

    @property
    def render_mode(self) -> str | None:
        """How worlds are shown, see ``Pictures``."""
        return self.pictures.mode

    @property
    def render_fps(self) -> float:
        """Frames per second at which a film runs in real time."""
        return self.pictures.fps

    def action_masks(self) -> Flags:
        """Return which choices agents have, fresh, ``(n_worlds, n_agents, n_choices)``, see ``ActionMasks``."""
        if self._masks is None:
            self._masks = ActionMasks(self.episodes)
        return self._masks.all()

    def limit(self, max_steps: int) -> None:
        """Set the time limit [steps], also for episodes under way."""
        self.episodes.limit(max_steps)
        self.task = self.episodes.task

    def begin(
        self,
        worlds: Sequence[int],
        seeds: Sequence[int | None],
        options: Sequence[Mapping[str, object]],
        draw: Callable[[int], int],
    ) -> None:
        """Begin an episode in each of the given worlds.

        A seed begins level ``seed`` of the split (``train`` unless the options say otherwise), the option ``level``
        exactly that level. Without either the world continues with the level that was chosen, or the next one of its
        chain, and a world that has none yet, or changes to another split, starts one. A choice is then forgotten.

        Args:
            worlds: Indices of the worlds.
            seeds: Seed of each world or None.
            options: ``{"split": name, "level": number}`` for each world, both may be absent.
            draw: Returns a level for a world that starts a chain without a seed.
        """
        following: list[int] = []
        first: dict[str, tuple[list[int], list[int]]] = {}
        choices = [read_options(option) for option in options]
        for w, seed, (split, level) in zip(worlds, seeds, choices, strict=True):
            same = self.begun[w] and split in (None, self._splits[w])
            if level is None and seed is None and same:
                following.append(w)
                continue
            if level is None:
                level = int(seed) % LEVELS if seed is not None else draw(w)
            self._splits[w] = split or "train"
            rows = first.setdefault(self._splits[w], ([], []))
            rows[0].append(w)
            rows[1].append(level)
        for name, (indices, levels) in first.items():
            self.episodes.begin(np.array(indices, np.int64), np.array(levels, np.int64), name)
        if following:
            self.episodes.begin_next(np.array(following, np.int64))
        self.begun[list(worlds)] = True
        self.pictures.note_beginning(np.array(worlds, np.int64))

    def choose_levels(self, levels: Sequence[int] | Ints, worlds: Sequence[int] | None = None) -> None:
        """Choose the levels that worlds begin next, each once and within the split that its world plays.

        Args:
            levels: Level of each world, as in the infos; -1 for the next one of its chain.
            worlds: Indices of the worlds; None for all.

        Raises:
            ResetNeeded: One of the worlds has not begun an episode.
            ValueError: There is another number of levels than of worlds, or one that is none.
        """
        chosen = np.arange(self.n_worlds) if worlds is None else np.asarray(worlds, np.int64)
        if not self.begun[chosen].all():
            raise ResetNeeded("call reset() before choosing the levels that follow")
        self.episodes.choose(chosen, checked_choice(levels, len(chosen)))

    def begin_next(self, worlds: Ints) -> None:
        """Begin the next level in worlds whose episodes have ended: the chosen one, else that of the chain."""
        self.episodes.begin_next(worlds)
        self.pictures.note_beginning(worlds, at_once=False)

    def respawn(self, agents: Flags) -> None:
        """Let agents ``(n_worlds, n_agents)`` begin elsewhere in their running worlds, see ``Episodes.respawn``."""
        self.episodes.respawn(agents)
        self.pictures.note_respawn(agents)

    def step(self, actions: NDArray[Any], worlds: Ints | None = None) -> None:
        """Advance the given worlds, or all, by one step, see ``Episodes.step``; and show what the mode asks for."""
        self.episodes.step(actions, worlds)
        self.pictures.note_step(worlds)

    def step_alone(self, action: NDArray[Any]) -> None:
        """Advance the only world with its only agent, as ``step`` does, with less Python around it.

        Args:
            action: Of the shape of the action space.
        """
        direct = self.episodes.direct
        if direct is None or not direct.run(action):
            self.episodes.step(action.reshape(1, 1, *action.shape))
        if self.pictures.trails is not None:
            self.pictures.note_step(None)

    def observation(self) -> Observation:
        """Return a fresh copy of the first agents' observations, ``(n_worlds, ...)`` or a dict of arrays."""
        return self.layout.fresh(self.episodes.view, FIRST_AGENTS)

    def observation_alone(self) -> Observation:
        """Return a fresh copy of the observation of the only agent of the only world, which is looked up once."""
        if not self.layout.plain:
            return self.layout.fresh(self.episodes.view, (0, 0))
        if self._row is None:
            self._row = self.episodes.view.observation[0, 0]
        return self._row.copy()

    def observations_of(self, worlds: Ints) -> Sequence[Observation]:
        """Return a fresh copy of the first agent's observation in each of several worlds."""
        return self.layout.each(self.episodes.view, worlds)

    def info_of(self, w: int, agent: int = 0) -> dict[str, Any]:
        """Return what is known about an agent of a world, as Python numbers: a dict of its own at each call."""
        return self.infos.of(w, agent)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_row": None}

    def moment(self, world: int = 0) -> WorldMoment:
        """Return one of the worlds as it is now, to be read.

        Raises:
            IndexError: There are not so many.
        """
        if not -self.n_worlds <= world < self.n_worlds:
            raise IndexError(f"world {world}: there are {self.n_worlds}")
        return WorldMoment(self.simulation, world % self.n_worlds)

    def mirror(self) -> Mirror:
        """Return what exchanges left and right in observations and actions.

        Raises:
            IrsimGymError: If they cannot be exchanged; the message lists every reason.
        """
        if self._mirror is None:
            self._mirror = mirror_of(self.episodes)
        return self._mirror

    def describe(
        self, agent: str | int = 0, *, of_agent: bool = False, more: Mapping[str, object] | None = None
    ) -> Description:
        """Return what observations, actions, rewards, endings and infos mean to a learner.

        Args:
            agent: Its name, or its number among the learners.
            of_agent: Leave out columns and components that mean nothing to it.
            more: What its infos hold besides those of ``info_of``.

        Raises:
            UnknownNameError: There is no such learner.
        """
        names = self.agent_names
        if isinstance(agent, str) and agent not in names:
            raise errors.UnknownNameError(f"no agent named {agent!r}{suggestion(agent, names)}")
        a = names.index(agent) if isinstance(agent, str) else agent
        return describe(self.episodes, {**self.info_of(0, a), **(more or {})}, a, of_agent=of_agent)

    def close(self) -> None:
        """Close the window and free the renderers; everything else is plain memory."""
        self.pictures.close()


def _warn_of_idle_robots(scenario: Scenario, task: Task) -> None:
    """Warn of robots that neither learn nor have a behaviour."""
    idle = idle_robots(scenario, task)
    if idle:
        ways = "parallel_env, make_batch, sb3.make_multi_agent_vec_env and, on the command line, --team"
        body = scenario.bodies[task.agents[0]]
        problem = Problem(body.line, body.name, f"{idle}: {ways} train {all_of(scenario)}")
        warn_caller(ScenarioWarning(scenario.source.title, [problem]))


def _loaded(scenario: ScenarioSource | None, parameters: Mapping[str, object], strict: bool) -> Scenario:
    if scenario is None:
        way = f"gymnasium.make('{ANY}', scenario='my_world.yaml')"
        raise errors.MissingScenarioError(f"no scenario given: {way} takes {SOURCES}")
    if not isinstance(scenario, Scenario):
        with given_as_keywords():
            return load_scenario(scenario, parameters, strict=strict)
    if parameters:
        message = f"pass parameters to load_scenario(); '{scenario.name}' is already loaded"
        raise errors.UnknownKeywordError.of(next(iter(parameters)), message)
    return scenario if strict else replace(scenario, strict=False)
