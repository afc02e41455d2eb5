"""The window of a world, and its keys."""

from collections.abc import Callable, Mapping

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Floats
from irsim_gym.base.errors import NoEffectWarning, NoWindowError, warn_caller
from irsim_gym.live.pictures.camera import Camera
from irsim_gym.live.session import moves
from irsim_gym.live.session.arguments import drawing_options
from irsim_gym.live.session.run_status import RunStatus
from irsim_gym.live.session.session import Session
from irsim_gym.live.session.vectors import vector
from irsim_gym.rendering.controls.driver import Driver

Point = tuple[float, float]
INTERVAL_S = 0.01
SHOW_S = 0.02


class Viewer:
    """Renders a world. With ``render_mode="human"``, it shows it in a window and executes the commands of its keys.

    Args:
        session: Bodies of the world.
        status: Status of the world.
        camera: Draws the world.
        render_mode: None, ``rgb_array`` or ``human``.
        commands: Functions of the keys ``reset``, ``next``, ``reload`` and ``figure``.
        needs_window: Where no window can be opened, it is an error; else a warning, and pictures without a window.

    Attributes:
        quit: Whether esc was pressed or the window was closed.
        driver: The open window; None before the first picture and after ``close``.
    """

    def __init__(
        self,
        session: Session,
        status: RunStatus,
        camera: Camera,
        render_mode: str | None,
        commands: Mapping[str, Callable[[], object]],
        *,
        needs_window: bool = True,
    ) -> None:
        self._session, self._status, self._camera = session, status, camera
        self.render_mode, self._needs_window = render_mode, needs_window
        self.driver: Driver | None = None
        self.quit = self._left = self._hidden = False
        self._commands: dict[str, Callable[[], object]] = {**commands, "quit": self._note_quit}
        self._commands["pause"] = lambda: status.resume() if status.paused else status.pause()
        self._commands |= {"step": status.allow_one_step, "switch": status.switch_control_mode}
        self._commands["display"] = self._toggle_display

    def _toggle_display(self) -> None:
        self._hidden = not self._hidden

    def _note_quit(self) -> None:
        self.quit = True

    @property
    def quit_flag(self) -> bool:
        """Whether esc was pressed or the window closed; then ``done`` is True.

        For loops that do not check ``done``, the second ``render`` after that ends the program (``SystemExit``).
        """
        return self.quit

    @property
    def headless(self) -> bool:
        """Whether there is no window."""
        return self.render_mode != "human"

    @property
    def display(self) -> bool:
        """Whether pictures are drawn in a window; the key y toggles it."""
        return not (self.headless or self.quit or self._hidden)

    @property
    def key_id(self) -> int:
        """Number of the robot among the robots that the keys drive."""
        if self.driver is None:
            return self._session.simulation.scenario.gui.keyboard.key_id
        return self.driver.keyboard.key_id

    @property
    def key_vel(self) -> Floats:
        """Velocity of the held keys: ahead [m/s], sideways [rad/s], turning [rad/s]; shape ``(3,)``."""
        return vector(np.zeros(3) if self.driver is None else self.driver.keyboard.key_vel, self._session.columns)

    @property
    def mouse_pos(self) -> Point | None:
        """Position of the mouse [m]; None outside the drawing area of the world, and without a window."""
        return None if self.driver is None else self.driver.mouse.position

    @property
    def mouse_left_pos(self) -> Point | None:
        """Position at which the left button was last pressed [m], rounded to 2 decimals; None if it never was."""
        return None if self.driver is None else self.driver.mouse.left

    @property
    def mouse_right_pos(self) -> Point | None:
        """Position at which the right button was last pressed [m], likewise."""
        return None if self.driver is None else self.driver.mouse.right

    @property
    def _chosen_robot(self) -> int | None:
        """Index of the robot that the keys drive; None if no robot with that number has a drive."""
        simulation = self._session.simulation
        robots = moves.robots(simulation)
        if self.key_id >= len(robots) or not simulation.model.movable[robots[self.key_id]]:
            return None
        return int(robots[self.key_id])

    def _command_names(self, body: int) -> tuple[str, ...]:
        names: tuple[str, ...] = self._session.simulation.scenario.bodies[body].kinematics.command_names
        return names

    def key_commands(self) -> dict[int, Floats]:
        """Return the command of the keys for the chosen robot, by its index; empty if keys do not drive."""
        chosen = self._chosen_robot
        is_driven = self._status.control_mode == "keyboard" and not self._session.simulation.parts.external
        if chosen is None or self.driver is None or not is_driven:
            return {}
        return {chosen: self.driver.keyboard.command(self._command_names(chosen))}

    def render(
        self,
        /,
        interval: float = INTERVAL_S,
        figure_kwargs: Mapping[str, object] | None = None,
        mode: str = "dynamic",
        **drawing: object,
    ) -> Bytes:
        """Return a picture of the world, uint8, shape ``(height, width, 3)``; show it if there is a window.

        With a window, one picture for each ``sample_time`` is drawn, and the commands of keys are executed.

        Args:
            interval: Time for which the picture is shown [s]. Without a window, there is no wait.
            figure_kwargs: IR-SIM's argument; it has no effect and gives a warning.
            mode: IR-SIM's ``dynamic``, ``static`` or ``all``; all bodies are drawn in each.
            **drawing: Keys of the sections ``plot`` such as ``show_goal=True``: so all bodies are drawn in this
                picture, and in the frames that are kept until the next call. Others change nothing but give a warning.

        Raises:
            ScenarioError: One of these keys has a bad value.
            ValueError: Another mode.
            NoWindowError: With ``render_mode="human"``: there is no display, or no toolkit that works. With
                ``display=True`` this is a warning, once.
            SystemExit: The person quit, and the caller went on.
        """
        self._camera.draw_with(drawing_options(figure_kwargs, mode, drawing))
        if self.headless:
            return self._camera.show(self._status.shown)
        if self._left:
            raise SystemExit(0)
        if self.driver is None:
            scenario = self._session.simulation.scenario
            frame = self._camera.show(self._status.shown)
            try:
                self.driver = Driver(scenario.name, frame, scenario.gui, self._camera.seen)
            except NoWindowError as error:
                if self._needs_window:
                    raise
                self.render_mode = "rgb_array"
                warn_caller(f"display=True shows nothing, render() returns pictures: {error}", NoEffectWarning)
                return frame
        elif self.display and (self._status.paused or self._camera.is_sample):
            self.driver.show(self._camera.show(self._status.shown))
        self.driver.wait(interval)
        self._execute(self.driver)
        return self.driver.picture

    def _execute(self, driver: Driver) -> None:
        """Execute the commands of keys and mouse."""
        chosen = self._chosen_robot
        turns = chosen is not None and len(self._command_names(chosen)) == 3
        drives = self._status.control_mode == "keyboard"
        driver.execute(lambda name: self._commands[name](), self._camera.show_part, drives=drives, turns=turns)
        if self.quit:
            self._left = True
            self._status.set_status("Quit")
            driver.close()

    def show(self) -> None:
        """Show the world in a window until the person closes it or presses esc.

        Without ``render_mode="human"`` it only warns that there is no window.

        Raises:
            NoWindowError: There is no display, or no toolkit that works.
        """
        if self.headless:
            warn_caller("there is no window to show: load(..., render_mode='human') opens one", NoEffectWarning)
            return
        while not (self.quit or self.headless):
            self.render(SHOW_S)

    def wait(self, seconds: float) -> None:
        """Keep an open window for a time [s]."""
        if self.driver is not None and not self.quit:
            self.driver.show(self._camera.frame(self._status.shown))
            self.driver.wait(seconds)

    def close(self) -> None:
        """Close the window."""
        if self.driver is not None:
            self.driver.close()
            self.driver = None
