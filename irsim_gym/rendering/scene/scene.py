"""Scenes: the content of a picture of one world at one moment, as plain data."""

from __future__ import annotations

from dataclasses import dataclass

from irsim_gym.base.arraytypes import Bytes, Flags, Floats
from irsim_gym.rendering.looks.styles import BodyStyle, ScanStyle
from irsim_gym.simulator.readings.marks import NOTHING, Overlay


@dataclass(frozen=True, eq=False)
class ImageView:
    """An image that replaces a footprint, stretched over its bounding rectangle.

    Attributes:
        pixels: Its pixels, RGBA, row 0 at the top, uint8, shape ``(height, width, 4)``, read-only. The right side of
            the image is the front of the body. The same object for all bodies and frames with this image.
        corners: Its lower left, lower right, upper right and upper left corners [m], shape ``(4, 2)``.
        alpha: Its opacity.
    """

    pixels: Bytes
    corners: Floats
    alpha: float


@dataclass(frozen=True, eq=False)
class Form:
    """A footprint in the body frame, the same object while the body moves.

    Attributes:
        lines: Chains of vertices [m], each of shape ``(n_vertices, 2)``; closed ones repeat the first vertex.
        discs: x, y, radius of its discs [m], shape ``(n_discs, 3)``.
        solid: Whether its closed chains bound an area.
        mark: Corners of the mark of its heading [m], shape ``(n_corners, 2)``; empty for none.
        corners: Corners of its bounding rectangle [m], as in ``ImageView``; None for an empty footprint.
        ghost: The outline for its trail, or None.
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
        solid: Whether its closed chains bound an area.
        heading: Corners of the mark of its heading [m], shape ``(n_corners, 2)``; empty for none.
        anchor: Position of its label [m].
        style: Its style.
        form: Its footprint in the body frame.
        pose: Pose of the body [m, m, rad].
        turn: Direction of the mark of the heading, relative to the heading [rad].
        image: Image that replaces the footprint, or None.
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
    """The goals of a body.

    Attributes:
        x: x of the next goal [m].
        y: y of the next goal [m].
        heading: The heading required for arrival [rad]; NaN for any.
        tolerance: Distance at which the goal counts as reached [m].
        later: The goals after it [m], shape ``(n, 2)``.
        arrived: Whether the body has arrived.
        name: Name of the body.
        style: Style of the body.
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
    """A scan of a range sensor.

    Attributes:
        origin: Position of the sensor [m], shape ``(2,)``.
        ends: Ends of the beams [m], shape ``(n_beams, 2)``.
        hits: Which beams hit something, shape ``(n_beams,)``.
        valid: Which beams hit something beyond the minimum range, shape ``(n_beams,)``.
        speeds: Radial velocities [m/s], positive away from the sensor, shape ``(n_beams,)``; zeros if not measured.
        surrounds: Whether the beams cover a full turn.
        style: Its style.
        body: Id of the body that carries the sensor.
        heading: Heading of the sensor [rad].
        angles: Directions of the beams relative to the heading [rad], shape ``(n_beams,)``.
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
    """The path of a body.

    Attributes:
        points: Its positions up to the present one [m], shape ``(n, 2)``.
        style: Style of the body.
    """

    points: Floats
    style: BodyStyle


@dataclass(frozen=True, eq=False)
class FieldView:
    """The field of view of a body.

    Attributes:
        x: x of its apex [m].
        y: y of its apex [m].
        heading: Direction of its middle [rad].
        span: Its width [rad].
        radius: Its depth [m].
        style: Style of the body.
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
        x: x of its middle [m].
        y: y of its lower edge [m].
        text: The words.
        style: Style of its body.
        under: y of an alternative upper edge [m], or None.
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
        occupied: Occupied cells, shape ``(n_columns, n_rows)``, from the lower left corner.
        colour: Colour of occupied cells.
        alpha: Opacity of occupied cells.
    """

    extent: tuple[float, float, float, float]
    occupied: Flags
    colour: str
    alpha: float


@dataclass(frozen=True, eq=False)
class FogView:
    """The fog over unseen cells, which lies above the map and fixed bodies and below everything else.

    Attributes:
        extent: Its rectangle [m]: x_min, y_min, x_max, y_max.
        covered: Covered cells, shape ``(n_columns, n_rows)``, from the lower left corner.
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
        world: Index of the world.
        bounds: Rectangle of the world [m]: x_min, y_min, x_max, y_max, shape ``(4,)``.
        title: Heading of the picture.
        time: Elapsed time [s].
        status: Status of the episode, e.g. ``"running"``.
        fixed: Bodies that never move. The same object until one of them changes.
        moving: The other bodies, in drawing order.
        struck: Bodies of both that take part in a robot's collision.
        goals: Visible goals.
        scans: Visible scans.
        trails: Visible paths.
        ghosts: Outlines in trails.
        fields: Visible fields of view.
        labels: Texts beside bodies and goals.
        map: The occupancy map, or None. The same object until it changes.
        center: Point in the middle of the picture [m], or None.
        fog: The fog, or None. The same object until it changes.
        overlay: Marks over the world. The same object until they change.
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
