"""Behaviours that a file names but that are not registered yet; a world by hand waits for them until its first step."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar, NoReturn

from irsim_gym.base.errors import BehaviorError, UnknownNameError
from irsim_gym.base.options import kind, option
from irsim_gym.scenario.checking.validation import BAD, Report, build, build_named
from irsim_gym.scenario.entries.body_checks import DECIDING, check_drive, check_scan
from irsim_gym.scenario.specs.spec import BodySpec, Scenario
from irsim_gym.scenario.specs.wander_goals import RenewsGoals
from irsim_gym.scenario.text.source import Place

RENEWAL = ("wander", "loop", "range_low", "range_high", "wander_goals")


@kind
class PendingBehavior(RenewsGoals):
    """A behaviour that is not registered yet; it raises an error when it has to decide.

    Members of a group whose behaviour is unknown decide individually, as in IR-SIM.
    """

    reads_neighbors: ClassVar[bool] = False
    is_known: ClassVar[bool] = False

    key: str = option("behavior", meaning="Where it stands: behavior or group_behavior.")
    where: str = option("", meaning="File and line.")
    place: tuple[Any, ...] = option((), meaning="Its path.")
    data: Any = option(None, meaning="What stands there.")

    @staticmethod
    def prepare(group: object, model: object, n_slots: int) -> None:
        """Do nothing."""

    @staticmethod
    def begin(group: object, shard: object) -> None:
        """Do nothing."""

    @staticmethod
    def decide(group: Any, model: Any, state: Any, shard: Any) -> NoReturn:
        """Raise an error about the missing behaviour.

        Raises:
            BehaviorError: Always.
        """
        raise BehaviorError(_missing(group.options[0]))


def _missing(pending: PendingBehavior) -> str:
    """Return a message about an unknown behaviour: its place, and what to do."""
    try:
        DECIDING[pending.key].entry(pending.data["name"])
    except UnknownNameError as error:
        message = f"{error}; world.load_behavior('my_module') imports a module that registers it"
    else:
        message = f"'{pending.data['name']}' is registered now; call world.load_behavior('its_module') to use it"
    return f"{pending.where}: {message}" if pending.where else message


def read_pending(key: str, data: Mapping[str, object], place: Place, report: Report) -> PendingBehavior | None:
    """Return a placeholder for an unknown behaviour; None after reporting problems with its goals."""
    made = build(PendingBehavior, {name: data[name] for name in RENEWAL if name in data}, place, report)
    line = report.source.line((*place, "name"))
    where = f"{report.source.title}:{line}" if line else report.source.title
    return None if made is None else replace(made, key=key, where=where, place=place, data=data)


def is_pending(key: str, data: object) -> bool:
    """Return whether an entry names a behaviour that is not registered."""
    name = data.get("name") if isinstance(data, Mapping) else None
    return key in DECIDING and isinstance(name, str) and name not in DECIDING[key]


def unknown_groups(scenario: Scenario) -> list[str]:
    """Return messages about groups whose behaviour is not registered."""
    found = [body.group_behavior for body in scenario.bodies]
    return list(dict.fromkeys(_missing(one) for one in found if isinstance(one, PendingBehavior)))


def resolve_pending(scenario: Scenario) -> Scenario:
    """Return a scenario with the behaviours that were registered after it was read.

    Raises:
        ScenarioError: If an entry of such a behaviour cannot be used; the error lists every problem with its line.
    """
    report = Report(scenario.source)
    made: dict[int, Any] = {}
    bodies = tuple(_resolved(body, made, report) for body in scenario.bodies)
    report.check()
    return replace(scenario, bodies=bodies) if made else scenario


def _resolved(body: BodySpec, made: dict[int, Any], report: Report) -> BodySpec:
    found: dict[str, PendingBehavior] = {}
    for key, registry in DECIDING.items():
        pending = getattr(body, key)
        if isinstance(pending, PendingBehavior) and not is_pending(key, pending.data):
            found[key] = pending
            if id(pending) not in made:
                built = build_named(registry, pending.data, pending.place, report)
                made[id(pending)] = BAD if built is None else built
    new = {key: made[id(pending)] for key, pending in found.items()}
    if not new or any(value is BAD for value in new.values()):
        return body
    resolved = replace(body, **new)
    values = {key: getattr(resolved, key) for key in ("kinematics", "static", "mass", "sensors", *DECIDING)}
    places = {key: getattr(getattr(body, key), "place", ()) for key in DECIDING}
    for check in (check_drive, check_scan):
        check(values, places, report)
    return resolved
