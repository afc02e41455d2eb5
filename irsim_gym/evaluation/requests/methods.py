"""Methods: groups of policies that are compared under one name, such as the seeds of a training."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.saved_policies.policies import Source, policy_digest, policy_names

Sources = Sequence[Source] | Mapping[str, Source | Sequence[Source]]
"""Policies, or a mapping from the names of methods to a policy or to several seeds."""


@dataclass(frozen=True)
class ComparedMethod:
    """A method: a single policy, or the seeds of a training.

    Attributes:
        name: Name in tables.
        sources: Policies of the method, as ``load_policy`` takes them.
    """

    name: str
    sources: tuple[str, ...]

    def identity(self) -> list[dict[str, Any]]:
        """Return the source of each policy, with the hash of its file."""
        return [{"source": source, "sha256": policy_digest(source)} for source in self.sources]


def read_methods(texts: Sequence[str]) -> list[ComparedMethod]:
    """Parse the methods of a command line: ``POLICY``, or ``NAME=POLICY,POLICY,...`` for several seeds.

    Raises:
        IrsimGymError: If two methods have the same name, or a method has no policy.
    """
    named = [_divided(text) for text in texts]
    short = iter(policy_names([text for name, text in named if not name]))
    methods = [ComparedMethod(name or next(short), tuple(text.split(",")) if name else (text,)) for name, text in named]
    for method in methods:
        if "" in method.sources:
            raise IrsimGymError(
                f"'{method.name}=...' needs policies, divided by commas, got '{','.join(method.sources)}'"
            )
    names = [method.name for method in methods]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise IrsimGymError(f"two methods are named '{twice[0]}': give them names, NAME=POLICY")
    return methods


def _divided(text: str) -> tuple[str, str]:
    """Return the name of a method, which may be empty, and its policies. An existing path may contain ``=``."""
    name, equals, rest = text.partition("=")
    is_named = equals and re.fullmatch(r"[\w.-]+", name) and not Path(text).exists()
    return (name, rest) if is_named else ("", text)


def by_method(sources: Sources) -> dict[str, list[Source]]:
    """Return the policies of each method. In a sequence, each policy is a method of its own.

    Raises:
        IrsimGymError: If a method has no policy.
    """
    if not isinstance(sources, Mapping):
        return {name: [source] for name, source in zip(policy_names(sources), sources, strict=True)}
    methods: dict[str, list[Source]] = {}
    for name, policies in sources.items():
        several = isinstance(policies, Sequence) and not isinstance(policies, str)
        methods[name] = list(policies) if several else [policies]  # type: ignore[arg-type, list-item]
        if not methods[name]:
            raise IrsimGymError(f"the method '{name}' has no policies: give it one, or a list of several")
    return methods


def names_of_policies(methods: Mapping[str, Sequence[Source]]) -> dict[str, list[str]]:
    """Return the names of the policies of each method; several policies are numbered.

    Raises:
        IrsimGymError: If two policies would have the same name.
    """
    names_by_method = {
        name: [name] if len(sources) == 1 else [f"{name}-{number}" for number in range(1, len(sources) + 1)]
        for name, sources in methods.items()
    }
    names = [name for several in names_by_method.values() for name in several]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise IrsimGymError(f"two policies are named '{twice[0]}': give their methods other names")
    return names_by_method
