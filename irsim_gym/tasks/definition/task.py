"""A task: the actions, observations, rewards and endings of the learning agents."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from irsim_gym.base.errors import Problem, ScenarioError, UnknownNameError
from irsim_gym.base.families import ACTIONS, ENDINGS, OBSERVATIONS, REWARDS, SHIELDS
from irsim_gym.base.options import kind, option
from irsim_gym.base.registry import Registry
from irsim_gym.scenario.checking.validation import Report, build, build_named
from irsim_gym.scenario.reading.notes import warn_of_keys
from irsim_gym.scenario.reading.parameters import PREDICT
from irsim_gym.scenario.specs import library
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.scenario.text.messages import show
from irsim_gym.scenario.text.source import MissingFileError, Place, Source, read_file, read_mapping
from irsim_gym.tasks.definition import checks
from irsim_gym.tasks.definition.audit import Sharing, check_audit
from irsim_gym.tasks.definition.layers import Layer, merge

DEFAULT = "navigation"
FAMILIES = {"observations": OBSERVATIONS, "rewards": REWARDS, "endings": ENDINGS}
LONGEST_CHAIN = 8
LONGEST = 10.0
"""Longest time that is predicted [s]."""
CARRIED = ("observation_form", "ended", "team_reward", "deadlock_speed", "deadlock_time", "near", "predict")
"""Options that a task has as they are."""
_CHANGES = "; changes the terms of the named task by name."


@kind
class TaskOptions:
    """The keys of the section `task` and of files in `tasks/`; defaults apply if the named task does not set a key."""

    name: str = option(DEFAULT, meaning="A shipped task or a file to extend; 'blank' starts from an empty task.")
    agents: str | tuple[str, ...] = option(
        "", meaning="Which robots learn: a name, a list of names, or 'all'; default: the first robot, or all in a team."
    )
    max_steps: int = option(500, ge=1, le=10**9, unit="steps", meaning="Time limit of an episode.")
    observation_form: Literal["flat", "dict"] = option("flat", meaning="One vector (flat), or several (dict).")
    ended: Literal["stay", "vanish"] = option(
        "stay", meaning="What becomes of the body of an ended agent: it stays, or is removed before the next step."
    )
    team_reward: float = option(
        0.0, ge=0.0, le=1.0, meaning="Share of the mean over all agents in each reward; the rest is the agent's own."
    )
    deadlock_speed: float = option(0.05, ge=0.0, unit="m/s", meaning="Slower, away from its goal, it is stalled.")
    deadlock_time: float = option(5.0, gt=0.0, unit="s", meaning="An agent stalled for this time is deadlocked.")
    predict: float | bool = option(
        False,
        unit="s",
        meaning="Time until a command acts; observations show what the agent will see then, as far as the commands "
        "under way say it. 'true': the latency of each level.",
    )
    audit: bool = option(True, meaning="Reject rewards under which crashing or leaving pays more than continuing.")
    near: float | None = option(
        None, ge=0.0, unit="m", meaning="Closer to another body a step costs 1 (info['cost']); default: no costs."
    )
    action: Any = option("velocity", meaning="What a learner commands.")
    shield: Any = option(None, meaning="What stands between a learner's commands and its drive.")
    observations: tuple[Any, ...] = option((), meaning=f"What a learner observes{_CHANGES}")
    rewards: tuple[Any, ...] = option((), meaning=f"Reward terms; the reward is their sum{_CHANGES}")
    endings: tuple[Any, ...] = option((), meaning=f"What ends an episode, besides the time limit{_CHANGES}")

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of an invalid option."""
        if not 0.0 <= self.predict <= LONGEST:
            yield "predict", f"must lie from 0 to {LONGEST:g} seconds, or be true or false, got {self.predict:g}"


