"""Groups of equal kinds, and the lists of bodies that phases work on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from irsim_gym.arraytypes import Ints
from irsim_gym.engine.parts import Parts
from irsim_gym.engine.ways import guard_ways
from irsim_gym.errors import Problem, ScenarioError
from irsim_gym.scenario.spec import BodySpec, PlacementSpec, Scenario
from irsim_gym.world.group import Group
from irsim_gym.world.model import LOOP, WorldModel
from irsim_gym.world.outline import Outline

Member = tuple[int, Any]


def collect_parts(
    scenario: Scenario,
    outlines: Sequence[Outline],
    model: WorldModel,
    agents: tuple[int, ...],
    n_slots: int,
) -> Parts:
    """Return the groups and lists of a scenario whose constants are written already."""
    bodies = list(enumerate(scenario.bodies))
    deciding = [(b, body.behavior) for b, body in bodies if body.behavior is not None and b not in agents]
    sensors = [(b, sensor) for b, body in bodies for sensor in body.sensors]
    placed = [scenario.placements[body.entry].kind.gives_goal for _, body in bodies]
    single = np.array([gives or len(body.goal) <= 1 for gives, (_, body) in zip(placed, bodies, strict=True)], np.bool_)
    return Parts(
        kinematics=group_members([(b, body.kinematics) for b, body in bodies if model.movable[b]]),
        behaviors=group_members([member for member in deciding if model.movable[member[0]]]),
        footprints=group_members([(b, body.shape) for b, body in bodies if body.shape.is_random]),
        placements=_placements(scenario, model, n_slots),
        sensors=_sensors(sensors, outlines, model, n_slots),
        movers=np.flatnonzero(model.movable),
        fixed=np.flatnonzero(~model.movable),
        goal_bodies=np.flatnonzero(model.has_goal),
        everyone=np.arange(len(bodies), dtype=np.int64),
        number_ranges=_number_ranges(scenario),
        loop_returns=np.flatnonzero(single & (model.goal_renewal == LOOP) & model.has_goal),
        ways=guard_ways(scenario, model, agents, n_slots),
        names=tuple(body.name for _, body in bodies),
        places=tuple(_place(scenario, body) for _, body in bodies),
    )


def _place(scenario: Scenario, body: BodySpec) -> str:
    return f"'{body.name}' ({scenario.file}:{body.line})" if scenario.file else f"'{body.name}'"


def group_members(members: Sequence[Member], key: Callable[[Any], Any] = type) -> list[Group]:
    """Return one group for each distinct key, in the order of first appearance."""
    found: dict[Any, list[Member]] = {}
    for member in members:
        found.setdefault(key(member[1]), []).append(member)
    return [
        Group(type(same[0][1]), [options for _, options in same], np.array([b for b, _ in same], np.int64))
        for same in found.values()
    ]


def _sensors(members: Sequence[Member], outlines: Sequence[Outline], model: WorldModel, n_slots: int) -> list[Group]:
    groups = group_members(members, key=lambda options: (type(options), options.group_key()))
    for group in groups:
        group.kind.prepare(group, [outlines[b] for b in group.members], model, n_slots)
    return groups


def _placements(scenario: Scenario, model: WorldModel, n_slots: int) -> list[Group]:
    """Return the entries in the order of placement: what is given, then random obstacles, then random robots.

    Raises:
        ScenarioError: A distribution does not fit the world.
    """
    groups = []
    for spec in sorted(scenario.placements, key=_turn):
        options = [spec.kind] * len(spec.members)
        group = Group(type(spec.kind), options, np.array(spec.members, np.int64))
        problem = group.kind.prepare(group, model, n_slots)
        if problem is not None and spec.members:
            body = scenario.bodies[spec.members[0]]
            raise ScenarioError(
                scenario.file or scenario.name, [Problem(body.line, f"{body.name}.distribution", problem)]
            )
        groups.append(group)
    return groups


def _turn(spec: PlacementSpec) -> int:
    if not spec.kind.is_random:
        return 0
    return 2 if spec.role == "robot" else 1


def _number_ranges(scenario: Scenario) -> Ints:
    rows = [
        (spec.members[0], *spec.number_range)
        for spec in scenario.placements
        if spec.number_range is not None and spec.members
    ]
    return np.array(rows, np.int64).reshape(-1, 3)
