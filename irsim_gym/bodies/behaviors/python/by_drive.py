"""Behaviours registered by drive and name as in IR-SIM, which get IR-SIM's arguments with column vectors."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from irsim_gym.base import families
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.options import make_kind, more_options, option_fields
from irsim_gym.base.registry import Registry
from irsim_gym.bodies.behaviors.python.custom import PythonBehavior, PythonGroupBehavior
from irsim_gym.bodies.behaviors.python.views import BodyView, EgoView

F = TypeVar("F", bound=Callable[..., Any])

_HANDLER = "what register_behavior_class made"
"""Key in a body's memory under which the instance is kept that a factory has made."""


@dataclass(frozen=True)
class _Written:
    """A function or class that is registered for one drive.

    Attributes:
        function: The deciding function, or the factory of one.
        makes: Whether it is a factory, which is called once in each episode.
    """

    function: Callable[..., Any]
    makes: bool


def register_behavior(kinematics: str, action: str) -> Callable[[F], F]:
    """Register a function as IR-SIM's ``register_behavior`` does, to be used as ``behavior: {name: action}``.

    The function is called as ``f(ego_object=..., external_objects=..., **options)`` and returns a command of the
    drive, flat or as a column. The objects are an ``EgoView`` and a list of ``BodyView``, whose arrays are columns of
    shape ``(n, 1)`` under IR-SIM's names. The options are ``name`` and all others in the file, without checks. A
    behaviour may be registered for several drives, with a function for each.

    Args:
        kinematics: Name of the drive, such as ``diff``.
        action: Name of the behaviour in YAML.

    Raises:
        UnknownNameError: If there is no such drive.
        IrsimGymError: If the name is taken for this drive.
    """
    return _decorator(families.BEHAVIORS, kinematics, action, makes=False)


def register_behavior_class(kinematics: str, action: str) -> Callable[[F], F]:
    """Register a class, or a function that makes an instance, as IR-SIM's ``register_behavior_class`` does.

    The class is called as ``f(object_info, **options)`` before the body's first decision in each episode. The result is
    called in each step, like a function of ``register_behavior``. ``object_info`` is the body's ``EgoView``.

    Args:
        kinematics: As for ``register_behavior``.
        action: See there.

    Raises:
        UnknownNameError: If there is no such drive.
        IrsimGymError: If the name is taken for this drive.
    """
    return _decorator(families.BEHAVIORS, kinematics, action, makes=True)


def register_group_behavior(kinematics: str, action: str) -> Callable[[F], F]:
    """Register a function as IR-SIM's ``register_group_behavior`` does, for ``group_behavior: {name: action}``.

    The function is called as ``f(members, **options)`` and returns a list with one command for each member; otherwise
    like ``register_behavior``. The drive is that of the group's first member.

    Args:
        kinematics: As for ``register_behavior``.
        action: See there.

    Raises:
        UnknownNameError: If there is no such drive.
        IrsimGymError: If the name is taken for this drive.
    """
    return _decorator(families.GROUP_BEHAVIORS, kinematics, action, makes=False)


def register_group_behavior_class(kinematics: str, action: str) -> Callable[[F], F]:
    """Register a class, or a function that makes an instance, as IR-SIM's ``register_group_behavior_class`` does.

    The class is called as ``f(members, **options)`` before the group's first decision in each episode. The result is
    called in each step, like a function of ``register_group_behavior``.

    Args:
        kinematics: As for ``register_behavior``.
        action: See there.

    Raises:
        UnknownNameError: If there is no such drive.
        IrsimGymError: If the name is taken for this drive.
    """
    return _decorator(families.GROUP_BEHAVIORS, kinematics, action, makes=True)


def _decorator(registry: Registry, drive: str, name: str, *, makes: bool) -> Callable[[F], F]:
    families.load()
    families.KINEMATICS.entry(drive)

    def register(function: F) -> F:
        kind = registry.entry(name).kind if name in registry else None
        # The first drive of this name makes the kind; a built-in kind of the name makes `register` raise.
        if kind is None or not hasattr(kind, "by_drive"):
            kind = _make_kind(registry, name, function)
            registry.register(name, kind)
        if drive in kind.by_drive:
            raise IrsimGymError(f"{registry.family} '{name}' is registered twice for kinematics '{drive}'")
        kind.by_drive[drive] = _Written(function, makes)
        kind.kinematics = tuple(kind.by_drive)
        return function

    return register


def _make_kind(registry: Registry, name: str, function: Callable[..., object]) -> type[Any]:
    """Return a kind that accepts any options and calls the function registered for the drive."""
    is_group = registry is families.GROUP_BEHAVIORS
    base = PythonGroupBehavior if is_group else PythonBehavior
    by_drive: dict[str, _Written] = {}

    def own_options(chosen: object) -> dict[str, Any]:
        values = {key: getattr(chosen, key) for key, field in option_fields(base).items()}
        # IR-SIM passes only the options that the file has, so common options at their defaults are left out.
        values = {key: value for key, value in values.items() if value != option_fields(base)[key].default}
        return {"name": name, **values, **more_options(chosen)}

    def decide(ego: EgoView, seen: list[BodyView], **options: object) -> Any:
        decider = _decider(by_drive[str(ego.kinematics)], ego, ego.memory, options)
        return decider(ego_object=ego, external_objects=seen, **options)

    def decide_together(members: list[EgoView], seen: list[BodyView], **options: object) -> Any:
        if not members:
            return []
        decider = _decider(by_drive[str(members[0].kinematics)], members, members[0].memory, options)
        return decider(members, **options)

    return make_kind(
        registry.family,
        name,
        function,
        base,
        {},
        takes_more=True,
        columns=True,
        kinematics=(),
        by_drive=by_drive,
        function=staticmethod(decide_together) if is_group else staticmethod(decide),
        own_options=staticmethod(own_options),
    )


def _decider(written: _Written, whom: object, memory: dict[str, Any], options: dict[str, Any]) -> Callable[..., Any]:
    """Return the deciding function: the registered one, or the one that the factory makes once in each episode."""
    if not written.makes:
        return written.function
    if _HANDLER not in memory:
        memory[_HANDLER] = written.function(whom, **options)
    handler: Callable[..., Any] = memory[_HANDLER]
    return handler
