"""What is drawn: one world at one moment, as plain data."""

from __future__ import annotations

from dataclasses import dataclass

from irsim_gym.arraytypes import Bytes, Flags, Floats
from irsim_gym.render.styles import BodyStyle, ScanStyle
from irsim_gym.world.marks import NOTHING, Overlay


@dataclass(frozen=True, eq=False)
class ImageView:
    """An image that is drawn in place of a footprint, stretched over the rectangle around it.

    Attributes:
        pixels: Its colours and opacity, row 0 at the top, uint8, shape ``(height, width, 4)``. The image's right
            is the body's front. The same object for all bodies and frames that show it; never written.
        corners: Where its lower left, lower right, upper right and upper left corners are [m], shape ``(4, 2)``.
        alpha: Its opacity.
    """

    pixels: Bytes
    corners: Floats
    alpha: float


@dataclass(frozen=True, eq=False)
class Form:
    """A footprint in the body frame, the same object however the body moves.

    Attributes:
        lines: Chains of vertices [m], each of shape ``(n_vertices, 2)``; closed ones repeat the first vertex.
        discs: x, y, radius of its discs [m], shape ``(n_discs, 3)``.
        solid: Its closed chains bound an area.
        mark: Corners of the mark that shows where it heads [m], shape ``(n_corners, 2)``; empty for none.
        corners: Corners of the rectangle around it [m], as of an ``ImageView``; None for an empty footprint.
        ghost: The outline that it leaves behind, or None.
    """

    lines: tuple[Floats, ...]
    discs: Floats
    solid: bool
    mark: Floats
    corners: Floats | None = None
    ghost: Form | None = None


@dataclass(frozen=True, eq=False)
class DrawnBody:
    """A body's footprint in the world frame.

    Attributes:
        body: Its id.
        name: Its name in the scenario.
        lines: Chains of vertices [m], each of shape ``(n_vertices, 2)``; closed ones repeat the first vertex.
        discs: x, y, radius of its discs [m], shape ``(n_discs, 3)``.
        solid: Its closed chains bound an area.
        heading: Corners of the mark that shows where it heads [m], shape ``(n_corners, 2)``; empty for none.
        anchor: Where its label stands [m].
        style: How it looks.
        form: Its footprint in the body frame.
        pose: Where the body frame is [m, m, rad].
        turn: The direction in which the mark of the heading points, relative to the heading [rad].
        image: What is drawn instead of the footprint, or None.
    """

    body: int
    name: str
    lines: tuple[Floats, ...]
    discs: Floats
    solid: bool
    heading: Floats
    anchor: tuple[float, float]
    style: BodyStyle
    form: Form
    pose: tuple[float, float, float]
    turn: float = 0.0
    image: ImageView | None = None


@dataclass(frozen=True, eq=False)
class GoalView:
    """Where a body goes.

    Attributes:
        x: Abscissa of the next goal [m].
        y: Its ordinate [m].
        heading: The heading that counts as arrived [rad]; NaN for any.
        tolerance: Distance at which it counts as reached [m].
        later: The goals after it [m], shape ``(n, 2)``.
        arrived: The body has reached it.
        name: Its body's name.
        style: How its body looks.
    """

    x: float
    y: float
    heading: float
    tolerance: float
    later: Floats
    arrived: bool
    name: str
    style: BodyStyle


@dataclass(frozen=True, eq=False)
class ScanView:
    """What a range sensor sees.

    Attributes:
        origin: Where it stands [m], shape ``(2,)``.
        ends: Where its beams end [m], shape ``(n_beams, 2)``.
        hits: Which beams end on something, shape ``(n_beams,)``.
        valid: Which of them were measured, those that are not too near, shape ``(n_beams,)``.
        speeds: Radial velocities [m/s], positive away from the sensor; zeros where it has none, shape ``(n_beams,)``.
        surrounds: The beams go all around.
        style: How it looks.
        body: Id of the body that carries it.
        heading: Where the sensor looks [rad].
        angles: Directions of its beams relative to that [rad], shape ``(n_beams,)``.
    """

    origin: Floats
    ends: Floats
    hits: Flags
    valid: Flags
    speeds: Floats
    surrounds: bool
    style: ScanStyle
    body: int
    heading: float
    angles: Floats


