"""From what a file says to arrays: here YAML's vocabulary ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from irsim_gym.arraytypes import Ints
from irsim_gym.engine import body_buckets
from irsim_gym.engine.collect import collect_parts
from irsim_gym.engine.given import check_agents, check_scenario
from irsim_gym.engine.level_table import roomy_outlines, varied_outlines
from irsim_gym.engine.shards import Shards
from irsim_gym.engine.simulation import Simulation
from irsim_gym.engine.start_checks import refuse_blocked_starts
from irsim_gym.geometry.cell_room import find_room
from irsim_gym.geometry.cells import find_boxes, find_free_squares
from irsim_gym.scenario.spec import BodySpec, Scenario
from irsim_gym.world.model import (
    KEEP_GOAL,
    LOOP,
    NO_DRIVE,
    OBSTACLE,
    POSITION,
    ROBOT,
    STATE,
    STOP,
    UNOBSTRUCTED,
    UNOBSTRUCTED_OBSTACLES,
    WANDER,
    WorldModel,
)
from irsim_gym.world.outline import Outline
from irsim_gym.world.state import WorldState

COLLISION_MODES = {
    "stop": STOP,
    "unobstructed": UNOBSTRUCTED,
    "unobstructed_obstacles": UNOBSTRUCTED_OBSTACLES,
}
ARRIVE_MODES = {"position": POSITION, "state": STATE}
RANDOM_OUTLINE = frozenset(
    {"local_segments", "local_discs", "segment_count", "disc_count", "reach", "radius", "centroid"}
)


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
        scenario: The description.
        n_worlds: Number of worlds that are stepped together.
        agents: Bodies whose behaviour is overridden: their commands come from outside.
        num_threads: Worlds are shared out over that many threads.
        check_starts: Refuse robots whose given start lies in an obstacle.
        fused: Replay a step as one call where that is possible; the results are the same.

    Raises:
        ScenarioError: A robot's given start lies in an obstacle.
        TypeError: It is no loaded scenario.
        ValueError: An agent is no body of it, or there is no world.
    """
    check_scenario(scenario)
    agents = check_agents(agents, scenario)
    if isinstance(n_worlds, bool) or not isinstance(n_worlds, int | np.integer) or n_worlds < 1:
        raise ValueError(f"n_worlds must be a whole number >= 1, got {n_worlds!r}")
    outlines, varied = roomy_outlines(scenario), varied_outlines(scenario)
    boxes = np.zeros((0, 4), np.int64) if scenario.occupied is None else find_boxes(scenario.occupied)
    plans = [_plan_goals(body, scenario, is_agent=b in agents) for b, body in enumerate(scenario.bodies)]
    sizes = {
        "map_box": len(boxes),
        "world": n_worlds,
        "body": len(scenario.bodies),
        "segment": sum(len(outline.segments) for outline in outlines),
        "disc": sum(len(outline.discs) for outline in outlines),
        "bucket": body_buckets.n_buckets(len(scenario.bodies)),
        "map_column": 1 if scenario.occupied is None else scenario.occupied.shape[0],
        "map_row": 1 if scenario.occupied is None else scenario.occupied.shape[1],
        "waypoint": max((goals.rows for goals in plans), default=1),
    }
    model = WorldModel.allocate(sizes, per_world=RANDOM_OUTLINE if varied.any() else frozenset())
    state = WorldState.allocate(sizes)
    _write_world(scenario, boxes, model)
    _write_outlines(outlines, model)
    for b, body in enumerate(scenario.bodies):
        _write_motion(b, body, model)
        model.driven[b] = body.behavior is not None or body.group_behavior is not None or b in agents
        _write_goals(b, body, plans[b], model)
    _hide_map(model)
    model.rigid[0] = not varied.any()
    model.stands[:] = ~(model.movable & model.driven)
    body_buckets.lay_out(model, varied)
    shards = Shards(n_worlds, num_threads)
    parts = collect_parts(scenario, outlines, model, agents, shards.n_slots)
    if check_starts:
        refuse_blocked_starts(scenario, parts, model, state)
    return Simulation(scenario, model, state, parts, np.array(agents, np.int64), shards, fused)


