"""Sensors, drives and placements of one's own, written as functions of one body."""

import inspect
from collections.abc import Callable, Sequence
from typing import Any, ClassVar, TypeVar

import numpy as np

from irsim_gym.base import families
from irsim_gym.base.options import function_parameters, kind
from irsim_gym.bodies.behaviors.python.custom import noting
from irsim_gym.bodies.behaviors.python.views import BodyView, reserve_memory
from irsim_gym.bodies.placements.free_space import is_goal_free, is_start_free
from irsim_gym.plugins.functions import answer, members, numbers, registering
from irsim_gym.simulator.geometry.angles import wrap_from
from irsim_gym.simulator.step import outlines
from irsim_gym.simulator.world.names import Floats, Group, Ints, Model, Shard, State
from irsim_gym.simulator.world.outline import Outline

F = TypeVar("F", bound=Callable[..., Any])

TRIES = 100
"""How often a placement is asked for a start until it is free."""


@kind
class FunctionSensor:
    """A sensor written as a function."""

    reading: ClassVar[str] = ""
    size: ClassVar[int] = 1

    def group_key(self) -> tuple[Any, ...]:
        """Return nothing: all members of the kind are one group."""
        return ()

    @staticmethod
    def prepare(group: Group, outlines: list[Outline], model: Model, n_slots: int) -> None:
        """Make room for readings ``(n_worlds, n_members, size)`` and memories."""
        group.arrays[group.kind.reading] = np.zeros((len(model.present), len(group.members), group.kind.size))
        reserve_memory(group, model)

    @staticmethod
    def sense(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write what the function returns."""
        size, readings = group.kind.size, group.arrays[group.kind.reading]
        for w, k, ego, options in members(group, model, state, shard):
            readings[w, k] = answer(group.kind, ego, size, group.kind.function, (), options)


@kind
class PythonDrive:
    """What drives in Python have in common, written as functions or as classes."""

    command_names: ClassVar[tuple[str, ...]] = ()
    state_size: ClassVar[int] = 3

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Make room for memories."""
        reserve_memory(group, model)


@kind
class FunctionDrive(PythonDrive):
    """A drive written as a function."""

    @staticmethod
    def begin(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' twists from their headings and initial velocities."""
        for w, k, ego, options in members(group, model, state, shard):
            state.twist[w, ego.id] = _turned(_twist(group, k, ego, options), state.pose[w, ego.id, 2])

    @staticmethod
    def move(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Advance the poses of the members that are free to move, and write all twists, after the move."""
        for w, k, ego, options in members(group, model, state, shard):
            pose, twist = state.pose[w, ego.id], _twist(group, k, ego, options)
            if not state.stopped[w, ego.id]:
                pose += _turned(twist, pose[2]) * model.step_time[0]
                pose[2] = wrap_from(pose[2], model.heading_low[ego.id])
            state.twist[w, ego.id] = _turned(twist, pose[2])


@kind
class FunctionSteeredDrive(FunctionDrive):
    """A drive with a second function, from a velocity to a command."""

    @staticmethod
    def steer(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Turn velocities in ``state.command`` into commands."""
        size, keys = len(group.kind.command_names), group.kind.steer_options
        for w, _, ego, options in members(group, model, state, shard):
            target, values = state.command[w, ego.id, :2].copy(), {key: options[key] for key in keys}
            command = answer(group.kind, ego, size, group.kind.steering, (target,), values)
            state.command[w, ego.id] = 0.0
            if not state.stopped[w, ego.id]:
                state.command[w, ego.id, :size] = command


def _twist(group: Group, k: int, ego: Any, options: dict[str, Any]) -> Floats:
    """Return a member's velocity in its own frame: ahead, left [m/s], turn rate [rad/s]."""
    size = len(group.kind.command_names)
    return answer(group.kind, ego, 3, group.kind.function, (ego.velocity[:size],), options)


def _turned(twist: Floats, heading: float) -> Floats:
    """Return a twist in the body frame in the world frame."""
    cosine, sine = np.cos(heading), np.sin(heading)
    return np.array([cosine * twist[0] - sine * twist[1], sine * twist[0] + cosine * twist[1], twist[2]])


@kind
class FunctionPlacement:
    """A distribution written as a function."""

    is_random: ClassVar[bool] = True
    roams: ClassVar[bool] = True
    ensures_way: ClassVar[bool] = False
    gives_goal: ClassVar[bool] = False

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> str | None:
        """Make room for views of bodies; a placement remembers nothing."""
        reserve_memory(group, model)
        return None

    @staticmethod
    def draw(group: Group, model: Model, state: State, shard: Shard, failed: Ints) -> None:
        """Ask for the start of each member that has none until it is free."""
        for w, _, ego, options in members(group, model, state, shard):
            if failed[w] == 0 and not state.placed[w, ego.id]:
                state.placed[w, ego.id] = _place(group, model, state, ego, options)
                failed[w] = 0 if state.placed[w, ego.id] else ego.id + 1


def _place(group: Group, model: Model, state: State, ego: Any, options: dict[str, Any]) -> bool:
    """Write a start, and a goal where the placement gives one; return whether both are free."""
    w, b, kind = ego._w, ego.id, group.kind
    everyone, body = np.arange(len(model.role)), np.array([b])
    placed = np.flatnonzero(state.placed[w] & model.present[w]).tolist()
    for _ in range(TRIES):
        others = [BodyView(group, model, state, w, other) for other in placed]
        with noting(kind, f"'{ego.name}'", state, w):
            found = kind.function(ego, others, **options)
            if found is None:
                return False
            poses = numbers(kind, ego.name, 6 if kind.gives_goal else 3, found).reshape(-1, 3)
        state.pose[w, b] = poses[0]
        outlines.place(body, model, state, Shard(np.array([w])))
        if not is_start_free(w, b, everyone, 0.0, model, state, model.cells):
            continue
        if kind.gives_goal and model.has_goal[b]:
            model.waypoints[w, b, 0] = poses[1]
            if not is_goal_free(w, b, 0, 0.0, model, state, model.cells):
                continue
        return True
    return False


def sensor(name: str, *, size: int = 1) -> Callable[[F], F]:
    """Register a function as a sensor, to be used in ``sensors:`` of a body.

    It is called as ``f(ego, **options)`` for one body of one world at a time, at the start of an episode and after each
    step, and returns ``size`` numbers. ``ego.reading(name)`` returns them, in functions of any kind; ``ego`` is an
    ``EgoView``, and ``ego.external_objects`` are the other bodies.

    Options are keyword-only parameters as for ``irsim_gym.behavior``. What the function remembers belongs into
    ``ego.memory``, a dictionary for each world and body that is empty when an episode begins; random numbers come from
    ``ego.uniform`` and ``ego.normal``, which draw from the world's own stream.

    Args:
        name: Its name in YAML, and that of its reading.
        size: How many numbers it returns.

    Raises:
        TypeError: The function's parameters are not as above.
        IrsimGymError: The name is taken.
    """
    return registering(families.SENSORS, name, FunctionSensor, ("ego",), reading=name, size=size)


def drive(
    name: str,
    *,
    command: Sequence[str],
    steer: Callable[..., Any] | None = None,
    mirrored_command: Sequence[tuple[int, int]] = (),
) -> Callable[[F], F]:
    """Register a function as a drive, to be used as ``kinematics: {name: ...}`` of a body.

    It is called as ``f(ego, command, **options)`` for one body of one world at a time: from a command, within the
    body's limits, to the velocity that it moves with in its own frame, ``[ahead, left, turn rate]`` [m/s, m/s, rad/s].
    ``steer(ego, velocity, **options)`` is the other direction: from a wanted velocity in the world frame, ``[vx, vy]``
    [m/s], to a command. With it any behaviour for ``omni`` drives the body, such as dash, rvo, orca and sfm; its
    greatest speed is the first number of ``vel_max``. Options, memory and random numbers are as for ``sensor``;
    ``steer`` takes those of the options that it names.

    Args:
        name: Its name in YAML.
        command: Names of the two or three numbers of a command.
        steer: From a velocity to a command; without it behaviours command the drive only if they name it.
        mirrored_command: For each number of a command, the number that takes its place where left and right are
            exchanged, and the sign of that: ``((1, 1), (0, 1))`` for the speeds of a left and a right track. Without
            it, no policy learns from mirrored rows.

    Raises:
        TypeError: The functions' parameters are not as above.
        ValueError: A command has not two or three numbers.
        IrsimGymError: The name is taken.
    """
    names = tuple(command)
    if isinstance(command, str) or len(names) not in (2, 3):
        raise ValueError(f"kinematics '{name}': command must be two or three names, got {command!r}")
    members: dict[str, Any] = {"command_names": names}
    if mirrored_command:
        members["mirrored_command"] = tuple(map(tuple, mirrored_command))
    if steer is None:
        return registering(families.KINEMATICS, name, FunctionDrive, ("ego", "command"), **members)
    parameters = function_parameters("steer of kinematics", name, steer)
    taken = tuple(item.name for item in parameters if item.kind is item.KEYWORD_ONLY)
    plain = [item for item in parameters if item.kind in (item.POSITIONAL_ONLY, item.POSITIONAL_OR_KEYWORD)]
    if len(plain) != 2 or len(plain) + len(taken) != len(parameters):
        raise TypeError(f"steer of kinematics '{name}': the parameters must be ego, velocity, a '*', and the options")
    members |= {"steering": staticmethod(steer), "steer_options": taken}
    register = registering(families.KINEMATICS, name, FunctionSteeredDrive, ("ego", "command"), **members)

    def check_and_register(function: F) -> F:
        missing = set(taken) - set(inspect.signature(function).parameters)
        if missing:
            raise TypeError(f"steer of kinematics '{name}': the drive has no option '{min(missing)}'")
        return register(function)

    return check_and_register


def placement(name: str, *, gives_goal: bool = False) -> Callable[[F], F]:
    """Register a function as a distribution, to be used as ``distribution: {name: ...}`` of an entry.

    It is called as ``f(ego, others, **options)`` for one body of one world at a time, whenever a level is drawn, and
    returns where the body starts, ``[x, y, heading]`` [m, m, rad], with ``gives_goal`` followed by where its goal is,
    or None where it finds no place. Where the body would touch what is placed already, or its goal lies in what stands,
    it is asked again, 100 times at most; then, and after None, the level is drawn anew. ``others`` are views of the
    bodies that are placed. Options are keyword-only parameters as for ``irsim_gym.behavior``; random numbers come from
    ``ego.uniform`` and ``ego.normal``, which draw from the world's own stream. A placement remembers nothing, so that
    a level follows from its seed alone.

    Args:
        name: Its name in YAML.
        gives_goal: It returns a goal, too.

    Raises:
        TypeError: The function's parameters are not as above.
        IrsimGymError: The name is taken.
    """
    return registering(families.PLACEMENTS, name, FunctionPlacement, ("ego", "others"), gives_goal=gives_goal)
