"""Behaviours in plain Python: a function becomes a kind, and its keyword parameters become options in YAML."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, ClassVar, Literal, TypeVar

import numpy as np

from irsim_gym.base import families
from irsim_gym.base.errors import BehaviorError
from irsim_gym.base.options import kind, kind_of_function, option
from irsim_gym.base.registry import Registry
from irsim_gym.bodies.behaviors.python.views import EgoView, ego_view, name_of, others, reserve_memory, tell_missing
from irsim_gym.scenario.specs.wander_goals import RenewsGoals
from irsim_gym.simulator.world.model import NO_DRIVE, OBSTACLE
from irsim_gym.simulator.world.names import OMNI_ANGULAR, ROBOT, Floats, Group, Model, Shard, State

# In the order of the option's choices; -1 stands for every role.
ROLES = (-1, ROBOT, OBSTACLE)

F = TypeVar("F", bound=Callable[..., Any])


@kind
class PythonBehavior(RenewsGoals):
    """The base class of behaviours in Python: their common options, and how they are called."""

    reads_neighbors: ClassVar[bool] = True
    columns: ClassVar[bool] = False

    target_roles: Literal["all", "robot", "obstacle"] = option("all", meaning="Which other bodies are seen.")

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Allocate the members' memories."""
        reserve_memory(group, model)

    @staticmethod
    def decide(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Call the function for the command of each member that can move, world by world."""
        for w in shard.worlds:
            for k, b in enumerate(group.members):
                state.command[w, b] = 0.0
                if not model.present[w, b] or state.stopped[w, b]:
                    continue
                # The index of the choice, as in every table of options.
                role = ROLES[group.params["target_roles"][k]]
                # A slice of one body: `others` leaves out the bodies of an array.
                seen = others(group, model, state, int(w), group.members[k : k + 1], role)
                ego = ego_view(group, model, state, int(w), int(b))
                with noting(group.kind, f"'{ego.name}'", state, int(w)):
                    answer = group.kind.function(ego, seen, **group.kind.own_options(group.options[k]))
                    write_command(group, model, int(b), answer, state.command[w, b])


@kind
class PythonGroupBehavior(RenewsGoals):
    """The base class of group behaviours in Python."""

    reads_neighbors: ClassVar[bool] = True
    columns: ClassVar[bool] = False

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Allocate the members' memories."""
        reserve_memory(group, model)

    @staticmethod
    def decide(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Call the function for the commands of all members, world by world."""
        for w in shard.worlds:
            is_present = model.present[w, group.members]
            members = [ego_view(group, model, state, int(w), int(b)) for b in group.members[is_present]]
            # Group behaviours have no option `target_roles`: they see every role.
            seen = others(group, model, state, int(w), group.members, -1)
            with noting(group.kind, f"the group of '{name_of(group, int(group.members[0]))}'", state, int(w)):
                answers = group.kind.function(members, seen, **group.kind.own_options(group.options[0]))
                commands = _one_each(group, members, answers)
                for ego, answer, decides in zip(members, commands, group.arrays["decides"][is_present], strict=True):
                    if decides:
                        state.command[w, ego.id] = 0.0
                        write_command(group, model, ego.id, answer, state.command[w, ego.id])


@contextmanager
def noting(kind: Any, whose: str, state: State, world: int) -> Iterator[None]:
    """Add the body and the time of the call to any error of a kind's function."""
    try:
        yield
    except Exception as error:
        if isinstance(error, AttributeError):
            tell_missing(error)
        # `state.step` counts completed steps, and this one is under way.
        step = int(state.step[world]) + 1
        error.add_note(f"in {kind.called} for {whose}, step {step} of world {world}")
        raise


def behavior(name: str, *, kinematics: Sequence[str] | None = None) -> Callable[[F], F]:
    """Register a function as a behaviour, to be used as ``behavior: {name: ...}`` in a scenario.

    The function is called as ``f(ego, others, **options)`` once per step, world and body, in the order of the bodies;
    earlier bodies have moved already. It returns the command of the body's drive, e.g. ``[v, w]``. ``ego`` is an
    ``EgoView``, ``others`` a list of ``BodyView``. Its keyword-only parameters are options in YAML with their types and
    defaults, in addition to ``wander``, ``loop``, ``target_roles``, ``range_low`` and ``range_high``. Keep memory in
    ``ego.memory``, and draw random numbers with ``ego.uniform`` and ``ego.normal``, so that a seed gives the same
    episode in any batch. A function with ``**more`` accepts any further options in the file, without checks.

    Args:
        name: Its name in YAML.
        kinematics: Names of the drives that it can command; by default all.

    Raises:
        TypeError: If the function's parameters are not as above.
        IrsimGymError: If the name is taken.
    """
    return _decorator(name, kinematics, PythonBehavior, families.BEHAVIORS)


def group_behavior(name: str, *, kinematics: Sequence[str] | None = None) -> Callable[[F], F]:
    """Register a function as a group behaviour, to be used as ``group_behavior: {name: ...}`` in a scenario.

    The function is called as ``f(members, others, **options)`` once per step, world and group, before any body moves.
    It returns a list with one command for each member; commands of members that cannot move, or that a learner drives,
    are ignored. ``members`` is a list of ``EgoView``, ``others`` a list of ``BodyView`` of the bodies outside of the
    group. Options, memory and random numbers work as for ``behavior``.

    Args:
        name: Its name in YAML.
        kinematics: Names of the drives that it can command; by default all.

    Raises:
        TypeError: If the function's parameters are not as above.
        IrsimGymError: If the name is taken.
    """
    return _decorator(name, kinematics, PythonGroupBehavior, families.GROUP_BEHAVIORS)


def _decorator(name: str, kinematics: Sequence[str] | None, base: type[Any], registry: Registry) -> Callable[[F], F]:
    families.load()
    for drive in kinematics or ():
        families.KINEMATICS.entry(drive)
    drives = {} if kinematics is None else {"kinematics": tuple(kinematics)}
    leading = ("ego", "others") if registry is families.BEHAVIORS else ("members", "others")

    def register(function: F) -> F:
        registry.register(name, kind_of_function(registry.family, name, function, base, leading, **drives))
        return function

    return register


def write_command(group: Group, model: Model, body: int, answer: Any, command: Floats) -> None:
    """Write what a function returned into ``command``, shape ``(3,)``.

    Raises:
        BehaviorError: If it is not a command of the body's drive.
    """
    drive = model.drive[body]
    size = 3 if drive == OMNI_ANGULAR else 2
    try:
        numbers = np.asarray(answer, np.float64).ravel()
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    # A body without a drive of ours has a command of up to three numbers, whose meaning its plugin knows.
    fits = 1 <= len(numbers) <= 3 if drive == NO_DRIVE else len(numbers) == size
    if not fits or not np.isfinite(numbers).all():
        raise BehaviorError(
            f"{group.kind.called} must return {size} finite numbers for '{name_of(group, body)}', got {answer!r}"
        )
    command[: len(numbers)] = numbers


def _one_each(group: Group, members: Sequence[EgoView], answers: Any) -> Sequence[Any]:
    """Return the answers of a group behaviour if there is one for each member."""
    count = len(answers) if isinstance(answers, Sequence | np.ndarray) else -1
    if count != len(members):
        said = "no list" if count < 0 else f"{count} commands"
        raise BehaviorError(f"{group.kind.called} must return {len(members)} commands, one per member, got {said}")
    return list(answers)