def _write_world(scenario: Scenario, boxes: Ints, model: WorldModel) -> None:
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
        find_free_squares(scenario.occupied, model.map_squares)
        model.map_boxes[:] = boxes
    if (cells := model.cells) is not None:
        find_room(cells, np.zeros(len(cells.room)))


def _hide_map(model: WorldModel) -> None:
    """Keep the map's body out of what looks at outlines: it has none, and its cells are asked for apart."""
    if model.cells is not None:
        model.unobstructed[-1] = True


def _write_outlines(outlines: Sequence[Outline], model: WorldModel) -> None:
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
    corners = np.hypot(outline.segments[:, 0::2], outline.segments[:, 1::2])
    discs = np.hypot(outline.discs[:, 0], outline.discs[:, 1]) + outline.discs[:, 2]
    return float(max(corners.max(initial=0.0), discs.max(initial=0.0)))


def _write_motion(b: int, body: BodySpec, model: WorldModel) -> None:
    model.role[b] = ROBOT if body.role == "robot" else OBSTACLE
    model.drive[b] = getattr(body.kinematics, "drive", NO_DRIVE)
    model.wheelbase[b] = _wheelbase(body)
    model.initial_steering[b] = body.steering
    model.movable[b] = body.kinematics is not None and not body.static
    model.unobstructed[b] = body.unobstructed
    model.arrive_mode[b] = ARRIVE_MODES[body.arrive_mode]
    model.goal_threshold[:, b] = body.goal_threshold
    model.heading_low[b] = body.angle_range[0]
    model.wraps_heading[b] = True
    for values, target in (
        (body.vel_min, model.velocity_min),
        (body.vel_max, model.velocity_max),
        (body.acce, model.acceleration_limit),
    ):
        target[:, b, : len(values)] = values
    model.initial_velocity[b, : len(body.velocity)] = body.velocity
    if body.state is not None:
        model.start[:, b] = body.state[:3]


def _wheelbase(body: BodySpec) -> float:
    """Return the axle distance [m] that the drive gives, else the shape; NaN without one, as 0 is."""
    given = (getattr(body.kinematics, "wheelbase", None), getattr(body.shape, "wheelbase", None))
    return next((float(value) for value in given if value), np.nan)


@dataclass(frozen=True)
class _GoalPlan:
    """What happens to a body's goals, and how much room they need.

    Attributes:
        renewal: ``KEEP_GOAL``, ``WANDER`` or ``LOOP``.
        count: Goals of a round; one that loops between a single goal and its start has two.
        placed: Its distribution gives the goal.
    """

    renewal: int
    count: int
    placed: bool

    @property
    def rows(self) -> int:
        """Rows of ``waypoints``: one is there for bodies without a goal too, and for those that are drawn."""
        return max(self.count, 1)


def _plan_goals(body: BodySpec, scenario: Scenario, *, is_agent: bool) -> _GoalPlan:
    """Return what happens to a body's goals.

    An agent's behaviour is overridden, so it does not loop, and wanders only where it has no other goal.
    """
    placed: bool = scenario.placements[body.entry].kind.gives_goal
    wanders = body.wanders and not (is_agent and (placed or body.goal))
    loops = bool(getattr(body.renewal, "loop", False)) and not wanders and not is_agent
    count = 1 if placed else len(body.goal)
    renewal = WANDER if wanders else LOOP if loops else KEEP_GOAL
    return _GoalPlan(renewal, 2 if loops and count == 1 else count, placed)


def _write_goals(b: int, body: BodySpec, plan: _GoalPlan, model: WorldModel) -> None:
    """Write goals, and who has any: what can move and was given some, by its entry or by its distribution."""
    if plan.renewal == WANDER:
        model.wander_low[b], model.wander_high[b] = body.renewal.range_low, body.renewal.range_high
    model.waypoints[:, b, :, 2] = np.nan
    given = np.array(body.goal[: plan.rows]).reshape(-1, 3)
    model.waypoints[:, b, : len(given)] = given
    model.has_goal[b] = bool(model.movable[b]) and (plan.renewal == WANDER or plan.placed or len(body.goal) > 0)
    model.goal_renewal[b] = plan.renewal
    model.waypoint_count[:, b] = plan.count
