"""Each drawing option changes what it says: layers, fields of view, trail shapes, viewpoint, margins, map, marks."""

from __future__ import annotations

import numpy as np
import pytest
from hand_made import Body, World, box, disc, make_world, wall

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.rendering import Renderer
from irsim_gym.rendering.looks.styles import scan_style
from irsim_gym.rendering.scene.frame_layout import lay_out
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.specs.plot_spec import ObjectPlot, WorldPlot
from irsim_gym.simulator.world.model import ACKERMANN
from irsim_gym.simulator.world.outline import Outline

ROBOT = (0x00, 0x9E, 0x73)
OBSTACLE = (0x47, 0x55, 0x69)
CARD = (255, 255, 255)
PLAIN = {"show_arrow": False, "show_goal": False, "show_trajectory": False, "show_sensor": False}


def colour_at(renderer: Renderer, frame: Bytes, x: float, y: float) -> tuple[int, ...]:
    column, row = renderer.layout.column_row(x, y)
    return tuple(int(level) for level in frame[int(row), int(column)])


def one_robot(radius: float = 1.0, world: WorldPlot | None = None, fov: float | None = None, **plot: object) -> World:
    """A robot in the middle, its goal where it stands, and a large obstacle on its right."""
    robot = Body(
        disc(radius),
        (5.0, 5.0, 0.0),
        robot=True,
        movable=True,
        goal=(5.0, 5.0),
        color="#009E73",
        plot=ObjectPlot(**{**PLAIN, **plot}),
        fov=fov,
        fov_radius=2.5,
    )
    return make_world([robot, Body(box(2.0, 2.0), (7.5, 5.0, 0.0))], lidar=False, plot=world)


def centre(world: World) -> tuple[int, ...]:
    renderer = world.renderer()
    return colour_at(renderer, renderer.frame(), 5.1, 5.0)


def test_the_goal_lies_under_its_robot_unless_its_layer_is_higher() -> None:
    assert centre(one_robot(show_goal=True, goal_color="red")) == ROBOT
    assert centre(one_robot(show_goal=True, goal_color="red", goal_zorder=2)) == ROBOT
    red, green, _ = centre(one_robot(show_goal=True, goal_color="red", goal_zorder=4))
    assert red > ROBOT[0]
    assert green < ROBOT[1]


@pytest.mark.parametrize(("layer", "covers"), [(0, False), (1, False), (5, True)])
def test_the_path_lies_under_its_robot_unless_its_layer_is_higher(layer: int, covers: bool) -> None:
    world = one_robot(show_trajectory=True, traj_color="red", traj_alpha=1.0, traj_width=0.3, traj_zorder=layer)
    renderer = world.renderer()
    for x in np.linspace(4.0, 5.0, 20):
        world.move(0, x, 5.0)
        world.step()
        frame = renderer.frame()
    assert (colour_at(renderer, frame, 4.8, 5.0) != ROBOT) == covers


@pytest.mark.parametrize(("layer", "covers"), [(0, False), (5, True)])
def test_the_trail_lies_under_its_robot_unless_its_layer_is_higher(layer: int, covers: bool) -> None:
    trail = {"show_trail": True, "trail_freq": 1, "trail_fill": True, "trail_color": "#FF0000", "trail_alpha": 1.0}
    assert (centre(one_robot(trail_zorder=layer, **trail)) == (255, 0, 0)) == covers


def test_the_mark_of_the_heading_has_its_own_layer() -> None:
    assert centre(one_robot(show_arrow=True)) != ROBOT
    assert centre(one_robot(show_arrow=True, arrow_zorder=2)) == ROBOT
    assert centre(one_robot(show_arrow=True, arrow_zorder=9)) != ROBOT
    far = one_robot(show_arrow=True, arrow_length=3.5, arrow_width=2.0, arrow_color="#FF0000", arrow_zorder=4)
    renderer = far.renderer()
    assert colour_at(renderer, renderer.frame(), 7.5, 5.0) != OBSTACLE, "it reaches over the obstacle"
    far = one_robot(show_arrow=True, arrow_length=3.5, arrow_width=2.0, arrow_color="#FF0000", arrow_zorder=0)
    renderer = far.renderer()
    assert colour_at(renderer, renderer.frame(), 7.5, 5.0) == OBSTACLE, "below layer 1 it lies under obstacles"


