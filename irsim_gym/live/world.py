"""A world that a script loads, steps, shows and changes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Literal, NoReturn, Self

from irsim_gym.live.action_pairs import Actions, pair_actions
from irsim_gym.live.drawing.drawing import Drawing
from irsim_gym.live.drawing.irsim_drawing import IrSimDrawing
from irsim_gym.live.pictures.camera import Camera
from irsim_gym.live.pictures.media import MediaWriter
from irsim_gym.live.pictures.viewer import Viewer
from irsim_gym.live.planning.path_planner import PathPlanner
from irsim_gym.live.planning.wayless import WaylessBodies
from irsim_gym.live.population.forwarding import Attribute, Method
from irsim_gym.live.population.late_behaviors import LateBehaviors
from irsim_gym.live.population.messages import WorldMessages
from irsim_gym.live.population.population import Population
from irsim_gym.live.session import moves
from irsim_gym.live.session.arguments import read_arguments
from irsim_gym.live.session.level_source import LevelSource, ScenarioSource
from irsim_gym.live.session.roster import Reference
from irsim_gym.live.session.run_status import ControlMode, RunStatus
from irsim_gym.live.session.track import Track
from irsim_gym.live.session.world_info import WorldInfo, WorldRecord
from irsim_gym.scenario import Scenario
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.readings.irsim_names import advice, missing


class World:
    """One world of a scenario, which a script steps, as in IR-SIM.

    It is a batch of one world in the simulator that learners use: steps, collisions and scans are the same. IR-SIM's
    names work; if one does not, the error says what to use instead. ``help`` lists all names. Arrays are flat, or
    columns as in IR-SIM with ``columns=True``. ``draw`` draws marks over the world.

    In a window (``render_mode="human"``) keys control the world: r resets, n draws the next level, l reloads the file,
    space pauses and resumes, F5 pauses and then makes single steps, esc quits, x switches between keyboard and auto,
    v saves a figure, y stops and resumes drawing. With ``control_mode: keyboard`` they drive a robot: w and s ahead and
    back, a and d turn (sideways for an omnidirectional robot). q and e turn an ``omni_angular`` robot; for others they
    change the maximum speed, as shift+z and shift+c do. z and c change the maximum turn rate; alt with a digit selects
    the robot. The mouse wheel zooms at the cursor, the middle button shows the whole world.

    Args:
        scenario: A shipped name such as ``cluttered_room``, an id, the path of a YAML file, or the same as plain data.
            By default, the YAML file with the name of the running script, in the same folder.
        seed: Number of the first level: the one that ``irsim_gym.make`` begins with ``reset(seed=seed)``.
        render_mode: With None or ``"rgb_array"``, ``render`` returns pictures; with ``"human"``, it also shows them in
            a window.
        record: Keep a frame of the start and of each sample, for ``save_animation`` and the other ``save_`` methods.
        save_ani: IR-SIM's argument: like ``record``, and ``end`` writes the film.
        strict: Unknown keys in the file are errors. With False they are ignored, with an ``IgnoredKeyWarning``.
        columns: Return states, velocities, goals and other vectors as columns ``(n, 1)``, as IR-SIM does, and corners
            as ``(2, n)``. By default they are flat, and combining a flat one with a column is an error.
        **others: Values of the scenario's parameters, and IR-SIM's other arguments: ``display=True`` means
            ``render_mode="human"``, ``step_mode`` replaces that of the file, ``log_level`` sets the level of
            ``logger``, ``ani_kwargs`` are defaults of ``end``, ``world_name`` is the file. Other arguments of IR-SIM
            are accepted only with the value that describes what happens here.

    Raises:
        ScenarioError: The file cannot be used; the error lists every problem with its line.
        UnknownNameError: No shipped scenario has this name, or no scenario is registered under this id.
        UnknownKeywordError: The scenario has no such parameter.
        ValueError: The render mode is unknown, or the seed is negative.
        TypeError: The seed is not an integer, an argument is not supported, or no file was given and there is none for
            the script.
    """

    def __init__(
        self,
        scenario: ScenarioSource | None = None,
        *,
        seed: int | None = None,
        render_mode: str | None = None,
        record: bool = False,
        save_ani: bool = False,
        strict: bool = True,
        columns: bool = False,
        **others: object,
    ) -> None:
        arguments = read_arguments(render_mode, others)
        self._levels = LevelSource(
            arguments.file if scenario is None else scenario, seed, strict=strict, arguments=arguments, columns=columns
        )
        self._session = self._levels.session
        self._status = RunStatus(self._session, has_window=arguments.render_mode == "human")
        self._info = WorldInfo(self._session, self._status)
        self._population = Population(self._session, self._status)
        self._messages = WorldMessages(self._session, self._status, self._population)
        self._late_behaviors = LateBehaviors(self._session)
        self._wayless = WaylessBodies()
        self._planner = PathPlanner(self._session, self._population)
        self.draw = Drawing()
        self._irsim_drawing = IrSimDrawing(self._session, self.draw)
        self._camera = Camera(self._session, self.draw)
        keys: dict[str, Callable[[], object]] = {"reset": self.reset, "reload": self.reload}
        keys["next"] = lambda: self.reset(random=True)
        keys["figure"] = lambda: self.save_figure(f"{self.name}_{self.count:04d}")
        seen = (self._session, self._status, self._camera)
        self._viewer = Viewer(*seen, arguments.render_mode, keys, needs_window=render_mode == "human")
        self._media = MediaWriter(*seen, self._viewer, record=record, save_at_end=save_ani, options=arguments.film)
        if arguments.log_level is not None:
            self.logger.setLevel(arguments.log_level)
        self._levels.begin()
        self._begin(self.scenario.world.status)

    def _begin(self, status: str) -> None:
        """Show the beginning of an episode."""
        self._status.begin(status)
        self._camera.clear()
        self._media.note_moment()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._media.free() if error is not None else self.close()

    if not TYPE_CHECKING:  # a type checker would otherwise accept any name

        def __getattr__(self, name: str) -> NoReturn:
            if name in dir(type(self)) or (name.startswith("_") and name not in advice("world")):
                object.__getattribute__(self, name)  # raises the error of the property itself
            raise AttributeError(missing("a world", name, advice("world"), dir(self)), name=name, obj=self)

    __getitem__ = Method("_population", Population.__getitem__)
    __iter__ = Method("_population", Population.__iter__)
    __len__ = Method("_population", Population.__len__)
    names = Attribute("_population", Population.names)
    objects = Attribute("_population", Population.objects)
    robots = robot_list = Attribute("_population", Population.robots)
    obstacles = obstacle_list = Attribute("_population", Population.obstacles)
    robot = Attribute("_population", Population.robot)
    robot_number = Attribute("_population", Population.robot_number)
    obstacle_number = Attribute("_population", Population.obstacle_number)
    static_objects = Attribute("_population", Population.static_objects)
    dynamic_objects = Attribute("_population", Population.dynamic_objects)
    contacts = Attribute("_population", Population.contacts)
    get_object_by_name = Method("_population", Population.get_object_by_name)
    get_object_by_id = Method("_population", Population.get_object_by_id)
    get_group_by_name = Method("_population", Population.get_group_by_name)
    get_robot_state = Method("_population", Population.get_robot_state)
    get_robot_info = Method("_population", Population.get_robot_info)
    get_robot_info_list = Method("_population", Population.get_robot_info_list)
    get_obstacle_info_list = Method("_population", Population.get_obstacle_info_list)
    get_lidar_scan = Method("_population", Population.get_lidar_scan)
    get_lidar_offset = Method("_population", Population.get_lidar_offset)
    add = Method("_population", Population.add)
    remove = Method("_population", Population.remove)
    delete_object = Method("_population", Population.delete_object)
    create_robot = Method("_population", Population.create_robot)
    create_obstacle = Method("_population", Population.create_obstacle)
    add_object = Method("_population", Population.add_object)
    add_objects = Method("_population", Population.add_objects)
    delete_objects = Method("_population", Population.delete_objects)
    random_obstacle_position = Method("_population", Population.random_obstacle_position)
    random_polygon_shape = Method("_population", Population.random_polygon_shape)
    get_msg = Method("_messages", WorldMessages.get_msg)
    receive_msg = Method("_messages", WorldMessages.receive_msg)
    load_behavior = Method("_late_behaviors", LateBehaviors.load_behavior)

    path = Method("_planner", PathPlanner.path)
    get_map = Method("_planner", PathPlanner.get_map)

    draw_trajectory = Method("_irsim_drawing", IrSimDrawing.draw_trajectory)
    draw_points = Method("_irsim_drawing", IrSimDrawing.draw_points)
    draw_box = Method("_irsim_drawing", IrSimDrawing.draw_box)
    draw_quiver = Method("_irsim_drawing", IrSimDrawing.draw_quiver)
    draw_quivers = Method("_irsim_drawing", IrSimDrawing.draw_quivers)
    set_title = Method("_irsim_drawing", IrSimDrawing.set_title)

    pause = Method("_status", RunStatus.pause)
    resume = Method("_status", RunStatus.resume)
    set_status = Method("_status", RunStatus.set_status)
    step_status = Method("_status", RunStatus.step_status)
    refresh = Method("_status", RunStatus.refresh)

    render = Method("_viewer", Viewer.render)
    show = Method("_viewer", Viewer.show)
    quit_flag = Attribute("_viewer", Viewer.quit_flag)
    headless = disable_all_plot = Attribute("_viewer", Viewer.headless)
    display = Attribute("_viewer", Viewer.display)
    key_id = Attribute("_viewer", Viewer.key_id)
    key_vel = Attribute("_viewer", Viewer.key_vel)
    mouse_pos = Attribute("_viewer", Viewer.mouse_pos)
    mouse_left_pos = Attribute("_viewer", Viewer.mouse_left_pos)
    mouse_right_pos = Attribute("_viewer", Viewer.mouse_right_pos)
    sampling = Attribute("_camera", Camera.is_sample)

    save_ani = Attribute("_media", MediaWriter.save_ani)
    save_figure = Method("_media", MediaWriter.save_figure)
    save_animation = Method("_media", MediaWriter.save_animation)
    save_html = Method("_media", MediaWriter.save_html)
    close = Method("_media", MediaWriter.close)
    end = Method("_media", MediaWriter.end)
    quit = Method("_media", MediaWriter.quit)

    name = Attribute("_info", WorldInfo.name)
    time = Attribute("_info", WorldInfo.time)
    count = Attribute("_info", WorldInfo.count)
    step_time = Attribute("_info", WorldInfo.step_time)
    step_mode = Attribute("_info", WorldInfo.step_mode)
    world_param = Attribute("_info", WorldInfo.world_param)
    x_range = Attribute("_info", WorldInfo.x_range)
    y_range = Attribute("_info", WorldInfo.y_range)
    logger = Attribute("_info", WorldInfo.logger)
    _objects = Attribute("_population", Population.objects)

    def reset_plot(self) -> None:
        """Do nothing: every picture is drawn anew."""

    def build_tree(self) -> None:
        """Do nothing: neighbours are found in each step."""

    def validate_unique_names(self) -> None:
        """Do nothing: names of bodies are always unique."""

    @property
    def _world(self) -> WorldRecord:
        return WorldRecord(self)

    @property
    def simulation(self) -> Simulation:
        """The simulator; ``add``, ``remove`` and ``reload`` replace it."""
        return self._session.simulation

    @property
    def track(self) -> Track:
        """The poses of all bodies since the reset; ``Body.trajectory`` returns those of one body."""
        return self._session.track

    @property
    def columns(self) -> bool:
        """Whether vectors are returned as columns ``(n, 1)``, and points as ``(2, n)``, as in IR-SIM."""
        return self._session.columns

    @property
    def render_mode(self) -> str | None:
        """None, ``rgb_array`` or ``human``."""
        return self._viewer.render_mode

    @property
    def scenario(self) -> Scenario:
        """The content of the file, with the present bodies."""
        return self.simulation.scenario

    @property
    def control_mode(self) -> ControlMode:
        """``auto`` (behaviours and actions drive) or ``keyboard`` (keys drive the chosen robot); the key x switches."""
        return self._status.control_mode

    @property
    def status(self) -> str:
        """The status as text.

        ``Arrived`` if all robots have arrived, else ``Collision`` if one collides, else ``Running``, or
        ``Running (keyboard)`` while keys drive. ``Pause`` lasts until ``resume``; ``Reset`` and ``Reload`` last until
        the next step. F5 sets ``Pause (Debugging)``, esc sets ``Quit``. The file may set the first one.
        """
        return self._status.text

    @property
    def pause_flag(self) -> bool:
        """Whether the world is paused: steps do nothing until ``resume``."""
        return self._status.paused

    def done(self, mode: Literal["all", "any"] = "all") -> bool:
        """Return whether all robots, or any of them, have arrived or are stopped by a collision.

        A world without robots is never done. After esc or the closing of its window (``quit_flag``) it always is.

        Raises:
            ValueError: The mode is unknown.
        """
        if mode not in ("all", "any"):
            raise ValueError(f"mode must be 'all' or 'any', got {mode!r}")
        state, robots = self.simulation.state, moves.robots(self.simulation)
        over = state.arrived[0, robots] | state.stopped[0, robots]
        return self.quit_flag or (bool(len(over)) and bool(over.all() if mode == "all" else over.any()))

    def step(self, action: Actions | None = None, action_id: Reference | Sequence[Reference] | None = None) -> None:
        """Advance by one step, unless the world is paused.

        An action is a command in the coordinates of the body's drive [m/s, rad/s]. It replaces the command of the
        body's behaviour in this step; keys that drive (``control_mode``) replace both. Limits and stopping at
        collisions still apply. Bodies that never move ignore actions.

        Args:
            action: None, one action, a list of actions, or a mapping from names to actions. If an action is None, the
                behaviour of the body decides.
            action_id: The body or bodies that the action is for: a number, a name, or a list of them. By default, one
                action is for the first body, and a list of actions for the bodies from the first on. With a list of
                actions and one number or name, they are for the bodies from that one on.

        Raises:
            ValueError: There is no such body, an action has a wrong length, there are more actions than bodies, or
                ``step_mode`` is ``external``.
        """
        if not self._status.may_step():
            return
        simulation = self.simulation
        rows = {} if action is None else pair_actions(action, action_id, self._session.roster)
        if rows and simulation.parts.external:
            raise ValueError("step_mode is external: set_state moves the bodies, actions have no effect")
        self._late_behaviors.warn_of_unknown_groups()
        bodies, commands = moves.commands(simulation, {**rows, **self._viewer.key_commands()})
        self._camera.leave()
        if len(bodies):
            simulation.step(commands, bodies)
        else:
            simulation.step()
        self._wayless.warn(simulation)
        self._status.note_step()
        self.track.note(simulation)
        self._media.note_moment()

    def reset(self, random: bool = False) -> None:
        """Begin a new episode.

        Args:
            random: False repeats the level with the present bodies. The same actions then give the same run, including
                noise; values set without ``init=True`` are lost. True draws the next level, with the bodies of the
                file.
        """
        self._camera.leave()
        if random:
            self._levels.begin_next()
        else:
            self._session.begin_again()
        self._begin("Reset")

    def reload(self, world_name: ScenarioSource | None = None) -> None:
        """Read the file again, or another one, and begin its first level.

        Args:
            world_name: Another file, which later calls reload, too.

        Raises:
            ScenarioError: The file cannot be used; the world is unchanged.
        """
        self._camera.leave()
        self._levels.reload(world_name)
        self._status.read_control_mode()
        self._begin("Reload")

    def set_random_seed(self, seed: int, reload: bool = False) -> None:
        """Draw levels from another random stream. The next ``reset(random=True)`` draws its first level.

        Args:
            seed: Seed of the stream.
            reload: Read the file again and begin that level at once.

        Raises:
            TypeError: The seed is not an integer.
            ValueError: The seed is negative.
        """
        self._levels.set_seed(seed)
        if reload:
            self.reload()


load = World
"""Load a scenario to step it from a script."""
