"""The scenarios that are played with bounds checks, by name: shipped, documented, compared with ir-sim, and random."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import yaml
from cases import all_cases, case_of
from documented import EXAMPLES
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st
from random_scenarios import cases
from test_every_feature import EVERYTHING
from test_every_key import TEXT

from irsim_gym.errors import ScenarioError
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.specs.library import scenario_names
from irsim_gym.simulator.engine import compile

DRAWN = {"min_distance": 0.2, "range_low": [0.6, 0.6, -3], "range_high": [9.4, 9.4, 3]}
FAST = {"kinematics": {"name": "diff"}, "vel_max": [3, 3], "vel_min": [-3, -3]}
SCANNER = [{"name": "lidar2d", "number": 20, "angle_range": 2 * math.pi, "range_max": 4, "has_velocity": True}]
SHORT = {"width": 6, "height": 6, "step_time": 0.5, "collision_mode": "unobstructed"}
LEFT = [{"name": "left_world", "use": False}]
GOES_ON = {"name": "navigation", "endings": LEFT, "rewards": LEFT}
AWAY = ((0, 99, 2), (1.57, 2, 99), (3.14, -99, 2), (-1.57, 2, -99))


def leaving(place: float, ways: Sequence[str]) -> list[dict[str, Any]]:
    """Return robots that drive off to all four sides, for each way of driving."""
    return [
        {**FAST, "state": [place, place, angle], "goal": [x, y], "behavior": {"name": way}, "sensors": SCANNER}
        for way in ways
        for angle, x, y in AWAY
    ]


def crowd(key: str, way: str) -> dict[str, Any]:
    """Return so many bodies that they are found by squares, which some of them drive out of."""
    disc = {**FAST, "shape": {"name": "circle", "radius": 0.1}, key: {"name": way}}
    far = {**disc, "number": 4, "distribution": {"name": "circle", "radius": 60}}
    inside = {**disc, "number": 60, "distribution": {"name": "circle", "radius": 4}}
    return {"world": {**SHORT, "width": 20, "height": 20}, "robot": far, "obstacle": inside}


MAPS_BY_LEVEL: tuple[dict[str, Any], ...] = (
    {"name": "cells"},
    {"name": "rooms", "resolution": 0.5, "least_side": 1, "loops": 1, "border": False},
    {"name": "maze", "loops": 0.5, "border": False},
    {"name": "cellular", "resolution": 0.5, "disc_radius": 0.25, "border": False},
    {"name": "shelves", "resolution": 0.5, "shelf": [1, 0.5], "aisle": 0.5},
)


def map_by_level(obstacle_map: dict[str, Any]) -> dict[str, Any]:
    """Return robots in the cells of a map that each level draws, one with a way of limited length."""
    disc = {**FAST, "shape": {"name": "circle", "radius": 0.1}, "behavior": {"name": "dash"}, "sensors": SCANNER}
    there = {**disc, "distribution": {"name": "cells", "max_way_length": 5, "goals": 2}}
    anywhere = {**disc, "behavior": {"name": "rvo"}, "distribution": {"name": "random", "reachable": True}}
    return {"world": {**SHORT, "obstacle_map": obstacle_map, "fog_map": True}, "robot": [there, anywhere]}


MASS = {"mass": 1, "friction": 0.1, "velocity": [1, 0.5, 2]}


def pushing(obstacle_map: dict[str, Any]) -> dict[str, Any]:
    """Return a scenario with many bodies of all shapes that push each other."""
    parts = [{"name": "rectangle", "length": 0.2, "width": 0.6}, {"name": "rectangle", "length": 0.6, "width": 0.2}]
    corner = [[0, 0], [0.6, 0], [0.6, 0.2], [0.2, 0.2], [0.2, 0.6], [0, 0.6]]
    shapes = [
        *({"name": name, "random_shape": True} for name in ("circle", "rectangle", "linestring")),
        {"name": "polygon", "random_shape": True, "is_convex": True, "avg_radius_range": [0.2, 0.3]},
        {"name": "compound", "parts": parts},
        {"name": "polygon", "vertices": corner},
    ]
    return {
        "world": {**SHORT, "collision_mode": "contact", "restitution": 0.5, "obstacle_map": obstacle_map},
        "robot": {**leaving(3, ["dash"])[0], "sensors": [{"name": "contact2d"}]},
        "obstacle": [{**MASS, "shape": one, "state": [1 + k, 3]} for k, one in enumerate(shapes)],
        "task": GOES_ON,
    }


PERLIN = {"name": "perlin", "resolution": 1, "fill": 0.1, "seed": 2}
ONE_BEAM = [{"name": "lidar2d", "number": 1}]
LOOP = {"name": "dash", "loop": True}
PATIENT = {"name": "dash", "wander": True, "wander_goals": {"patience": 1}}
BY_HAND: dict[str, dict[str, Any]] = {
    "loop between what is drawn": {
        "robot": {**FAST, "number": 2, "distribution": {"name": "circle"}, "behavior": LOOP}
    },
    "everybody leaves the world": {"world": SHORT, "robot": leaving(3, ["dash"]), "task": GOES_ON},
    "everybody leaves the map": {
        "world": {**SHORT, "obstacle_map": PERLIN, "fog_map": True},
        "robot": leaving(3, ["dash", "rvo", "sfm"]),
        "task": GOES_ON,
    },
    "everybody leaves a map of discs": {
        "world": {**SHORT, "obstacle_map": {**PERLIN, "disc_radius": 0.5}},
        "robot": [*leaving(3, ["rvo", "sfm"]), crowd("group_behavior", "orca")["robot"]],
        "task": GOES_ON,
    },
    "pursuit leaves the map": {
        "world": {**SHORT, "obstacle_map": PERLIN},
        "robot": [
            *leaving(3, ["pursuit"])[:1],
            {**leaving(3, ["pursuit"])[2], "behavior": {"name": "pursuit", "known": "seen", "cell": 0.5}},
        ],
        "task": GOES_ON,
    },
    **{f"map by level: {one['name']}": map_by_level(one) for one in MAPS_BY_LEVEL},
    "tracks of bodies that pass": {
        "world": SHORT,
        "robot": leaving(3, ["dash"]),
        "task": {"name": "blank", "max_steps": 9, "observations": ["tracks", {"name": "time_to_tracks", "speeds": 2}]},
    },
    "scanner of one beam": {"robot": {**FAST, "state": [1, 1], "goal": [3, 3], "sensors": ONE_BEAM}},
    "contacts within a step": {
        "world": {**SHORT, "collision_mode": "stop", "collision_check": "swept", "obstacle_map": PERLIN},
        "robot": leaving(3, ["dash"]),
        "obstacle": [
            {**FAST, "number": 2, "distribution": {"name": "random"}, "behavior": PATIENT, "shape": shape}
            for shape in ({"name": "rectangle", "length": 0.5, "width": 0.2}, {"name": "circle", "radius": 0.1})
        ],
        "task": GOES_ON,
    },
    "bodies that push": pushing({"name": "perlin", "resolution": 1, "fill": 0.1, "seed": 2}),
    "bodies that push, on a map of discs by level": pushing({"name": "cells", "fill": [0.05, 0.1], "disc_radius": 0.3}),
    "bodies that coast": {"obstacle": {**MASS, "number": 3, "distribution": {"name": "random"}}},
    "crowd that dashes": crowd("behavior", "dash"),
    "crowd that avoids": crowd("behavior", "rvo"),
    "crowd of forces": crowd("behavior", "sfm"),
    "crowd that plans": crowd("group_behavior", "orca"),
    "crowd of groups": crowd("group_behavior", "sfm"),
}


@st.composite
def drawn_levels(draw: Any) -> dict[str, Any]:
    """A random scenario whose entries have several bodies, at places that are drawn for each level."""
    case: dict[str, Any] = draw(cases())
    for role in ("robot", "obstacle"):
        for body in case[role]:
            if isinstance(body["state"][0], list) or draw(st.integers(0, 3)) == 0:
                continue
            body["number"] = draw(st.integers(1, 3))
            name = draw(st.sampled_from(["random", "random", "circle"]))
            body["distribution"] = {"name": name, **(DRAWN if name == "random" else {})}
            for key in ("state", "goal"):
                body.pop(key, None)
            if role == "obstacle" and draw(st.booleans()):
                body["number_range"] = [0, body.pop("number")]
                body["shape"] = {
                    "name": draw(st.sampled_from(["circle", "polygon", "linestring"])),
                    "random_shape": True,
                }
    case["world"] |= {"width": 10, "height": 10, "update": draw(st.sampled_from(["sequential", "simultaneous"]))}
    case["world"]["fog_map"] = draw(st.integers(0, 3)) == 0
    return case


def random_scenarios(sort: str, number: int, count: int) -> dict[str, Any]:
    """Return random scenarios that can be played, by name; always the same ones.

    Args:
        sort: ``random`` for those of tests/parity, ``drawn`` for those whose levels differ.
        number: Which ones: the seed.
        count: How many.
    """
    found: dict[str, Any] = {}

    @seed(number)
    @settings(
        max_examples=3 * count,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given({"random": cases, "drawn": drawn_levels}[sort]())
    def collect(case: dict[str, Any]) -> None:
        scenario = without_plan(case)
        if len(found) < count and is_playable(scenario):
            found[f"{sort} {number}.{len(found)}"] = scenario

    collect()
    return found


def is_playable(data: Mapping[str, Any]) -> bool:
    """Return whether a scenario can be read, and no robot begins within an obstacle."""
    try:
        compile(load_scenario(data, warn=False))
    except ScenarioError:
        return False
    return True


def without_plan(case: Mapping[str, Any]) -> dict[str, Any]:
    """Return the scenario of a case of tests/parity; letters of a map are cells."""
    scenario = {key: value for key, value in case.items() if key != "parity"}
    rows = (case.get("parity") or {}).get("map")
    if rows:
        columns = [[letter in "#+" for letter in column] for column in zip(*reversed(rows), strict=True)]
        scenario["world"] = {**(case.get("world") or {}), "obstacle_map": columns}
    return scenario


def listed() -> dict[str, Any]:
    """Return all scenarios but the random ones, by name, as ``load_scenario`` takes them."""
    every: dict[str, Any] = {f"shipped {name}": name for name in scenario_names()}
    every |= {f"documented {name}": yaml.safe_load(text) for name, text in EXAMPLES.items()}
    every |= {"every feature": yaml.safe_load(EVERYTHING), "every key": yaml.safe_load(TEXT)}
    every |= {f"parity {name}": without_plan(case_of(name)) for name in all_cases()}
    return every | BY_HAND
