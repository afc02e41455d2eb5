"""Random valid scenarios, all features mixed, for hypothesis."""

from __future__ import annotations

import math
from typing import Any

from hypothesis import strategies as st

from irsim_gym.base import families

families.load()
PI = 3.141592653589793
DRIVES = ["diff", "omni", "body", "omni_angular", "acker"]
FIT = {"rvo": ("diff", "omni", "body"), "sfm": ("diff", "body")}
BEHAVIORS = families.BEHAVIORS.names()
GROUP_BEHAVIORS = families.GROUP_BEHAVIORS.names()
SHAPES = families.FOOTPRINTS.names()


def number(low: float, high: float) -> st.SearchStrategy[float]:
    """A number with three digits, or a multiple of 1/4, where coincidences are frequent."""
    fine = st.integers(int(low * 1000), int(high * 1000)).map(lambda value: value / 1000)
    coarse = st.integers(math.ceil(low * 4), int(high * 4)).map(lambda value: value / 4)
    return st.one_of(fine, coarse)


def vector(size: int, low: float, high: float) -> st.SearchStrategy[list[float]]:
    return st.lists(number(low, high), min_size=size, max_size=size)


POINT = st.tuples(number(0.5, 9.5), number(0.5, 9.5)).map(list)
HEADING = st.one_of(number(-3, 3), st.sampled_from([0.0, PI, -PI, PI / 2, 4.0]))
POSE = st.tuples(number(0.5, 9.5), number(0.5, 9.5), HEADING).map(list)
GOAL = st.one_of(POINT, POSE)


@st.composite
def shapes(draw: Any, wheelbase: float | None = None) -> dict[str, Any]:
    """One footprint."""
    name = draw(st.sampled_from([shape for shape in SHAPES if wheelbase is None or shape in ("circle", "rectangle")]))
    shape: dict[str, Any] = {"name": name}
    if wheelbase is not None:
        shape["wheelbase"] = wheelbase
    if name == "circle":
        shape["radius"] = draw(number(0.1, 0.8))
        if draw(st.booleans()):
            shape["center"] = draw(vector(2, -0.5, 0.5))
    elif name == "rectangle":
        shape["length"], shape["width"] = draw(number(0.25, 2)), draw(number(0.25, 2))
    elif name == "compound":
        circle = {"name": "circle", "radius": draw(number(0.1, 0.6)), "pose": draw(vector(3, -1, 1))}
        shape["parts"] = [circle, {"name": "rectangle", "length": draw(number(0.25, 2)), "width": 0.3}]
    else:
        outline = draw(st.sampled_from([TRIANGLE, HOOK, ARROW]))
        size, x, y = draw(number(0.5, 1.5)), draw(number(-0.5, 0.5)), draw(number(-0.5, 0.5))
        shape["vertices"] = [[round(size * a + x, 6), round(size * b + y, 6)] for a, b in outline]
    return shape


TRIANGLE = [(0.4, 0.0), (-0.2, 0.3), (-0.3, -0.2)]
HOOK = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.5), (0.5, 0.5), (0.5, 1.0), (0.0, 1.0)]
ARROW = [(-0.5, -0.5), (0.5, 0.0), (-0.5, 0.5), (-0.2, 0.0)]


@st.composite
def sensors(draw: Any) -> list[dict[str, Any]]:
    """None, one or two scanners."""
    found = []
    for _ in range(draw(st.integers(0, 2))):
        sensor: dict[str, Any] = {"name": draw(st.sampled_from(["lidar2d", "fmcw_lidar2d"]))}
        sensor["number"] = draw(st.integers(1, 24))
        sensor["angle_range"] = draw(number(0, 7))
        sensor["range_max"] = draw(number(1, 12))
        sensor["range_min"] = draw(st.sampled_from([0.0, 0.5]))
        sensor["offset"] = draw(vector(3, -0.5, 0.5))
        if sensor["name"] == "lidar2d":
            sensor["has_velocity"] = draw(st.booleans())
        else:
            sensor["motion_compensate"] = draw(st.booleans())
        found.append(sensor)
    return found


