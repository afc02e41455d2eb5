"""Turns a scenario into arrays. The vocabulary of YAML ends here."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from irsim_gym.base.options import defaults
from irsim_gym.scenario.reading.level_checks import n_goals_drawn
from irsim_gym.scenario.specs.spec import BodySpec, Scenario
from irsim_gym.scenario.specs.wander_goals import WanderGoals
from irsim_gym.simulator.cell_maps.cells import find_boxes
from irsim_gym.simulator.cell_maps.world_maps import lay_cells, most_boxes
from irsim_gym.simulator.contact import body_buckets
from irsim_gym.simulator.engine.collect import collect_parts
from irsim_gym.simulator.engine.disturbing import disturb
from irsim_gym.simulator.engine.given import check_agents, check_scenario, check_worlds
from irsim_gym.simulator.engine.simulation import Simulation
from irsim_gym.simulator.engine.start_checks import refuse_blocked_starts
from irsim_gym.simulator.levels.level_table import roomy_outlines, varied_outlines
from irsim_gym.simulator.levels.traits import drawn_traits, watching_bodies, write_people
from irsim_gym.simulator.running.shards import Shards
from irsim_gym.simulator.world import model as fields
from irsim_gym.simulator.world.model import KEEP_GOAL, LOOP, NO_DRIVE, OBSTACLE, ROBOT, WANDER, Model
from irsim_gym.simulator.world.names import Flags, Outline, State

COLLISION_MODES = {"stop": fields.STOP, "unobstructed": fields.UNOBSTRUCTED, "contact": fields.CONTACT}
COLLISION_MODES |= {"unobstructed_obstacles": fields.UNOBSTRUCTED_OBSTACLES}
ARRIVE_MODES = {"position": fields.POSITION, "state": fields.STATE}
RANDOM_OUTLINE = frozenset(
    {"local_segments", "local_discs", "segment_count", "disc_count", "reach", "radius", "centroid"}
)
RANDOM_MAP = frozenset({"map_squares", "map_room", "map_boxes", "map_n_boxes"})


def compile(
    scenario: Scenario,
    n_worlds: int = 1,
    *,
    agents: Sequence[int] = (),
    num_threads: int = 1,
    check_starts: bool = True,
    fused: bool = True,
) -> Simulation:
    """Turn a scenario into arrays for ``n_worlds`` worlds.

    Args:
        scenario: The scenario to compile.
        n_worlds: Number of worlds that are stepped together.
        agents: Bodies commanded from outside; their behaviour is ignored.
        num_threads: Number of threads that share the worlds.
        check_starts: Whether to refuse robots whose given start lies in an obstacle.
        fused: Whether to record a step and replay it as one call where possible. Results are the same.

    Raises:
        ScenarioError: A robot's given start lies in an obstacle, or a disturbance does not fit it.
        TypeError: It is no loaded scenario.
        ValueError: An agent is no body of it, or there is no world.
    """
    check_scenario(scenario)
    agents = check_agents(agents, scenario)
    check_worlds(n_worlds)
    outlines, varied = roomy_outlines(scenario), varied_outlines(scenario)
    map_shape = (1, 1) if scenario.occupied is None else scenario.occupied.shape
    plans = [_plan_goals(body, scenario, is_agent=b in agents) for b, body in enumerate(scenario.bodies)]
    sizes = {
        "map_box": _count_boxes(scenario, varied),
        "world": n_worlds,
        "body": len(scenario.bodies),
        "segment": sum(len(outline.segments) for outline in outlines),
        "disc": sum(len(outline.discs) for outline in outlines),
        "bucket": body_buckets.n_buckets(len(scenario.bodies)),
        "map_column": map_shape[0],
        "map_row": map_shape[1],
        "watching": len(watching_bodies(scenario)),
        "waypoint": max((goals.rows for goals in plans), default=1),
    }
    per_world = drawn_traits(scenario) | _rows_by_world(scenario, varied)
    model, state = Model.allocate(sizes, per_world=per_world), State.allocate(sizes)
    _write_world(scenario, model)
    _write_outlines(outlines, model)
    for b, body in enumerate(scenario.bodies):
        _write_motion(b, body, model, is_agent=b in agents)
        _write_goals(b, body, plans[b], is_agent=b in agents, model=model)
    _hide_map(model)
    write_people(scenario, model)
    model.rigid[0] = not varied.any()
    body_buckets.lay_out(model, varied)
    shards = Shards(n_worlds, num_threads)
    parts = collect_parts(scenario, outlines, model, agents, shards.n_slots)
    parts.disturbances = disturb(scenario, agents, model, state, parts)
    if check_starts:
        refuse_blocked_starts(scenario, parts, model, state)
    return Simulation(scenario, model, state, parts, np.array(agents, np.int64), shards, fused)


def _rows_by_world(scenario: Scenario, varied: Flags) -> frozenset[str]:
    """Return the fields that need one row per world, because levels change them."""
    if scenario.occupied is None:
        return RANDOM_OUTLINE if varied.any() else frozenset()
    # The map is the last body: it has no outline, but may vary by itself.
    outlines = RANDOM_OUTLINE if varied[:-1].any() else frozenset()
    return outlines | (RANDOM_MAP if varied[-1] else frozenset())


def _count_boxes(scenario: Scenario, varied: Flags) -> int:
    """Return the number of boxes that cover the occupied cells of the map; an upper bound if levels draw the map."""
    if scenario.occupied is None:
        return 0
    if varied[-1]:
        return most_boxes(*scenario.occupied.shape)
    # Without rows to write to, the boxes are only counted.
    return int(find_boxes(scenario.occupied, np.zeros((0, 4), np.int32)))


def _write_world(scenario: Scenario, model: Model) -> None:
    world = scenario.world
    x, y = world.offset
    model.bounds[:] = [x, y, x + world.width, y + world.height]
    model.step_time[0] = world.step_time
    model.collision_mode[0] = COLLISION_MODES[world.collision_mode]
    model.present[:] = True
    model.static_partner[:] = -1
    model.map_frame[0] = x, y, world.width, world.height, -1
    if scenario.occupied is not None:
        columns, rows = scenario.occupied.shape
        size = world.width / columns, world.height / rows
        model.map_frame[0] = x, y, *size, len(scenario.bodies) - 1
        model.map_disc[0] = getattr(scenario.bodies[-1].shape, "disc_radius", None) or 0.0
        cells: Any = model.cells
        # Only row 0 is computed. Where each world has a row, the others begin as copies, until their level is drawn.
        lay_cells(cells, 0, scenario.occupied, np.zeros(columns))
        for field in RANDOM_MAP:
            getattr(model, field)[1:] = getattr(model, field)[0]


def _hide_map(model: Model) -> None:
    """Hide the body of the map from code that reads outlines: it has none, and its cells are tested separately."""
    if model.cells is not None:
        model.unobstructed[-1] = True


def _write_outlines(outlines: Sequence[Outline], model: Model) -> None:
    segment, disc = 0, 0
    for b, outline in enumerate(outlines):
        n_segments, n_discs = len(outline.segments), len(outline.discs)
        model.segment_start[b], model.disc_start[b] = segment, disc
        model.segment_count[:, b], model.disc_count[:, b] = n_segments, n_discs
        model.local_segments[:, segment : segment + n_segments] = outline.segments
        model.local_discs[:, disc : disc + n_discs] = outline.discs
        model.solid[b] = outline.solid
        model.reach[:, b] = _reach(outline)
        segment, disc = segment + n_segments, disc + n_discs


def _reach(outline: Outline) -> float:
    # Columns 0 and 2 are x, 1 and 3 are y of both ends.
    corners = np.hypot(outline.segments[:, 0::2], outline.segments[:, 1::2])
    discs = np.hypot(outline.discs[:, 0], outline.discs[:, 1]) + outline.discs[:, 2]
    return float(max(corners.max(initial=0.0), discs.max(initial=0.0)))


def _write_motion(b: int, body: BodySpec, model: Model, *, is_agent: bool) -> None:
    model.driven[b] = body.behavior is not None or body.group_behavior is not None or is_agent
    model.role[b] = ROBOT if body.role == "robot" else OBSTACLE
    model.drive[b] = getattr(body.kinematics, "drive", NO_DRIVE)
    model.speed_bound[b] = getattr(body.kinematics, "bound", "") == "speed"
    model.wheelbase[b] = _wheelbase(body)
    model.initial_steering[b] = body.steering
    model.movable[b] = not body.static
    model.stands[b] = body.static or not (model.driven[b] or body.coasts)
    model.unobstructed[b] = body.unobstructed
    model.arrive_mode[b] = ARRIVE_MODES[body.arrive_mode]
    model.goal_threshold[:, b] = body.goal_threshold
    model.heading_low[b] = body.angle_range[0]
    for values, target in (
        (body.vel_min, model.velocity_min),
        (body.vel_max, model.velocity_max),
        (body.acce, model.acceleration_limit),
    ):
        target[:, b, : len(values)] = values
    model.drawn_speed[:, b] = np.inf if body.speed_range is None else body.speed_range[1]
    if model.movable[b]:
        model.initial_velocity[b, : len(body.velocity)] = body.velocity
    if body.state is not None:
        model.start[:, b] = body.state[:3]


def _wheelbase(body: BodySpec) -> float:
    """Return the axle distance [m] of the drive, else of the shape; NaN if neither has one above 0."""
    lengths = (getattr(body.kinematics, "wheelbase", None), getattr(body.shape, "wheelbase", None))
    return next((float(value) for value in lengths if value), np.nan)


@dataclass(frozen=True)
class _GoalPlan:
    """What happens to a body's goals, and how much room they need.

    Attributes:
        renewal: ``KEEP_GOAL``, ``WANDER`` or ``LOOP``.
        count: Number of goals of a round; two for a body that loops between a single goal and its start.
        placed: Number of goals that its distribution gives.
        keeps_first: Whether it wanders only after a first goal that is given.
    """

    renewal: int
    count: int
    placed: int
    keeps_first: bool

    @property
    def rows(self) -> int:
        """Rows of ``waypoints``: at least one, also for a body without a goal and for a goal that is drawn."""
        return 2 if self.keeps_first else max(self.count, 1)


def _plan_goals(body: BodySpec, scenario: Scenario, *, is_agent: bool) -> _GoalPlan:
    """Return what happens to a body's goals.

    An agent's behaviour is overridden, so it does not loop, and wanders only where it has no other goal.
    """
    placed = n_goals_drawn(scenario.placements[body.entry])
    # Nothing checks whether a goal that is drawn on the way can be reached, as in IR-SIM.
    wanders = body.wanders and not (is_agent and (placed or body.goal))
    loops = bool(getattr(body.renewal, "loop", False)) and not wanders and not is_agent
    count = placed or len(body.goal)
    renewal = WANDER if wanders else LOOP if loops else KEEP_GOAL
    keeps_first = wanders and count > 0 and bool(_wander_goals(body).keep_first)
    return _GoalPlan(renewal, 2 if loops and count == 1 else count, placed, keeps_first)


def _wander_goals(body: BodySpec) -> WanderGoals:
    """Return where a body's goals lie when it wanders; behaviours of others may not have the option."""
    return getattr(body.renewal, "wander_goals", defaults(WanderGoals))


def _write_goals(b: int, body: BodySpec, plan: _GoalPlan, *, is_agent: bool, model: Model) -> None:
    """Write a body's goals, and whether it has any: it can move, and its entry or its distribution gives some."""
    if plan.renewal == WANDER:
        goals = _wander_goals(body)
        # A learner never gives up its goal.
        interval = (
            0 if is_agent or goals.interval is None else max(1, round(goals.interval / float(model.step_time[0])))
        )
        model.wander_low[b], model.wander_high[b] = body.renewal.range_low, body.renewal.range_high
        model.wandering[b] = goals.radius or 0.0, goals.jitter, goals.chance, plan.keeps_first, interval
    model.waypoints[:, b, :, 2] = np.nan
    # A body that wanders has only one or two rows, however many goals the file gives.
    given = np.array(body.goal[: plan.rows]).reshape(-1, 3)
    model.waypoints[:, b, : len(given)] = given
    model.has_goal[b] = bool(model.movable[b]) and (plan.renewal == WANDER or plan.placed > 0 or len(body.goal) > 0)
    model.goal_renewal[b], model.drawn_goals[b] = plan.renewal, plan.placed
    model.waypoint_count[:, b] = plan.count
