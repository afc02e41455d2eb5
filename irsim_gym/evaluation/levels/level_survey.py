"""What training will meet in the first levels of a scenario: goals that nobody can reach, or not in time."""

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from irsim_gym.base.errors import Problem, ScenarioError
from irsim_gym.evaluation.measures.optimum import stops, straight_distance
from irsim_gym.evaluation.protocol.teams import top_speed
from irsim_gym.scenario.reading.level_checks import levels_differ
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.cell_paths import queries as ways
from irsim_gym.simulator.engine import compile
from irsim_gym.simulator.geometry.polygons import contains_point
from irsim_gym.simulator.geometry.segments import point_segment_distance2
from irsim_gym.simulator.levels.level_table import given_bodies, varied_outlines
from irsim_gym.simulator.world.model import UNOBSTRUCTED, WANDER, Model
from irsim_gym.tasks import Episodes, Task

LEVELS = 16
"""Number of levels that are looked at; fewer for teams."""
MOST_CELLS = 2_000_000
"""Largest grid on which a path is searched."""
CURES = "`reachable: true` in its distribution, or fewer and smaller obstacles", "move the goal, or what is in its way"
"""Cures where levels differ, and where there is only one."""
ONE_LEVEL = "nothing in the file is drawn at random: all levels are the same, so training and evaluation see only one"


def survey(scenario: Scenario, task: Task) -> list[Problem]:
    """Begin the first training levels of a scenario, and return remarks on what its learners meet there.

    Raises:
        ScenarioError: If a goal of a learner lies so deep in an obstacle that it can never arrive.
    """
    n_worlds = max(2, LEVELS // len(task.agents)) if levels_differ(scenario) else 1
    episodes = Episodes(compile(scenario, n_worlds, agents=task.agents), task)
    worlds = np.arange(n_worlds)
    episodes.begin(worlds, worlds, "train")
    notes = [] if levels_differ(scenario) else [scenario.problem(("world",), ONE_LEVEL)]
    if not any(term.needs_goal for term in (*task.endings, *task.rewards)):
        return notes
    _refuse_blocked_goals(episodes)
    return [*notes, *_way_notes(episodes)]


def _refuse_blocked_goals(episodes: Episodes) -> None:
    """Refuse goals that the file gives within obstacles that it gives, too.

    A robot arrives within ``goal_threshold`` of its goal. There it would touch what a disc about the goal touches whose
    radius is that of the largest disc within the robot, less the threshold.
    """
    simulation = episodes.simulation
    scenario, model, state = simulation.scenario, simulation.model, simulation.state
    random = [scenario.placements[body.entry].kind.is_random for body in scenario.bodies]
    is_fixed = ~(np.array(random, np.bool_) | varied_outlines(scenario) | given_bodies(scenario))
    map_is_given = model.cells is None or bool(is_fixed[-1])
    problems = []
    for body in simulation.agents.tolist():
        spec = scenario.bodies[body]
        radius = inner_radius(model, 0, body) - spec.goal_threshold
        is_drawn = bool(model.drawn_goals[body]) or model.goal_renewal[body] == WANDER
        if is_drawn or not is_fixed[body] or radius <= 0.0 or _passes(model, body):
            continue
        for goal in spec.goal:
            hit = ways.blocking_bodies(model, state, 0, radius, goal, ways.fixed_bodies(model, 0) & is_fixed)
            names = ["the obstacle map" if b is None else f"'{scenario.bodies[b].name}'" for b in hit]
            if names and (map_is_given or hit != [None]):
                where = f"the goal ({goal[0]:g}, {goal[1]:g}) lies in {names[0]}"
                problems.append(Problem(spec.line, spec.name, f"{where}, so the robot can never arrive: move one"))
    if problems:
        raise ScenarioError(scenario.file or scenario.name, problems)


def _passes(model: Model, body: int) -> bool:
    """Return whether a body passes through obstacles."""
    return bool(model.collision_mode[0] == UNOBSTRUCTED or model.unobstructed[body])


def inner_radius(model: Model, world: int, body: int) -> float:
    """Return the radius of the largest disc about a body's origin within its outline [m]; 0 if there is none."""
    row, disc, segment = world % len(model.reach), model.disc_start[body], model.segment_start[body]
    discs = model.local_discs[row, disc : disc + model.disc_count[row, body]]
    lines = model.local_segments[row, segment : segment + model.segment_count[row, body]]
    inside = float(np.max(discs[:, 2] - np.hypot(discs[:, 0], discs[:, 1]), initial=0.0))
    if not len(lines) or len(discs) or not model.solid[body] or not contains_point(lines, 0, len(lines), (0.0, 0.0)):
        return inside
    return math.sqrt(min(point_segment_distance2(0.0, 0.0, *line) for line in lines.tolist()))


def _way_notes(episodes: Episodes) -> Iterator[Problem]:
    """Yield remarks on levels without a way to the goal, and on ways that take longer than the time limit."""
    simulation, task = episodes.simulation, episodes.task
    scenario, model = simulation.scenario, simulation.model
    limit = task.max_steps * float(model.step_time[0])
    no_way, late = np.zeros((2, episodes.n_worlds, episodes.n_agents), np.bool_)
    for w, a in np.ndindex(no_way.shape):
        body, speed = int(simulation.agents[a]), top_speed(episodes, w, a)
        if speed > 0.0 and model.has_goal[body]:
            threshold = float(model.goal_threshold[w % len(model.goal_threshold), body])
            straight, length = straight_distance(episodes, w, a), _way_length(episodes, w, a, threshold)
            no_way[w, a] = length == math.inf
            late[w, a] = (straight if no_way[w, a] or math.isnan(length) else length) > limit * speed + threshold
    cures = CURES[not levels_differ(scenario)]
    late_note = f"the way to its goal takes longer than max_steps ({task.max_steps}) at full speed: raise max_steps"
    for flags, note in ((no_way, f"no way wide enough for it leads to its goal: {cures}"), (late, late_note)):
        if flags.any():
            spec = scenario.bodies[int(simulation.agents[np.flatnonzero(flags.any(axis=0))[0]])]
            count = f"in {int(flags.any(axis=1).sum())} of the first {len(flags)} levels, "
            yield Problem(spec.line, spec.name, f"{count if levels_differ(scenario) else ''}{note}")


def _way_length(episodes: Episodes, w: int, a: int, threshold: float) -> float:
    """Return a lower bound of the length of an agent's way [m]: that of the largest disc within its outline.

    Infinite where no way is found, NaN where it is not known: in a world too large to search, or where an agent might
    arrive within ``threshold`` although it has no room at the goal itself.
    """
    simulation = episodes.simulation
    model, state, body = simulation.model, simulation.state, int(simulation.agents[a])
    places = stops(episodes, w, a)
    if _passes(model, body):
        return math.nan
    radius, blocks = inner_radius(model, w, body), ways.standing_bodies(model, w)
    for goal in places[1:]:
        if ways.blocking_bodies(model, state, w, radius, goal, blocks):
            is_shut = radius > threshold and ways.blocking_bodies(model, state, w, radius - threshold, goal, blocks)
            return math.inf if is_shut else math.nan
    width, height = model.bounds[2:] - model.bounds[:2]
    for cell in (ways.COARSE, ways.FINE):
        if width * height / cell**2 > MOST_CELLS:
            return math.nan
        legs = [
            ways.free_path_length(model, state, w, radius, *leg, blocks=blocks, cell=cell) for leg in pairwise(places)
        ]
        if math.isfinite(sum(legs)):
            return sum(legs)
    return math.inf
