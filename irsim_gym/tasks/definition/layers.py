"""Merges task files in layers: a section of a scenario overrides the file that it names.

Each value keeps its origin, so that a problem in the merged task names the right file and line.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from irsim_gym.base.errors import Problem, ScenarioError, suggestion
from irsim_gym.scenario.checking.validation import Report
from irsim_gym.scenario.text.source import Place, Source, dotted

LISTS = ("observations", "rewards", "endings")


@dataclass(frozen=True)
class Layer:
    """One file, or one section of it.

    Attributes:
        title: Name of the file in messages.
        data: The plain data.
        line: Returns the line of a path within ``data``.
        prefix: Path of ``data`` in the file.
        remark: Returns a remark on a value for the end of a message, e.g. the parameter that gave it.
    """

    title: str
    data: Mapping[str, Any]
    line: Callable[[Place], int]
    prefix: Place = ()
    remark: Callable[[Place], str] = lambda place: ""


@dataclass(frozen=True)
class Node:
    """A value with its place; ``value`` holds nodes in place of the items of a mapping or list."""

    layer: Layer
    place: Place
    value: Any


@dataclass
class Merged:
    """The merged task as one source, whose "lines" are numbers of origins.

    Attributes:
        data: Plain data.
        report: Collects problems by merged path.
        origins: Origin of each numbered value: its merged path and its node.
        outside: Problems that belong to no value of a layer, with their file.
    """

    data: dict[str, Any]
    report: Report
    origins: list[tuple[Place, Node]]
    outside: list[tuple[str, Problem]] = field(default_factory=list)

    def refuse(self, main: str) -> None:
        """Raise all problems: those of the file ``main`` with their lines, others with file and line in their path.

        Raises:
            ScenarioError: If there is a problem.
        """
        refused = [*self.outside, *map(self._origin, self.report.problems)]
        if not refused:
            return
        titles = [title for title, _ in refused]
        file = main if main in titles else titles[0]
        problems = [problem if title == file else _elsewhere(title, problem) for title, problem in refused]
        raise ScenarioError(file, problems)

    def ignored(self, main: str) -> list[Problem]:
        """Return the ignored keys as problems, in the form of ``refuse``."""
        problems = map(self._origin, self.report.ignored)
        return [problem if title == main else _elsewhere(title, problem) for title, problem in problems]

    def own_place(self, *places: Place) -> Place:
        """Return the first of these places that the uppermost layer sets; the first place if it sets none."""
        places_here = {place for place, node in self.origins if node.layer.title == self.report.source.title}
        return next((place for place in places if place in places_here), places[0])

    def _origin(self, problem: Problem) -> tuple[str, Problem]:
        place, node = self.origins[min(problem.line, len(self.origins)) - 1]
        # A problem may lie deeper than the numbered value; the rest of its path is put behind that of the origin.
        suffix = problem.path[len(dotted(place)) :]
        path = dotted((*node.layer.prefix, *node.place)) + suffix
        message = problem.message + ("" if suffix else node.layer.remark(node.place))
        return node.layer.title, Problem(node.layer.line(node.place), path.removeprefix("."), message)


def _elsewhere(title: str, problem: Problem) -> Problem:
    where = f"{title}:{problem.line}" if problem.line else title
    return Problem(0, f"{where} {problem.path}".strip(), problem.message)


def merge(layers: list[Layer], *, strict: bool = True) -> Merged:
    """Merge layers into a task; later layers override earlier ones.

    Args:
        layers: The layers, the most basic one first.
        strict: Whether unused keys are problems, see ``Report``.
    """
    complaints: list[tuple[Node, str]] = []
    trees = [_normal(_tree(layer, (), layer.data)) for layer in layers]
    whole = trees[0]
    for tree in trees[1:]:
        whole = _over(whole, tree, complaints)
    whole = _without_unused(whole, complaints)
    origins: list[tuple[Place, Node]] = []
    lines: dict[Place, int] = {}
    data = _flat(whole, (), origins, lines)
    merged = Merged(data, Report(Source(layers[-1].title, data, lines), strict=strict), origins)
    for node, message in complaints:
        layer = node.layer
        path = dotted((*layer.prefix, *node.place))
        merged.outside.append((layer.title, Problem(layer.line(node.place), path, message)))
    return merged


def _tree(layer: Layer, place: Place, value: object) -> Node:
    if isinstance(value, Mapping):
        return Node(layer, place, {key: _tree(layer, (*place, key), item) for key, item in value.items()})
    if isinstance(value, list | tuple):
        return Node(layer, place, [_tree(layer, (*place, i), item) for i, item in enumerate(value)])
    return Node(layer, place, value)


def _normal(tree: Node) -> Node:
    """Convert plain names (``[scan, goal]``, ``action: velocity``) to mappings."""
    children = dict(tree.value)
    for key in LISTS:
        if key in children and isinstance(children[key].value, list):
            items = [_named(item) for item in children[key].value]
            children[key] = Node(tree.layer, children[key].place, items)
    for key in ("action", "shield"):
        if key in children:
            children[key] = _named(children[key])
    return Node(tree.layer, tree.place, children)


def _named(node: Node) -> Node:
    return Node(node.layer, node.place, {"name": node}) if isinstance(node.value, str) else node


def _name(node: Node) -> object:
    named = node.value.get("name") if isinstance(node.value, dict) else None
    return named.value if named is not None else None


def _over(base: Node, over: Node, complaints: list[tuple[Node, str]]) -> Node:
    children = dict(base.value)
    for key, node in over.value.items():
        below = children.get(key)
        if below is None:
            children[key] = node
        elif key in LISTS and isinstance(below.value, list) and isinstance(node.value, list):
            children[key] = _over_items(below, node, key, complaints)
        elif key in ("action", "shield"):
            children[key] = _over_options(below, node)
        else:
            children[key] = node
    return Node(over.layer, over.place, children)


def _over_items(base: Node, over: Node, key: str, complaints: list[tuple[Node, str]]) -> Node:
    """Merge items into those of the same name; append the others."""
    items = list(base.value)
    for item in over.value:
        names = [_name(other) for other in base.value]
        name = _name(item)
        if name is not None and name in names:
            items[names.index(name)] = _over_options(items[names.index(name)], item)
            continue
        if _is_unused(item):
            near = suggestion(str(name), [str(other) for other in names])
            complaints.append((item, f"there is no '{name}' among the {key} to leave out{near}"))
        items.append(item)
    return Node(over.layer, over.place, items)


def _over_options(base: Node, over: Node) -> Node:
    """Merge options into options; an item with another name starts from its own defaults."""
    if not isinstance(base.value, dict) or not isinstance(over.value, dict):
        return over
    if _name(over) not in (None, _name(base)):
        return over
    return Node(over.layer, over.place, {**base.value, **over.value})


def _is_unused(item: Node) -> bool:
    return isinstance(item.value, dict) and "use" in item.value and item.value["use"].value is False


def _without_unused(tree: Node, complaints: list[tuple[Node, str]]) -> Node:
    """Drop items with ``use: false``."""
    children = dict(tree.value)
    for key in LISTS:
        if key not in children or not isinstance(children[key].value, list):
            continue
        items = []
        for item in children[key].value:
            if isinstance(item.value, dict) and "use" in item.value:
                use = item.value["use"]
                if not isinstance(use.value, bool):
                    complaints.append((use, "must be true or false"))
                options = {name: node for name, node in item.value.items() if name != "use"}
                items += [] if use.value is False else [Node(item.layer, item.place, options)]
            else:
                items.append(item)
        children[key] = Node(children[key].layer, children[key].place, items)
    return Node(tree.layer, tree.place, children)


def _flat(node: Node, place: Place, origins: list[tuple[Place, Node]], lines: dict[Place, int]) -> Any:
    """Return plain data, and number all values."""
    origins.append((place, node))
    # The "line" of a value is the number of its origin, from 1: ``_origin`` finds the value's file and line by it.
    lines[place] = len(origins)
    if isinstance(node.value, dict):
        return {key: _flat(item, (*place, key), origins, lines) for key, item in node.value.items()}
    if isinstance(node.value, list):
        return [_flat(item, (*place, i), origins, lines) for i, item in enumerate(node.value)]
    return node.value
