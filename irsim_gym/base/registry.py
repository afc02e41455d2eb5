"""Named kinds: the one way in which the package is extended."""

import importlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from irsim_gym.base.errors import IrsimGymError, UnknownNameError, suggestion

OWN = "irsim_gym."
"""How the names of the package's own modules begin."""


@dataclass(frozen=True)
class Entry:
    """A registered kind.

    Attributes:
        name: Its name in YAML.
        kind: The class; a frozen dataclass made by ``base.options.kind``.
    """

    name: str
    kind: type[Any]


class Registry:
    """The kinds of one family, by their YAML names.

    Args:
        family: What they are, in messages.
        advice: What to do about a name that is like no other, because nobody has registered it yet.
        contract: Module and name of the ``contract.Contract`` that classes from outside the package have to keep. By
            name, so that nothing here depends on a kind; without one nothing is checked.
    """

    def __init__(self, family: str, advice: str = "", contract: tuple[str, str] | None = None) -> None:
        self.family = family
        self._advice = advice
        self._contract = contract
        self._entries: dict[str, Entry] = {}

    def register(self, name: str, kind: type[Any]) -> None:
        """Add a kind.

        Raises:
            IrsimGymError: The name is taken by another class.
            KindError: A class of one's own does not do what the family asks for.
        """
        if self._contract and not getattr(kind, "__module__", "").startswith(OWN):
            module, attribute = self._contract
            contract = getattr(importlib.import_module(module), attribute)
            importlib.import_module("irsim_gym.base.contract").check_kind(self.family, name, kind, contract)
        entry = self._entries.get(name)
        if entry is not None and entry.kind is not kind:
            raise IrsimGymError(f"{self.family} '{name}' is registered twice: by {_path(entry.kind)} and {_path(kind)}")
        self._entries[name] = Entry(name, kind)

    def entry(self, name: str) -> Entry:
        """Return what is registered under ``name``.

        Raises:
            UnknownNameError: Nothing is; the message offers the nearest name.
        """
        try:
            return self._entries[name]
        except KeyError:
            cure = suggestion(name, self._entries) or self._advice
            raise UnknownNameError(f"no {self.family} named '{name}'{cure}") from None

    def __contains__(self, name: str) -> bool:
        return name in self._entries

    def __iter__(self) -> Iterator[Entry]:
        return iter(self._entries.values())

    def names(self) -> tuple[str, ...]:
        """Return the names of the kinds, in the order of their registration."""
        return tuple(self._entries)

    def name_of(self, kind: type[Any]) -> str:
        """Return the YAML name of a registered class."""
        for entry in self:
            if entry.kind is kind:
                return entry.name
        raise UnknownNameError(f"{_path(kind)} is not a registered {self.family}")


def _path(kind: type[Any]) -> str:
    return f"{kind.__module__}.{kind.__qualname__}"
