"""Styles of bodies and scans, from a scenario's plot options and the theme."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from irsim_gym.rendering.looks import theme
from irsim_gym.simulator.world.model import OMNI_BODY, OMNI_WORLD

if TYPE_CHECKING:
    from irsim_gym.scenario.specs.plot_spec import ObjectPlot
    from irsim_gym.scenario.specs.spec import BodySpec

T = TypeVar("T")

GROUND, TOP = 1.0, 1e9
"""The layer of obstacles, and the layer above everything."""
ARROW = "gold"
"""Default colour of arrows that extend beyond the footprint."""
CLEAR = "none"
LINESTYLES = {"-": "solid", "--": "dashed", "-.": "dashdot", ":": "dotted"}


@dataclass(frozen=True)
class BodyStyle:
    """The style of a body. Lengths are typographic points unless marked as [m].

    Opacities include those of the given colours. The colour of an edge may be ``"none"``.

    Attributes:
        colour: Fill colour, or the colour of the line of a curve.
        edge_colour: Edge colour; None for a darker shade of the fill.
        filled: Whether the area is filled.
        alpha: Opacity.
        image_alpha: Opacity of the image.
        line_width: Width of the edge.
        wall_width: Width of the line of a curve.
        line_style: Style of the edge.
        order: Layer; bodies in higher layers cover those in lower ones.
        show_goal: Whether to draw the goal.
        goal_colour: Colour of the goal.
        goal_alpha: Opacity of the goal.
        goal_order: Layer of the goal.
        show_arrow: Whether to mark the heading.
        arrow: Length and width of the mark [m]; None for a mark inside the footprint.
        arrow_colour: Colour of the mark.
        arrow_alpha: Opacity of the mark; includes that of the body for a mark inside the footprint.
        arrow_order: Layer of the mark; None for that of the body.
        show_trajectory: Whether to draw the path.
        trajectory_colour: Colour of the path.
        trajectory_style: Line style of the path.
        trajectory_width: Width of the path [m]; None for that of the theme.
        trajectory_alpha: Opacity of the path at its end.
        trajectory_length: Number of the latest positions to draw; 0 for all.
        trajectory_order: Layer of the path.
        ghost: Style of the outlines in the trail; None for no trail.
        ghost_shape: Shape of the outlines; None for that of the body.
        ghost_every: Steps between two outlines.
        ghost_length: Number of the latest outlines to draw; 0 for all.
        show_sensor: Whether to draw the sensors' readings.
        show_field: Whether to draw the field of view.
        field_colour: Colour of the field of view.
        field_edge_colour: Edge colour of the field of view.
        field_alpha: Opacity of the field of view.
        field_order: Layer of the field of view.
        label: Text beside the body; empty for none.
        goal_label: Text beside the goal; empty for none.
        label_colour: Colour of the texts.
        label_halo: Colour of a halo around their letters; empty for none.
        label_size: Type size of the texts.
        label_alpha: Opacity of the texts.
        label_offset: Position of the text relative to the body's origin [m]; None for above the body.
        label_order: Layer of the texts.
    """

    colour: str
    edge_colour: str | None = None
    filled: bool = True
    alpha: float = 1.0
    image_alpha: float = 1.0
    line_width: float = 1.0
    wall_width: float = 2.2
    line_style: str = "solid"
    order: float = GROUND
    show_goal: bool = False
    goal_colour: str = theme.ROBOT
    goal_alpha: float = 1.0
    goal_order: float = GROUND
    show_arrow: bool = False
    arrow: tuple[float, float] | None = None
    arrow_colour: str = theme.HEADING
    arrow_alpha: float = 0.95
    arrow_order: float | None = None
    show_trajectory: bool = False
    trajectory_colour: str = theme.ROBOT
    trajectory_style: str = "solid"
    trajectory_width: float | None = None
    trajectory_alpha: float = 0.85
    trajectory_length: int = 0
    trajectory_order: float = GROUND
    ghost: BodyStyle | None = None
    ghost_shape: str | None = None
    ghost_every: int = 1
    ghost_length: int = 0
    show_sensor: bool = True
    show_field: bool = False
    field_colour: str = theme.FIELD
    field_edge_colour: str = theme.FIELD_EDGE
    field_alpha: float = 0.3
    field_order: float = GROUND
    label: str = ""
    goal_label: str = ""
    label_colour: str = theme.INK
    label_halo: str = ""
    label_size: float = 8.0
    label_alpha: float = 1.0
    label_offset: tuple[float, float] | None = None
    label_order: float = TOP


@dataclass(frozen=True)
class VelocityStyle:
    """The style of radial velocities.

    Attributes:
        coloured: Whether beams are coloured by velocity.
        rest_colour: Colour for velocity 0.
        away_colour: Colour for motion away from the sensor.
        nearer_colour: Colour for motion towards the sensor.
        full_speed: Speed at which the colour is saturated [m/s].
        width: Width of beams that hit something.
        free_colour: Colour of the other beams.
        free_alpha: Opacity of the other beams.
        free_width: Width of the other beams.
        mark_size: Area of the marks at hit points [point^2]; 0 for none.
        mark_edge_colour: Edge colour of the marks.
        mark_edge_width: Edge width of the marks.
    """

    coloured: bool
    rest_colour: str
    away_colour: str
    nearer_colour: str
    full_speed: float
    width: float
    free_colour: str
    free_alpha: float
    free_width: float
    mark_size: float
    mark_edge_colour: str
    mark_edge_width: float


@dataclass(frozen=True)
class ScanStyle:
    """The style of a scan.

    Attributes:
        colour: Colour of beams and hits.
        alpha: Opacity of the beams, which forms scale; the theme is designed for 0.3. With coloured velocities, the
            opacity of beams that hit something.
        velocity: Style of radial velocities; None if the sensor does not measure them.
    """

    colour: str = theme.BEAM
    alpha: float = 0.3
    velocity: VelocityStyle | None = None


def body_style(body: BodySpec, *, learner: bool = False) -> BodyStyle:
    """Return the style of a body; a learner shows its goal and trajectory by default."""
    plot, robot = body.plot, body.role == "robot"
    body_colour = str(body.color if plot.obj_color is None else plot.obj_color)
    label, arrow = _short_name(body.name, robot), _arrow(plot)
    band = plot.traj_width is not None
    colour, alpha = faded(body_colour, plot.obj_alpha)
    goal_colour, goal_alpha = faded(_or_else(plot.goal_color, body_colour), plot.goal_alpha)
    arrow_colour, arrow_alpha = faded(_or_else(plot.arrow_color, ARROW if arrow else theme.HEADING), plot.arrow_alpha)
    path_colour, path_alpha = faded(
        _or_else(plot.traj_color, body_colour), _or_else(plot.traj_alpha, 0.5 if band else 0.85)
    )
    field_colour, field_alpha = faded(plot.fov_color, plot.fov_alpha)
    label_colour, label_alpha = faded(plot.text_color, plot.text_alpha)
    return BodyStyle(
        colour=colour,
        alpha=alpha,
        image_alpha=plot.obj_alpha,
        line_width=_or_else(plot.obj_linewidth, 1.0),
        wall_width=_or_else(plot.obj_linewidth, 2.2),
        line_style=_line_style(plot.obj_linestyle),
        order=float(_or_else(plot.obj_zorder, 3 if robot else 1)),
        show_goal=_or_else(plot.show_goal, learner),
        goal_colour=goal_colour,
        goal_alpha=goal_alpha,
        goal_order=_or_else(plot.goal_zorder, GROUND),
        show_arrow=_or_else(plot.show_arrow, not body.static and not is_omni(body) and body.description is None),
        arrow=arrow,
        arrow_colour=arrow_colour,
        arrow_alpha=arrow_alpha if arrow else arrow_alpha * alpha,
        arrow_order=plot.arrow_zorder,
        show_trajectory=_or_else(plot.show_trajectory, learner),
        trajectory_colour=path_colour,
        trajectory_style=_line_style(plot.traj_style),
        trajectory_width=plot.traj_width,
        trajectory_alpha=path_alpha,
        trajectory_length=plot.keep_traj_length,
        trajectory_order=_or_else(plot.traj_zorder, GROUND),
        ghost=_ghost(plot, body_colour) if plot.show_trail else None,
        ghost_shape=plot.trail_type,
        ghost_every=plot.trail_freq,
        ghost_length=plot.keep_trail_length,
        show_sensor=plot.show_sensor,
        show_field=plot.show_fov,
        field_colour=field_colour,
        field_edge_colour=plot.fov_edge_color,
        field_alpha=field_alpha,
        field_order=_or_else(plot.fov_zorder, GROUND),
        label=label if plot.show_text else "",
        goal_label=label if plot.show_goal_text else "",
        label_colour=label_colour,
        label_size=plot.text_size,
        label_alpha=label_alpha,
        label_offset=plot.text_position,
        label_order=_or_else(plot.text_zorder, TOP),
    )


def is_omni(body: BodySpec) -> bool:
    """Return whether a body can move in any direction without turning."""
    return getattr(body.kinematics, "drive", None) in (OMNI_WORLD, OMNI_BODY)


def field_of_view(body: BodySpec) -> tuple[float, float] | None:
    """Return width [rad] and depth [m] of a body's field of view, by default those of its first scanner, or None."""
    scanners = [sensor for sensor in body.sensors if hasattr(sensor, "angle_range") and hasattr(sensor, "range_max")]
    span = scanners[0].angle_range if body.fov is None and scanners else body.fov
    depth = scanners[0].range_max if body.fov_radius is None and scanners else body.fov_radius
    return None if span is None or depth is None else (min(float(span), 2.0 * math.pi), float(depth))