@st.composite
def moving_bodies(draw: Any, ghosts: bool) -> dict[str, Any]:
    """A body with a drive."""
    drive = draw(st.sampled_from(DRIVES))
    size = 3 if drive == "omni_angular" else 2
    body: dict[str, Any] = {"kinematics": {"name": drive}, "state": draw(POSE)}
    if drive == "body":
        body["kinematics"] = {"name": "omni", "frame": "body"}
    wheelbase = draw(number(0.25, 1.5)) if drive == "acker" else None
    body["shape"] = draw(shapes(wheelbase))
    highest = draw(st.sampled_from([3.0, 4.0]))
    if drive == "omni":  # limits bind in the command's frame: only equal ones, wide enough, give ir-sim's motion
        body["vel_max"], body["vel_min"] = [highest] * 2, [-2 * highest] * 2
    else:
        if draw(st.booleans()):
            body["vel_max"] = draw(vector(size, 0.25, 2))
        if draw(st.booleans()):
            body["vel_min"] = draw(vector(size, -2, 0))
        if draw(st.booleans()):
            body["acce"] = draw(
                st.lists(st.one_of(number(0.25, 4), st.just(float("inf"))), min_size=size, max_size=size)
            )
        if draw(st.booleans()):
            body["velocity"] = draw(vector(size, -1, 1))
    body["goal"] = draw(st.one_of(GOAL, st.lists(POSE, min_size=2, max_size=3).map(lambda goals: [goals])))
    body["goal_threshold"] = draw(st.sampled_from([0.1, 0.25, 1.0]))
    body["arrive_mode"] = draw(st.sampled_from(["position", "state"]))
    low = draw(st.sampled_from([-PI, 0.0, -PI / 2]))
    body["angle_range"] = [low, low + 2 * PI]
    body["behavior"] = draw(behaviors(drive))
    if (body["behavior"] or {"name": "dash"})["name"] == "sfm":
        # At rest the sideways force of each neighbour has the sign of a rounding error.
        body["velocity"] = draw(vector(2, 0.25, 0.75))
    body["sensors"] = draw(sensors())
    body["unobstructed"] = ghosts and draw(st.booleans())
    return {key: value for key, value in body.items() if value not in (None, [])}


@st.composite
def behaviors(draw: Any, drive: str) -> dict[str, Any] | None:
    """None, or a behaviour that the drive has."""
    fit = [name for name in BEHAVIORS if name == "dash" or drive in FIT.get(name, ())]
    name = draw(st.sampled_from([None, *fit]))
    if name is None:
        return None
    behavior: dict[str, Any] = {"name": name, "loop": draw(st.booleans()), "wander": draw(st.integers(0, 5)) == 0}
    if behavior["wander"]:
        behavior["range_low"], behavior["range_high"] = [2, 2, -3], [8, 8, 3]
        behavior["loop"] = False
    if name == "dash" and draw(st.booleans()):
        behavior["angle_tolerance"] = draw(number(0, 0.5))
    if name == "rvo":
        behavior["mode"] = draw(st.sampled_from(["rvo", "hrvo", "vo"]))
        behavior["acce"] = draw(st.sampled_from([1.0, 0.4]))
    if name != "dash":
        behavior["target_roles"] = draw(st.sampled_from(["all", "robot", "obstacle"]))
        behavior["neighbor_threshold"] = draw(st.sampled_from([3.0, 6.0]))
    return behavior


@st.composite
def parties(draw: Any, ghosts: bool) -> dict[str, Any]:
    """Robots that decide together."""
    count, drive = draw(st.integers(2, 3)), draw(st.sampled_from(["diff", "body"]))
    name = draw(st.sampled_from(GROUP_BEHAVIORS))
    way: dict[str, Any] = {"name": name}
    if name == "orca":
        way |= {"timeHorizon": draw(st.sampled_from([20.0, 4.0])), "maxNeighbors": draw(st.integers(1, 4))}
    elif count == 3 and draw(st.booleans()):
        way["social_groups"] = [[0, 1]]
    return {
        "number": count,
        "kinematics": {"name": "diff"} if drive == "diff" else {"name": "omni", "frame": "body"},
        "shape": {"name": "circle", "radius": draw(number(0.1, 0.4))},
        "state": draw(st.lists(POSE, min_size=count, max_size=count, unique_by=lambda pose: tuple(pose[:2]))),
        "goal": draw(st.lists(POSE, min_size=count, max_size=count)),
        "velocity": draw(vector(2, 0.1, 0.6)),
        "vel_max": draw(vector(2, 0.5, 2)),
        "group_behavior": way,
        "unobstructed": ghosts and draw(st.booleans()),
    }


