"""The status of a world: running or paused, driven by behaviours or keys, and as text."""

from typing import Literal

from irsim_gym.base.errors import NoKeyboardWarning, warn_caller
from irsim_gym.live.session import moves
from irsim_gym.live.session.session import Session

ControlMode = Literal["auto", "keyboard"]
DEBUGGING = "Pause (Debugging)"


class RunStatus:
    """The status of a world.

    Args:
        session: The world's bodies.
        has_window: Keys can be read.

    Attributes:
        text: The status as text, see ``World.status``.
        paused: Steps do nothing.
        control_mode: Who drives the chosen robot.
    """

    def __init__(self, session: Session, *, has_window: bool) -> None:
        self._session, self._has_window = session, has_window
        self.text, self.paused, self._granted = "None", False, False
        self.control_mode: ControlMode = "auto"
        self.read_control_mode()

    def read_control_mode(self) -> None:
        """Take over who drives from the file; without a window there is no keyboard."""
        self.control_mode = self._session.scenario.world.control_mode
        if self.control_mode == "keyboard" and not self._has_window:
            self.control_mode = "auto"
            warn_caller(
                "keys are read in a window alone, load(..., render_mode='human'): the behaviours drive "
                "(control_mode: auto)",
                NoKeyboardWarning,
            )

    def begin(self, text: str) -> None:
        """Begin an episode, paused if the file says so."""
        self.paused = self._session.scenario.world.status == "Pause"
        self.text = "Pause" if self.paused else text

    def may_step(self) -> bool:
        """Return whether the world may step: during a pause only once after each ``allow_one_step``."""
        granted, self._granted = self._granted, False
        return granted or not self.paused

    def note_step(self) -> None:
        """Update the text after a step."""
        self.text = DEBUGGING if self.paused else self._present()

    def step_status(self) -> None:
        """Update ``status`` from the robots' flags, as ``step`` and ``refresh`` do."""
        self.text = self._present()

    def refresh(self) -> None:
        """Update outlines, flags, scans and status after bodies were moved by hand, without a step."""
        self._session.simulation.refresh()
        self.step_status()

    def set_status(self, status: str) -> None:
        """Set the status until the next step; pictures show it."""
        self.text = str(status)

    def pause(self) -> None:
        """Make steps do nothing until ``resume``."""
        self.paused, self._granted, self.text = True, False, "Pause"

    def resume(self) -> None:
        """End a pause."""
        self.paused, self._granted, self.text = False, False, self._with_driver("Running")

    def allow_one_step(self) -> None:
        """Pause; if the world is paused already, allow one step."""
        self._granted, self.paused, self.text = self.paused, True, DEBUGGING

    def switch_control_mode(self) -> None:
        """Switch between keyboard and behaviours."""
        self.control_mode = "auto" if self.control_mode == "keyboard" else "keyboard"
        if self.text.startswith("Running"):
            self.text = self._with_driver("Running")

    @property
    def shown(self) -> str:
        """What pictures say: the text; before there is one, how the robots are."""
        return self._present() if self.text == "None" else self.text

    def _present(self) -> str:
        return self._with_driver(moves.status_of(self._session.simulation))

    def _with_driver(self, status: str) -> str:
        return "Running (keyboard)" if status == "Running" and self.control_mode == "keyboard" else status
