"""What the docstring of a public name has to say, and where it does not."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import re
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, get_origin

import numpy as np
from builder import reference

from irsim_gym.base import arraytypes

SECTIONS = ("Args", "Attributes", "Returns", "Yields", "Raises", "Example", "Examples")
ARRAY = re.compile(r"NDArray|ndarray|Tensor|\b(Floats|Ints|Flags|Rays|Words|Pixels|Bytes|Spans|Labels)\b")
FLOAT = re.compile(r"\bfloat\b")
SHAPE = re.compile(r"\bshapes?\b|``\(|\blikewise\b|\bscalar\b", re.IGNORECASE)
UNIT = re.compile(
    r"\[[^\]]+\]|\b(share|factor|opacity|layer|ratio|probability|without unit|unit of|likewise|by name)\b",
    re.IGNORECASE,
)
OWN = "irsim_gym"


def words_of(annotation: object) -> str:
    """Return an annotation as it is written: arrays and classes by their names."""
    if isinstance(annotation, str):
        return annotation
    for name, value in vars(arraytypes).items():
        if name[0].isupper() and get_origin(value) is np.ndarray and value == annotation:
            return name
    return annotation.__name__ if isinstance(annotation, type) else str(annotation).replace("numpy.ndarray", "NDArray")


@dataclass(frozen=True)
class Documented:
    """A public function, method or class with its docstring.

    Attributes:
        name: Its dotted name.
        value: What it is.
        owner: The class that has it; None for functions and classes.
    """

    name: str
    value: Any
    owner: type | None = None

    @cached_property
    def function(self) -> Callable[..., Any] | None:
        """The function that runs; None for a class without a constructor of its own."""
        value = self.value
        if inspect.isclass(value):
            own = vars(value).get("__init__")
            return None if own is None or getattr(value, "_is_protocol", False) or _is_generated(value) else own
        if isinstance(value, property):
            return value.fget
        return getattr(value, "__func__", value)

    @cached_property
    def text(self) -> str:
        """The docstring, without what a base class says."""
        return inspect.cleandoc(self.value.__doc__ or "")

    @cached_property
    def sections(self) -> dict[str, str]:
        """The parts of the docstring by their headings; the first has none."""
        parts = re.split(rf"^({'|'.join(SECTIONS)}):$", self.text, flags=re.MULTILINE)
        return {"": parts[0], **dict(zip(parts[1::2], parts[2::2], strict=True))}

    @cached_property
    def entries(self) -> dict[str, str]:
        """What is said of each parameter and attribute."""
        lines = self.sections.get("Args", "") + self.sections.get("Attributes", "")
        return _entries(lines)

    @property
    def values(self) -> Iterator[tuple[str, str]]:
        """Parameters, and fields of a class, with their annotations."""
        if inspect.isclass(self.value):
            fields = inspect.get_annotations(self.value).items()
            yield from ((name, words_of(kind)) for name, kind in fields if not name.startswith("_"))
        if self.function is not None and not isinstance(self.value, property):
            for parameter in inspect.signature(self.function).parameters.values():
                if parameter.name not in ("self", "cls"):
                    yield parameter.name, words_of(parameter.annotation)

    @property
    def returned(self) -> str:
        """The annotation of what it returns; empty for a class."""
        if inspect.isclass(self.value) or self.function is None:
            return ""
        return words_of(inspect.signature(self.function).return_annotation)

    @property
    def is_of_others(self) -> bool:
        """Whether another package declares this method, and documents it."""
        bases = self.owner.__mro__[1:] if self.owner is not None else ()
        name = self.name.rpartition(".")[2]
        return any(name in vars(base) for base in bases if not base.__module__.startswith(OWN))

    @property
    def raised(self) -> set[str]:
        """Names of the errors that its own body raises."""
        if self.function is None:
            return set()
        tree = ast.parse(textwrap.dedent(inspect.getsource(inspect.unwrap(self.function))))
        calls = (node.exc for node in _own_nodes(tree.body[0]) if isinstance(node, ast.Raise))
        return {call.func.id for call in calls if isinstance(call, ast.Call) and isinstance(call.func, ast.Name)}


def documented() -> Iterator[Documented]:
    """Yield the functions, the classes and the public methods of the reference, each once."""
    seen: set[int] = set()
    for section in reference.SECTIONS.values():
        for name, value in reference.names(section):
            if id(value) in seen or not str(getattr(value, "__module__", "")).startswith(OWN):
                continue
            seen.add(id(value))
            if inspect.isclass(value):
                yield Documented(name, value)
                yield from _methods(name, value)
            elif inspect.isroutine(value) or hasattr(value, "__wrapped__"):
                yield Documented(name, value)


def _methods(name: str, kind: type) -> Iterator[Documented]:
    for own, value in vars(kind).items():
        if not own.startswith("_") and isinstance(value, property | classmethod | staticmethod | type(_methods)):
            yield Documented(f"{name}.{own}", value, kind)


def unnamed(one: Documented) -> Iterator[str]:
    """Yield parameters and fields that are neither under Args or Attributes nor in backticks, nor declare themselves.

    The first sentence may say all of a single parameter that is neither an array nor a float.
    """
    declared, values = _declared(one.value), list(one.values)
    for name, kind in values:
        is_number = ARRAY.search(kind) or FLOAT.search(kind)
        explains_itself = kind in PUBLIC_CLASSES or "ClassVar" in kind or (len(values) == 1 and not is_number)
        if name not in one.entries and f"``{name}``" not in one.text and name not in declared and not explains_itself:
            yield f"{one.name}: {name}"


def without_shape(one: Documented) -> Iterator[str]:
    """Yield arrays, given or returned, whose shape is not said."""
    for name, kind in one.values:
        if ARRAY.search(kind) and name in one.entries and not SHAPE.search(one.entries[name]):
            yield f"{one.name}: {name}"
    if ARRAY.search(one.returned) and not SHAPE.search(one.sections[""] + one.sections.get("Returns", "")):
        yield f"{one.name}: what it returns"


def without_unit(one: Documented) -> Iterator[str]:
    """Yield floats, given or returned, of which neither a unit is said nor that there is none."""
    for name, kind in one.values:
        if FLOAT.search(kind) and name in one.entries and not UNIT.search(one.entries[name]):
            yield f"{one.name}: {name}"
    said = one.sections[""] + one.sections.get("Returns", "")
    if re.fullmatch(r"float( \| None)?", one.returned) and not UNIT.search(said):
        yield f"{one.name}: what it returns"


def unsaid_errors(one: Documented) -> Iterator[str]:
    """Yield errors that the body raises and Raises does not name."""
    said = _entries(one.sections.get("Raises", ""))
    yield from (f"{one.name}: {error}" for error in sorted(one.raised) if error not in said)


PUBLIC_CLASSES = {"Term", "Model", "State", "EpisodeState", "Shard", "Group", "Simulation"}
"""Types of parameters that say all: what kinds of plugins are called with."""


def _entries(text: str) -> dict[str, str]:
    found: dict[str, str] = {}
    for names, said in re.findall(r"^    (\*{0,2}\w[\w, *.]*?): (.*(?:\n(?:     .*|$))*)", text, re.MULTILINE):
        found |= {name.strip().lstrip("*"): said for name in names.split(",")}
    return found


def _declared(value: Any) -> set[str]:
    """Return fields that are declared with shape, unit and meaning, or with the words of an annotation."""
    fields = dataclasses.fields(value) if dataclasses.is_dataclass(value) else ()
    return {one.name for one in fields if "column" in one.metadata}


def _is_generated(kind: type) -> bool:
    return dataclasses.is_dataclass(kind) or issubclass(kind, tuple)


def _own_nodes(function: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a function, without those of functions inside it."""
    for node in ast.iter_child_nodes(function):
        if not isinstance(node, ast.FunctionDef | ast.Lambda):
            yield node
            yield from _own_nodes(node)