def test_the_text_lies_on_top_unless_its_layer_is_lower() -> None:
    def dark_pixels(layer: int | None) -> int:
        world = one_robot(
            2.0, show_text=True, text_position=(0.0, -0.3), text_size=30, text_color="red", text_zorder=layer
        )
        frame = world.renderer().frame().astype(int)
        return int(((frame[..., 0] > 200) & (frame[..., 1] < 60)).sum())

    assert dark_pixels(None) > 100
    assert dark_pixels(7) == dark_pixels(None)
    assert dark_pixels(2) == 0, "a robot's layer is 3"


def test_a_fixed_body_of_a_higher_layer_covers_robots() -> None:
    robot = Body(disc(1.0), (5.0, 5.0, 0.0), robot=True, movable=True, color="#009E73", plot=ObjectPlot(**PLAIN))
    for layer, expected in ((None, ROBOT), (1, ROBOT), (4, OBSTACLE)):
        block = Body(box(1.0, 1.0), (5.0, 5.0, 0.0), plot=ObjectPlot(obj_zorder=layer))
        assert centre(make_world([robot, block], lidar=False)) == expected


def test_the_field_of_view_is_a_sector() -> None:
    world = one_robot(0.2, fov=np.pi / 2, show_fov=True, fov_color="#00FF00", fov_alpha=0.8, fov_edge_color="red")
    renderer = world.renderer()
    frame = renderer.frame()
    inside = colour_at(renderer, frame, 6.2, 5.0)
    assert inside == (51, 255, 51)
    assert colour_at(renderer, frame, 6.2, 5.7) == inside
    assert colour_at(renderer, frame, 5.0, 6.2) == CARD, "90 degrees aside is outside"
    assert colour_at(renderer, frame, 3.8, 5.0) == CARD, "behind is outside"
    edge = frame[int(renderer.layout.column_row(5.0, 6.0)[1]), int(renderer.layout.column_row(6.0, 5.0)[0])]
    assert edge[0] > 150 > edge[1], "the edge at 45 degrees"
    world.move(0, 5.0, 5.0, np.pi)
    frame = renderer.frame()
    assert colour_at(renderer, frame, 3.8, 5.0) == inside
    assert colour_at(renderer, frame, 6.2, 5.0) == CARD


def test_a_field_of_view_all_around_is_a_disc() -> None:
    world = one_robot(0.2, fov=2.0 * np.pi, show_fov=True)
    renderer = world.renderer()
    frame = renderer.frame()
    assert colour_at(renderer, frame, 3.0, 5.0) == colour_at(renderer, frame, 5.0, 6.8) != CARD
    assert colour_at(renderer, frame, 2.3, 5.0) == CARD, "beyond its radius of 2.5 m"
    assert colour_at(renderer, frame, 7.2, 5.0) != OBSTACLE, "it lies over fixed bodies"
    assert centre(one_robot(0.2, fov=None, show_fov=True)) == ROBOT, "without a width nothing is drawn"


def test_the_field_of_view_has_its_own_layer() -> None:
    shown = {"show_fov": True, "fov_color": "#00FF00", "fov_alpha": 0.8}
    assert centre(one_robot(fov=2.0, **shown)) == ROBOT
    assert centre(one_robot(fov=2.0, fov_zorder=5, **shown)) != ROBOT
    world = one_robot(fov=2.0, fov_zorder=0, **shown)
    renderer = world.renderer()
    assert colour_at(renderer, renderer.frame(), 7.2, 5.0) == OBSTACLE


