"""A world that a person may watch in a window, and drive with keys."""

from __future__ import annotations

import warnings
from abc import abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np

from irsim_gym.arraytypes import Bytes, Floats
from irsim_gym.controls.driver import Driver
from irsim_gym.errors import NoEffectWarning, NoKeyboardWarning
from irsim_gym.live import moves
from irsim_gym.live.arguments import drawing_options
from irsim_gym.live.sketched import Sketched
from irsim_gym.live.vectors import vector
from irsim_gym.scenario import Scenario

Point = tuple[float, float]
INTERVAL_S = 0.01
ENDING_S = 3.0
SHOW_S = 0.02
DEBUGGING = "Pause (Debugging)"


class Driven(Sketched):
    """What a person does to a world: with ``render_mode="human"``, in a window that ``render`` keeps up to date.

    Keys and mouse are read by ``render``, which also does what they ask for, such as a reset.
    """

    def _begin_driving(self, render_mode: str | None, scenario: Scenario) -> None:
        self.render_mode = render_mode
        self._control_mode: Literal["auto", "keyboard"] = "auto"
        self._driver: Driver | None = None
        self._quit = self._left = False
        self._hidden = self._granted = False
        self._take_control_mode(scenario)

    def _take_control_mode(self, scenario: Scenario) -> None:
        """Take over who drives; without a window there is no keyboard."""
        self._control_mode = scenario.world.control_mode
        if self._control_mode == "keyboard" and self.render_mode != "human":
            self._control_mode = "auto"
            warnings.warn(
                "keys are read in a window alone, load(..., render_mode='human'): the behaviours drive "
                "(control_mode: auto)",
                NoKeyboardWarning,
                stacklevel=5,
            )

    @abstractmethod
    def reset(self, random: bool = False) -> None:
        """Begin again."""

    @abstractmethod
    def reload(self) -> None:
        """Read the file again and begin its first level."""

    @abstractmethod
    def save_figure(self, path: str | Path | None = None) -> Path:
        """Write a picture to a file and return its path."""

    @property
    def control_mode(self) -> Literal["auto", "keyboard"]:
        """Who drives the chosen robot: its behaviour and ``step``'s actions, or the keys; the key x changes it."""
        return self._control_mode

    @property
    def quit_flag(self) -> bool:
        """The person pressed esc or closed the window: ``done`` is True from now on.

        The next ``render`` after the one that noticed ends the program (``SystemExit``), for loops that ask nobody.
        """
        return self._quit

    @property
    def headless(self) -> bool:
        """There is no window."""
        return self.render_mode != "human"

    @property
    def disable_all_plot(self) -> bool:
        """IR-SIM's name for ``headless``."""
        return self.headless

    @property
    def display(self) -> bool:
        """There is a window and pictures are drawn in it; the key y changes it."""
        return self.render_mode == "human" and not self._quit and not self._hidden

    @property
    def key_id(self) -> int:
        """Number of the robot among the robots that the keys drive."""
        return self.scenario.gui.keyboard.key_id if self._driver is None else self._driver.keyboard.key_id

    @property
    def key_vel(self) -> Floats:
        """What the held keys ask for: ahead [m/s], aside [rad/s], turning [rad/s]; shape ``(3,)``."""
        return vector(np.zeros(3) if self._driver is None else self._driver.keyboard.key_vel, self.columns)

    @property
    def mouse_pos(self) -> Point | None:
        """Where the mouse points to [m]; None outside of the world's drawing area, and without a window."""
        return None if self._driver is None else self._driver.mouse.position

    @property
    def mouse_left_pos(self) -> Point | None:
        """Where the left button was last pressed [m], rounded to 2 decimals; None if never."""
        return None if self._driver is None else self._driver.mouse.left

    @property
    def mouse_right_pos(self) -> Point | None:
        """Where the right button was last pressed, likewise."""
        return None if self._driver is None else self._driver.mouse.right

    def pause(self) -> None:
        """Let steps do nothing until ``resume``."""
        self._paused, self._granted, self._status = True, False, "Pause"

    def resume(self) -> None:
        """Go on after a pause."""
        self._paused, self._granted, self._status = False, False, self._with_driver("Running")

    def _told(self, status: str) -> str:
        """Return the status after a step, with who drives."""
        if self._paused:
            return DEBUGGING
        return self._with_driver(status)

    def _may_step(self) -> bool:
        """Return whether a step is to be done: always, but in a pause only when F5 was pressed, once each time."""
        granted, self._granted = self._granted, False
        return granted or not self._paused

    def _keys(self) -> dict[int, Floats]:
        """Return the command that the keys give to the chosen robot, by its index; none when they do not drive."""
        chosen = self._chosen_robot()
        if chosen is None or self._driver is None or self._control_mode != "keyboard" or self.simulation.parts.external:
            return {}
        return {chosen: self._driver.keyboard.command(self.scenario.bodies[chosen].kinematics.command_names)}

    def _chosen_robot(self) -> int | None:
        """Return the index of the robot that the keys drive; None where there is none with that number and a drive."""
        robots = moves.robots(self.simulation)
        if self.key_id >= len(robots) or not self.simulation.model.movable[robots[self.key_id]]:
            return None
        return int(robots[self.key_id])

    def render(
        self,
        interval: float = INTERVAL_S,
        figure_kwargs: Mapping[str, Any] | None = None,
        mode: str = "dynamic",
        **drawing: Any,
    ) -> Bytes:
        """Return a picture of the world, uint8, shape ``(height, width, 3)``; show it where there is a window.

        With a window, one picture for each ``sample_time`` is drawn, and what keys ask for is done.

        Args:
            interval: How long to let people look [s]; without a window nothing waits.
            figure_kwargs: IR-SIM's; it changes nothing, and a warning says so.
            mode: IR-SIM's ``dynamic``, ``static`` or ``all``; all bodies are drawn in each.
            **drawing: Keys of the sections ``plot`` such as ``show_goal=True``: so all bodies are drawn in this
                picture, and in the frames that are kept until the next call. Others change nothing but give a warning.

        Raises:
            ScenarioError: One of these keys has a bad value.
            ValueError: Another mode.
            NoWindowError: With ``render_mode="human"``: there is no display, or no toolkit that works.
            SystemExit: The person quit, and the caller went on.
        """
        self._camera.draw_with(drawing_options(figure_kwargs, mode, drawing))
        if self.render_mode != "human":
            return self._camera.show(self._shown_status())
        if self._left:
            raise SystemExit(0)
        if self._driver is None:
            frame = self._camera.show(self._shown_status())
            self._driver = Driver(self.scenario.name, frame, self.scenario.gui, self._camera.seen)
        elif self._quit:
            pass
        elif not self._hidden and (self._paused or self.sampling):
            self._driver.show(self._camera.show(self._shown_status()))
        self._driver.wait(interval)
        self._do_what_is_asked(self._driver)
        return self._driver.picture

    def _do_what_is_asked(self, driver: Driver) -> None:
        chosen = self._chosen_robot()
        turns = chosen is not None and len(self.scenario.bodies[chosen].kinematics.command_names) == 3
        for asked in driver.poll(drives=self._control_mode == "keyboard", turns=turns):
            self._do(asked)
        changed, limits = driver.new_limits()
        if changed:
            self._camera.show_part(limits)
        if self._quit:
            self._left, self._status = True, "Quit"
            driver.close()

    def _do(self, asked: str) -> None:
        """Do what a key asks for, of the values of ``controls.keyboard.COMMANDS``."""
        match asked:
            case "reset":
                self.reset()
            case "next":
                self.reset(random=True)
            case "reload":
                self.reload()
            case "pause":
                (self.resume if self._paused else self.pause)()
            case "step":
                self._granted, self._paused = self._paused, True
                self._status = DEBUGGING
            case "switch":
                self._control_mode = "auto" if self._control_mode == "keyboard" else "keyboard"
                if self._status.startswith("Running"):
                    self._status = self._with_driver("Running")
            case "figure":
                self.save_figure(f"{self.scenario.name}_{int(self.simulation.state.step[0]):04d}")
            case "display":
                self._hidden = not self._hidden
            case "quit":
                self._quit = True

    def show(self) -> None:
        """Show the world in a window until the person closes it or presses esc.

        Without ``render_mode="human"`` there is none, and nothing to wait for; a warning says so.

        Raises:
            NoWindowError: There is no display, or no toolkit that works.
        """
        if self.render_mode != "human":
            message = "there is no window to show: load(..., render_mode='human') opens one"
            warnings.warn(message, NoEffectWarning, stacklevel=2)
            return
        while not self._quit:
            self.render(SHOW_S)

    def _linger(self, seconds: float) -> None:
        """Leave an open window for a time [s]."""
        if self._driver is not None and not self._quit:
            self._driver.show(self._camera.frame(self._shown_status()))
            self._driver.wait(seconds)

    def _close_window(self) -> None:
        if self._driver is not None:
            self._driver.close()
            self._driver = None
