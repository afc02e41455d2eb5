"""Converts YAML text to plain data with line numbers: bounded, safe, and with reports of repeated keys.

It replaces PyYAML's composer, because only here can depth, the number of values after alias expansion, anchors that
contain themselves and duplicate keys be checked.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import yaml

from irsim_gym.scenario.text.messages import show
from irsim_gym.scenario.text.syntax import explain

Place = tuple[str | int, ...]

MAX_DEPTH = 40
MAX_VALUES = 100_000

_TAG = "tag:yaml.org,2002:"
_SCALARS = {_TAG + name for name in ("null", "bool", "int", "float", "str")}
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class Fatal(Exception):  # noqa: N818  (it never leaves the package: source.py turns it into a ScenarioError)
    """A problem that stops reading."""

    def __init__(self, line: int, message: str) -> None:
        self.line = line
        super().__init__(message)


@dataclass
class Document:
    """The content of a file.

    Attributes:
        data: The plain data.
        lines: Line of each value by its path: that of its key or list item, or of the scalar itself.
        problems: Line, path and message of each mistake.
        repeats: Line, path and message of each repeated key, and whether it holds a block of further keys; the last
            value counts.
    """

    data: Any = None
    lines: dict[Place, int] = field(default_factory=dict)
    problems: list[tuple[int, Place, str]] = field(default_factory=list)
    repeats: list[tuple[int, Place, str, bool]] = field(default_factory=list)


@dataclass
class _Node:
    """A value before aliases are expanded; its ``error`` is reported wherever the value is used."""

    line: int
    scalar: Any = None
    pairs: list[tuple[_Node, _Node, int]] | None = None
    items: list[_Node] | None = None
    error: str = ""
    is_merge: bool = False
    is_open: bool = False

    @property
    def holds_keys(self) -> bool:
        """Whether the value is a mapping or a list with a mapping."""
        return self.pairs is not None or any(item.pairs is not None for item in self.items or ())


def compose(text: str) -> Document:
    """Return the only document of a YAML text.

    Raises:
        Fatal: If the text is not YAML, is empty, holds several documents or exceeds a bound.
    """
    try:
        root = _Composer(text).document()
    except yaml.MarkedYAMLError as error:
        if "nesting depth" in str(error.problem):  # a bound of newer parsers, met while they look ahead
            line = error.problem_mark.line + 1 if error.problem_mark else 0
            raise Fatal(line, f"nested deeper than {MAX_DEPTH} levels") from None
        raise Fatal(*explain(error, text)) from None
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1 if isinstance(error.position, int) else 0
        raise Fatal(line, "not YAML: it contains a character that is not text") from None
    document = Document()
    document.data = _Expansion(document).value(root, (), root.line)
    return document


class _Composer:
    """Builds nodes from the parser's events."""

    def __init__(self, text: str) -> None:
        self._loader = _Loader("")
        self._events: Iterator[Any] = yaml.parse(text, Loader=_Loader)
        self._anchors: dict[str, _Node] = {}
        self._count = 0

    def document(self) -> _Node:
        root = None
        for event in self._events:
            if isinstance(event, yaml.DocumentStartEvent):
                if root is not None:
                    raise Fatal(_line(event), "only one document per file: a second '---' begins here")
                root = self._node(next(self._events), 0)
        if root is None:
            raise Fatal(0, "the file is empty")
        return root

    def _node(self, event: Any, depth: int) -> _Node:
        if depth > MAX_DEPTH:
            raise Fatal(_line(event), f"nested deeper than {MAX_DEPTH} levels")
        self._count += 1
        if self._count > 2 * MAX_VALUES:  # keys count here, but not as values
            raise Fatal(_line(event), f"more than {MAX_VALUES} values")
        if isinstance(event, yaml.AliasEvent):
            return self._alias(event)
        node = _Node(_line(event), is_open=True)
        if event.anchor is not None:
            self._anchors[event.anchor] = node
        if isinstance(event, yaml.ScalarEvent):
            self._scalar(event, node)
        elif isinstance(event, yaml.SequenceStartEvent):
            self._check_tag(event, node, "seq")
            node.items = []
            while not isinstance(following := next(self._events), yaml.SequenceEndEvent):
                node.items.append(self._node(following, depth + 1))
        else:
            self._check_tag(event, node, "map")
            node.pairs = []
            while not isinstance(following := next(self._events), yaml.MappingEndEvent):
                key = self._node(following, depth + 1)
                value_event = next(self._events)
                node.pairs.append((key, self._node(value_event, depth + 1), _line(value_event)))
        node.is_open = False
        return node

    def _alias(self, event: Any) -> _Node:
        node = self._anchors.get(event.anchor)
        if node is None:
            return _Node(_line(event), error=f"no anchor named '&{event.anchor}'")
        if node.is_open:
            return _Node(_line(event), error=f"anchor '&{event.anchor}' contains itself")
        return node

    def _scalar(self, event: Any, node: _Node) -> None:
        tag = event.tag
        if tag is None or tag == "!":
            tag = self._loader.resolve(yaml.ScalarNode, event.value, event.implicit)
        if tag == _TAG + "merge":
            node.is_merge = True
        if tag in (_TAG + "merge", _TAG + "timestamp", _TAG + "value"):
            tag = _TAG + "str"
        if tag not in _SCALARS:
            node.error = f"the tag '{_short(tag)}' is not allowed"
            return
        if tag == _TAG + "str":
            node.scalar = event.value
            return
        self._loader.constructed_objects.clear()  # PyYAML would keep every node
        try:
            node.scalar = self._loader.construct_object(yaml.ScalarNode(tag, event.value))
        except (ValueError, KeyError, OverflowError, yaml.YAMLError):
            node.error = f"not a readable number: {event.value[:40]}"

    @staticmethod
    def _check_tag(event: Any, node: _Node, expected: str) -> None:
        if event.tag not in (None, "!", _TAG + expected):
            node.error = f"the tag '{_short(event.tag)}' is not allowed"


