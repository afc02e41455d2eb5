"""Groups of equal kinds, and the lists of bodies that phases work on."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from irsim_gym.base.errors import Problem, ScenarioError
from irsim_gym.scenario.reading.level_checks import n_goals_drawn
from irsim_gym.scenario.specs.spec import BodySpec, PlacementSpec, Scenario
from irsim_gym.simulator.contact.swept import lay_sweep
from irsim_gym.simulator.engine import field_of_view
from irsim_gym.simulator.engine.own_scans import with_scans
from irsim_gym.simulator.levels.body_measures import measure
from irsim_gym.simulator.levels.level_table import given_bodies, lay_levels, varied_outlines
from irsim_gym.simulator.levels.path_checks import reachability_check
from irsim_gym.simulator.levels.traits import collect_traits
from irsim_gym.simulator.pushing.coasting import Coasting
from irsim_gym.simulator.pushing.matter import Matter, is_weighed, lay_matter, weigh_anew
from irsim_gym.simulator.pushing.memory import Pushing, lay_pushing
from irsim_gym.simulator.step.fog import lay_fog
from irsim_gym.simulator.step.guide import guide
from irsim_gym.simulator.step.parts import Parts
from irsim_gym.simulator.step.patience import find_patient
from irsim_gym.simulator.step.turns import Turn, take_turns
from irsim_gym.simulator.world.model import LOOP, WANDER
from irsim_gym.simulator.world.names import Flags, Group, Ints, Model, Outline, WorldContext

Member = tuple[int, Any]

_OTHER_BEAMS = "its group reads scans, so the first range sensor of each member must be of one kind with the same beams"


def collect_parts(
    scenario: Scenario, outlines: Sequence[Outline], model: Model, agents: tuple[int, ...], n_slots: int
) -> Parts:
    """Return the groups and lists of a scenario whose constants are written already."""
    bodies = list(enumerate(scenario.bodies))
    scanners = _sensors([(b, sensor) for b, body in bodies for sensor in body.sensors], outlines, model, n_slots)
    group_behaviors = _group_behaviors(scenario, scanners, model, agents, n_slots)
    # A behaviour of one's own does not act where a learner or the behaviour of the group commands the body.
    led = {*agents, *(int(b) for group in group_behaviors for b in group.members)}
    deciding = [(b, body.behavior) for b, body in bodies if body.behavior is not None and b not in led]
    able = [member for member in deciding if model.movable[member[0]]]
    behaviors = [part for group in _behaviors(able, model) for part in with_scans(group, scenario.bodies, scanners)]
    names = tuple(body.name for _, body in bodies)
    matter = lay_matter(scenario, model) if is_weighed(scenario) else None
    context = make_context(scenario, model, scanners, matter, lay_pushing(scenario, matter, model, n_slots))
    kinematics = _kinematics(scenario, model, matter)
    placements, placed = _placements(scenario, model, n_slots), given_bodies(scenario)
    for group in (*group_behaviors, *behaviors, *kinematics, *scanners, *placements):
        group.names, group.context = names, context
    for group in (*behaviors, *kinematics):
        group.kind.prepare(group, model, n_slots)
    for group in (*behaviors, *group_behaviors):
        guide(group, scenario.bodies, kinematics, model)
    external = scenario.world.step_mode == "external"
    everyone, movers = np.arange(len(bodies), dtype=np.int64), np.flatnonzero(model.movable)
    patience = find_patient(scenario, model, agents)
    return Parts(
        kinematics=kinematics,
        behaviors=behaviors,
        group_behaviors=[] if external else group_behaviors,
        turns=[] if external else _turns(scenario, behaviors, kinematics, movers, matter),
        visitors=[] if external else [group for group in behaviors if hasattr(group.kind, "appear")],
        external=external,
        footprints=_footprints(scenario, model),
        maps=_maps(scenario, model, n_slots),
        placements=placements,
        levels=lay_levels(scenario, model, n_slots),
        free=[group for group in placements if not placed[group.members].all()],
        promised=_promised(placements, placed, model),
        sensors=scanners,
        movers=everyone if external else movers,
        fixed=everyone[:0] if external else np.flatnonzero(~model.movable),
        goal_bodies=np.flatnonzero(model.has_goal),
        everyone=everyone,
        measured=_measure(scenario, outlines, model, [*behaviors, *group_behaviors]),
        number_ranges=_number_ranges(scenario),
        traits=collect_traits(scenario, model),
        loop_returns=_loop_returns(scenario, model),
        ways=reachability_check(scenario, model, agents, n_slots),
        fog=lay_fog(scenario, scanners, model),
        sweep=lay_sweep(scenario, model, movers, None if patience is None else patience.free),
        patience=patience,
        matter=matter,
        pushing=context.pushing,
        names=names,
        places=tuple(_place(scenario, body) for _, body in bodies),
    )


def _turns(
    scenario: Scenario, behaviors: list[Group], kinematics: list[Group], movers: Ints, matter: Matter | None
) -> list[Turn]:
    driven = movers if matter is None else np.setdiff1d(movers, matter.coasting)
    return take_turns(movers, behaviors, kinematics, driven, in_order=scenario.world.update == "sequential")


def make_context(
    scenario: Scenario, model: Model, sensors: Sequence[Group], matter: Matter | None, pushing: Pushing | None
) -> WorldContext:
    """Return what readers of single bodies look at; without masses, these are made when they are asked for."""
    weighed = partial(weigh_anew, scenario, model, matter)
    return WorldContext(scenario.bodies, sensors, field_of_view.detect, weighed, pushing)


def _kinematics(scenario: Scenario, model: Model, matter: Matter | None) -> list[Group]:
    """Return the bodies that move, by drive; those that coast last."""
    bodies = [(b, body) for b, body in enumerate(scenario.bodies) if model.movable[b]]
    driven = group_members([(b, body.kinematics) for b, body in bodies if not body.coasts])
    coasting = group_members([(b, Coasting()) for b, body in bodies if body.coasts])
    for group in coasting:
        group.tables = matter
    return driven + coasting


def _loop_returns(scenario: Scenario, model: Model) -> Ints:
    """Return the bodies that loop between a single goal and their start; with several goals, a loop leaves it out."""
    n_goals = [n_goals_drawn(scenario.placements[body.entry]) or len(body.goal) for body in scenario.bodies]
    single = np.array([count <= 1 for count in n_goals], np.bool_)
    return np.flatnonzero(single & (model.goal_renewal == LOOP) & model.has_goal)


def _place(scenario: Scenario, body: BodySpec) -> str:
    return f"'{body.name}' ({scenario.file}:{body.line})" if scenario.file else f"'{body.name}'"


def group_members(members: Sequence[Member], key: Callable[[Any], Any] = type) -> list[Group]:
    """Return one group for each distinct key, in the order of first appearance."""
    groups: dict[Any, list[Member]] = {}
    for member in members:
        groups.setdefault(key(member[1]), []).append(member)
    return [
        Group(type(same[0][1]), [options for _, options in same], np.array([b for b, _ in same], np.int64))
        for same in groups.values()
    ]


def _behaviors(members: Sequence[Member], model: Model) -> list[Group]:
    """Return the groups of bodies that decide for themselves: those of one behaviour and one drive together."""
    drives = sorted({int(model.drive[b]) for b, _ in members})
    by_drive = [[member for member in members if model.drive[member[0]] == drive] for drive in drives]
    return [group for same in by_drive for group in group_members(same)]


def _group_behaviors(
    scenario: Scenario, sensors: Sequence[Group], model: Model, agents: tuple[int, ...], n_slots: int
) -> list[Group]:
    """Return the groups that decide together, by group number; the first member's entry says how.

    ``arrays["decides"]`` marks the members whose commands they write; the others are only seen by them.

    Raises:
        ScenarioError: A group reads scans, and its members' differ in their beams.
    """
    groups = []
    by_number: dict[int, list[int]] = {}
    for b, body in enumerate(scenario.bodies):
        by_number.setdefault(body.group, []).append(b)
    for _, members in sorted(by_number.items()):
        options = scenario.bodies[members[0]].group_behavior
        if options is None or not getattr(options, "is_known", True):
            continue
        decides = model.movable[members] & ~np.isin(members, agents)
        if getattr(options, "reads_scan", False) and not decides.any():
            continue
        group = Group(type(options), [options] * len(members), np.array(members, np.int64))
        group, *others = with_scans(group, scenario.bodies, sensors)
        if others:
            body = scenario.bodies[int(others[0].members[0])]
            raise ScenarioError(scenario.file or scenario.name, [Problem(body.line, body.name, _OTHER_BEAMS)])
        group.arrays["decides"] = decides
        group.kind.prepare(group, model, n_slots)
        groups.append(group)
    return groups


def _measure(scenario: Scenario, outlines: Sequence[Outline], model: Model, deciding: Sequence[Group]) -> Ints:
    """Write radius and centroid of all bodies if anything reads them; return the bodies whose outline levels draw."""
    # A new reader of ``model.radius`` or ``model.centroid`` has to ask for them here.
    if not any(group.kind.reads_neighbors for group in deciding):
        return np.zeros(0, np.int64)
    everyone = np.arange(len(outlines), dtype=np.int64)
    measure(np.arange(len(model.radius), dtype=np.int64), everyone, model)
    for b, outline in enumerate(outlines):
        if outline.centroid is not None:
            model.centroid[:, b] = outline.centroid
    return everyone[varied_outlines(scenario)]


def _footprints(scenario: Scenario, model: Model) -> list[Group]:
    """Return the groups of bodies whose outline each level draws; a map has none."""
    shapes = [(b, body.shape) for b, body in enumerate(scenario.bodies) if b != model.map_frame[0].body]
    return group_members([(b, shape) for b, shape in shapes if shape.is_random])


def _maps(scenario: Scenario, model: Model, n_slots: int) -> list[Group]:
    """Return the group of the occupancy map if each level draws one."""
    b = int(model.map_frame[0].body)
    if b < 0 or not scenario.bodies[b].shape.is_random:
        return []
    groups = group_members([(b, scenario.bodies[b].shape)])
    groups[0].kind.prepare(groups[0], model, n_slots)
    return groups


def _sensors(members: Sequence[Member], outlines: Sequence[Outline], model: Model, n_slots: int) -> list[Group]:
    groups = group_members(members, key=lambda options: (type(options), options.group_key()))
    for group in groups:
        group.kind.prepare(group, [outlines[b] for b in group.members], model, n_slots)
    return groups


def _placements(scenario: Scenario, model: Model, n_slots: int) -> list[Group]:
    """Return the entries in the order of placement: those with the least freedom first.

    These are given places, places shifted from given ones, random obstacles, random robots.

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


def _promised(placements: Sequence[Group], placed: Flags, model: Model) -> list[Group]:
    """Return the bodies whose ways have to be proved again, since bodies that stand are placed after them."""
    keeps_goal = model.has_goal & ((model.goal_renewal != WANDER) | model.wandering["keeps_first"])
    promises, followed = [], False
    for group in reversed(placements):
        chosen = []
        for k, b in reversed(list(enumerate(group.members))):
            if followed and keeps_goal[b] and not placed[b]:
                chosen.append(k)
            followed = followed or bool(model.stands[b] and not model.unobstructed[b] and not placed[b])
        if chosen and group.options[0].ensures_way and hasattr(group.kind, "confirm"):
            promises.append(group.select(np.array(chosen[::-1])))
    return promises[::-1]


def _turn(spec: PlacementSpec) -> int:
    if not spec.kind.roams:
        return 1 if spec.kind.is_random else 0
    return 3 if spec.role == "robot" else 2


def _number_ranges(scenario: Scenario) -> Ints:
    rows = [(spec.members[0], *spec.number_range) for spec in scenario.placements if spec.number_range and spec.members]
    return np.array(rows, np.int64).reshape(-1, 3)
