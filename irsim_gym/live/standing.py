"""How a world stands: its clock, its status, and what its file says."""

from __future__ import annotations

import logging
from abc import abstractmethod
from dataclasses import dataclass
from typing import Literal

from irsim_gym.live import moves
from irsim_gym.live.crowd import Crowd
from irsim_gym.scenario import Scenario


@dataclass(frozen=True)
class WorldParam:
    """The moment of a world, as IR-SIM's scripts ask for it.

    Attributes:
        time: Elapsed time [s].
        count: Steps since the reset.
        step_time: Duration of a step [s].
        sample_time: Time between frames [s].
        step_mode: ``internal`` or ``external``.
        control_mode: ``auto`` or ``keyboard``.
        collision_mode: What a collision does.
    """

    time: float
    count: int
    step_time: float
    sample_time: float
    step_mode: str
    control_mode: str
    collision_mode: str


class Standing(Crowd):
    """What a world tells of itself, beside its bodies."""

    _status: str
    _paused: bool

    @property
    def scenario(self) -> Scenario:
        """What the file says, with the bodies that are here now."""
        return self.simulation.scenario

    @property
    def name(self) -> str:
        """Its name."""
        return self.scenario.name

    @property
    def time(self) -> float:
        """Elapsed time [s]: steps times ``step_time``, not rounded."""
        return float(self.simulation.state.time[0])

    @property
    def count(self) -> int:
        """Steps since the reset."""
        return int(self.simulation.state.step[0])

    @property
    def step_time(self) -> float:
        """Duration of a step [s]."""
        return self.scenario.world.step_time

    @property
    def step_mode(self) -> str:
        """``internal``, or ``external`` where ``set_state`` moves the bodies and steps do not."""
        return self.scenario.world.step_mode

    @property
    @abstractmethod
    def control_mode(self) -> Literal["auto", "keyboard"]:
        """Who drives the chosen robot."""

    @property
    def world_param(self) -> WorldParam:
        """Clock and modes at the moment, in one record."""
        world = self.scenario.world
        modes = self.step_mode, self.control_mode, world.collision_mode
        return WorldParam(self.time, self.count, self.step_time, world.sample_time, *modes)

    @property
    def x_range(self) -> tuple[float, float]:
        """Least and greatest x of the world [m]."""
        x_min, _, x_max, _ = map(float, self.simulation.model.bounds)
        return x_min, x_max

    @property
    def y_range(self) -> tuple[float, float]:
        """Least and greatest y of the world [m]."""
        _, y_min, _, y_max = map(float, self.simulation.model.bounds)
        return y_min, y_max

    @property
    def sampling(self) -> bool:
        """The present moment is a sample: there is one every ``sample_time``, rounded to whole steps."""
        return self.count % self.scenario.world.steps_per_sample == 0

    @property
    def status(self) -> str:
        """How the world stands, as text.

        ``Arrived`` when all robots have arrived, else ``Collision`` when one collides, else ``Running``, or
        ``Running (keyboard)`` when keys drive. ``Pause`` lasts until ``resume``, ``Reset`` and ``Reload`` until the
        next step; at first it is what the file says. ``Pause (Debugging)`` after F5, ``Quit`` after esc.
        """
        return self._status

    def set_status(self, status: str) -> None:
        """Say how the world stands until the next step; pictures show it."""
        self._status = str(status)

    def step_status(self) -> None:
        """Bring ``status`` up to date from the robots' flags, as ``step`` and ``refresh`` do."""
        self._status = self._with_driver(moves.status_of(self.simulation))

    @property
    def pause_flag(self) -> bool:
        """Steps do nothing until ``resume``."""
        return self._paused

    @property
    def logger(self) -> logging.Logger:
        """A logger for scripts, of Python's own; the package writes nothing to it.

        What it shows is Python's affair: warnings and errors, and the rest after ``logging.basicConfig(level="INFO")``.
        """
        return logging.getLogger(f"irsim_gym.{self.name}")

    def _shown_status(self) -> str:
        """Return what pictures say: the status, or before there is one how the robots stand, spelt as after a step."""
        return self._with_driver(moves.status_of(self.simulation)) if self._status == "None" else self._status

    def _with_driver(self, status: str) -> str:
        """Return a status with who drives."""
        return "Running (keyboard)" if status == "Running" and self.control_mode == "keyboard" else status
