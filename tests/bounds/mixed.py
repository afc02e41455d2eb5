"""Random scenarios with a random task each, all features and options mixed."""

from __future__ import annotations

import math
import types
from collections.abc import Iterable
from random import Random
from typing import Any, Literal, Union, get_args, get_origin

from random_scenarios import ARROW, DRIVES, HOOK, PI, TRIANGLE

from irsim_gym.base import families
from irsim_gym.base.options import option_fields

families.load()
LEFT_OUT = frozenset({"recorded", "image", "array", "ros"})
"""Kinds that need a file or a list of cells."""
CONFLICTING = frozenset(
    {"lookahead_max", "lateral", "clear_to", "fill_from", "range_min", "alpha", "seed", "radius", "center"}
)
"""Options whose values depend on others."""
FACTORS = (0.0, 0.25, 0.5, 2.0, 4.0)
MOST = 24
"""Most of what options count: more takes longer and shows nothing else."""


def some_options(rng: Random, family: Any, name: str, share: float = 0.3) -> dict[str, Any]:
    """Return a kind with random values for some of its options, drawn by their declarations."""
    found: dict[str, Any] = {"name": name}
    fields = option_fields(family.entry(name).kind)
    for key, field in fields.items():
        if field.is_required() and key == "resolution":
            found[key] = 0.5
        elif rng.random() < share and not field.is_required() and key not in CONFLICTING:
            value = some_value(rng, field)
            if value is not None:
                found[key] = value
    if "near" in found or "zero" in found:  # their product is bounded
        found["zero"] = rng.choice((0.0, 0.3, 0.5)) / found.get("near", 0.5) if "code" in fields else 0.0
        found = found if "zero" in fields else {key: value for key, value in found.items() if key != "zero"}
    return found


def some_value(rng: Random, field: Any) -> Any:
    """Return a value that an option may have; None for one that is neither a number nor a choice."""
    hint, default = field.annotation, field.default
    if get_origin(hint) is Literal:
        return rng.choice(get_args(hint))
    if hint is bool:
        return rng.random() < 0.5
    if isinstance(default, tuple) and default and all(isinstance(value, int | float) for value in default):
        factor = rng.choice((0.5, 1.0, 1.5))
        return [max(1, round(factor * value)) if type(value) is int else factor * value for value in default]
    inner = set(get_args(hint)) if get_origin(hint) in (Union, types.UnionType) else {hint}
    if int in inner:
        return round(within(field, min(rng.choice((1, 2, 5, default or 3)), MOST)))
    if float in inner:
        number = default * rng.choice(FACTORS) if default else rng.choice((0.1, 0.5, 2.0))
        return within(field, float(number))
    return None


def within(field: Any, value: float) -> float:
    """Return a number, moved into the bounds of an option."""
    for bound in field.metadata:
        value = max(value, getattr(bound, "ge", value))
        value = min(value, getattr(bound, "le", value), getattr(bound, "lt", value))
        value = value if value > getattr(bound, "gt", value - 1.0) else bound.gt + 0.1
    return value


def some_world(rng: Random) -> dict[str, Any]:
    """Return a world, a third of them with a map."""
    side = rng.choice((3, 6, 10, 10))
    world: dict[str, Any] = {
        "width": side,
        "height": side * rng.choice((0.6, 1.0, 1.0)),
        "step_time": rng.choice((0.1, 0.1, 0.2, 0.5, 1.0)),
        "collision_mode": rng.choice(("stop", "stop", "unobstructed", "unobstructed_obstacles")),
        "update": rng.choice(("sequential", "simultaneous")),
        "fog_map": rng.random() < 0.1,
    }
    if rng.random() < 0.35:
        name = rng.choice([name for name in families.MAPS.names() if name not in LEFT_OUT])
        world["obstacle_map"] = some_options(rng, families.MAPS, name)
        world["obstacle_map"]["resolution"] = rng.choice((0.4, 1.0)) if side > 3 else 0.25
        if "disc_radius" in world["obstacle_map"]:
            world["obstacle_map"]["disc_radius"] = 0.1
        if name == "shelves":
            world["obstacle_map"] |= {"shelf": [1.0, 0.5], "aisle": 0.5}
    if rng.random() < 0.15:
        world["offset"] = [-3.0, 7.5]
    return world


def some_body(rng: Random, role: str, world: dict[str, Any], sensors: list[dict[str, Any]]) -> dict[str, Any]:
    """Return an entry of one to three bodies."""
    body: dict[str, Any] = {"shape": some_shape(rng, may_vary=role == "obstacle")}
    if role == "robot" or rng.random() < 0.6:
        add_drive(rng, body)
    if role == "robot" and rng.random() < 0.8:
        body["sensors"] = sensors
    elif rng.random() < 0.2:
        body["sensors"] = [some_scanner(rng)]
    if "kinematics" in body:
        add_limits(rng, body)
        if role == "obstacle" or rng.random() < 0.7:
            add_behavior(rng, body, sensors)
    add_places(rng, body, world)
    if role == "obstacle" and rng.random() < 0.15:
        body["number_range"] = [rng.choice((0, 1)), max(body.pop("number", 1), 1)]
    if rng.random() < 0.1:
        body["fov"], body["fov_radius"] = 2.0, 3.0
    body["unobstructed"] = rng.random() < 0.1
    return body


