"""Messages as rclpy makes them: types of rosbags that begin empty, and whose numbers have to be of their type."""

from __future__ import annotations

from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)


def blank(kind: tuple[Nodetype, Any]) -> Any:
    """Return what a field is at first."""
    node, what = kind
    if node == Nodetype.NAME:
        return message(what)()
    if node == Nodetype.BASE:
        return {"string": "", "float": 0.0}.get(what[0].rstrip("0123456789"), 0)
    return [blank(what[0]) for _ in range(what[1] if node == Nodetype.ARRAY else 0)]


def message(name: str) -> Any:
    """Return the class of a message such as ``geometry_msgs/msg/Twist``."""
    fields = dict(STORE.fielddefs[name][1])
    base: Any = STORE.types[name]

    class Message(base):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__(**{field: blank(kind) for field, kind in fields.items()})

        def __setattr__(self, field: str, value: Any) -> None:
            if field != "__msgtype__":
                node, what = fields[field]  # what is no field is a KeyError
                is_float = node == Nodetype.BASE and what[0].startswith("float")
                assert not is_float or isinstance(value, float), f"{field} must be of type float"
            super().__setattr__(field, value)

    return Message
