"""How a decorator makes a kind of a function, and how the kind calls it."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

import numpy as np

from irsim_gym.base import families
from irsim_gym.base.errors import KindError
from irsim_gym.base.options import kind_of_function
from irsim_gym.base.registry import Registry
from irsim_gym.bodies.behaviors.python.custom import noting
from irsim_gym.bodies.behaviors.python.views import EgoView, ego_view
from irsim_gym.simulator.world.names import Floats, Group, Model, Shard, State

F = TypeVar("F", bound=Callable[..., Any])


def registering(
    registry: Registry, name: str, base: type[Any], leading: Sequence[str], **members: Any
) -> Callable[[F], F]:
    """Return a decorator that registers a function as a kind, and returns the function as it is.

    Args:
        registry: Of the family.
        name: Name of the kind in YAML.
        base: Class that calls the function.
        leading: What the function is called with before its options.
        **members: Attributes of the kind.
    """
    families.load()

    def register(function: F) -> F:
        registry.register(name, kind_of_function(registry.family, name, function, base, leading, **members))
        return function

    return register


def answer(
    kind: Any, ego: EgoView, size: int, function: Callable[..., Any], arguments: Sequence[Any], options: dict[str, Any]
) -> Floats:
    """Return the numbers that a kind's function returns for a body, shape ``(size,)``.

    Raises:
        KindError: It returns anything else.
    """
    with noting(kind, f"'{ego.name}'", ego._now, ego._w):
        return numbers(kind, ego.name, size, function(ego, *arguments, **options))


def numbers(kind: Any, whose: str, size: int, answer: Any) -> Floats:
    """Return ``size`` numbers as an array.

    Raises:
        KindError: They are not that many, or no numbers.
    """
    try:
        row = np.asarray(answer, np.float64).ravel()
    except (TypeError, ValueError):
        row = np.zeros(0)
    if answer is None or len(row) != size:
        many = "one number" if size == 1 else f"{size} numbers"
        raise KindError(f"{kind.called} must return {many} for '{whose}', got {answer!r}")
    return row


def members(
    group: Group, model: Model, state: State, shard: Shard
) -> Iterator[tuple[int, int, EgoView, dict[str, Any]]]:
    """Yield world, number, view and options of each member that is there, world by world."""
    values = [group.kind.own_options(options) for options in group.options]
    for w in shard.worlds.tolist():
        for k, b in enumerate(group.members.tolist()):
            if model.present[w, b]:
                yield w, k, ego_view(group, model, state, w, b), values[k]
