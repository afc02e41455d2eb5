"""Drawing options as data, independent of the renderer."""

from collections.abc import Collection, Iterable, Iterator
from typing import Annotated, Any, Literal

from pydantic import Field

from irsim_gym.base.options import defaults, kind, option
from irsim_gym.scenario.specs.colors import color_problem

ROBOT_COLOR = "#009E73"
CAR_COLOR = "#117733"
COASTING_COLOR = "#E69F00"
OBSTACLE_COLOR, MOVING_OBSTACLE_COLOR, MAP_COLOR = "#475569", "#64748B", "#334155"
CYCLE = ("#009E73", "#E69F00", "#56B4E9", "#D55E00", "#0072B2", "#CC79A7", "#F0E442", "#000000")

LineStyle = Literal["-", "--", "-.", ":", "solid", "dashed", "dashdot", "dotted"]
Pixels = Annotated[int, Field(ge=16, le=10_000)]


@kind
class SavedFigure:
    """Options of figures that are written to files."""

    dpi: int = option(100, ge=1, le=2400, unit="1/inch", meaning="Resolution of saved figures.")
    bbox_inches: Literal["tight", "standard"] | None = option(
        "tight", meaning="Crop a saved figure to its content (tight), or keep all (standard, null)."
    )
    format: Literal["png", "pdf", "svg", "jpg", "jpeg", "eps", "ps", "tif", "tiff", "webp"] = option(
        "png", meaning="File format of saved figures without a suffix."
    )
    pad_inches: float = option(0.1, ge=0.0, le=10.0, unit="inch", meaning="Margin where bbox_inches is tight.")
    facecolor: str | None = option(None, min_length=1, meaning="Colour around the world; default: light grey.")
    transparent: bool = option(False, meaning="A transparent background, if possible.", consequence="No facecolor.")

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of an unknown colour."""
        problem = color_problem(self.facecolor)
        if problem:
            yield "facecolor", problem


@kind
class WorldPlot:
    """Drawing options of the world."""

    saved_figure: SavedFigure = option(defaults(SavedFigure), meaning="Options of saved figures.")
    figure_pixels: tuple[Pixels, Pixels] | None = option(
        None,
        unit="pixel",
        meaning="Width and height of a picture; default: [600, 600] for a square world, otherwise in proportion "
        "to its sides.",
    )
    show_title: bool = option(True, meaning="Show a title.")
    title: str | None = option(None, meaning="Text of the title; default: the world's name, time and status.")
    no_axis: bool = option(False, meaning="Hide the axes.")
    tight: bool = option(True, meaning="Keep only as much margin around the world as ticks and title need.")
    viewpoint: str | tuple[float, float] | None = option(None, unit="m", meaning="Body or point in the middle.")


@kind
class ObjectPlot:
    """Drawing options of a body. Colours that are not given are the body's own."""

    obj_linestyle: LineStyle = option("-", meaning="Line style of the outline.")
    obj_zorder: int | None = option(None, meaning="Layer; higher ones lie on top; default: robots 3, obstacles 1.")
    obj_color: str | None = option(None, meaning="Colour of the body.")
    obj_alpha: float = option(1.0, ge=0.0, le=1.0, meaning="Opacity of the body.")
    obj_linewidth: float | None = option(None, ge=0.0, unit="point", meaning="Outline; default: 1, linestring 2.2.")

    show_goal: bool | None = option(None, meaning="Draw the goal; default: only for learners.")
    goal_color: str | None = option(None, meaning="Colour of the goal.")
    goal_alpha: float = option(1.0, ge=0.0, le=1.0, meaning="Opacity of the goal.")
    goal_zorder: int | None = option(None, meaning="Layer of the goal; default: between fixed and moving bodies.")

    show_text: bool = option(False, meaning="Write the body's short name beside it.")
    show_goal_text: bool = option(False, meaning="Write the body's short name beside its goal.")
    text_color: str = option("#1F2933", meaning="Colour of the text.")
    text_size: float = option(10.0, gt=0.0, unit="point", meaning="Size of the text.")
    text_alpha: float = option(1.0, ge=0.0, le=1.0, meaning="Opacity of the text.")
    text_zorder: int | None = option(None, meaning="Layer of the text; default: above everything.")
    text_position: tuple[float, float] | None = option(None, unit="m", meaning="Place from the body; default: above.")

    show_arrow: bool | None = option(
        None,
        meaning="Mark the heading, by default for bodies that move and turn: inside the footprint, or as an arrow "
        "if arrow_length or arrow_width is given.",
    )
    arrow_color: str | None = option(None, meaning="Colour of the arrow; default: white inside, gold with a size.")
    arrow_length: float | None = option(None, ge=0.0, unit="m", meaning="Length of an arrow; default: 0.4 with width.")
    arrow_width: float | None = option(None, ge=0.0, unit="m", meaning="Width of the arrow; default: 0.6 with length.")
    arrow_alpha: float = option(1.0, ge=0.0, le=1.0, meaning="Opacity of the arrow.")
    arrow_zorder: int | None = option(None, meaning="Layer of the arrow; default: that of the body.")

    show_trajectory: bool | None = option(None, meaning="Draw the path driven so far; default: only for learners.")
    traj_color: str | None = option(None, meaning="Colour of the path.")
    traj_style: LineStyle = option("-", meaning="Line style of the path.")
    traj_width: float | None = option(None, gt=0.0, unit="m", meaning="Width of the path; default: thin, fading.")
    traj_alpha: float | None = option(
        None, ge=0.0, le=1.0, meaning="Opacity of the path at its end; default: 0.85, or 0.5 with traj_width."
    )
    traj_zorder: int | None = option(None, meaning="Layer of the path; default: between fixed and moving bodies.")
    keep_traj_length: int = option(0, ge=0, unit="step", meaning="Number of steps to keep in the path; 0 keeps all.")

    show_trail: bool = option(False, meaning="Draw outlines of the body along its path.")
    trail_freq: int = option(2, ge=1, unit="step", meaning="Steps between two outlines of the trail.")
    trail_type: Literal["circle", "rectangle", "polygon", "linestring", "compound"] | None = option(
        None, meaning="Shape of the trail's outlines; default: the body's. 'circle' and 'rectangle' enclose it."
    )
    trail_edgecolor: str | None = option(None, meaning="Edge colour of the trail.")
    trail_linewidth: float = option(0.8, ge=0.0, unit="point", meaning="Edge width of the trail.")
    trail_alpha: float = option(0.7, ge=0.0, le=1.0, meaning="Opacity of the trail.")
    trail_fill: bool = option(False, meaning="Fill the trail's outlines.")
    trail_color: str | None = option(None, meaning="Fill colour of the trail.")
    trail_zorder: int | None = option(None, meaning="Layer of the trail; default: between fixed and moving bodies.")
    keep_trail_length: int = option(0, ge=0, meaning="Number of outlines to keep in the trail; 0 keeps all.")

    show_sensor: bool = option(True, meaning="Draw the sensors.")
    show_fov: bool = option(False, meaning="Draw the field of view (fov and fov_radius, otherwise the lidar's).")
    fov_color: str = option("#56B4E9", meaning="Colour of the field of view.")
    fov_edge_color: str = option("#0072B2", meaning="Edge colour of the field of view.")
    fov_alpha: float = option(0.5, ge=0.0, le=1.0, meaning="Opacity of the field of view.")
    fov_zorder: int | None = option(None, meaning="Layer of the field of view; default: above fixed bodies.")

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of each unknown colour."""
        for key in COLOR_KEYS:
            problem = color_problem(getattr(self, key))
            if problem:
                yield key, problem


COLOR_KEYS = tuple(name for name in ObjectPlot.__annotations__ if name.endswith(("_color", "_edgecolor")))


def trailing(bodies: Iterable[Any], learners: Collection[int] = ()) -> list[int]:
    """Return the numbers of the bodies (``BodySpec``) with a drawn path or trail; learners have a path by default."""
    trailing_bodies = []
    for b, body in enumerate(bodies):
        plot = body.plot
        has_path = b in learners if plot.show_trajectory is None else plot.show_trajectory
        if (has_path or plot.show_trail) and not body.static:
            trailing_bodies.append(b)
    return trailing_bodies
