"""For the driver, by NumPy alone: scans as the contract's scanner would read them, poses, stamps, broken contracts."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

NUMBERS = {"integer": int, "number": (int, float)}
TYPES: dict[str, Any] = {"object": dict, "array": list, "string": str, "boolean": bool, "null": type(None), **NUMBERS}


def read_contract(file: Path) -> Any:
    """Return a contract; a ValueError says what is wrong with it, by the schema beside it."""
    try:
        contract = json.loads(file.read_text(encoding="utf-8"))
    except ValueError as problem:
        raise ValueError(f"{file} is not JSON: {problem}") from None
    schema = json.loads(file.with_suffix(".schema.json").read_text(encoding="utf-8"))
    if said := fault(contract, schema, schema["$defs"]):
        raise ValueError(f"{file}: {said}")
    return contract


def differing(session: Any, contract: Any) -> list[str]:
    """Return the inputs, and the outputs for states, that a graph or its contract alone has."""
    taken, returned = ({one.name for one in every} for every in (session.get_inputs(), session.get_outputs()))
    states = {f"{name}_next" for name in contract["states"]}
    return sorted((taken ^ set(contract["inputs"])) | (returned ^ states) - {"command"})


def fault(found: Any, form: dict[str, Any], forms: dict[str, Any], key: str = "") -> str:
    """Return what is wrong with JSON data by their schema: key, what was found, what would be right; empty if nothing.

    Other forms are the schema's "$defs".
    """
    about = form.get("description", "")
    if "anyOf" in form:
        said = [fault(found, {"description": about, **one}, forms, key) for one in form["anyOf"]]
        return "" if "" in said else said[0]
    right = forms[form["$ref"].split("/")[-1]] if "$ref" in form else form
    kind, known = right.get("type"), {**right.get("properties", {})}
    allowed = right.get("enum", [right.get("const", found)])
    is_kind = kind is None or (isinstance(found, TYPES[kind]) and isinstance(found, bool) == (kind == "boolean"))
    if not is_kind or found not in allowed:
        good = " or ".join(map(json.dumps, allowed)) if is_kind else kind
        return f"{key or 'the contract'} is {json.dumps(found)}: it must be {good}. {about}"
    if kind == "object":
        known = {**dict.fromkeys(found, right.get("additionalProperties")), **known}
    elif kind == "array":
        known = dict(enumerate(right.get("prefixItems", [right.get("items")] * len(found))))
        if len(found) > len(known):
            return f"{key} has {len(found)} items: it must have {len(known)}. {about}"
        found = dict(enumerate(found))
    for name, inner in known.items():
        place = f"{key}.{name}".lstrip(".")
        if name not in found and name in right.get("required", known):
            return f"{place} is missing. {inner.get('description', '')}"
        if isinstance(inner, dict) and name in found and (wrong := fault(found[name], inner, forms, place)):
            return wrong
    return ""


def as_beams(ranges: Any, angles: tuple[float, float], mount: Any, own: dict[str, Any]) -> Any:
    """Return scans (n, size) as the contract's beams see them, (n, n_beams): of each beam's share the shortest range.

    The scanner is mounted at (x, y, turn), and its beams look at angles: the first one's, and the step to the next.
    """
    n_beams, share, (n, size) = own["beams"], own["step"] or 2.0 * np.pi, ranges.shape
    looks = (angles[0] + angles[1] * np.arange(size) + mount[2] - own["mount"][2])[None]
    if (mount[0], mount[1]) != tuple(own["mount"][:2]):
        shift = (complex(*mount[:2]) - complex(*own["mount"][:2])) * np.exp(-1j * own["mount"][2])
        ends = np.minimum(ranges, 1e6) * np.exp(1j * looks) + shift
        ranges, looks = np.where(np.isfinite(ranges), np.abs(ends), ranges), np.angle(ends)
    looks = looks - own["first"]
    outside = (looks < -0.5 * share) | (looks >= (n_beams - 0.5) * share)
    places = np.where(outside, np.remainder(looks + 0.5 * share, 2.0 * np.pi) / share - 0.5, looks / share)
    beams = np.broadcast_to(np.rint(places).astype(int), (n, size))
    seen, lacking = np.full((n, n_beams), np.inf, np.float32), np.ones((n, n_beams), bool)
    rows, columns = np.nonzero((beams >= 0) & (beams < n_beams))
    np.minimum.at(seen, (rows, beams[rows, columns]), ranges[rows, columns].astype(np.float32))
    lacking[rows, beams[rows, columns]] = False
    for w in range(len(places)) if size else ():  # beams of a coarser scanner take the nearest reading
        missed, worlds = np.flatnonzero(lacking[w]), slice(None) if len(places) == 1 else w
        away = np.abs(np.remainder((places[w] - missed[:, None]) * share + np.pi, 2.0 * np.pi) - np.pi)
        near = away.min(axis=1) <= 0.51 * max(abs(angles[1]), share)
        seen[worlds, missed[near]] = ranges[worlds, away.argmin(axis=1)[near]]
    return seen


def compared(found: dict[str, float], own: dict[str, Any], step: float) -> tuple[str, str]:
    """Return why a scanner is refused, and how one that was tested differs from that of the training; empty if not.

    It is described by beams, range_max [m], field_of_view [rad] and its mount: x, y [m], turn [rad]; step is the angle
    between its beams [rad].
    """
    spans, known = dict(own["tested"]), {**own, "field_of_view": own["step"] * (own["beams"] - 1)}
    for k, name in enumerate(("x", "y", "turn")):
        spans[name], known[name] = own["mounts"][k], own["mount"][k]
    slacks = {**{name: 0.01 * spans[name][1] for name in ("beams", "range_max")}, "field_of_view": step + 0.01}
    fault, notes = "", []
    for name, (low, high) in spans.items():
        slack, value = slacks.get(name, 0.01), found[name]
        text = f"scanner: {name} {value:.4g}, tested from {low:.4g} to {high:.4g}"
        if not low - slack <= value <= high + slack:
            fault = fault or text
        elif abs(value - known[name]) > slack:
            notes.append(f"{text}, trained with {known[name]:.4g}")
    return fault, "; ".join(notes)


def lost_beams(msg: Any, no_return: str) -> Any:
    """Return which beams of a sensor_msgs/LaserScan are lost, (size,): NaN, or shorter than its range_min."""
    ranges = np.array(msg.ranges, float)
    lost = np.isnan(ranges) | (ranges < msg.range_min) & np.isfinite(ranges)
    return lost & (ranges != 0.0) if no_return == "zero" else lost


def seconds(stamp: Any) -> float:
    """Return a stamp of ROS 1 or ROS 2, or a number, in seconds."""
    is_ros_1 = hasattr(stamp, "to_sec")
    return float(stamp.to_sec() if is_ros_1 else stamp.sec + 1e-9 * stamp.nanosec if hasattr(stamp, "sec") else stamp)


def pose(pose: Any) -> Any:
    """Return a geometry_msgs/Pose as x, y [m] and heading [rad], (1, 3)."""
    return np.array([[pose.position.x, pose.position.y, heading(pose.orientation)]], float)


def heading(q: Any) -> float:
    """Return the heading of a geometry_msgs/Quaternion [rad]."""
    return float(np.arctan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z)))
