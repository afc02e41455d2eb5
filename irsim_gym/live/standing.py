"""How a world stands: its clock, its status, and what its file says."""

from __future__ import annotations

from irsim_gym.live.crowd import Crowd
from irsim_gym.scenario import Scenario


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

    def _shown_status(self) -> str:
        return "" if self._status == "None" else self._status