@dataclass(frozen=True)
class Task:
    """A task.

    Attributes:
        name: Name of the task file that it extends.
        agents: Bodies of the learners.
        max_steps: Time limit [steps]; an episode that is still running then is truncated.
        action: Instance of a registered action.
        observations: Instances of registered observations, in order.
        rewards: Instances of registered rewards, in order.
        endings: Instances of registered endings.
        names_agents: Whether the task says which robots learn.
        observation_form: ``flat`` or ``dict``.
        ended: What happens to the body of an agent whose episode has ended: ``stay`` or ``vanish``.
        team_reward: Share of each reward term that is the mean over the agents of a world.
        deadlock_speed: Speed below which an agent counts as stalled [m/s].
        deadlock_time: Time after which a stalled agent is deadlocked [s].
        shield: Instance of a registered shield; None without one.
        near: Clearance below which a step costs 1 [m]; None if nothing does.
        predict: Time until a command acts, for which observations are predicted [s]; True for each level's latency.
    """

    name: str
    agents: tuple[int, ...]
    max_steps: int
    action: Any
    observations: tuple[Any, ...]
    rewards: tuple[Any, ...]
    endings: tuple[Any, ...]
    observation_form: Literal["flat", "dict"] = "flat"
    ended: Literal["stay", "vanish"] = "stay"
    team_reward: float = 0.0
    deadlock_speed: float = 0.05
    deadlock_time: float = 5.0
    names_agents: bool = False
    shield: Any = None
    near: float | None = None
    predict: float | bool = False


def load_task(
    scenario: Scenario,
    task: str | Path | Mapping[str, object] | None = None,
    max_steps: int | None = None,
    *,
    team: bool = False,
) -> Task:
    """Load the task of a scenario, and check that it fits.

    Args:
        scenario: The scenario.
        task: A shipped name, the path of a YAML file, or its content as plain data, in place of the scenario's own
            section ``task``; None for that section, or ``navigation`` without one. ``predict`` of the scenario's own
            section applies unless the task sets it; with a name or path, its time limit does, too.
        max_steps: Replaces the task's time limit.
        team: Whether all robots learn, instead of the first one, if the task does not set ``agents``.

    Raises:
        ScenarioError: If the task cannot be used; the error lists every problem with its line.
        UnknownNameError: If ``task`` is no shipped name.
    """
    if max_steps is not None:
        checked_limit(max_steps)
    name, layers = _layers(scenario, task)
    merged = merge(layers, strict=scenario.strict)
    report, data = merged.report, merged.data
    options = build(TaskOptions, data, (), report, skip={"name", "action", "shield", *FAMILIES})
    action = build_named(ACTIONS, data.get("action", {"name": "velocity"}), ("action",), report)
    asked = data.get("shield")
    shield = scenario.shield or (build_named(SHIELDS, asked, ("shield",), report) if asked is not None else None)
    terms = {key: _terms(family, key, data, report) for key, family in FAMILIES.items()}
    is_sound = not report.problems and not merged.outside
    if options is not None:
        agents = checks.choose_agents(scenario, options.agents, team, merged)
        if agents:
            terms["observations"] = checks.check_fit(scenario, agents, name, terms, merged)
            checks.check_action(scenario, agents, action, report)
            if shield is not None:
                checks.check_shield(scenario, agents, merged)
            if options.predict:
                checks.check_prediction(scenario, agents, terms, report)
        if is_sound:
            checks.check_terms(terms, merged)
            if options.audit:
                check_audit(terms, Sharing(options.team_reward, len(agents)), merged)
    merged.refuse(_title(scenario))
    warn_of_keys(_title(scenario), merged.ignored(_title(scenario)))
    assert options is not None
    parts: dict[str, Any] = {key: tuple(item for _, item in items) for key, items in terms.items()}
    limit = options.max_steps if max_steps is None else max_steps
    parts |= {name: getattr(options, name) for name in CARRIED}
    return Task(name, agents, limit, action, **parts, names_agents=bool(options.agents), shield=shield)


def merged_task(
    scenario: Scenario, task: str | Path | Mapping[str, object] | None = None
) -> tuple[str, dict[str, Any]]:
    """Return a task's name, and its merged files and sections as plain data.

    Args:
        scenario: The scenario.
        task: The task, as ``load_task`` takes it.

    Raises:
        ScenarioError: If a file cannot be read.
        UnknownNameError: If ``task`` is no shipped name.
    """
    name, layers = _layers(scenario, task)
    return name, merge(layers, strict=scenario.strict).data


def checked_limit(max_steps: int) -> int:
    """Return a valid time limit [steps]; raise a ValueError for others."""
    if isinstance(max_steps, bool) or not isinstance(max_steps, int) or max_steps < 1:
        raise ValueError(f"max_steps must be a whole number >= 1, got {max_steps!r}")
    return max_steps


def _title(scenario: Scenario) -> str:
    return scenario.source.title


