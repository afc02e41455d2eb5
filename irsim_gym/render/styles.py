"""How things look: a scenario's plot options where it sets them, the theme elsewhere."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Any

from irsim_gym.render import theme
from irsim_gym.world.model import OMNI_BODY, OMNI_WORLD

UNSET_OBSTACLE_COLOURS = frozenset({"k"})
GROUND, TOP = 1.0, 1e9
"""Layers: that of obstacles, and that of what covers everything."""
LINESTYLES = {"-": "solid", "--": "dashed", "-.": "dashdot", ":": "dotted"}


@dataclass(frozen=True)
class BodyStyle:
    """How one body is drawn; lengths in points of the figure unless they say [m].

    Attributes:
        colour: Its fill, and the colour of its line when it is a curve.
        edge_colour: Colour of its edge; None for a darker shade of the fill.
        filled: Its area is filled.
        alpha: Its opacity.
        line_width: Width of its edge.
        wall_width: Width of its line when it is a curve.
        line_style: Style of its edge.
        order: Bodies with a higher number are drawn over those with a lower one.
        show_goal: Mark its goal.
        goal_colour: Colour of the mark.
        goal_alpha: Opacity of the mark.
        goal_order: Its layer.
        show_arrow: Mark where it heads.
        arrow: Length and width of that mark [m]; None for one that fits into the footprint.
        arrow_colour: Colour of that mark.
        arrow_alpha: Opacity of that mark.
        arrow_order: Its layer; None for the body's.
        show_trajectory: Draw where it has been.
        trajectory_colour: Colour of that line.
        trajectory_style: Style of that line.
        trajectory_width: Width of that line [m]; None for the theme's.
        trajectory_alpha: Opacity of that line at its head.
        trajectory_length: So many of the latest positions are drawn; 0 for all.
        trajectory_order: Layer of that line.
        ghost: How the outlines look that it leaves behind; None for none.
        ghost_shape: Shape of those outlines; None for the body's own.
        ghost_every: It leaves one at every n-th step.
        ghost_length: So many of the latest outlines are drawn; 0 for all.
        show_sensor: Draw what its sensors see.
        show_field: Draw its field of view.
        field_colour: Colour of the field of view.
        field_edge_colour: Colour of its edge.
        field_alpha: Its opacity.
        field_order: Its layer.
        label: Text beside it; empty for none.
        goal_label: Text beside its goal; empty for none.
        label_colour: Colour of those texts.
        label_size: Their size.
        label_alpha: Their opacity.
        label_offset: Where the text stands, from the body's origin [m]; None for above the body.
        label_order: Layer of those texts.
    """

    colour: str
    edge_colour: str | None = None
    filled: bool = True
    alpha: float = 1.0
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
    label_size: float = 8.0
    label_alpha: float = 1.0
    label_offset: tuple[float, float] | None = None
    label_order: float = TOP


@dataclass(frozen=True)
class ScanStyle:
    """How a scan is drawn.

    Attributes:
        colour: Colour of beams and hits.
        alpha: Strength of the beams; 0.3 is what the theme is made for.
    """

    colour: str = theme.BEAM
    alpha: float = 0.3


def body_style(body: Any, *, learner: bool = False) -> BodyStyle:
    """Return how a body of the scenario (``BodySpec``) is drawn; a learner shows its goal and trajectory unasked."""
    options = partial(chosen, body.plot)
    robot, moves = body.role == "robot", not body.static
    colour = options("obj_color", _body_colour(body, robot, moves))
    length, width = options("arrow_length", None), options("arrow_width", None)
    arrow = None if length is None and width is None else (length or 0.4, width or 0.6)
    label = _short_name(body.name, robot)
    return BodyStyle(
        colour=colour,
        alpha=options("obj_alpha", 1.0),
        line_width=options("obj_linewidth", 1.0),
        wall_width=options("obj_linewidth", 2.2),
        line_style=_line_style(options("obj_linestyle", "-")),
        order=float(options("obj_zorder", 3 if robot else 1)),
        show_goal=options("show_goal", learner),
        goal_colour=options("goal_color", colour),
        goal_alpha=options("goal_alpha", 1.0),
        goal_order=options("goal_zorder", GROUND),
        show_arrow=options("show_arrow", moves and not is_omni(body)),
        arrow=arrow,
        arrow_colour=options("arrow_color", theme.HEADING),
        arrow_alpha=options("arrow_alpha", 0.95),
        arrow_order=options("arrow_zorder", None),
        show_trajectory=options("show_trajectory", learner),
        trajectory_colour=options("traj_color", colour),
        trajectory_style=_line_style(options("traj_style", "-")),
        trajectory_width=options("traj_width", None),
        trajectory_alpha=options("traj_alpha", 0.85),
        trajectory_length=options("keep_traj_length", 0),
        trajectory_order=options("traj_zorder", GROUND),
        ghost=_ghost(body.plot, colour) if options("show_trail", False) else None,
        ghost_shape=options("trail_type", None),
        ghost_every=options("trail_freq", 2),
        ghost_length=options("keep_trail_length", 0),
        show_sensor=options("show_sensor", True),
        show_field=options("show_fov", False),
        field_colour=options("fov_color", theme.FIELD),
        field_edge_colour=options("fov_edge_color", theme.FIELD_EDGE),
        field_alpha=options("fov_alpha", 0.3),
        field_order=options("fov_zorder", GROUND),
        label=label if options("show_text", False) else "",
        goal_label=label if options("show_goal_text", False) else "",
        label_colour=options("text_color", theme.INK),
        label_size=float(options("text_size", 8.0)),
        label_alpha=options("text_alpha", 1.0),
        label_offset=options("text_position", None),
        label_order=options("text_zorder", TOP),
    )


def is_omni(body: Any) -> bool:
    """Return whether a body moves without turning."""
    return getattr(body.kinematics, "drive", None) in (OMNI_WORLD, OMNI_BODY)


def field_of_view(body: Any) -> tuple[float, float] | None:
    """Return width [rad] and depth [m] of a body's field of view: its own, else its first scanner's; None without."""
    scanners = [sensor for sensor in body.sensors if hasattr(sensor, "angle_range") and hasattr(sensor, "range_max")]
    span = scanners[0].angle_range if body.fov is None and scanners else body.fov
    depth = scanners[0].range_max if body.fov_radius is None and scanners else body.fov_radius
    return None if span is None or depth is None else (min(float(span), 2.0 * math.pi), float(depth))


def map_style(style: BodyStyle | None) -> tuple[str, float]:
    """Return colour and opacity of a map's occupied cells; a colour of its own wins over the theme's."""
    if style is None or style.colour == theme.OBSTACLE:
        return theme.MAP, 1.0 if style is None else style.alpha
    return style.colour, style.alpha


def scan_style(sensor: Any) -> ScanStyle:
    """Return how a sensor's scan (its options) is drawn; what stands under ``plot`` wins."""
    plot = getattr(sensor, "plot", None)
    colour = str(chosen(plot, "color", chosen(sensor, "color", theme.BEAM)))
    alpha = float(chosen(plot, "alpha", getattr(sensor, "alpha", 0.3)))
    return ScanStyle(colour=colour, alpha=alpha if math.isfinite(alpha) else 0.3)


