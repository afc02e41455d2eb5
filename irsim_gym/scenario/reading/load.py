"""Loads a scenario from a name, a file or a mapping, or lists all its problems."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from irsim_gym.base import families
from irsim_gym.base.errors import ScenarioError, nearest, suggestion
from irsim_gym.base.options import option_fields
from irsim_gym.scenario.checking.needless import UNOBSTRUCTED_MODES
from irsim_gym.scenario.checking.validation import BAD, Report, build
from irsim_gym.scenario.checking.whereabouts import unknown_key
from irsim_gym.scenario.entries.bodies import make_bodies, name_of, placement_of, with_map
from irsim_gym.scenario.entries.entries import read_entry
from irsim_gym.scenario.entries.presets import with_presets
from irsim_gym.scenario.entries.recorded_bodies import give_recordings
from irsim_gym.scenario.entries.shorthand import split_entries, split_sections
from irsim_gym.scenario.reading import notes
from irsim_gym.scenario.reading.level_checks import home_of, misfits, read_level_file, tell, with_levels
from irsim_gym.scenario.reading.level_reading import read_levels
from irsim_gym.scenario.reading.map_cells import map_extent, read_cells, read_map
from irsim_gym.scenario.reading.parameters import BESIDE, PERTURBED, PREDICT, SHIELDED, fill_in
from irsim_gym.scenario.reading.perturbations import read_perturbations, read_shield
from irsim_gym.scenario.specs import library
from irsim_gym.scenario.specs.gui_spec import GuiSpec
from irsim_gym.scenario.specs.ids import IDS
from irsim_gym.scenario.specs.plot_spec import ObjectPlot
from irsim_gym.scenario.specs.spec import MAX_BODIES, BodySpec, PlacementSpec, Scenario
from irsim_gym.scenario.specs.world_spec import WorldSpec
from irsim_gym.scenario.text.messages import choices, literal_values, show
from irsim_gym.scenario.text.source import ROLES, SECTIONS, WRAPPER, Place, Source, read_file, read_mapping

LENIENT = "With strict=False, or --lenient in the shell, unknown keys, unknown modes and repeated keys are warnings."
STAND_INS = {
    "collision_mode": ("unobstructed", "bodies do not stop at a collision"),
    "control_mode": ("auto", "behaviours and actions drive"),
}
"""What IR-SIM takes a word for that it does not know, by the key of ``world``, and what that means."""


def load_scenario(
    scenario: str | Path | Mapping[str, object],
    parameters: Mapping[str, object] | None = None,
    *,
    strict: bool = True,
    warn: bool = True,
    may_pend: bool = False,
) -> Scenario:
    """Read and check a scenario.

    Args:
        scenario: A shipped name such as ``cluttered_room``, an id, the path of a YAML file, or its content as plain
            data; or the path of a file of levels, .npz, for the scenario that it names with these levels.
        parameters: Values for its parameters, e.g. ``{"n_robots": 16}``; other parameters keep their defaults. Each
            scenario also takes ``disturbances`` of all learners, such as ``{"disturbances": "latency:time=0.2"}``, and
            ``predict`` of its task.
        strict: Whether unused keys are errors; False ignores them with an ``IgnoredKeyWarning``.
        warn: Whether to warn of suspicious values, such as degrees (``ScenarioWarning``), and of ignored keys
            (``IgnoredKeyWarning``).
        may_pend: Whether behaviours may be registered later; an unknown one raises an error when it has to decide.

    Raises:
        ScenarioError: If the scenario cannot be used; the error lists every problem with its line. If the file does
            not exist, the error is also a FileNotFoundError.
        UnknownNameError: If no shipped scenario has the name, no environment has the id, or the scenario has no such
            parameter.
        TypeError: ``scenario`` is neither a name, nor a path, nor a mapping.
    """
    families.load()
    if not isinstance(scenario, str | Path | Mapping):
        raise TypeError(f"a scenario is a name, a path or a mapping, got {type(scenario).__name__}")
    scenario = IDS.scenario(scenario)
    if not isinstance(scenario, Mapping) and Path(scenario).suffix == ".npz":
        levels = read_levels(scenario)
        home, values = home_of(levels)
        how: dict[str, Any] = {"strict": strict, "warn": warn, "may_pend": may_pend}
        played = with_levels(load_scenario(home, {**values, **(parameters or {})}, **how), levels)
        if warn:
            notes.warn_of_levels(played, str(scenario))
        return played
    source = read_mapping(scenario) if isinstance(scenario, Mapping) else read_file(library.find(scenario))
    loaded = read_scenario(source, parameters or {}, strict=strict, may_pend=may_pend)
    if warn:
        notes.warn(loaded)
    return loaded


def read_scenario(
    source: Source, parameters: Mapping[str, object] | None = None, *, strict: bool = True, may_pend: bool = False
) -> Scenario:
    """Check plain data and return its scenario; see ``load_scenario``.

    Raises:
        ScenarioError: If the scenario cannot be used; the error lists every problem with its line.
        UnknownNameError: If the scenario has no such parameter.
    """
    left = dict(parameters or {})
    beside = {name: left.pop(name) for name in BESIDE if left.get(name) is not None}
    source, values = fill_in(source, left, strict=strict)
    source = with_presets(source)
    report = Report(source, strict=strict)
    report.may_pend = may_pend
    _report_repeats(report)
    sections, roots = split_sections(source.data, report)
    places = _places(sections, roots, report)
    world = _world(sections.get("world"), places["world"], source, report)
    gui = build(GuiSpec, sections.get("gui"), places["gui"], report)
    task = _task(sections.get("task"), places["task"], report)
    if PREDICT in beside:
        told = beside[PREDICT]
        task = {**task, PREDICT: {"true": True, "false": False}.get(str(told).lower(), told)}
    step_time = float(option_fields(WorldSpec)["step_time"].default) if world is None else world.step_time
    bodies, placements = _bodies(sections, places, step_time, report)
    _check_viewpoint(world, bodies, (*places["world"], "plot", "viewpoint"), report)
    map_place = (*places["world"], "obstacle_map")
    occupied = read_cells(world, map_place, source, report) if world is not None else None
    levels = read_level_file(sections.get("levels"), places["levels"], source, report)
    if world is not None and levels is not None and not report.problems:
        tell(list(misfits(levels, bodies, placements, world, occupied)), places["levels"], report, levels.file)
    if world is not None and occupied is not None:
        bodies, placements = with_map(world, bodies, placements, source.line(map_place))
    if report.problems:
        raise ScenarioError(source.title, list(report.problems), LENIENT if report.could_be_lenient else "")
    assert world is not None
    assert gui is not None
    return Scenario(
        name=world.name,
        file=source.file,
        world=world,
        bodies=bodies,
        placements=placements,
        gui=gui,
        task=task,
        custom=sections.get("custom"),
        source=source,
        root=roots,
        occupied=occupied,
        levels=levels,
        doubts=tuple(report.doubts),
        ignored=tuple(report.ignored),
        strict=strict,
        parameters={**values, **{name: str(value) for name, value in beside.items()}},
        disturbances=read_perturbations(beside[PERTURBED]) if PERTURBED in beside else (),
        shield=read_shield(beside[SHIELDED]) if SHIELDED in beside else None,
    )


def _report_repeats(report: Report) -> None:
    """Report repeated keys as problems if strict, except whole sections; else as doubts, and the last one counts."""
    for problem, is_block in report.source.repeats:
        if report.strict and not is_block:
            report.problems[problem], report.could_be_lenient = None, True
        else:
            report.doubts[replace(problem, message=f"{problem.message}: only the last one counts")] = None


def _places(sections: dict[str, Any], roots: Mapping[str, Place], report: Report) -> dict[str, Place]:
    """Return the path of each section; report misspelt ones, and read them as the sections they resemble."""
    places: dict[str, Place] = {name: (*roots.get(name, ()), name) for name in SECTIONS}
    for name in [name for name in sections if name not in SECTIONS]:
        if report.is_full:
            break
        # Whoever writes `robots:` means all of its content, so that nothing of it may be ignored.
        is_plural = f"{name}s" in SECTIONS or str(name).removesuffix("s") in SECTIONS
        refuse = report.add if is_plural else report.refuse
        refuse((*roots[name], name), unknown_key(name, [*SECTIONS, WRAPPER]))
        near = nearest(name, SECTIONS)
        if report.strict and near is not None and near not in sections:
            sections[near], places[near] = sections[name], (*roots[name], name)
    return places


def _world(data: object, place: Place, source: Source, report: Report) -> WorldSpec | None:
    """Return the section ``world``, named after the file if it has no name."""
    if isinstance(data, Mapping):
        data = {**data, **{key: _known_mode(data.get(key), key, place, report) for key in STAND_INS}}
        if data.get("name") is None and source.file:
            data = {**data, "name": Path(source.file).name.split(".")[0] or "world"}
    elif data is None and source.file:
        data = {"name": Path(source.file).name.split(".")[0] or "world"}
    if isinstance(data, Mapping) and data.get("obstacle_map") is not None:
        map_options = read_map(data["obstacle_map"], (*place, "obstacle_map"), report)
        data = {**map_extent(map_options, source), **data, "obstacle_map": None if map_options is BAD else map_options}
    has_map = isinstance(data, Mapping) and "obstacle_map" in data  # the value of a misspelt key is not read as a map
    return build(WorldSpec, data, place, report, skip=() if has_map else ["obstacle_map"])


def _known_mode(mode: object, key: str, place: Place, report: Report) -> object:
    """Return the mode that a file's word stands for: if the reader is not strict, any word has IR-SIM's meaning."""
    is_needless = key == "collision_mode" and mode in UNOBSTRUCTED_MODES
    is_unknown = isinstance(mode, str) and mode not in literal_values(option_fields(WorldSpec)[key].annotation)
    report.could_be_lenient |= is_unknown
    if is_unknown and (is_needless or not report.strict):
        stand_in, meaning = STAND_INS[key]
        report.doubt((*place, key), f"{show(mode)} is '{stand_in}', as in IR-SIM 2.12.0: {meaning}")
        return stand_in
    return mode


def _check_viewpoint(world: WorldSpec | None, bodies: tuple[BodySpec, ...], place: Place, report: Report) -> None:
    """Report a viewpoint that names no body, unless there are other problems already."""
    name = world.plot.viewpoint if world is not None else None
    names = [body.name for body in bodies]
    if isinstance(name, str) and name not in names and not report.problems:
        report.add(place, f"no body named {show(name)}{suggestion(name[:40], names)}")


def _task(data: object, place: Place, report: Report) -> Mapping[str, Any]:
    if data is None:
        return {}
    if isinstance(data, str):
        return {"name": data}
    if isinstance(data, Mapping):
        return data
    report.add(place, f"must be the name of a task or a mapping, got {show(data)}")
    return {}


def _bodies(
    sections: Mapping[str, Any], places: Mapping[str, Place], step_time: float, report: Report
) -> tuple[tuple[BodySpec, ...], tuple[PlacementSpec, ...]]:
    plot = sections.get("plot")
    if build(ObjectPlot, plot, places["plot"], report) is None or plot is None:
        plot = {}
    bodies: list[BodySpec] = []
    placements: list[PlacementSpec] = []
    total, next_group = 0, 0
    names: list[tuple[Place, str]] = []
    watchers: list[tuple[Place, Any]] = []
    for role in ROLES:
        raws = split_entries(role, sections.get(role), places[role], report)
        entries = [read_entry(raw, plot, report) for raw in raws]
        for k, entry in enumerate(entries):
            if total + entry.count > MAX_BODIES:
                report.add(entry.raw.place, f"too many bodies: at most {MAX_BODIES}")
                break
            entry_bodies = make_bodies(entry, len(placements), total, next_group + k, report)
            entry_bodies = give_recordings(entry_bodies, entry, step_time, report)
            if entry.count:
                placements.append(placement_of(entry, total, report))
            names.extend(name_of(entry, i, total + i) for i in range(entry.count))
            watchers.extend(entry.values.get("seen_by", ()))
            total += entry.count
            bodies.extend(entry_bodies)
        next_group = 1 + max((body.group for body in bodies), default=len(entries) - 1)
    _check_names(names, report)
    _check_watchers(watchers, bodies, report)
    return tuple(bodies), tuple(placements)


def _check_watchers(watchers: list[tuple[Place, Any]], bodies: list[BodySpec], report: Report) -> None:
    """Report words of ``seen_by`` that name no role, body or group, unless there are other problems already."""
    names = list(dict.fromkeys([*ROLES, *(body.name for body in bodies), *(body.group_name for body in bodies)]))
    for place, words in [] if report.problems else watchers:
        for word in words or ():
            if word not in names:
                near = suggestion(word[:40], names)
                report.add(place, f"no role, body or group named {show(word)}{near or '; a role is ' + choices(ROLES)}")


def _check_names(names: list[tuple[Place, str]], report: Report) -> None:
    """Report names that two bodies share."""
    first: dict[str, Place] = {}
    for place, name in names:
        if name not in first:
            first[name] = place
            continue
        line = report.source.line(first[name])
        where = f" (first in line {line})" if line and first[name] != place else ""
        hint = "; a list gives each body its own" if first[name] == place else ""
        report.add(place, f"the name '{name[:40]}' is given to several bodies{where}{hint}")