def some_shape(rng: Random, *, may_vary: bool) -> dict[str, Any]:
    """Return a footprint, drawn by each level or fixed."""
    name = rng.choice(("circle", "circle", *families.FOOTPRINTS.names()))
    size = rng.choice((0.3, 0.5, 1.0))
    if may_vary and name != "compound" and rng.random() < 0.3:
        return {"name": name, "random_shape": True}
    if name == "circle":
        return {"name": name, "radius": 0.4 * size, "center": rng.choice(([0, 0], [0.2, -0.1]))}
    if name == "rectangle":
        return {"name": name, "length": size, "width": rng.choice((0.2, size))}
    if name == "compound":
        disc = {"name": "circle", "radius": 0.3 * size, "pose": [0.2, 0.1, 1.0]}
        return {"name": name, "parts": [disc, {"name": "rectangle", "length": size, "width": 0.2}]}
    outline = rng.choice((TRIANGLE, HOOK, ARROW))
    return {"name": name, "vertices": [[size * x, size * y] for x, y in outline]}


def some_scanner(rng: Random) -> dict[str, Any]:
    """Return a range sensor."""
    names = [entry.name for entry in families.SENSORS if entry.kind.reading == "ranges"]
    sensor = some_options(rng, families.SENSORS, rng.choice(names))
    sensor |= {"number": rng.choice((1, 2, 12, 40)), "offset": [rng.choice((0.0, 0.1)), 0.0, rng.choice((0.0, 1.0))]}
    return {key: value for key, value in sensor.items() if key not in ("color", "plot", "scan_time")}


def add_drive(rng: Random, body: dict[str, Any]) -> None:
    """Give an entry a drive."""
    drive = rng.choice(DRIVES)
    body["kinematics"] = some_options(rng, families.KINEMATICS, "omni" if drive == "body" else drive)
    if drive == "acker":
        body["kinematics"]["wheelbase"] = rng.choice((0.2, 0.5))


def add_limits(rng: Random, body: dict[str, Any]) -> None:
    """Give an entry limits of its velocity, traits that levels draw, and a first velocity."""
    size = 3 if body["kinematics"]["name"] == "omni_angular" else 2
    if rng.random() < 0.5:
        body["vel_max"] = [rng.choice((0.0, 0.3, 1.0, 2.5)) for _ in range(size)]
        body["vel_min"] = [rng.choice((-2.0, -0.5, 0.0, min(0.2, high))) for high in body["vel_max"]]
    if rng.random() < 0.3:
        body["acce"] = [rng.choice((0.5, 3.0, math.inf)) for _ in range(size)]
    if rng.random() < 0.2:
        body["velocity"] = [rng.choice((-1.0, 0.3)) for _ in range(size)]
    if rng.random() < 0.4:
        low = rng.choice((0.0, 0.2, 0.6))
        body["speed_range"] = [low, low + rng.choice((0.0, 0.5))]
    if rng.random() < 0.2:
        body["unyielding"] = rng.choice((0.5, 1.0))
    if rng.random() < 0.3:
        body["goal_threshold"], body["arrive_mode"] = rng.choice((0.1, 1.0)), rng.choice(("position", "state"))
    low = rng.choice((-PI, 0.0))
    body["angle_range"] = [low, low + 2 * PI]


def add_places(rng: Random, body: dict[str, Any], world: dict[str, Any]) -> None:
    """Say where the bodies of an entry start, and where those that move drive."""
    x, y = world.get("offset", (0.0, 0.0))
    width, height = world["width"], world["height"]

    def pose(n_axes: int = 3) -> list[float]:
        edge = rng.choice((0.1, 0.1, 0.1, -0.1))  # some start, or drive, outside of the world
        place = [x + width * rng.uniform(edge, 1 - edge), y + height * rng.uniform(edge, 1 - edge)]
        return [*place, rng.choice((0.0, PI, rng.uniform(-3, 3)))][:n_axes]

    has_map = "obstacle_map" in world
    if has_map or rng.random() < 0.6:
        body["number"] = rng.choice((1, 2, 3))
        name = rng.choice(("random", "random", "circle", *(("cells",) if has_map else ())))
        body["distribution"] = some_options(rng, families.PLACEMENTS, name, 0.2)
        if "kinematics" not in body or body.get("behavior", {}).get("wander"):
            body["distribution"].pop("goals", None)
        if "jitter" in body["distribution"]:
            body["distribution"]["jitter"] = 0.2
    else:
        body["state"] = pose()
        if "kinematics" in body:
            several = [[pose() for _ in range(rng.choice((2, 3)))]]
            body["goal"] = rng.choice((pose(2), pose(3), several))


