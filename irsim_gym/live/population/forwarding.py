"""Names of an object that one of its parts answers, with types and documentation of the part."""

from collections.abc import Callable
from typing import Any, Concatenate, Generic, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


class Method(Generic[P, R]):
    """A method of a part.

    Args:
        part: Name of the attribute that holds the part.
        function: The method, as a function of the part's class.
    """

    def __init__(self, part: str, function: Callable[Concatenate[Any, P], R]) -> None:
        self._part, self._function = part, function

    def __get__(self, whole: object, owner: type[Any] | None = None) -> Callable[P, R]:
        return self._function.__get__(None if whole is None else getattr(whole, self._part), owner)  # type: ignore[no-any-return]


class Attribute(Generic[R]):
    """A property of a part, which can only be read.

    Args:
        part: Name of the attribute that holds the part.
        getter: The property, as an attribute of the part's class.
    """

    def __init__(self, part: str, getter: Callable[[Any], R]) -> None:
        self._part, self._getter = part, getter
        self.__doc__ = getter.__doc__

    def __get__(self, whole: object, owner: type[Any] | None = None) -> R:
        if whole is None:
            return self  # type: ignore[return-value]
        return self._getter.__get__(getattr(whole, self._part))  # type: ignore[no-any-return]

    def __set__(self, whole: object, value: object) -> None:
        raise AttributeError("this attribute can only be read", obj=whole)