def scan_style(sensor: object) -> ScanStyle:
    """Return the style of a sensor's scan from the sensor's options; those in ``plot`` take precedence."""
    plot: Any = getattr(sensor, "plot", None)
    beam_colour = _or_else(getattr(plot, "color", None), getattr(sensor, "color", theme.BEAM))
    alpha = _or_else(getattr(plot, "alpha", None), getattr(sensor, "alpha", 0.3))
    if not hasattr(plot, "velocity_color"):
        return ScanStyle(*faded(beam_colour, alpha))
    velocity = VelocityStyle(
        coloured=plot.velocity_color,
        rest_colour=plot.zero_velocity_color,
        away_colour=plot.positive_velocity_color,
        nearer_colour=plot.negative_velocity_color,
        full_speed=plot.velocity_color_max,
        width=plot.velocity_linewidth,
        free_colour=plot.no_hit_color,
        free_alpha=plot.no_hit_alpha,
        free_width=plot.no_hit_linewidth,
        mark_size=plot.velocity_marker_size if plot.show_velocity_markers else 0.0,
        mark_edge_colour=plot.velocity_marker_edge_color,
        mark_edge_width=plot.velocity_marker_edge_width,
    )
    return ScanStyle(*faded(beam_colour, _or_else(alpha, 1.0 if plot.velocity_color else 0.3)), velocity)


