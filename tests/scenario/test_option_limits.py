"""Limits and defaults of options: the last value that is accepted, and the first one beyond that is refused."""

from __future__ import annotations

import re
from typing import Any

import pytest
from pydantic import ValidationError

from irsim_gym.bodies.behaviors.local_planners.dwa import Dwa
from irsim_gym.bodies.behaviors.pursuit.pursuit import Pursuit
from irsim_gym.bodies.maps.cells import RandomCells
from irsim_gym.bodies.maps.cellular import CellularMap
from irsim_gym.bodies.maps.maze import MazeMap
from irsim_gym.bodies.maps.rooms import RoomsMap
from irsim_gym.bodies.maps.shelves import ShelvesMap
from irsim_gym.bodies.placements.cells import CellPlacement
from irsim_gym.tasks.observations.bodies.time_to_collision import TimeToCollision
from irsim_gym.tasks.observations.seen_map.way_on_seen_map import WayOnSeenMap
from irsim_gym.tasks.observations.seen_map.yielding_way import YieldingWay

KINDS: dict[type[Any], str] = {
    Dwa: """
        sim_time 1.5 > 0 <= 60; sim_granularity 0.1 > 0; free_time None >= 0; escape_speed 0.0 <= 0;
        min_turn_rate 0.5 >= 0; oscillation_distance 0.25 >= 0; obstacle_weight 0.002 >= 0; path_clearance 0.1 >= 0;
        memory 60.0 > 0; spacing 0.02 >= 0; obstacle_range 2.5 > 0; inflation_radius 0.5 >= 0; cost_scaling 5.0 >= 0;
        path_weight 0.5 >= 0; goal_weight 1.0 >= 0; lookahead 4.0 > 0; forward_point 0.3 >= 0;
        footprint_padding 0.02 >= 0; min_speed 0.0; samples (7, 21)
    """,
    Pursuit: """
        clearance 0.1 >= 0; cell None > 0; speed None > 0; lookahead_time 0.6 >= 0; lookahead_min 0.3 > 0;
        lookahead_max None > 0; min_radius 0.5 >= 0; proximity 0.1 >= 0; proximity_gain 1.0 > 0 <= 1;
        min_speed 0.25 >= 0; approach 0.6 >= 0; approach_speed 0.05 >= 0; turn_angle 0.785 > 0
    """,
    RandomCells: "resolution 1.0 > 0; disc_radius None > 0; border True; fill (0.0, 0.6)",
    CellularMap: "fill_from 5 >= 1 <= 9; clear_to 3 >= -1 <= 8; fill (0.4, 0.48); rounds (4, 4)",
    MazeMap: "corridor 1.0 > 0; loops 0.1 >= 0 <= 1",
    RoomsMap: "least_side 2.0 > 0; loops 0.0 >= 0 <= 1; number (4, 9); door (1.0, 1.0)",
    ShelvesMap: "aisle 1.5 > 0; shelf (3.0, 1.0); missing (0.0, 0.3); turn True",
    CellPlacement: "min_way_length 0.0 >= 0; max_way_length None > 0; goals 1 >= 1",
    TimeToCollision: """
        directions 32 >= 1 <= 1024; speeds 1 >= 1 <= 16; speed None > 0; horizon 5.0 > 0; range None > 0; moving False;
        margin 0.0 >= 0
    """,
    WayOnSeenMap: "cell None > 0; every 4 >= 1; clearance 0.0 >= 0",
    YieldingWay: "cell None > 0; every 4 >= 1; ahead 4.0 > 0; width 0.8 > 0",
}
CASES = [(kind, text.strip()) for kind, options in KINDS.items() for text in options.split(";")]


@pytest.mark.parametrize(("kind", "text"), CASES, ids=[f"{kind.__name__} {text.split()[0]}" for kind, text in CASES])
def test_limits_and_defaults(kind: type[Any], text: str) -> None:
    name, rest = text.split(maxsplit=1)
    default, *_ = re.split(r" [<>]=? ", rest)
    assert repr(getattr(kind(), name)) == default
    whole = default.lstrip("-").isdigit()
    step = 1 if whole else 0.001
    for sign, number in re.findall(r"([<>]=?) (\S+)", rest):
        limit, outside = (int(number) if whole else float(number)), -step if sign[0] == ">" else step
        accepted, refused = (limit, limit + outside) if sign.endswith("=") else (limit - outside, limit)
        assert getattr(kind(**{name: accepted}), name) == accepted
        with pytest.raises(ValidationError, match=name):
            kind(**{name: refused})


def test_what_no_goal_needs_is_said() -> None:
    """A goal is needed by what observes the way to it, and by nothing else of these."""
    assert (TimeToCollision.needs_goal, WayOnSeenMap.needs_goal, YieldingWay.needs_goal) == (False, True, True)
