"""Ways on the seen map that keep a distance from obstacles."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from task_tools import play

from irsim_gym.errors import ScenarioError
from irsim_gym.tasks import Episodes

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
