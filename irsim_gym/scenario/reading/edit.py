"""Adds bodies to scenarios and removes them, for worlds by hand."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from irsim_gym.base.errors import ScenarioError
from irsim_gym.scenario.checking.validation import Report
from irsim_gym.scenario.entries.bodies import make_bodies, name_of, placement_of
from irsim_gym.scenario.entries.entries import read_entry
from irsim_gym.scenario.entries.presets import with_presets
from irsim_gym.scenario.entries.shorthand import RawEntry, split_sections
from irsim_gym.scenario.reading.notes import warn_of_keys
from irsim_gym.scenario.specs.spec import MAX_BODIES, BodySpec, PlacementSpec, Scenario
from irsim_gym.scenario.text.messages import choices
from irsim_gym.scenario.text.source import ROLES, read_mapping


def add_bodies(scenario: Scenario, role: str, entry: Mapping[str, object], first: int) -> Scenario:
    """Return a scenario with the bodies of a further entry at the end, before the obstacle map.

    Args:
        scenario: The scenario so far.
        role: ``robot`` or ``obstacle``.
        entry: The entry, as in that section of a file.
        first: Number of its first body, for default names.

    Raises:
        ScenarioError: If the entry cannot be used; the error lists every problem.
        ValueError: If there is no such role.
    """
    if role not in ROLES:
        raise ValueError(f"role must be {choices(ROLES)}, got {role!r}")
    source = with_presets(read_mapping({role: entry}))
    report = Report(source, strict=scenario.strict)
    raw = RawEntry(role, (role,), source.data[role])
    read = read_entry(raw, _shared_plot(scenario), report)
    if len(scenario.bodies) + read.count > MAX_BODIES:
        raise ScenarioError(source.title, [source.problem((role,), f"too many bodies: at most {MAX_BODIES}")])
    group = 1 + max((body.group for body in scenario.bodies), default=-1)
    new_bodies = make_bodies(read, len(scenario.placements), first, group, report)
    taken = {body.name for body in scenario.bodies}
    for i in range(read.count):
        place, name = name_of(read, i, first + i)
        if name in taken:
            report.add(place, f"the name '{name[:40]}' is given to several bodies")
        taken.add(name)
    report.check()
    warn_of_keys(source.title, report.ignored)
    if not read.count:
        return scenario
    end = len(scenario.bodies) - (scenario.occupied is not None)
    placements = [_shifted(spec, end, read.count) for spec in scenario.placements]
    placements.append(placement_of(read, end, report))
    bodies = (*scenario.bodies[:end], *new_bodies, *scenario.bodies[end:])
    return replace(scenario, bodies=bodies, placements=tuple(placements))


def _shifted(spec: PlacementSpec, end: int, count: int) -> PlacementSpec:
    """Return a placement after ``count`` bodies were inserted before body ``end``."""
    return replace(spec, members=tuple(b + count if b >= end else b for b in spec.members))


def _shared_plot(scenario: Scenario) -> Mapping[str, Any]:
    """Return the file's drawing options for all bodies, which were checked when it was read."""
    plot = split_sections(scenario.source.data, Report(scenario.source))[0].get("plot")
    return plot if isinstance(plot, Mapping) else {}


def remove_body(scenario: Scenario, number: int) -> Scenario:
    """Return a scenario without a body; its entry no longer varies in number. Without its body, the map is removed."""
    bodies = [body for b, body in enumerate(scenario.bodies) if b != number]
    is_map = scenario.occupied is not None and number == len(scenario.bodies) - 1
    placements: list[PlacementSpec] = []
    entries: dict[int, int] = {}
    for entry, spec in enumerate(scenario.placements):
        members = tuple(b - (b > number) for b in spec.members if b != number)
        if members:
            entries[entry] = len(placements)
            number_range = spec.number_range if len(members) == len(spec.members) else None
            placements.append(replace(spec, members=members, number_range=number_range))
    gone = scenario.bodies[number]
    counted = sum(body.group == gone.group for body in scenario.bodies[:number])
    left = (_without(body, counted) if body.group == gone.group else body for body in bodies)
    left_bodies = tuple(replace(body, entry=entries[body.entry]) for body in left)
    occupied = None if is_map else scenario.occupied
    return replace(scenario, bodies=left_bodies, placements=tuple(placements), occupied=occupied)


def _without(body: BodySpec, member: int) -> BodySpec:
    """Return a body whose group has lost a member; some group behaviours refer to members by number."""
    recount = getattr(body.group_behavior, "without_member", None)
    return body if recount is None else replace(body, group_behavior=recount(member))