def add_behavior(rng: Random, body: dict[str, Any], sensors: list[dict[str, Any]]) -> None:
    """Give an entry a behaviour that can command its drive, and sometimes wandering or a loop."""
    drive_name = body["kinematics"]["name"]
    drive = families.KINEMATICS.entry(drive_name).kind
    kinds = {name: families.BEHAVIORS.entry(name).kind for name in families.BEHAVIORS.names()}
    fit = [name for name, kind in kinds.items() if name not in LEFT_OUT and families.commands(kind, drive)]
    behavior = some_options(rng, families.BEHAVIORS, rng.choice(fit), share=0.15)
    behavior["wander"] = rng.random() < 0.3
    behavior["loop"] = not behavior["wander"] and rng.random() < 0.3
    if behavior["wander"] and rng.random() < 0.3:
        goals = {"radius": 2.0, "keep_first": rng.random() < 0.5, "interval": 0.5, "chance": 0.5}
        behavior["wander_goals"] = goals
    if "range_low" in behavior or "range_high" in behavior:
        behavior["range_low"], behavior["range_high"] = [0.5, 0.5, -3], [2.5, 2.5, 3]
    group = [name for name in families.GROUP_BEHAVIORS.names() if drive_name in ("diff", "omni")]
    if group and rng.random() < 0.2:
        body["group_behavior"] = some_options(rng, families.GROUP_BEHAVIORS, rng.choice(group), share=0.15)
        return
    body["behavior"] = behavior
    if getattr(kinds[behavior["name"]], "reads_scan", False) or behavior.get("known", behavior.get("path")) == "seen":
        body["sensors"] = body.get("sensors") or sensors


def fits_all(entry: Any) -> bool:
    """Return whether a kind of a task needs nothing of the scenario, such as bodies that push each other."""
    return not hasattr(entry.kind, "misfit")


def some_terms(rng: Random, family: Any, names: Iterable[str], share: float) -> list[dict[str, Any]]:
    """Return some terms with random options."""
    return [some_options(rng, family, name) for name in names if rng.random() < share]


def some_task(rng: Random, robots: list[dict[str, Any]]) -> dict[str, Any]:
    """Return a task of random terms."""
    has_sensors = all(body.get("sensors") for body in robots)
    seen = [entry for entry in families.OBSERVATIONS if has_sensors or "scan" not in entry.kind().needs]
    names = [entry.name for entry in seen if fits_all(entry)]
    endings = [entry.name for entry in families.ENDINGS if fits_all(entry) and rng.random() < 0.6]
    paid = {"deadlock": "deadlocked", "collision": "collided", "left_world": "left_world", "arrival": "arrived"}
    every = [entry.name for entry in families.REWARDS if fits_all(entry)]
    rewards = [name for name in every if paid.get(name, "") in ("", *endings)]
    action = rng.choice(("velocity", "velocity", "discrete"))
    return {
        "name": "blank",
        "audit": False,
        "max_steps": rng.choice((3, 8, 40)),
        "agents": rng.choice(("", "all")),
        "observation_form": rng.choice(("flat", "flat", "dict")),
        "ended": rng.choice(("stay", "vanish")),
        "team_reward": rng.choice((0.0, 0.5)),
        "action": some_options(rng, families.ACTIONS, action),
        "observations": some_terms(rng, families.OBSERVATIONS, names, 0.3) or ["velocity"],
        "rewards": some_terms(rng, families.REWARDS, rewards, 0.4),
        "endings": [some_options(rng, families.ENDINGS, name) for name in endings],
    }


def mixed(seed: int) -> dict[str, Any]:
    """Return a random scenario with a task, always the same one for a seed."""
    rng = Random(seed)
    world, sensors = some_world(rng), [some_scanner(rng)]
    robots = [some_body(rng, "robot", world, sensors) for _ in range(rng.choice((1, 1, 2)))]
    obstacles = [some_body(rng, "obstacle", world, sensors) for _ in range(rng.choice((0, 1, 2, 3)))]
    scenario = {"world": world, "robot": robots, "obstacle": obstacles}
    scenario["task"] = some_task(rng, robots)
    if rng.random() < 0.2:
        add_pushing(rng, scenario)
    return scenario


def add_pushing(rng: Random, scenario: dict[str, Any]) -> None:
    """Let bodies push each other, add some that can be pushed, and terms about them; no level draws an outline."""
    scenario["world"]["collision_mode"] = "contact"
    for body in scenario["obstacle"]:
        body["shape"] = {"name": "circle", "radius": 0.2} if "random_shape" in body["shape"] else body["shape"]
    shape = rng.choice(({"name": "circle", "radius": 0.2}, {"name": "rectangle", "length": 0.4, "width": 0.3}))
    place = {"name": "random", "min_distance": 0}
    box = {"shape": shape, "mass": rng.choice((0.2, 2.0)), "number": rng.choice((1, 3)), "distribution": place}
    scenario["obstacle"].append(box)
    for key, family in (("observations", families.OBSERVATIONS), ("rewards", families.REWARDS)):
        scenario["task"][key] += some_terms(rng, family, [e.name for e in family if not fits_all(e)], 0.7)
    scenario["task"]["endings"] += [{"name": "bodies_arrived"}] if rng.random() < 0.5 else []
