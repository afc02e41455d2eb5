"""Ways on the seen map that keep a distance from obstacles."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from task_tools import play

from irsim_gym.errors import ScenarioError
from irsim_gym.simulator.cell_paths.cell_lines import free_cell
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.observations.seen_map.seen_ways import find_way

WALL: list[dict[str, Any]] = [
    {"shape": {"name": "linestring", "vertices": [[4, 2], [4, 4.75]]}},
    {"shape": {"name": "linestring", "vertices": [[4, 5.25], [4, 8]]}},
]
"""A wall with a gap of 0.5 m between the robot (radius 0.2 m) and its goal 6 m ahead."""


def before_the_wall(clearance: float | None, radius: float = 0.2, wall: Any = None) -> Episodes:
    way = {"name": "way_on_seen_map", "cell": 0.1} | ({} if clearance is None else {"clearance": clearance})
    shape = {"name": "circle", "radius": radius}
    return play({"shape": shape}, WALL if wall is None else wall, {"name": "blank", "observations": [way]})


def way(episodes: Episodes) -> tuple[float, float]:
    """Return angle [rad] and length [m] of the way."""
    cosine, sine, length = episodes.view.observation[0, 0].tolist()
    return float(np.arctan2(sine, cosine)), length * float(np.hypot(10, 10))


@pytest.mark.parametrize("clearance", [None, 0.0, 0.02])
def test_a_way_leads_through_a_gap_that_leaves_the_clearance(clearance: float | None) -> None:
    angle, length = way(before_the_wall(clearance))
    assert angle == pytest.approx(0.0, abs=0.1)
    assert 5.9 < length < 6.3


def test_a_way_leads_around_a_gap_that_does_not() -> None:
    angle, length = way(before_the_wall(0.2))
    assert abs(angle) > 0.8
    assert length > 2 * np.hypot(2, 3)  # to one of the wall's ends, and from there to the goal, is not shorter


def test_cells_are_those_of_a_body_as_much_larger() -> None:
    levels = [
        episodes.terms["observations"][0].arrays.levels
        for episodes in (before_the_wall(0.05), before_the_wall(0.0, radius=0.25), before_the_wall(0.0))
    ]
    np.testing.assert_array_equal(levels[0], levels[1])
    assert (levels[0] != levels[2]).any()


def test_without_a_way_that_leaves_the_clearance_the_goal_itself_is_shown() -> None:
    closed = [{"shape": {"name": "linestring", "vertices": [[4, 0], [4, 4.75]]}}]
    closed.append({"shape": {"name": "linestring", "vertices": [[4, 5.25], [4, 10]]}})
    assert way(before_the_wall(0.02, wall=closed))[1] < 6.3
    assert way(before_the_wall(0.2, wall=closed)) == pytest.approx((0.0, np.hypot(10, 10)), abs=1e-5)


def test_a_clearance_is_not_negative() -> None:
    with pytest.raises(ScenarioError, match=r"clearance: must be >= 0"):
        before_the_wall(-0.1)


@pytest.mark.parametrize("task", ["level", "goal", "moved away"])
def test_costs_of_ways_are_those_that_are_computed_anew(task: str) -> None:
    """Costs are kept while neither the goal, nor the level, nor an obstacle that is gone makes other ways shorter."""
    walls = {"number": 5, "shape": {"name": "rectangle", "length": 2.5, "width": 0.3}}
    walls["distribution"] = {"name": "random", "range_low": [3, 1, -3], "range_high": [7, 9, 3]}
    people = {"number": 5, "kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.4}}
    people |= {"behavior": {"name": "dash", "wander": True}, "distribution": {"name": "random"}, "vel_max": [1, 3]}
    way = {"name": "way_on_seen_map", "cell": 0.2, "every": 1}
    obstacles = [people] if task == "moved away" else [walls]
    episodes = play({"shape": {"name": "circle", "radius": 0.2}}, obstacles, {"name": "blank", "observations": [way]})
    differ, rng = 0, np.random.default_rng(0)
    for step in range(60):
        if task == "level" and step % 6 == 5:
            episodes.begin(np.array([0]), np.array([step]))
        elif task == "goal":
            episodes.simulation.state.goal[0, 0, 1] = 2.0 + step % 7
            episodes.step(rng.uniform(-1, 1, (1, 1, 2)))
        else:
            episodes.step(rng.uniform(-1, 1, (1, 1, 2)))
        kept, fresh = costs_here(episodes)
        assert kept == fresh
        differ += kept > 0
    assert differ > 20


def costs_here(episodes: Episodes) -> tuple[int, int]:
    """Return the costs of the robot's way, as they are kept and computed anew; 0 without a way."""
    ways, state = episodes.terms["observations"][0].arrays, episodes.simulation.state
    here, goal = (tuple(place[0, 0, :2]) for place in (state.pose, state.goal))
    start, costs = free_cell(ways.seen.grid, ways.levels[0, 0], here), []
    least, target = ways.least.copy(), ways.target.copy()
    for first in (target[0, 0].copy(), np.nan):
        ways.target[0, 0] = first
        found = find_way(ways, 0, 0, 0, here, goal)
        costs.append(int(ways.least[0, 0].reshape(-1)[start]) if found else 0)
    ways.least[:], ways.target[:] = least, target
    return costs[0], costs[1]
