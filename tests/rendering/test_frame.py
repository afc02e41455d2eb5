"""The line above the world, what happens at its border, bands and labels."""

from __future__ import annotations

import numpy as np
import pytest
from hand_made import Body, World, box, disc, make_world

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.scenario.specs.plot_spec import ObjectPlot, WorldPlot

LONG = "What was learned from a long experiment, " * 8
PLAIN = ObjectPlot(show_arrow=False)


def ink(frame: Bytes, until: int) -> list[tuple[int, int]]:
    """Return first and last column of each text in the rows above ``until``, where gaps are wider than 10 pixels."""
    paper = frame[2, 2].astype(int)
    columns = np.flatnonzero((np.abs(frame[:until].astype(int) - paper).max(axis=2) > 40).any(axis=0))
    breaks = np.flatnonzero(np.diff(columns) > 10)
    starts, ends = np.concatenate([[0], breaks + 1]), np.concatenate([breaks, [len(columns) - 1]])
    return [(int(columns[a]), int(columns[b])) for a, b in zip(starts, ends, strict=True)] if len(columns) else []


def head(size: tuple[int, int], title: str | None, name: str = "hand_made") -> list[tuple[int, int]]:
    world = make_world([Body(disc(1.0), (5.0, 5.0, 0.0))], lidar=False, plot=WorldPlot(figure_pixels=size, title=title))
    world.scenario.name = name
    renderer = world.renderer()
    return ink(renderer.frame(), renderer.layout.height - renderer.layout.bottom - renderer.layout.plot_height - 6)


@pytest.mark.parametrize("size", [(1200, 400), (600, 600), (200, 500)])
def test_a_long_title_stays_in_the_picture(size: tuple[int, int]) -> None:
    texts = head(size, LONG)
    assert len(texts) == 1
    assert texts[0][0] > 2
    assert texts[0][1] < size[0] - 2
    assert texts[0][1] - texts[0][0] > 0.8 * size[0]


def test_a_title_stands_alone_in_the_middle() -> None:
    ((first, last),) = head((1200, 400), "Custom")
    assert (first + last) / 2 == pytest.approx(605, abs=8)
    assert head((1200, 400), "") == []


@pytest.mark.parametrize("size", [(1200, 400), (600, 600), (400, 900)])
@pytest.mark.parametrize("name", ["short", "a_name_of_a_world_that_goes_on_for_ever_and_ever"])
def test_name_status_and_time_do_not_overlap(size: tuple[int, int], name: str) -> None:
    texts = head(size, None, name)
    assert len(texts) == 3, "name, status, time"
    assert texts[0][0] > 2
    assert texts[-1][1] < size[0] - 2


def test_what_reaches_beyond_the_world_is_cut_there() -> None:
    bodies = [Body(disc(1.0), (0.0, 5.0, 0.0)), Body(box(2.0, 2.0), (5.0, 10.0, 0.0), movable=True, plot=PLAIN)]
    for viewpoint, beyond in ((None, False), ((5.0, 5.0), True)):
        world = make_world(bodies, lidar=False, plot=WorldPlot(viewpoint=viewpoint))
        renderer = world.renderer()
        frame, layout = renderer.frame(), renderer.layout
        for x, y, inwards in ((0.0, 5.0, (1, 0)), (5.0, 10.0, (0, 1))):
            column, row = (int(value) for value in layout.column_row(x, y))
            outside = frame[row - 5 * inwards[1], column - 5 * inwards[0]]
            inside = frame[row + 5 * inwards[1], column + 5 * inwards[0]]
            assert (outside.max() < 200) == beyond
            assert inside.max() < 200


def test_beams_end_at_the_border() -> None:
    world = make_world([Body(disc(0.3), (0.5, 5.0, 0.0), robot=True, movable=True)])
    renderer = world.renderer()
    frame, layout = renderer.frame(), renderer.layout
    column = int(layout.column_row(0.0, 5.0)[0])
    left = frame[
        layout.height - layout.bottom - layout.plot_height : layout.height - layout.bottom, column - 5 : column - 3
    ]
    assert left.std(axis=0).max() < 1.0  # matplotlib 3.8 puts a faint pixel of a tick's label here


def driven(points: list[tuple[float, float]], **plot: object) -> World:
    shown = ObjectPlot(show_trajectory=True, traj_color="#FF0000", show_arrow=False, obj_alpha=0.0, **plot)
    return make_world([Body(disc(0.1), (*points[0], 0.0), robot=True, movable=True, plot=shown)], lidar=False)


def test_a_path_with_a_width_is_one_band() -> None:
    """Half clear red over white, the same along the way, round the bend and where the path crosses itself."""
    turns = np.linspace(0.0, 2.5 * np.pi, 200)
    points = [(5.0 + 2.0 * np.sin(2.0 * t), 5.0 + 2.0 * np.sin(t)) for t in turns]
    world = driven(points, traj_width=0.6)
    renderer = world.renderer()
    for x, y in points:
        world.move(0, x, y)
        world.step()
        renderer.trails.record(np.zeros(1, np.int64), world.state.step, world.state.pose)
    frame = renderer.frame()
    for k in (3, 40, 80, 120, 160, 195):
        column, row = renderer.layout.column_row(*points[k])
        assert frame[int(row), int(column)].tolist() == pytest.approx([255, 128, 128], abs=1)
    across = [renderer.layout.column_row(5.0, 7.0 + dy) for dy in (-0.25, 0.25)]
    assert all(frame[int(row), int(column)].tolist() == pytest.approx([255, 128, 128], abs=1) for column, row in across)


@pytest.mark.parametrize(("goal", "moved"), [((5.0, 5.0), True), ((8.0, 8.0), False)])
def test_a_label_gives_way_to_a_flag(goal: tuple[float, float], moved: bool) -> None:
    plot = ObjectPlot(show_text=True, show_goal=True, text_color="#FF00FF", show_arrow=False)
    robot = Body(disc(0.2), (5.0, 5.0, 0.0), robot=True, movable=True, goal=goal, plot=plot)
    renderer = make_world([robot], lidar=False).renderer()
    frame = renderer.frame().astype(int)
    rows = np.flatnonzero(((frame[..., 0] > 180) & (frame[..., 1] < 120) & (frame[..., 2] > 180)).any(axis=1))
    below = renderer.layout.column_row(5.0, 5.0)[1]
    assert len(rows) > 3
    assert (rows.min() > below) if moved else (rows.max() < below)
