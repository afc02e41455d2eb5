"""What a class has to have to become a kind of its family: checked when somebody registers one from outside.

A family states it once, as a ``Protocol``: methods with their arguments, and attributes with their types and, as
``Annotated[type, "meaning"]``, what they say. The check reads the protocol, so that it cannot differ from it.
"""

import inspect
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Annotated, Any, ClassVar, Literal, Protocol, get_args, get_origin, get_type_hints, runtime_checkable

from pydantic import ConfigDict, TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from irsim_gym.base.errors import KindError, nearest, suggestion
from irsim_gym.base.options import option_fields
from irsim_gym.base.registry import OWN


@runtime_checkable
class HasProblems(Protocol):
    """A kind whose options have to fit each other."""

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message for each option that does not fit the others; an empty key means the whole kind."""


@dataclass(frozen=True)
class Contract:
    """What the kinds of a family have to have.

    Attributes:
        protocol: Declares the methods and attributes that each kind must have.
        optional: Protocols whose methods a kind may have.
        rules: Yields what else is wrong with a class.
    """

    protocol: type[Any]
    optional: tuple[type[Any], ...] = ()
    rules: Callable[[type[Any]], Iterable[str]] = lambda kind: ()


def is_foreign(kind: Any) -> bool:
    """Return whether a kind is not one of the package's own, which its tests see to."""
    return not str(getattr(kind, "__module__", "")).startswith(OWN)


def check_kind(family: str, name: str, kind: Any, contract: Contract) -> None:
    """Check a class that is about to be registered.

    Raises:
        KindError: It cannot work; the error lists all that is wrong with it.
    """
    if not isinstance(kind, type):
        raise KindError(f"{family} '{name}': register takes the class, got {kind!r}")
    problems = [*_making(kind), *_members(kind, contract.protocol, required=True)]
    optional: tuple[type[Any], ...] = (*contract.optional, HasProblems)
    for protocol in optional:
        problems += _members(kind, protocol, required=False)
    refuse(family, name, kind, [*problems, *contract.rules(kind)])


def refuse(family: str, name: str, kind: type[Any], problems: Iterable[str], method: str = "") -> None:
    """Raise a KindError that lists problems, if there are any, with file and line of the kind or of its method."""
    issues = list(problems)
    if not issues:
        return
    head = f"{family} '{name}' ({kind.__qualname__}{place_of(kind, method)})"
    raise KindError(f"{head}: {issues[0]}" if len(issues) == 1 else "\n  ".join([f"{head}:", *issues]))


def place_of(kind: type[Any], method: str = "") -> str:
    """Return ``, file:line`` of a method, or of a class; nothing where that is not known.

    Of a class that a decorator has made, it is that of the function.
    """
    members = vars(kind)
    method = "function" if "function" in members else method
    try:
        if not method:
            return f", {inspect.getsourcefile(kind)}:{inspect.getsourcelines(kind)[1]}"
    except (OSError, TypeError):
        pass  # made by exec, or typed in
    for name in [method] if method else [name for name in members if name[:2] != "__"]:
        if code := getattr(_function(members.get(name)), "__code__", None):
            return f", {code.co_filename}:{code.co_firstlineno}"
    return ""


def has_member(kind: type[Any], name: str) -> bool:
    """Return whether a class has an option, an attribute or a method of this name."""
    return name in getattr(kind, "__pydantic_fields__", ()) or hasattr(kind, name)


def check_method(kind: type[Any], name: str, protocol: type[Any], *, required: bool) -> Iterator[str]:
    """Yield what is wrong with a method that a protocol declares."""
    arguments = [one for one in inspect.signature(getattr(protocol, name)).parameters if one != "self"]
    call, member = f"{name}({', '.join(arguments)})", inspect.getattr_static(kind, name, None)
    function = _function(member)
    if member is None:
        near = nearest(name, [one for one, value in vars(kind).items() if _is_method(value)])
        if required:
            yield f"it has no method {call}" + (f"; is '{near}' meant?" if near else "")
    elif not callable(function) or isinstance(member, property):
        yield f"'{name}' must be a method {call}, got {type(member).__name__}"
    else:
        bound, signature = 0 if isinstance(member, staticmethod) else 1, inspect.signature(function)
        names = list(signature.parameters)[bound : bound + len(arguments)]
        if not _takes(signature, bound + len(arguments)):
            cure = "; write @staticmethod above it" if bound and _takes(signature, len(arguments)) else ""
            yield f"'{name}' is called as {call}, but takes {signature}{cure}"
        elif names != arguments and sorted(names) == sorted(arguments):
            yield f"'{name}' is called as {call}, by position, but takes {signature}: another order"


