"""Finds robots with a blocked start before the first level is drawn."""

from dataclasses import replace

import numpy as np

from irsim_gym.base.errors import Problem, ScenarioError
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.contact import body_buckets, contact
from irsim_gym.simulator.levels.level_table import given_bodies, varied_outlines
from irsim_gym.simulator.step import outlines
from irsim_gym.simulator.step.parts import Parts
from irsim_gym.simulator.world.model import UNOBSTRUCTED
from irsim_gym.simulator.world.names import ROBOT, Model, Shard, State


def refuse_blocked_starts(scenario: Scenario, parts: Parts, model: Model, state: State) -> None:
    """Refuse a file that starts a robot in an obstacle that never moves and would hold it forever.

    A script may resolve such a collision itself, so worlds by hand only warn; for a learner the episode is worthless.

    Raises:
        ScenarioError: With the line of every such robot.
    """
    blocked = find_blocked_starts(scenario, parts, model, state)
    advice = "; a robot must begin clear of static obstacles; irsim_gym.load runs the file all the same"
    if blocked:
        problems = [replace(problem, message=problem.message + advice) for problem in blocked]
        raise ScenarioError(scenario.file or scenario.name, problems)


def find_blocked_starts(scenario: Scenario, parts: Parts, model: Model, state: State) -> tuple[Problem, ...]:
    """Return the start of each robot that the file puts into an obstacle that never moves.

    Nobody is blocked if collisions hold nobody in place. The test uses the first world, before its first level.
    """
    # Only what the file fixes can be blamed on it: neither drawn places nor outlines that levels change.
    fixed = ~np.array([scenario.placements[body.entry].kind.is_random for body in scenario.bodies], np.bool_)
    fixed &= ~varied_outlines(scenario) & ~given_bodies(scenario)
    robots = np.flatnonzero(fixed & model.movable & (model.role == ROBOT))
    walls = fixed & ~model.movable
    if not len(robots) or not walls.any() or model.collision_mode[0] == UNOBSTRUCTED:
        return ()
    shard = Shard(np.zeros(1, np.int64))
    state.pose[0] = model.start[0]
    outlines.place(parts.everyone, model, state, shard)
    body_buckets.empty(model, state, shard)
    body_buckets.refresh(parts.everyone, model, state, shard)
    problems = []
    for b in robots:
        # Only the walls and this robot exist during the test, so that nothing else can be hit.
        model.present[0] = walls
        model.present[0, b] = True
        contact.find(np.array([b], np.int64), model, state, shard)
        if state.collided[0, b]:
            problems.append(_blocked(scenario, int(b), int(state.hit[0, b])))
    # World 0 was used for the test: leave it as it was allocated.
    model.present[0] = True
    for field in (state.pose, state.segments, state.discs, state.collided, state.stopped, state.hit):
        field[0] = 0
    return tuple(problems)


def _blocked(scenario: Scenario, robot: int, obstacle: int) -> Problem:
    body, other = scenario.bodies[robot], scenario.bodies[obstacle]
    is_map = scenario.occupied is not None and obstacle == len(scenario.bodies) - 1
    name = "the obstacle map" if is_map else f"'{other.name}'"
    where = f" (line {other.line})" if other.line else ""
    return Problem(body.line, body.name, f"the start lies in {name}{where}")
