"""Typed, frozen models of a scenario."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AllowInfNan, Field

from irsim_gym.base.errors import Problem, several
from irsim_gym.base.options import defaults, kind, option
from irsim_gym.scenario.specs.gui_spec import GuiSpec
from irsim_gym.scenario.specs.level_set import LevelSet
from irsim_gym.scenario.specs.plot_spec import ObjectPlot
from irsim_gym.scenario.specs.world_spec import Coordinate, WorldSpec
from irsim_gym.scenario.text.messages import with_parameters
from irsim_gym.scenario.text.source import Place, Source

Waypoint = tuple[float, float, float]
Limit = Annotated[float, AllowInfNan(True), Field(ge=0.0)]
Mass = Annotated[float, AllowInfNan(True), Field(gt=0.0)]

MAX_BODIES = 100_000


@kind
class BodyOptions:
    """The keys of an entry of ``robot`` or ``obstacle``."""

    preset: str | None = option(None, meaning="A shipped robot, whose values hold where the entry has no key.")
    number: int = option(
        1, ge=0, le=MAX_BODIES, meaning="Number of bodies in the entry.", consequence="Too many: an error names one."
    )
    number_range: tuple[int, int] | None = option(None, meaning="Bounds of a number drawn by level; replaces number.")
    distribution: Any = option(None, meaning="How starts and goals are chosen; default: as given (manual).")
    name: str | None = option(None, min_length=1, max_length=200, meaning="Unique name; default: such as robot_0.")
    kinematics: Any = option(None, meaning="The drive; a body without one, or with {name: static}, never moves.")
    shape: Any = option(None, meaning="The footprint; default: a circle of radius 0.2 m.")
    state: tuple[Coordinate, ...] = option(
        (0.0, 0.0, 0.0), min_length=1, unit="m, m, rad", meaning="Start pose; missing numbers are 0."
    )
    velocity: tuple[float, ...] = option(
        (),
        unit="m/s or rad/s",
        meaning="Velocity at the start, in the drive's coordinates; of a body with a mass and no drive, along x and y, "
        "and its turn rate; missing numbers are 0.",
    )
    mass: Mass | None = option(
        None,
        unit="kg",
        meaning="Mass; default: 1 with a drive, else infinite. A body with a finite mass and no drive coasts, and what "
        "touches it pushes it (collision_mode: contact).",
    )
    friction: float | None = option(None, ge=0.0, meaning="Friction with all that it touches; default: the world's.")
    inertia: Mass | None = option(None, unit="kg m2", meaning="Moment of inertia; default: that of an even footprint.")
    restitution: float | None = option(None, ge=0.0, le=1.0, meaning="Speed that a bounce keeps; default: the world's.")
    goal: tuple[tuple[Coordinate, ...], ...] = option(
        (),
        unit="m, m, rad",
        meaning="[x, y] or [x, y, heading]; for one body also a list of them, in order; for several bodies, see above.",
        consequence="Without a goal, behaviours stand still and the body never arrives.",
    )
    behavior: Any = option(None, meaning="How the body decides; without one, it stands unless an agent drives it.")
    group_behavior: Any = option(None, meaning="How the bodies of a group decide together.")
    role: Literal["robot", "obstacle"] | None = option(None, meaning="The name of the section; may be left out.")
    color: str | None = option(
        None,
        min_length=1,
        meaning="Colour: a name, '#rrggbb', or 3 or 4 numbers from 0 to 1; 'cycle' gives each body of the entry its "
        "own. Default: green for robots, grey for obstacles.",
    )
    static: bool = option(False, meaning="The body never moves.")
    vel_min: tuple[float, ...] | None = option(
        None,
        unit="m/s or rad/s",
        meaning="Minimum velocities; default: -1 each.",
        consequence="Above 0: it never stands.",
    )
    vel_max: tuple[float, ...] | None = option(
        None,
        unit="m/s or rad/s",
        meaning="Maximum velocities; default: 1 each.",
        consequence="For acker, the second is the largest steering angle [rad]; near pi/2, the car spins.",
    )
    acce: tuple[Limit, ...] | None = option(
        None,
        unit="m/s2 or rad/s2",
        meaning="Maximum change of each velocity per second; default: no limit (.inf).",
        consequence="If small, the body cannot brake in time and overshoots its goal.",
    )
    angle_range: tuple[float, float] = option((-np.pi, np.pi), unit="rad", meaning="Interval of headings, 2 pi wide.")
    goal_threshold: float = option(
        0.1,
        ge=0.0,
        unit="m",
        meaning="The body reaches the goal when it is closer than this.",
        consequence="If smaller than half of a step's way, the body may jump over the goal; 0 is never reached.",
    )
    sensors: Any = option(None, meaning="List of sensors.")
    disturbances: Any = option(None, meaning="List of what makes the robot drive and measure differently.")
    arrive_mode: Literal["position", "state"] = option(
        "position",
        meaning="What must match the goal on arrival.",
        consequence="state adds metres and radians; dash does not turn at the goal, so it seldom arrives.",
    )
    description: str | None = option(
        None,
        min_length=1,
        meaning="Image instead of the outline, seen from above and heading right: a file beside the scenario, an "
        "absolute path, or a shipped one: car_blue.png, car_green.png, car_red.png, diff_robot0.png, diff_robot1.png; "
        "default: car_green.png for a rectangular acker robot without a colour or line style.",
    )
    group: int | None = option(None, ge=0, meaning="Number of the group, which joins entries; default: one per entry.")
    group_name: str | None = option(None, min_length=1, meaning="Name of the group; default: role_group.")
    unobstructed: bool = option(
        False,
        meaning="Collisions and sensors ignore the body; rvo, sfm and Python functions still see it.",
        consequence="The body drives through everything, and everything drives through it.",
    )
    seen_by: tuple[str, ...] | None = option(
        None,
        meaning="Whose behaviours see the body: all (default), or a list of roles, names and group names; [] for none.",
        consequence="Others walk into a body that they do not see. Sensors and observations are not concerned.",
    )
    speed_range: tuple[float, float] | None = option(
        None, unit="m/s", meaning="Bounds of the maximum speed, which each level draws in place of those of vel_max."
    )
    party: Annotated[int, Field(ge=1, le=100)] = option(
        1,
        meaning="Number of successive bodies of the entry that walk together. A circle places them side by side; if "
        "they wander, they share the goals of the first.",
    )
    unyielding: Annotated[float, Field(ge=0.0, le=1.0)] = option(
        0.0, meaning="Probability, for each body and level, that its behaviour ignores everything that moves."
    )
    plot: ObjectPlot = option(defaults(ObjectPlot), meaning="Drawing options of the body.")
    state_dim: int | None = option(None, ge=1, meaning="Number of state variables; must match the drive.")
    vel_dim: int | None = option(None, ge=1, meaning="Number of velocities; must match the drive.")
    fov: float | None = option(None, gt=0.0, unit="rad", meaning="Width of the field of view; default: the lidar's.")
    fov_radius: float | None = option(None, gt=0.0, unit="m", meaning="Depth of the view; default: the lidar's.")


@dataclass(frozen=True, kw_only=True)
class BodySpec:
    """One robot or obstacle.

    Attributes:
        name: Unique name.
        role: ``robot`` or ``obstacle``.
        entry: Index of its placement.
        line: Line of its entry in the file; 0 if unknown.
        kinematics: Instance of a registered drive; None for a body that never moves.
        shape: Instance of a registered footprint.
        behavior: Instance of a registered behaviour, or None.
        group_behavior: Instance of a registered group behaviour, or None.
        sensors: Instances of registered sensors.
        disturbances: Instances of registered disturbances.
        state: Start pose (x, y, heading) [m, m, rad]; None if the distribution chooses it.
        steering: Steering angle at the start [rad].
        goal: Waypoints (x, y, heading) [m, m, rad] in order; headings that are not given are NaN; empty without a goal.
        velocity: Velocity at the start, in the drive's coordinates [m/s or rad/s].
        vel_min: Minimum velocities [m/s or rad/s].
        vel_max: Maximum velocities [m/s or rad/s].
        acce: Maximum changes per second [m/s2 or rad/s2]; may be infinite.
        angle_range: Interval that headings wrap into [rad]; exactly 2 pi wide.
        goal_threshold: The goal is reached when the body is closer than this [m].
        arrive_mode: ``position`` or ``state``.
        static: Whether the body never moves; True without kinematics and a finite mass.
        mass: Mass [kg]; may be infinite.
        friction: Coefficient of friction, a factor without unit; None for the world's.
        inertia: Moment of inertia [kg m2]; None for that of an even footprint.
        restitution: The share of the speed that a bounce keeps; None for the world's.
        unobstructed: Whether collisions and sensors ignore the body; behaviours do not.
        group: Number of its group.
        group_name: Name of its group.
        color: Colour.
        description: Image that depicts it, or None.
        fov: Width of the field of view [rad], by default that of its first range sensor; None without either.
        fov_radius: Depth of the field of view [m], likewise.
        plot: Drawing options.
        seen_by: Roles, names and group names of bodies whose behaviours see it; None for all.
        speed_range: Bounds of its maximum speed [m/s], which each level draws; None to use ``vel_max``.
        unyielding: Probability that it ignores everything that moves, drawn for each level.
        party: Number of successive bodies of its entry that walk together.
    """

    name: str
    role: Literal["robot", "obstacle"]
    entry: int
    line: int
    kinematics: Any = None
    shape: Any
    behavior: Any = None
    group_behavior: Any = None
    sensors: tuple[Any, ...] = ()
    disturbances: tuple[Any, ...] = ()
    state: Waypoint | None = (0.0, 0.0, 0.0)
    steering: float = 0.0
    goal: tuple[Waypoint, ...] = ()
    velocity: tuple[float, ...] = (0.0, 0.0)
    vel_min: tuple[float, ...] = (-1.0, -1.0)
    vel_max: tuple[float, ...] = (1.0, 1.0)
    acce: tuple[float, ...] = (np.inf, np.inf)
    angle_range: tuple[float, float] = (-np.pi, np.pi)
    goal_threshold: float = 0.1
    arrive_mode: Literal["position", "state"] = "position"
    static: bool
    mass: float = np.inf
    friction: float | None = None
    inertia: float | None = None
    restitution: float | None = None
    unobstructed: bool = False
    group: int
    group_name: str
    color: str
    description: str | None = None
    fov: float | None = None
    fov_radius: float | None = None
    plot: ObjectPlot = field(default_factory=lambda: defaults(ObjectPlot))
    seen_by: tuple[str, ...] | None = None
    speed_range: tuple[float, float] | None = None
    unyielding: float = 0.0
    party: int = 1

    @property
    def coasts(self) -> bool:
        """Whether it moves without a drive, because it has a finite mass."""
        return self.kinematics is None and not self.static

    @property
    def renewal(self) -> Any:
        """The behaviour that determines whether it wanders or loops: its own, else that of its group."""
        return self.group_behavior if self.behavior is None else self.behavior

    @property
    def wanders(self) -> bool:
        """Whether it draws its own goals."""
        return bool(getattr(self.renewal, "wander", False))


@dataclass(frozen=True)
class PlacementSpec:
    """The placement of the bodies of one entry.

    Attributes:
        members: Numbers of the bodies.
        kind: Instance of a registered distribution.
        number_range: Minimum and maximum number of members present in a level; None for all.
        role: ``robot`` or ``obstacle``.
        line: Line of the entry in the file; 0 if unknown.
    """

    members: tuple[int, ...]
    kind: Any
    number_range: tuple[int, int] | None
    role: Literal["robot", "obstacle"]
    line: int


@dataclass(frozen=True)
class Scenario:
    """A scenario. A body's number is its index in ``bodies``: robots first, then obstacles.

    Attributes:
        name: Name of the world.
        file: Path of the file; empty for a mapping.
        world: The section ``world``.
        bodies: Robots, then obstacles.
        placements: One placement for each entry that makes bodies, in the same order.
        gui: The section ``gui``.
        task: The section ``task`` as plain data; ``{"name": ...}`` if it is a name; empty without one.
        custom: The section ``custom``, unchanged.
        source: The data that it was read from, with lines.
        root: Path of the wrapper key around all sections; empty without one.
        occupied: Cells of the obstacle map, ``(columns, rows)``, from the lower left; None without. It is the last.
        levels: Levels from a file (``levels``); None if they are drawn.
        doubts: Remarks on suspicious values, found while reading.
        ignored: Unused keys that were ignored.
        strict: Whether unused keys are errors, also in the section ``task``.
        parameters: Values of its parameters by name: given ones, else the defaults.
        disturbances, shield: Of all learners, besides those of their entries; in place of the task's, or None.
    """

    name: str
    file: str
    world: WorldSpec
    bodies: tuple[BodySpec, ...]
    placements: tuple[PlacementSpec, ...]
    gui: GuiSpec
    task: Mapping[str, object]
    custom: Any
    source: Source = field(repr=False, compare=False)
    root: Mapping[str, Place] = field(repr=False, compare=False, default_factory=dict)
    occupied: NDArray[np.bool_] | None = field(repr=False, compare=False, default=None)
    levels: LevelSet | None = field(repr=False, compare=False, default=None)
    doubts: tuple[Problem, ...] = field(repr=False, compare=False, default=())
    ignored: tuple[Problem, ...] = field(repr=False, compare=False, default=())
    strict: bool = field(repr=False, compare=False, default=True)
    parameters: Mapping[str, bool | int | float | str] = field(default_factory=dict)
    disturbances: tuple[Any, ...] = ()
    shield: Any = None

    def __repr__(self) -> str:
        n_robots, n_bodies = len(self.robots), len(self.bodies)
        return f"<Scenario {self.label}: {several(n_robots, 'robot')}, {several(n_bodies - n_robots, 'obstacle')}>"

    @property
    def label(self) -> str:
        """Its name with the values of its parameters, for reports."""
        return with_parameters(self.name, self.parameters)

    @property
    def robots(self) -> tuple[int, ...]:
        """Numbers of the robots."""
        return tuple(b for b, body in enumerate(self.bodies) if body.role == "robot")

    def problem(self, place: Place, message: str) -> Problem:
        """Return a problem with its line.

        Args:
            place: Path of the value, such as ``("task", "rewards", 0, "weight")``.
            message: What is wrong with it.
        """
        return self.source.problem((*(self.root.get(str(place[0]), ()) if place else ()), *place), message)
