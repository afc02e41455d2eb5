"""What a level asks of a robot, against hand calculations and an independent search."""

from __future__ import annotations

import heapq
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.evaluation.measures.certificate_measures import least_steps, measure_level
from irsim_gym.simulator.engine import Simulation

pytestmark = pytest.mark.filterwarnings("ignore:seldom meant:irsim_gym.errors.ScenarioWarning")
DISC = {"name": "circle", "radius": 0.2}
WALL = {"name": "linestring"}


def begun(robot: dict[str, Any], *obstacles: dict[str, Any]) -> Simulation:
    """Return a world of 10 x 10 m, with steps of 0.5 s, at its beginning."""
    drive = {"kinematics": {"name": "diff"}, "shape": DISC, "state": [1, 5, 0], "goal": [9, 5], **robot}
    scenario = {"world": {"step_time": 0.5}, "robot": drive, "obstacle": list(obstacles)}
    simulation = ig.compile(ig.load_scenario(scenario), 1, agents=(0,))
    simulation.reset(seed=0)
    return simulation


def measured(simulation: Simulation, **options: Any) -> Any:
    return measure_level(simulation.model, simulation.state, 0, 0, **options)


def test_a_gate_in_a_wall() -> None:
    """The straight way leads through the lower gate, 0.6 m wide; the upper one, 1.4 m wide, is the widest way."""
    walls = ([5, -1], [5, 4.7]), ([5, 5.3], [5, 7.8]), ([5, 9.2], [5, 11])
    found = measured(begun({}, *({"shape": {**WALL, "vertices": list(wall)}} for wall in walls)))
    assert found.reachable
    assert found.length == found.straight == 8.0
    assert found.clearance == pytest.approx(0.7 - 0.2, abs=0.03)
    assert found.clearance <= 0.5


def test_ends_bound_the_clearance() -> None:
    """The start is 0.45 m from the wall behind it, and nothing else is as near."""
    found = measured(begun({"state": [1, 5, 0]}, {"shape": {**WALL, "vertices": [[0.55, 0], [0.55, 10]]}}))
    assert found.clearance == pytest.approx(0.45 - 0.2, abs=1e-3)


def test_no_way() -> None:
    found = measured(begun({}, {"shape": {**WALL, "vertices": [[5, -1], [5, 11]]}}))
    assert not found.reachable
    assert found.length == found.least_time == math.inf
    assert math.isnan(found.clearance)


@pytest.mark.parametrize(
    ("robot", "legs", "steps"),
    [
        # Threshold 0.1 m, 1 m/s, steps of 0.5 s: 7.9 m are 15.8 steps.
        ({"goal_threshold": 0.1, "vel_max": [1, 1]}, [8.0], 16),
        # 0.25, 0.5, 0.75 and 1 m/s, so 1.25 m in four steps, then 6.65 m in 13.3 steps.
        ({"goal_threshold": 0.1, "vel_max": [1, 1], "acce": [0.5, 1]}, [8.0], 18),
        # 0.125 n (n + 1) / 2 m in n steps: 0.375 m in two, 0.75 m in three.
        ({"goal_threshold": 0.1, "vel_max": [9, 1], "acce": [0.5, 1]}, [0.475], 2),
        ({"goal_threshold": 0.1, "vel_max": [9, 1], "acce": [0.5, 1]}, [0.476], 3),
        # Reverse is faster; goals are left at their thresholds too: 7.9 + 3.8 m at 2 m/s are 11.7 steps.
        ({"goal_threshold": 0.1, "vel_max": [1, 1], "vel_min": [-2, -1]}, [8.0, 4.0], 12),
        # Both axes together: 5 m/s.
        ({"goal_threshold": 0.5, "kinematics": {"name": "omni"}, "vel_max": [3, 4]}, [8.0], 3),
        ({"goal_threshold": 9.0}, [8.0], 1),
        ({"vel_max": [0, 1], "vel_min": [0, -1]}, [8.0], math.inf),
    ],
)
def test_least_steps(robot: dict[str, Any], legs: list[float], steps: float) -> None:
    simulation = begun(robot)
    assert least_steps(simulation.model, simulation.state, 0, 0, legs) == steps


def test_least_steps_of_a_world_are_by_its_own_limits() -> None:
    simulation = begun({"goal_threshold": 0.1})
    model = replace(
        simulation.model,
        velocity_max=np.concatenate([simulation.model.velocity_max, 2.0 * simulation.model.velocity_max]),
        velocity_min=np.concatenate([simulation.model.velocity_min, 2.0 * simulation.model.velocity_min]),
    )
    state = simulation.state
    two = replace(state, velocity=np.concatenate([state.velocity, state.velocity]))
    assert [least_steps(model, two, world, 0, [8.1]) for world in (0, 1)] == [16, 8]


def test_all_goals_in_turn_count() -> None:
    found = measured(begun({"goal": [[9, 5], [9, 1], [5, 1]], "goal_threshold": 0.1}))
    assert found.length == pytest.approx(16.0)
    assert found.least_time == math.ceil((7.9 + 3.8 + 3.8) / 0.5) * 0.5
    assert found.clearance == math.inf


def bottleneck(simulation: Simulation, cell: float) -> float:
    """Return the widest way's least clearance over cells, by a best-first search with shapely's distances."""
    import shapely

    world = simulation.scenario.world
    shapes = []
    state, model = simulation.state, simulation.model
    for b in range(1, len(model.role)):
        if not model.present[0, b]:
            continue
        rows = state.segments[0, model.segment_start[b] :][: model.segment_count[0, b]]
        discs = state.discs[0, model.disc_start[b] :][: model.disc_count[0, b]]
        shapes += [shapely.Point(x, y).buffer(r, quad_segs=64) for x, y, r in discs]
        if len(rows):
            line = [*rows[:, :2], rows[-1, 2:]]
            shapes.append(shapely.Polygon(line) if model.solid[b] else shapely.LineString(line))
    union = shapely.union_all(shapes)
    shapely.prepare(union)
    n = round(world.width / cell)
    ends = [tuple((place / cell).astype(int)) for place in (state.pose[0, 0, :2], state.goal[0, 0, :2])]
    x, y = np.meshgrid((np.arange(n) + 0.5) * cell, (np.arange(n) + 0.5) * cell, indexing="ij")
    room = shapely.distance(union, shapely.points(x, y))
    heap, known = [(-room[ends[0]], ends[0])], np.zeros((n, n), bool)
    while heap:
        width, (i, j) = heapq.heappop(heap)
        if (i, j) == ends[1]:
            return -width - 0.2
        for p in range(max(i - 1, 0), min(i + 2, n)):
            for q in range(max(j - 1, 0), min(j + 2, n)):
                if not known[p, q]:
                    known[p, q] = True
                    heapq.heappush(heap, (max(width, -room[p, q]), (p, q)))
    return -math.inf


def test_the_widest_way_of_drawn_levels() -> None:
    """Clearances are within the cells' size of those of another search; the length is bounded by other facts."""
    simulation = ig.compile(ig.load_scenario("dense_room"), 1, agents=(0,))
    for level in range(4):
        simulation.reset(seed=level)
        found = measured(simulation)
        assert found.reachable
        assert found.clearance == pytest.approx(bottleneck(simulation, 0.05), abs=0.06)
        assert found.length >= found.straight
        assert found.least_time >= (found.straight - 0.3) / 1.0
