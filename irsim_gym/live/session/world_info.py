"""Clock, size and name of a world."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NoReturn, cast

import numpy as np

from irsim_gym.live.session.run_status import RunStatus
from irsim_gym.live.session.session import Session
from irsim_gym.scenario import Scenario
from irsim_gym.simulator.readings.irsim_names import advice, missing


@dataclass(frozen=True)
class WorldParam:
    """Clock and modes of a world, as IR-SIM's scripts ask for them.

    Attributes:
        time: Elapsed time [s].
        count: Steps since the reset.
        step_time: Duration of a step [s].
        sample_time: Time between frames [s].
        step_mode: ``internal`` or ``external``.
        control_mode: ``auto`` or ``keyboard``.
        collision_mode: Effect of a collision.
        gravity: Gravity [m/s2].
        friction: Coefficient of friction of bodies without their own.
        restitution: Restitution of bodies without their own.
        drive_tau: Time constant of drives without their own [s].
    """

    time: float
    count: int
    step_time: float
    sample_time: float
    step_mode: str
    control_mode: str
    collision_mode: str
    gravity: float
    friction: float
    restitution: float
    drive_tau: float

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> NoReturn:
            message = missing("world_param", name, advice("world_param"), dir(self))
            raise AttributeError(message, name=name, obj=self)


class WorldRecord:
    """IR-SIM's private ``_world``: sizes of the world, and the names that the world itself has.

    Args:
        world: The world.
    """

    def __init__(self, world: Any) -> None:
        self._own = world

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            if name in advice("_world") or not hasattr(self._own, name):
                message = missing("_world", name, advice("_world"), dir(self._own))
                raise AttributeError(message, name=name, obj=self)
            return getattr(self._own, name)

    @property
    def offset(self) -> list[float]:
        """x, y of the lower left corner [m]."""
        return [self._own.x_range[0], self._own.y_range[0]]

    @property
    def width(self) -> float:
        """Size along x [m]."""
        return float(np.ptp(self._own.x_range))

    @property
    def height(self) -> float:
        """Size along y [m]."""
        return float(np.ptp(self._own.y_range))

    @property
    def sample_time(self) -> float:
        """Time between frames [s]."""
        return float(self._own.world_param.sample_time)


class WorldLogger(logging.Logger):
    """A logger with the methods that IR-SIM adds."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> NoReturn:
            raise AttributeError(f"a logger has no '{name}': it is one of Python's logging", name=name, obj=self)

    def success(self, message: str) -> None:
        """Log a message at the level INFO."""
        self.info(message)

    def trace(self, message: str) -> None:
        """Log a message at the level DEBUG."""
        self.debug(message)

    def warning_once(self, message: str, key: object = None) -> None:
        """Log a warning unless the same one, or one with the same key, was logged."""
        told = self.__dict__.setdefault("told", set())
        if (mark := message if key is None else key) not in told:
            told.add(mark)
            self.warning(message)

    def close(self) -> None:
        """Do nothing: handlers are closed by those who add them."""


class WorldInfo:
    """Name, size and clock of a world.

    Args:
        session: Bodies of the world.
        status: Status, which knows who drives.
    """

    def __init__(self, session: Session, status: RunStatus) -> None:
        self._session, self._status = session, status

    @property
    def _scenario(self) -> Scenario:
        return self._session.simulation.scenario

    @property
    def name(self) -> str:
        """Its name."""
        return self._scenario.name

    @property
    def time(self) -> float:
        """Elapsed time [s]: steps times ``step_time``, not rounded."""
        return float(self._session.simulation.state.time[0])

    @property
    def count(self) -> int:
        """Steps since the reset."""
        return int(self._session.simulation.state.step[0])

    @property
    def step_time(self) -> float:
        """Duration of a step [s]."""
        return self._scenario.world.step_time

    @property
    def step_mode(self) -> str:
        """``internal``, or ``external`` if only ``set_state`` moves bodies."""
        return self._scenario.world.step_mode

    @property
    def world_param(self) -> WorldParam:
        """Present clock and modes, in one record."""
        world = self._scenario.world
        modes = self.step_mode, self._status.control_mode, world.collision_mode
        matter = world.gravity, world.friction, world.restitution, world.drive_tau
        return WorldParam(self.time, self.count, self.step_time, world.sample_time, *modes, *matter)

    @property
    def x_range(self) -> tuple[float, float]:
        """Minimum and maximum x of the world [m]."""
        x_min, _, x_max, _ = map(float, self._session.simulation.model.bounds)
        return x_min, x_max

    @property
    def y_range(self) -> tuple[float, float]:
        """Minimum and maximum y of the world [m]."""
        _, y_min, _, y_max = map(float, self._session.simulation.model.bounds)
        return y_min, y_max

    @property
    def logger(self) -> WorldLogger:
        """A logger for scripts, from Python's ``logging``, with IR-SIM's ``success``. The package does not write to it.

        By default, Python shows warnings and errors; after ``logging.basicConfig(level="INFO")``, it shows all
        messages.
        """
        logger = logging.getLogger(f"irsim_gym.{self.name}")
        logger.__class__ = WorldLogger  # logging makes all loggers of one class
        return cast(WorldLogger, logger)
