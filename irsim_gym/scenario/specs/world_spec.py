"""The section ``world`` of a file."""

from typing import Annotated, Any, Literal

from pydantic import Field

from irsim_gym.base.options import LARGEST, defaults, kind, option
from irsim_gym.scenario.specs.plot_spec import WorldPlot

Coordinate = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]


@kind
class WorldSpec:
    """The section ``world``."""

    name: str = option("world", min_length=1, max_length=200, meaning="Name of the world; default: the file's name.")
    width: float = option(10.0, gt=0.0, le=1e5, unit="m", meaning="Size in x; bodies may leave it.")
    height: float = option(10.0, gt=0.0, le=1e5, unit="m", meaning="Size of the world in y.", consequence="As width.")
    step_time: float = option(
        0.1,
        gt=0.0,
        le=100.0,
        unit="s",
        meaning="Duration of a step.",
        consequence="If large, bodies jump through thin walls and over small goals.",
    )
    sample_time: float = option(
        0.1, gt=0.0, unit="s", meaning="Time from frame to frame, in steps.", consequence="Short: each step is a frame."
    )
    offset: tuple[Coordinate, Coordinate] = option(
        (0.0, 0.0), unit="m", meaning="Lower left corner of the world.", consequence="It does not shift given poses."
    )
    control_mode: Literal["auto", "keyboard"] = option(
        "auto", meaning="What drives in irsim_gym.load: behaviours, or the keyboard of a window. No effect on learners."
    )
    collision_mode: Literal["stop", "unobstructed", "unobstructed_obstacles", "contact"] = option(
        "stop",
        meaning="Which bodies stop at a collision: all, none, or robots only; with contact, bodies push each other.",
        consequence="With stop, bodies that touch stand still until one of them is removed.",
    )
    gravity: float = option(9.81, gt=0.0, unit="m/s2", meaning="Gravity, which presses bodies to the ground.")
    friction: float = option(0.5, ge=0.0, meaning="Coefficient of friction of bodies without their own.")
    restitution: float = option(0.0, ge=0.0, le=1.0, meaning="Restitution of bodies without their own; 1 keeps speed.")
    drive_tau: float = option(0.0, ge=0.0, unit="s", meaning="With contact, lag of drives without tau; 0: none.")
    collision_check: Literal["step_end", "swept"] = option(
        "step_end",
        meaning="Where contacts are looked for: where each step ends, or all along its way (swept).",
        consequence="With step_end, bodies pass what is thinner than a step is long. swept takes time.",
    )
    status: Literal["None", "Running", "Arrived", "Collision", "Pause"] = option(
        "None", meaning="Status text at the start; with Pause, irsim_gym.load begins paused. No effect on learners."
    )
    obstacle_map: Any = option(None, meaning="Occupied cells: an image, a map.yaml of ROS, or a kind with its options.")
    mdownsample: int = option(1, ge=1, meaning="Keep every n-th cell.", consequence="Thinner walls may vanish.")
    plot: WorldPlot = option(defaults(WorldPlot), meaning="Drawing options of the world.")
    step_mode: Literal["internal", "external"] = option(
        "internal", meaning="What moves the bodies: the step, or the caller (external; not for learners)."
    )
    fog_map: bool = option(False, meaning="Keep a map of what the robots have seen; it does not affect the simulation.")
    fog_map_resolution: float | None = option(None, gt=0.0, unit="m", meaning="Cell size; default: the map's or 0.1 m.")
    update: Literal["sequential", "simultaneous"] = option(
        "sequential", meaning="Bodies see earlier ones moved (sequential), or all before the step (simultaneous)."
    )

    @property
    def steps_per_sample(self) -> int:
        """Number of steps between samples: ``sample_time`` in whole steps, at least one."""
        return max(1, int(round(self.sample_time / self.step_time, 9)))
