"""Checks that each level has a path to the goal, for agents whose placement does not guarantee one."""

from dataclasses import dataclass

import numpy as np

from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.paths.clearance import Obstacles, mark_standing
from irsim_gym.simulator.paths.grid import Grid
from irsim_gym.simulator.paths.regions import WayTables, of_slot, way_exists, way_tables
from irsim_gym.simulator.world.model import KEEP_GOAL, UNOBSTRUCTED, Model
from irsim_gym.simulator.world.names import Cells, Flags, Ints, Shard, State, Struct, kernel, row_of

CELL_PER_REACH = 0.5


@dataclass(repr=False)
class ReachabilityCheck(Struct):
    """Agents whose paths are checked when a level is drawn, and the grid for the search.

    Attributes:
        agents: Bodies, shape ``(n,)``.
        blocks: Scratch, shape ``(n_slots, body)``.
        tables: The grid and its memory, see ``simulator.paths.regions``.
    """

    agents: Ints
    blocks: Flags
    tables: WayTables


def reachability_check(scenario: Scenario, model: Model, agents: tuple[int, ...], n_slots: int) -> ReachabilityCheck:
    """Return the check for round agents, if levels differ and their placement does not guarantee a path."""
    varied = [spec.kind.is_random for spec in scenario.placements]
    stands = [bool(model.stands[list(spec.members)].any()) for spec in scenario.placements]
    # Only where walls, or the agent's own place, differ between levels is there anything to check.
    walls_vary = any(random and standing for random, standing in zip(varied, stands, strict=True))
    walls_vary = walls_vary or (scenario.occupied is not None and scenario.bodies[-1].shape.is_random)
    guarded = []
    for b in agents:
        spec = scenario.placements[scenario.bodies[b].entry]
        is_round = model.disc_count[0, b] == 1 and model.segment_count[0, b] == 0
        if model.has_goal[b] and is_round and (walls_vary or spec.kind.is_random) and not spec.kind.ensures_way:
            guarded.append(b)
    if model.collision_mode[0] == UNOBSTRUCTED:
        guarded = []
    guarded = [b for b in guarded if not model.unobstructed[b]]
    reach = min((float(model.reach[0, b]) for b in guarded), default=np.inf)
    x0, y0, x1, y1 = (float(value) for value in model.bounds)
    # Cells are half as wide as the smallest agent's reach; without an agent to check, one cell saves memory.
    grid = Grid.over(model.bounds, CELL_PER_REACH * reach if guarded else max(x1 - x0, y1 - y0))
    return ReachabilityCheck(
        agents=np.array(guarded, np.int64),
        blocks=np.zeros((n_slots, len(model.role)), np.bool_),
        tables=way_tables(grid, n_slots, len(model.role)),
    )


def check(ways: ReachabilityCheck, model: Model, state: State, shard: Shard, failed: Ints) -> None:
    """Set ``failed`` to body + 1 in worlds in which an agent has no path from its start through its goals."""
    if not len(ways.agents):
        return
    tables = of_slot(ways.tables, shard.slot)
    check_ways(shard.worlds, shard.slot, ways, tables, model.cells, model, state, failed)


@kernel
def check_ways(
    worlds: Ints,
    slot: int,
    ways: ReachabilityCheck,
    tables: WayTables,
    cells: Cells,
    model: Model,
    state: State,
    failed: Ints,
) -> None:
    """Search for a path past all standing bodies, from the start to the first goal and from each goal to the next.

    Reads: ways (agents, blocks), model (goal_renewal, present, reach, stands, unobstructed, waypoint_count, waypoints),
        state (pose).
    Writes: ways (blocks), tables, failed.
    """
    blocks = ways.blocks[slot]
    for w in worlds:
        for agent in ways.agents:
            if failed[w] > 0 or model.goal_renewal[agent] != KEEP_GOAL:
                continue
            mark_standing(model, w, agent, blocks)
            obstacles = Obstacles(model, state, w, blocks, cells, None)
            radius = model.reach[row_of(model.reach, w), agent]
            start = (state.pose[w, agent, 0], state.pose[w, agent, 1])
            for g in range(model.waypoint_count[w, agent]):
                goal = (model.waypoints[w, agent, g, 0], model.waypoints[w, agent, g, 1])
                if not way_exists(obstacles, radius, start, goal, tables):
                    failed[w] = agent + 1
                    break
                start = goal