@pytest.mark.parametrize(
    ("shape", "corner", "side"), [(None, CARD, CARD), ("rectangle", (255, 0, 0), CARD), ("circle", CARD, (255, 0, 0))]
)
def test_trails_may_have_another_shape(shape: str | None, corner: tuple[int, ...], side: tuple[int, ...]) -> None:
    """A diamond of half diagonals 2 and 1, turned by 90 degrees: its box has corners, its circle goes beyond."""
    diamond = np.array([[2.0, 0.0, 0.0, 1.0], [0.0, 1.0, -2.0, 0.0], [-2.0, 0.0, 0.0, -1.0], [0.0, -1.0, 2.0, 0.0]])
    outline = box(1.0, 1.0)
    outline.segments[:] = diamond
    shown = ObjectPlot(
        **PLAIN, show_trail=True, trail_type=shape, trail_fill=True, trail_color="#FF0000", trail_alpha=1.0, obj_alpha=0
    )
    world = make_world([Body(outline, (5.0, 5.0, np.pi / 2), robot=True, movable=True, plot=shown)], lidar=False)
    renderer = world.renderer()
    frame = renderer.frame()
    assert colour_at(renderer, frame, 5.0, 5.0) == (255, 0, 0)
    assert colour_at(renderer, frame, 5.9, 6.9) == corner
    assert colour_at(renderer, frame, 6.7, 5.0) == side


def test_a_body_stays_in_the_middle() -> None:
    world = one_robot(0.4, WorldPlot(viewpoint="robot_0"))
    renderer = world.renderer()
    frame = renderer.frame()
    layout = renderer.layout
    row = layout.height - layout.bottom - layout.plot_height // 2
    column = layout.left + layout.plot_width // 2 + 3
    assert tuple(frame[row, column]) == ROBOT
    for x, y in ((4.0, 7.0), (8.0, 2.0), (40.0, 40.0)):
        world.move(0, x, y)
        frame = renderer.frame()
        assert tuple(frame[row, column]) == ROBOT
        obstacle = column + (7.5 - x) * layout.scale, row - (5.0 - y) * layout.scale
        if x < 10.0:
            assert tuple(frame[int(obstacle[1]), int(obstacle[0])]) == OBSTACLE, (
                "what stands still moves in the picture"
            )


def test_a_point_stays_in_the_middle() -> None:
    world = one_robot(0.4, WorldPlot(viewpoint=(7.5, 5.0)))
    renderer = world.renderer()
    frame, layout = renderer.frame(), renderer.layout
    row, column = layout.height - layout.bottom - layout.plot_height // 2, layout.left + layout.plot_width // 2
    assert tuple(frame[row, column]) == OBSTACLE
    assert tuple(frame[row, column - int(2.5 * layout.scale)]) == ROBOT


def test_a_loose_layout_has_wider_margins() -> None:
    tight, loose = (make_world([], lidar=False, plot=WorldPlot(tight=tight)).renderer() for tight in (True, False))
    assert loose.layout.left > tight.layout.left
    assert loose.layout.bottom > tight.layout.bottom
    size = lay_out(np.array([0.0, 0.0, 10.0, 10.0]), (800, 600), tight=False)
    assert (size.width, size.height) == (800, 600)
    assert size.left >= 0.125 * 800
    assert size.bottom >= 0.11 * 600
    assert loose.frame().shape == (loose.layout.height, loose.layout.width, 3)