PICTURE = ["########", "#   #  #", "#      #", "# ##   #", "#      #", "#    ###", "#      #", "########"]


@st.composite
def standing_bodies(draw: Any, ghosts: bool) -> dict[str, Any]:
    """A body that cannot move."""
    body = {"shape": draw(shapes()), "state": draw(POSE), "sensors": draw(sensors())}
    return {**{key: value for key, value in body.items() if value}, "unobstructed": ghosts and draw(st.booleans())}


def place_of(body: dict[str, Any]) -> tuple[float, ...]:
    """Return where a body starts: between two in one place, the direction of the other is a rounding error."""
    return tuple(body["state"][:2])


def show_alike(body: dict[str, Any]) -> None:
    """Change a body that rvo and sfm see otherwise here: what stands and has sides, and the middle of a compound."""
    name = body["shape"]["name"]
    if name == "compound" or ("kinematics" not in body and name not in ("circle", "linestring")):
        wheelbase = {key: value for key, value in body["shape"].items() if key == "wheelbase"}
        body["shape"] = {"name": "circle", "radius": 0.4, **wheelbase}


@st.composite
def cases(draw: Any) -> dict[str, Any]:
    """A scenario, and which of its bodies are commanded from outside."""
    ghosts = draw(st.integers(0, 3)) == 0
    bodies = st.one_of(moving_bodies(ghosts), standing_bodies(ghosts))
    robots = draw(st.lists(moving_bodies(ghosts), min_size=1, max_size=3, unique_by=place_of))
    obstacles = draw(st.lists(bodies, max_size=4, unique_by=place_of))
    obstacles = [body for body in obstacles if place_of(body) not in map(place_of, robots)]
    if any(body.get("behavior", {"name": "dash"})["name"] != "dash" for body in (*robots, *obstacles)):
        for body in (*robots, *obstacles):
            show_alike(body)
    world = {
        "step_time": draw(st.sampled_from([0.1, 0.05, 0.25])),
        "collision_mode": draw(st.sampled_from(["stop", "unobstructed", "unobstructed_obstacles"])),
    }
    movers = [b for b, body in enumerate([*robots, *obstacles]) if "kinematics" in body]
    driven = draw(st.lists(st.sampled_from(movers), unique=True, max_size=2))
    entries = [*robots, *obstacles]
    for b in driven:
        entries[b].pop("behavior", None)
    plan: dict[str, Any] = {"steps": draw(st.integers(2, 5)), "actions": dict.fromkeys(driven, "random"), "ties": 1.0}
    company = draw(st.sampled_from([None, None, None, "party", "map"]))
    if company == "party":
        obstacles.append(add_party(draw(parties(ghosts)), [*robots, *obstacles]))
    elif company == "map":
        plan["map"] = PICTURE
        for body in (*robots, *obstacles):  # who looks around sees a map otherwise here (decision map_is_no_disc)
            if (body.get("behavior") or {"name": "dash"})["name"] != "dash":
                body["behavior"] = {"name": "dash"}
    if any((body.get("behavior") or {}).get("wander") for body in (*robots, *obstacles)):
        plan["random_placement"] = True
    return {"world": world, "robot": robots, "obstacle": obstacles, "parity": plan}


def add_party(party: dict[str, Any], others: list[dict[str, Any]]) -> dict[str, Any]:
    """Make others such that a party sees them alike: orca avoids what stands (decision ``orca_walls``)."""
    for body in others:
        if party["group_behavior"]["name"] == "sfm":
            show_alike(body)
        else:
            body.setdefault("kinematics", {"name": "diff"})
    return party
