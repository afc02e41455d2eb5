"""From our scenario language to ir-sim's: the few words in which they differ, each a named decision."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from typing import Any

from irsim_gym.scenario.text.expressions import evaluate

AVOIDING = ("rvo",)
NOWHERE = [1e6, 1e6, 0.0]
NUMERIC = ("angle_range", "state", "goal", "range_low", "range_high", "offset", "pose", "fov", "velocity")


def to_ir_sim(scenario: Mapping[str, Any], decisions: set[str]) -> dict[str, Any]:
    """Return the scenario in ir-sim's words; adds the decisions that this took to ``decisions``."""
    data = {key: copy.deepcopy(value) for key, value in scenario.items() if key != "task"}
    world = data.get("world") or {}
    data["world"] = {key: value for key, value in world.items() if key not in ("name", "update")}
    for role in ("robot", "obstacle"):
        section = data.get(role)
        if isinstance(section, Mapping):
            decisions.add("role_groups")
            data[role] = [dict(section)]
        for entry in data.get(role) or []:
            _translate_entry(entry, decisions)
    _show_outlines(data, decisions)
    return {key: _numbers(value) for key, value in data.items()}


def _translate_entry(entry: dict[str, Any], decisions: set[str]) -> None:
    if "shape" not in entry:
        decisions.add("missing_shape")
        entry["shape"] = {"name": "circle"}
    if (entry.get("distribution") or {"name": "manual"})["name"] == "manual":
        if "state" not in entry:
            decisions.add("missing_state")
            entry["state"] = [0, 0, 0]
        if entry.get("goal") is None:
            decisions.add("missing_goal")
            entry["goal"] = list(NOWHERE)
    if entry.get("unobstructed"):
        decisions.add("unobstructed_is_symmetric")
    for drive in _mappings(entry.get("kinematics")):
        frame = drive.pop("frame", "world")
        if drive.get("name") == "omni" and frame == "world":
            decisions.add("omni_frame")


def _show_outlines(data: dict[str, Any], decisions: set[str]) -> None:
    """Where anyone looks around, write standing rectangles and polygons as their outlines (``obstacle_sizes``).

    ir-sim's rvo sees linestrings as they are; scanners and contact from outside see no difference.
    """
    entries = [*(data.get("robot") or []), *(data.get("obstacle") or [])]
    ways = [way for entry in entries for key in ("behavior", "group_behavior") for way in _mappings(entry.get(key))]
    if not any(way["name"] in AVOIDING for way in ways):
        return
    for entry in entries:
        for shape in _mappings(entry["shape"]):
            if not entry.get("kinematics") and shape["name"] in ("rectangle", "polygon"):
                decisions.add("obstacle_sizes")
                corners = shape.get("vertices") or _corners(shape.get("length", 1.0), shape.get("width", 1.0))
                shape.clear()
                shape.update({"name": "linestring", "vertices": [*corners, corners[0]]})


def _corners(length: float, width: float) -> list[list[float]]:
    x, y = length / 2, width / 2
    return [[-x, -y], [x, -y], [x, y], [-x, y]]


def _mappings(value: Any) -> Iterator[dict[str, Any]]:
    for item in value if isinstance(value, list) else [value]:
        if isinstance(item, dict):
            yield item


def _numbers(value: Any, numeric: bool = False) -> Any:
    """Evaluate expressions such as ``-pi / 2`` where a number is meant."""
    if isinstance(value, Mapping):
        return {key: _numbers(item, key in NUMERIC) for key, item in value.items()}
    if isinstance(value, list):
        return [_numbers(item, numeric) for item in value]
    if numeric and isinstance(value, str):
        return evaluate(value)
    return value