@dataclass(frozen=True, eq=False)
class TrailView:
    """Where a body has been.

    Attributes:
        points: Its positions, the last one now [m], shape ``(n, 2)``.
        style: How its body looks.
    """

    points: Floats
    style: BodyStyle


@dataclass(frozen=True, eq=False)
class FieldView:
    """What a body could see.

    Attributes:
        x: Abscissa of its apex [m].
        y: Its ordinate [m].
        heading: Direction of its middle [rad].
        span: Its width [rad].
        radius: Its depth [m].
        style: How its body looks.
    """

    x: float
    y: float
    heading: float
    span: float
    radius: float
    style: BodyStyle


@dataclass(frozen=True, eq=False)
class LabelView:
    """A text.

    Attributes:
        x: Abscissa of its middle [m].
        y: Ordinate of its foot [m].
        text: The words.
        style: How its body looks.
        under: Below which ordinate it may stand instead [m], or None.
    """

    x: float
    y: float
    text: str
    style: BodyStyle
    under: float | None = None


@dataclass(frozen=True, eq=False)
class MapView:
    """The occupancy map.

    Attributes:
        extent: Its rectangle [m]: x_min, y_min, x_max, y_max.
        occupied: Which cells are, shape ``(n_columns, n_rows)``, from the lower left corner.
        colour: Colour of occupied cells.
        alpha: Their opacity.
    """

    extent: tuple[float, float, float, float]
    occupied: Flags
    colour: str
    alpha: float


@dataclass(frozen=True, eq=False)
class FogView:
    """What nobody has seen yet: it lies above the map and fixed bodies, below all else.

    Attributes:
        extent: Its rectangle [m]: x_min, y_min, x_max, y_max.
        covered: Which cells are covered, shape ``(n_columns, n_rows)``, from the lower left corner.
        colour: Its colour.
        alpha: Its opacity.
    """

    extent: tuple[float, float, float, float]
    covered: Flags
    colour: str
    alpha: float


@dataclass(frozen=True, eq=False)
class Scene:
    """One world at one moment.

    Attributes:
        world: Its index.
        bounds: Its rectangle [m]: x_min, y_min, x_max, y_max, shape ``(4,)``.
        title: Heading of the picture.
        time: Elapsed time [s].
        status: How the episode stands, e.g. ``"running"``.
        fixed: Bodies that never move. The same object as long as none of them has changed.
        moving: The other bodies, in drawing order.
        struck: The bodies among both that take part in a robot's collision.
        goals: Goals that are shown.
        scans: Scans that are shown.
        trails: Trajectories that are shown.
        ghosts: Outlines that bodies have left behind.
        fields: Fields of view that are shown.
        labels: Texts beside bodies and goals.
        map: The occupancy map, or None. The same object as long as it has not changed.
        center: Point that stays in the middle of the picture [m], or None.
        fog: What nobody has seen yet, or None. The same object as long as it has not changed.
        overlay: What somebody drew over the world. The same object as long as it has not changed.
    """

    world: int
    bounds: Floats
    title: str
    time: float
    status: str
    fixed: tuple[DrawnBody, ...]
    moving: tuple[DrawnBody, ...]
    struck: tuple[DrawnBody, ...]
    goals: tuple[GoalView, ...]
    scans: tuple[ScanView, ...]
    trails: tuple[TrailView, ...]
    ghosts: tuple[DrawnBody, ...]
    fields: tuple[FieldView, ...] = ()
    labels: tuple[LabelView, ...] = ()
    map: MapView | None = None
    center: tuple[float, float] | None = None
    fog: FogView | None = None
    overlay: Overlay = NOTHING