def _members(kind: type[Any], protocol: type[Any], *, required: bool) -> Iterator[str]:
    """Yield what is wrong with the methods and attributes that a protocol declares."""
    for name, hint in get_type_hints(protocol, include_extras=True).items():
        yield from _attribute(kind, name, hint, required=required)
    for name, value in vars(protocol).items():
        if name.startswith("_"):
            continue
        if isinstance(value, property):
            if required and not has_member(kind, name):
                yield f"it has no '{name}': {(inspect.getdoc(value) or '').splitlines()[0]}"
        elif _is_method(value):
            yield from check_method(kind, name, protocol, required=required)


def _attribute(kind: type[Any], name: str, hint: Any, *, required: bool) -> Iterator[str]:
    """Yield what is wrong with an attribute; one that a protocol declares without ``ClassVar`` is an option."""
    is_option = get_origin(hint) is not ClassVar
    inner = hint if is_option else get_args(hint)[0]
    allowed, meaning = get_args(inner)[:2] if get_origin(inner) is Annotated else (inner, "")
    choices = _choices(allowed)
    meaning = ", ".join(part for part in (meaning, f"one of {', '.join(choices)}" if choices else "") if part)
    given = inspect.getattr_static(kind, name, None)
    if not has_member(kind, name):
        if required:
            yield f"it has no {'option ' if is_option else ''}'{name}': {meaning}"
    elif not is_option and name not in kind.__dict__.get("__pydantic_fields__", ()) and not _fits(given, allowed):
        yield f"'{name}' must be {meaning}, got {given!r}{suggestion(str(given), choices)}"


def _choices(hint: Any) -> list[str]:
    """Return the names of the values that a type allows, where these are few."""
    if get_origin(hint) is Literal:
        return [f"{type(one).__name__}.{one.name}" if isinstance(one, Enum) else str(one) for one in get_args(hint)]
    return [f"{hint.__name__}.{one.name}" for one in hint] if isinstance(hint, type) and issubclass(hint, Enum) else []


def _fits(given: Any, hint: Any) -> bool:
    """Return whether a value has a type; what is worked out for each instance is not looked at."""
    if isinstance(given, property) or inspect.isdatadescriptor(given):
        return True
    try:
        TypeAdapter(hint, config=ConfigDict(strict=True, arbitrary_types_allowed=True)).validate_python(given)
    except ValidationError:
        return False
    return True


def _function(attribute: Any) -> Any:
    """Return the function behind a method, a static one or a property."""
    if isinstance(attribute, property):
        return attribute.fget
    return getattr(attribute, "__func__", attribute)


def _is_method(value: Any) -> bool:
    return inspect.isfunction(value) or isinstance(value, staticmethod)


def _making(kind: type[Any]) -> Iterator[str]:
    """Yield whether the class was made by ``@kind``, with all its options."""
    if not hasattr(kind, "__pydantic_fields__"):
        yield "it is no kind: write @kind above the class (from irsim_gym.plugins import kind)"
        return
    declared = option_fields(kind)
    for name, value in vars(kind).items():
        if isinstance(value, FieldInfo) and name not in declared:
            yield f"option '{name}' has no type: write '{name}: float = option(...)'"
    hints = {name: str(hint) for name, hint in vars(kind).get("__annotations__", {}).items() if name not in declared}
    lost = [name for name, hint in hints.items() if "ClassVar" not in hint]
    if lost:
        yield f"its options {', '.join(lost)} are not known: write @kind above this class too"


def _takes(signature: inspect.Signature, count: int) -> bool:
    try:
        signature.bind(*range(count))
    except TypeError:
        return False
    return True