def test_the_map_stands_where_its_cells_are() -> None:
    """Five columns by four rows of 0.5 m x 1 m from (2, 3); cells (0, 0) and (4, 1) are occupied."""
    world = make_world([], lidar=False)
    world.model.map_frame[:] = 2.0, 3.0, 0.5, 1.0, 0
    world.model.map_squares = np.ones((1, 4, 5, 4), np.uint8)
    world.model.map_squares[:, :, 0, 0] = world.model.map_squares[:, :, 4, 1] = 0
    renderer = world.renderer()
    frame = renderer.frame()
    for x in np.arange(2.02, 4.5, 0.05):
        for y in np.arange(3.03, 7.0, 0.1):
            is_occupied = (int((x - 2.0) / 0.5), int(y - 3.0)) in {(0, 0), (4, 1)}
            near_edge = min((x - 2.0) % 0.5, (y - 3.0) % 1.0) < 0.03 or max((x - 2.0) % 0.5, (y - 3.5) % 0.5) > 0.47
            if not near_edge:
                assert (colour_at(renderer, frame, x, y) == CARD) == (not is_occupied), (x, y)
    assert colour_at(renderer, frame, 1.9, 3.5) == CARD


def test_fine_maps_lose_no_walls() -> None:
    """A wall of one cell among 2,000 in a row is thinner than a pixel and still seen."""
    world = make_world([], lidar=False)
    world.model.map_frame[:] = 0.0, 0.0, 0.005, 10.0, 0
    world.model.map_squares = np.ones((1, 4, 2000, 1), np.uint8)
    world.model.map_squares[:, :, 1001] = 0
    renderer = world.renderer(size=(200, 200))
    frame = renderer.frame()
    row = int(renderer.layout.column_row(5.0, 5.3)[1])
    columns = [int(renderer.layout.column_row(x, 5.3)[0]) for x in (4.9, 5.1)]
    assert frame[row, columns[0] : columns[1] + 1].min() < 253


def test_cars_have_a_windscreen() -> None:
    plot = ObjectPlot(**{**PLAIN, "show_arrow": True})
    car = Body(box(4.0, 2.0), (5.0, 5.0, 0.0), robot=True, movable=True, color="#009E73", plot=plot)
    world = make_world([car], lidar=False)
    world.model.drive[0] = ACKERMANN
    renderer = world.renderer()
    frame = renderer.frame()
    assert colour_at(renderer, frame, 5.6, 5.0) != ROBOT, "in front of the middle"
    for x in (3.5, 5.0, 6.5):
        assert colour_at(renderer, frame, x, 5.0) == ROBOT


def test_arrows_of_thin_bodies() -> None:
    line = Body(wall((4.0, 5.0), (6.0, 5.0)), movable=True, plot=ObjectPlot(show_arrow=True))
    assert len(make_world([line], lidar=False).renderer().scene().moving[0].heading) == 4


def test_parts_of_one_body_have_no_edges_within() -> None:
    outline = Outline(segments=box(4.0, 1.0).segments, discs=np.array([[2.0, 0.0, 1.0]]))
    world = make_world([Body(outline, (5.0, 5.0, 0.0), plot=ObjectPlot(obj_linewidth=4))], lidar=False)
    renderer = world.renderer()
    frame = renderer.frame()
    for x, y in ((6.0, 5.0), (7.0, 5.0), (7.0, 5.2)):
        assert colour_at(renderer, frame, x, y) == OBSTACLE, "where an edge of one part lies in the other"
    assert colour_at(renderer, frame, 4.0, 5.5) not in (OBSTACLE, CARD), "the edge around both"


@pytest.mark.parametrize("kind", ["lidar2d", "fmcw_lidar2d"])
def test_a_sensors_plot_wins_over_its_own_keys(kind: str) -> None:
    options = [{"color": "red", "alpha": 0.5}, {"color": "red", "plot": {"color": "blue", "alpha": 0.7}}]
    robot = {"kinematics": {"name": "diff"}, "sensors": [{"name": kind, **one} for one in options]}
    styles = [scan_style(sensor) for sensor in load_scenario({"robot": robot}).bodies[0].sensors]
    assert [(style.colour, style.alpha) for style in styles] == [("red", 0.5), ("blue", 0.7)]