def _layers(scenario: Scenario, task: str | Path | Mapping[str, object] | None) -> tuple[str, list[Layer]]:
    """Return the task's name, and its files and sections, the most basic one first."""
    folder = Path(scenario.file).parent if scenario.file else Path()
    if isinstance(task, str | Path):
        called, layers = _file_layers(library.find(task, "tasks"), folder)
        return called, [*layers[:-1], *_own(scenario, "max_steps", PREDICT), layers[-1]]
    if task is None:
        top = Layer(_title(scenario), scenario.task, _task_line(scenario), ("task",), _task_remark(scenario))
    else:
        source = read_mapping(task)
        _refuse_unreadable(source)
        top = Layer("the given task", source.data, source.line)
    name = top.data.get("name", DEFAULT)
    if not isinstance(name, str) or not name:
        message = f"must be the name or the file of a task, got {show(name)}"
        raise ScenarioError(top.title, [Problem(top.line(("name",)), _path(top), message)])
    try:
        called, layers = _file_layers(_find(name, folder), folder)
    except MissingFileError as error:
        if error.problems[0].path or error.file not in (name, str(folder / name)):
            raise
        message = f"{error.problems[0].message}, neither beside this file nor at the given path: {show(name)}"
        raise MissingFileError(top.title, [Problem(top.line(("name",)), _path(top), message)]) from None
    except UnknownNameError as error:
        raise ScenarioError(top.title, [Problem(top.line(("name",)), _path(top), str(error))]) from None
    return called, [*layers, *(_own(scenario, PREDICT) if task is not None else ()), top]


def _own(scenario: Scenario, *keys: str) -> list[Layer]:
    """Return options of a scenario's own section that also apply to other tasks unless they set them."""
    # The limit belongs to the level and the prediction to the robot, what is observed and paid to the task.
    section = {key: value for key, value in scenario.task.items() if key in keys}
    if not section:
        return []
    return [Layer(_title(scenario), section, _task_line(scenario), ("task",), _task_remark(scenario))]


def _task_line(scenario: Scenario) -> Callable[[Place], int]:
    return lambda place: scenario.problem(("task", *place), "").line


def _task_remark(scenario: Scenario) -> Callable[[Place], str]:
    return lambda place: scenario.problem(("task", *place), "").message


def _path(layer: Layer) -> str:
    return ".".join([*map(str, layer.prefix), "name"])


def _find(name: str, folder: Path) -> Path:
    """Return the file of a task; a relative path is first looked up beside the file that names it."""
    file = library.find(name, "tasks")
    beside = folder / file
    return beside if not file.is_absolute() and beside.is_file() else file


def _file_layers(file: Path, folder: Path) -> tuple[str, list[Layer]]:
    """Return the name of a task file, and the files that it extends, with itself at the end."""
    name = file.stem
    layers: list[Layer] = []
    for _ in range(LONGEST_CHAIN):
        source = read_file(file)
        _refuse_unreadable(source)
        layers.insert(0, Layer(source.title, source.data, source.line))
        base = source.data.get("name", file.stem)
        if base == file.stem:
            return name, layers
        try:
            file = _find(base, file.parent) if isinstance(base, str) else library.find("", "tasks")
        except UnknownNameError as error:
            raise ScenarioError(source.title, [source.problem(("name",), str(error))]) from None
    raise ScenarioError(str(file), [Problem(0, "name", f"tasks extend each other more than {LONGEST_CHAIN} deep")])


def _refuse_unreadable(source: Source) -> None:
    problems = [*source.problems, *(problem for problem, _ in source.repeats)]
    if not isinstance(source.data, Mapping):
        problems.append(source.problem((), f"a task must be a mapping, got {show(source.data)}"))
    if problems:
        raise ScenarioError(source.title, problems)


def _terms(family: Registry, key: str, data: Mapping[str, object], report: Report) -> list[tuple[Place, Any]]:
    """Return the valid kinds of a list with their paths."""
    given = data.get(key)
    if given is None:
        return []
    if not isinstance(given, list):
        report.add((key,), f"must be a list, got {show(given)}")
        return []
    places: list[Place] = [(key, i) for i in range(len(given))]
    made = [(place, build_named(family, given[i], place, report)) for i, place in enumerate(places)]
    found = [(place, item) for place, item in made if item is not None]
    seen: set[type[Any]] = set()
    for place, item in found:
        if type(item) in seen:
            report.add(place, f"{family.family} '{family.name_of(type(item))}' is given twice")
        seen.add(type(item))
    return found