def _or_else(value: T | None, otherwise: T) -> T:
    """Return a given option, or else its default."""
    return otherwise if value is None else value


def _arrow(plot: ObjectPlot) -> tuple[float, float] | None:
    """Return length and width of an arrow [m]; None if neither is given."""
    if plot.arrow_length is None and plot.arrow_width is None:
        return None
    return _or_else(plot.arrow_length, 0.4), _or_else(plot.arrow_width, 0.6)


def _ghost(plot: ObjectPlot, colour: str) -> BodyStyle:
    """Return the style of the outlines in a body's trail."""
    edge, edge_alpha = faded(_or_else(plot.trail_edgecolor, colour), plot.trail_alpha)
    fill, fill_alpha = faded(_or_else(plot.trail_color, colour), plot.trail_alpha)
    filled, wide = plot.trail_fill, plot.trail_linewidth
    look: dict[str, Any] = {"filled": filled, "line_width": wide, "wall_width": wide}
    look |= {"alpha": fill_alpha if filled else edge_alpha, "order": _or_else(plot.trail_zorder, GROUND)}
    return BodyStyle(colour=fill, edge_colour=CLEAR if edge_alpha == 0.0 else edge, **look)


def faded(colour: str, alpha: float) -> tuple[str, float]:
    """Return a colour without its own opacity, and the product of both opacities."""
    if colour.lower() == CLEAR:
        return "#000000", 0.0
    if colour.startswith("#") and len(colour) in (5, 9):
        digits = 1 if len(colour) == 5 else 2
        return colour[:-digits], alpha * int(colour[-digits:], 16) / (16**digits - 1)
    return colour, alpha


def _line_style(name: str) -> str:
    return LINESTYLES.get(name, name)


def _short_name(name: str, robot: bool) -> str:
    """Return the label of a body as in IR-SIM: r0 for robot_0; other names are unchanged."""
    head, _, number = name.rpartition("_")
    return ("r" if robot else "o") + number if head in ("robot", "obstacle") and number.isdigit() else name