class _Expansion:
    """Converts nodes to data, expanding aliases and merge keys."""

    def __init__(self, document: Document) -> None:
        self._document = document
        self._count = 0

    def value(self, node: _Node, place: Place, line: int) -> Any:
        self._step(line)
        if len(place) > MAX_DEPTH:
            raise Fatal(line, f"nested deeper than {MAX_DEPTH} levels")
        self._document.lines[place] = line
        if node.error:
            self._document.problems.append((line, place, node.error))
            return None
        if node.items is not None:
            return [self.value(item, (*place, i), item.line) for i, item in enumerate(node.items)]
        if node.pairs is not None:
            return self._mapping(node, place)
        return node.scalar

    def _step(self, line: int) -> None:
        self._count += 1
        if self._count > MAX_VALUES:
            raise Fatal(line, f"more than {MAX_VALUES} values (after aliases are expanded)")

    def _mapping(self, node: _Node, place: Place) -> dict[str, object]:
        data: dict[str, Any] = {}
        first: dict[str, int] = {}
        last: dict[str, tuple[_Node, int]] = {}
        merged: list[_Node] = []
        for key, value, value_line in node.pairs or ():
            if key.is_merge:
                merged.extend(value.items if value.items is not None else [value])
            elif self._accept_key(key, value, place):
                if key.scalar in first:
                    message = f"given twice (first in line {first[key.scalar]})"
                    repeat = (key.line, (*place, key.scalar), message, value.holds_keys)
                    self._document.repeats.append(repeat)
                first.setdefault(key.scalar, key.line)
                is_block = value.items is not None or value.pairs is not None
                last[key.scalar] = value, key.line if is_block else value_line
        for name, (value, line) in last.items():
            data[name] = self.value(value, (*place, name), line)
        for other in merged:
            self._merge(other, place, data)
        return data

    def _accept_key(self, key: _Node, value: _Node, place: Place) -> bool:
        name = key.scalar
        if key.error or key.items is not None or key.pairs is not None or not isinstance(name, str):
            key_type = "a list or mapping" if key.items is not None or key.pairs is not None else show(name)
            stands_alone = type(name) is int and value.scalar is None and value.items is None and value.pairs is None
            hint = "; decimals have a point, as in 0.1" if stands_alone else ""
            self._document.problems.append((key.line, place, f"keys must be text, got {key_type}{hint}"))
            return False
        return True

    def _merge(self, other: _Node, place: Place, data: dict[str, Any]) -> None:
        """Add the keys of ``<<:`` that are not given; the first mapping with a key wins."""
        self._step(other.line)
        if other.pairs is None:
            message = other.error or "'<<' merges mappings only"
            self._document.problems.append((other.line, place, message))
            return
        unset = _Node(other.line, pairs=[pair for pair in other.pairs if pair[0].scalar not in data])
        if len(unset.pairs or ()) > 0:
            for name, value in self._mapping(unset, place).items():
                data.setdefault(name, value)


def _line(event: Any) -> int:
    return int(event.start_mark.line) + 1


def _short(tag: str) -> str:
    return ("!!" + tag.removeprefix(_TAG) if tag.startswith(_TAG) else tag)[:60]
