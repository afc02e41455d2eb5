"""Drives as classes in IR-SIM's form: one instance moves one body of one world."""

import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np

from irsim_gym.base import families
from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.options import kind, make_kind, more_options
from irsim_gym.bodies.behaviors.python.custom import noting
from irsim_gym.bodies.behaviors.python.views import EgoView
from irsim_gym.irsim.rotations import vel_diff2world
from irsim_gym.plugins.body_kinds import PythonDrive
from irsim_gym.plugins.functions import members, numbers
from irsim_gym.simulator.geometry.angles import wrap, wrap_from
from irsim_gym.simulator.world.names import Group, Model, Shard, State

HANDLER = "what register_kinematics has registered"
"""Key in a body's memory under which its instance is kept."""
COMMAND_NAMES = ("linear", "angular", "third")

C = TypeVar("C", bound=type["KinematicsHandler"])


class KinematicsHandler(ABC):
    """What classes for ``register_kinematics`` derive from; an instance belongs to one body until its episode ends.

    Args:
        name: Name of the drive in YAML.
        noise: The key ``noise`` of ``kinematics``, for the class to use.
        alpha: The key ``alpha``, likewise.

    Attributes:
        action_dim: How many numbers a command has: 2, or 3.
        tau: The key ``tau`` [s]; None without it.
    """

    action_dim: int = 2
    tau: float | None = None

    def __init__(self, name: str, noise: bool = False, alpha: Sequence[float] | None = None) -> None:
        self.name, self.noise, self.alpha = name, noise, list(alpha or (0.03, 0.0, 0.0, 0.03))

    @abstractmethod
    def step(self, state: Floats, velocity: Floats, step_time: float) -> Any:
        """Return the pose after a step, x, y, heading [m, m, rad], flat or as a column.

        Args:
            state: The present pose, shape ``(3, 1)``.
            velocity: The command within the body's limits, shape ``(action_dim, 1)``.
            step_time: Duration of the step [s].
        """

    def velocity_to_xy(self, state: Floats, velocity: Floats) -> Any:
        """Return the velocity in the world, vx and vy [m/s], where an episode begins; by default as of ``diff``.

        Args:
            state: The pose, shape ``(3, 1)``.
            velocity: The velocity of the file, shape ``(action_dim, 1)``.
        """
        return vel_diff2world(float(state[2, 0]), velocity)


class DifferentialKinematics(KinematicsHandler):
    """The drive ``diff`` as a class, to derive from."""

    def step(self, state: Floats, velocity: Floats, step_time: float) -> Any:
        """Return the pose after a step along the heading of its start, shape ``(3, 1)``.

        Args:
            state: The present pose, x, y, heading [m, m, rad], shape ``(3, 1)``.
            velocity: Speed ahead and turn rate [m/s, rad/s], shape ``(2, 1)``.
            step_time: Duration of the step [s].
        """
        return differential_kinematics(state, velocity, step_time)


def differential_kinematics(state: Floats, velocity: Floats, step_time: float) -> Floats:
    """Return the pose of a differential drive after a step, without noise, shape ``(3, 1)``.

    Args:
        state: The present pose, x, y, heading [m, m, rad], shape ``(3, 1)``.
        velocity: Speed ahead and turn rate [m/s, rad/s], shape ``(2, 1)``.
        step_time: Duration of the step [s].
    """
    heading = float(state[2, 0])
    ahead = np.vstack([vel_diff2world(heading, velocity), velocity[1:2]])
    moved: Floats = state[:3] + step_time * ahead
    moved[2, 0] = wrap(moved[2, 0])
    return moved


def register_kinematics(name: str) -> Callable[[C], C]:
    """Register a class as IR-SIM's ``register_kinematics`` does, to be used as ``kinematics: {name: name}``.

    The class derives from ``KinematicsHandler``. It is called as ``f(name, noise, alpha, **options)``, with all other
    keys of the file, before a body moves for the first time in an episode, and its ``step`` moves the body then. Limits
    of speed and acceleration act before it. ``tau`` is an attribute, too, as in IR-SIM.

    Args:
        name: Its name in YAML.

    Raises:
        TypeError: It is no such class.
        IrsimGymError: The name is taken.
    """
    families.load()

    def register(written: C) -> C:
        if not (inspect.isclass(written) and issubclass(written, KinematicsHandler)):
            raise TypeError(f"kinematics '{name}': must be a class derived from KinematicsHandler, got {written!r}")
        options: dict[str, Any] = {"command_names": COMMAND_NAMES[: written.action_dim], "handler": written}
        options |= {"own_options": staticmethod(more_options), "takes_more": True}
        families.KINEMATICS.register(name, make_kind("kinematics", name, written, ClassDrive, {}, **options))
        return written

    return register


@kind
class ClassDrive(PythonDrive):
    """A drive written as a class."""

    @staticmethod
    def begin(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' twists from their initial velocities."""
        for w, _, ego, options in members(group, model, state, shard):
            handler, pose, velocity = _handler(group.kind, ego, options), *_columns(group, state, w, ego.id)
            with noting(group.kind, f"'{ego.name}'", state, w):
                state.twist[w, ego.id, :2] = numbers(group.kind, ego.name, 2, handler.velocity_to_xy(pose, velocity))
            state.twist[w, ego.id, 2] = 0.0

    @staticmethod
    def move(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Move the members that are free to move, and write the twists with which they have."""
        dt = float(model.step_time[0])
        for w, _, ego, options in members(group, model, state, shard):
            handler, pose, velocity = _handler(group.kind, ego, options), *_columns(group, state, w, ego.id)
            before = state.pose[w, ego.id].copy()
            with noting(group.kind, f"'{ego.name}'", state, w):
                moved = numbers(group.kind, ego.name, 3, np.ravel(handler.step(pose, velocity, dt))[:3])
            if not state.stopped[w, ego.id]:
                state.pose[w, ego.id, :2] = moved[:2]
                state.pose[w, ego.id, 2] = wrap_from(moved[2], model.heading_low[ego.id])
            way = state.pose[w, ego.id] - before
            state.twist[w, ego.id] = way[0] / dt, way[1] / dt, wrap(way[2]) / dt


def _columns(group: Group, state: State, w: int, b: int) -> tuple[Floats, Floats]:
    """Return copies of a body's pose and velocity as columns."""
    size = len(group.kind.command_names)
    return state.pose[w, b].reshape(3, 1).copy(), state.velocity[w, b, :size].reshape(size, 1).copy()


def _handler(kind: Any, ego: EgoView, options: dict[str, Any]) -> KinematicsHandler:
    """Return a body's instance, which its first call in an episode makes."""
    if HANDLER not in ego.memory:
        arguments = {"noise": False, "alpha": None, **options}
        tau = arguments.get("tau")
        if "tau" not in inspect.signature(kind.handler).parameters:
            arguments.pop("tau", None)
        with noting(kind, f"'{ego.name}'", ego._now, ego._w):
            result = kind.handler(kind.registered[1], arguments.pop("noise"), arguments.pop("alpha"), **arguments)
        result.tau = tau
        ego.memory[HANDLER] = result
    handler: KinematicsHandler = ego.memory[HANDLER]
    return handler