def chosen(options: Any, name: str, otherwise: Any = None) -> Any:
    """Return an option that a scenario sets; ``otherwise`` where it is absent or equal to its default."""
    value = getattr(options, name, None)
    declared = getattr(type(options), "__pydantic_fields__", {}).get(name)
    return otherwise if value is None or (declared is not None and value == declared.default) else value


def _body_colour(body: Any, robot: bool, moves: bool) -> str:
    """Return the body's colour; IR-SIM's black, the colour of obstacles without one, becomes the theme's."""
    if not robot and body.color in UNSET_OBSTACLE_COLOURS:
        return theme.MOVING_OBSTACLE if moves else theme.OBSTACLE
    return str(body.color)


def _ghost(plot: Any, colour: str) -> BodyStyle:
    """Return how the outlines look that a body leaves behind."""
    options = partial(chosen, plot)
    return BodyStyle(
        colour=options("trail_color", colour),
        edge_colour=options("trail_edgecolor", colour),
        filled=options("trail_fill", False),
        alpha=options("trail_alpha", 0.7),
        line_width=options("trail_linewidth", 0.8),
        wall_width=options("trail_linewidth", 0.8),
        order=options("trail_zorder", GROUND),
    )


def _line_style(name: str) -> str:
    return LINESTYLES.get(name, name)


def _short_name(name: str, robot: bool) -> str:
    """Return the label that IR-SIM puts beside a body: r0 for robot_0; other names as they are."""
    head, _, number = name.rpartition("_")
    return ("r" if robot else "o") + number if head in ("robot", "obstacle") else name
