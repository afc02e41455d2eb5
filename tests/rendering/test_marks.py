"""Marks over a world: what they look like in pixels, what covers what, and that figures show them as frames do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pixels import WAYS, of_world
from test_agreement import LEAST, similarity

import irsim_gym
from irsim_gym.base.arraytypes import Bytes
from irsim_gym.live.drawing.drawing import Drawing
from irsim_gym.live.world import World
from irsim_gym.rendering import Renderer

ROOM: dict[str, Any] = {
    "world": {"height": 10, "width": 10},
    "robot": [{"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.5}, "state": [5, 5, 0]}],
    "obstacle": [{"shape": {"name": "rectangle", "length": 2, "width": 2}, "state": [2, 2, 0], "color": "#0000ff"}],
}
RED, BLUE, WHITE, GREEN = (255, 0, 0), (0, 0, 255), (255, 255, 255), (0, 158, 115)
TALL = 300.0


def room(**plot: Any) -> World:
    """Return a world of 10 x 10 m whose colours are flat."""
    return irsim_gym.load({**ROOM, "world": {**ROOM["world"], "plot": plot}})


def colour(here: World, frame: Bytes, x: float, y: float) -> tuple[int, int, int]:
    """Return the colour at a point of the world [m]."""
    column, row = here._camera.seen().column_row(x, y)
    red, green, blue = frame[int(row), int(column)].tolist()
    return red, green, blue


def shows(drawn: tuple[int, int, int], wanted: tuple[int, int, int]) -> bool:
    return bool(np.abs(np.subtract(drawn, wanted)).max() <= 2)


@pytest.fixture(params=WAYS)
def how(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_places_and_colours(how: str) -> None:
    here = room()
    here.draw.path([[1, 7.5], [3.5, 7.5]], color="red", width=6)
    here.draw.points([[7, 7], [8, 7]], color=["red", "#0000ff"], size=12)
    here.draw.points([[6, 7]], color="red", size=12, marker="s")
    here.draw.polygon([[7, 1], [9, 1], [9, 3], [7, 3]], color="#0000ff", fill="red", width=6)
    here.draw.arrows([[6, 9]], [[3, 0]], color="red", width=0.3)
    frame = of_world(here, how)
    seen = {
        (2.5, 7.5): RED, (2.5, 7.7): WHITE, (3.7, 7.5): WHITE,
        (7.0, 7.0): RED, (8.0, 7.0): BLUE, (7.16, 7.16): WHITE, (6.1, 7.1): RED,
        (8.0, 2.0): RED, (7.0, 2.1): BLUE, (8.1, 1.0): BLUE, (6.85, 2.1): WHITE,
        (6.5, 9.0): RED, (8.4, 9.2): WHITE, (7.75, 9.2): RED, (8.85, 9.0): RED, (9.15, 9.1): WHITE,
    }  # fmt: skip
    found = {place: colour(here, frame, *place) for place in seen}
    assert {place: drawn for place, drawn in found.items() if not shows(drawn, seen[place])} == {}


def test_a_line_is_as_wide_as_it_says(how: str) -> None:
    """A point is 100 / 72 pixels in a frame of 600 x 600."""
    here = room()
    here.draw.path([[4, 8], [8, 8]], color="black", width=7.2)
    frame = of_world(here, how)
    column, row = (int(value) for value in here._camera.seen().column_row(6.3, 8))
    dark = 1.0 - frame[row - 12 : row + 12, column].mean(axis=1) / 255.0
    assert dark.sum() == pytest.approx(10.0, abs=0.1)


def test_dashes_and_opacity(how: str) -> None:
    here = room()
    here.draw.path([[1, 8], [9, 8]], "r--", width=4)
    here.draw.path([[1, 7], [9, 7]], "r", width=6, alpha=0.4)
    here.draw.polygon([[7, 1], [9, 1], [9, 3]], color=None, fill="#ff000066")
    frame = of_world(here, how)
    column, row = (int(value) for value in here._camera.seen().column_row(1, 8))
    end = int(here._camera.seen().column_row(9, 8)[0])
    share = (frame[row, column:end, 1] < 128).mean()
    assert share == pytest.approx(3.7 / (3.7 + 1.6), abs=0.04)
    pale = (255, 153, 153)  # 255 * 0.6
    assert shows(colour(here, frame, 5.3, 7.0), pale)
    assert shows(colour(here, frame, 8.7, 1.5), pale)


@pytest.mark.parametrize(("layer", "over_wall", "over_robot"), [(0.5, False, False), (1, True, False), (4, True, True)])
def test_layers(layer: float, over_wall: bool, over_robot: bool) -> None:
    """Obstacles are in layer 1, robots in 3, as in IR-SIM; in one layer marks cover what was there."""
    here = room()
    before = here.render()  # the ground is drawn before there is a mark below it
    here.draw.polygon([[0, 0], [10, 0], [10, 10], [0, 10]], color=None, fill="red", layer=layer, once=True)
    frame = here.render()
    assert shows(colour(here, frame, 8, 8), RED)
    assert shows(colour(here, frame, 2.0, 2.5), RED if over_wall else BLUE)
    assert shows(colour(here, frame, 4.75, 5.3), RED if over_robot else GREEN)
    assert np.array_equal(here.render(), before)


def test_marks_of_one_layer_cover_each_other_in_their_order(how: str) -> None:
    here = room()
    for color in ("red", "#0000ff"):
        here.draw.points([[8, 8]], color=color, size=30)
    here.draw.points([[8, 2]], color="red", size=30, layer=1.5)
    here.draw.points([[8, 2]], color="#0000ff", size=30)
    frame = of_world(here, how)
    assert shows(colour(here, frame, 8, 8), BLUE)
    assert shows(colour(here, frame, 8, 2), RED)


def test_nothing_is_drawn_beyond_the_world() -> None:
    here = room()
    before = here.render()
    here.draw.points([[0, 5], [10, 5], [5, 0], [5, 10], [-3, 4], [1e9, 4]], color="red", size=TALL / 4)
    here.draw.path([[-50, -40], [60, 70]], width=9)
    frame = here.render()
    left, top = (int(value) for value in here._camera.seen().column_row(0, 10))
    right, foot = (int(value) for value in here._camera.seen().column_row(10, 0))
    outside = np.ones(frame.shape[:2], np.bool_)
    outside[top - 1 : foot + 2, left - 1 : right + 2] = False
    assert np.array_equal(frame[outside], before[outside])
    assert not np.array_equal(frame, before)


def ink(frame: Bytes, box: Sequence[int]) -> tuple[float, float]:
    """Return the first and the last column with dark pixels in a box: left, top, right, foot."""
    left, top, right, foot = box
    columns = np.flatnonzero((frame[top:foot, left:right].mean(axis=2) < 128).any(axis=0))
    return float(left + columns[0]), float(left + columns[-1] + 1)


def test_texts_stand_where_they_are_told(how: str) -> None:
    here = room()
    for row, align in ((8.0, "left"), (7.0, "center"), (6.0, "right")):
        here.draw.text(7, row, "HIH", size=12, align=align, color="black")
    frame, layout = of_world(here, how), here._camera.seen()
    for row, share in ((8.0, 0.0), (7.0, 0.5), (6.0, 1.0)):
        middle, line = (int(value) for value in layout.column_row(7, row))
        first, last = ink(frame, (middle - 80, line - 12, middle + 80, line + 12))
        assert last - first == pytest.approx(27.0, abs=1.5)  # 1.8 em, without the room beside its letters
        assert first + share * (last - first) == pytest.approx(middle, abs=2.5)
        rows = np.flatnonzero((frame[line - 14 : line + 14, middle - 60 : middle + 60].mean(axis=2) < 128).any(axis=1))
        assert rows.mean() - 14 == pytest.approx(0.0, abs=2.5)


def test_a_text_whose_place_is_not_shown_is_not_seen() -> None:
    here = room()
    here.draw.text(12, 5, "far away", align="right")
    before = room().render()
    assert np.array_equal(here.render(), before)


def test_texts_that_change_leave_nothing_behind() -> None:
    """A text with a number in it is another one in each picture."""
    here = room(figure_pixels=[120, 120])
    for k in range(600):
        here.draw.text(5, 8, f"{0.1 * k:.1f} s", once=True)
        here.draw.title(f"step {k}")
        here.render()
    painter = here._camera._ready()._painter
    for masks in (painter.marks._masks, painter._masks):
        assert len(masks.rows) <= 258
        assert masks.levels.nbytes < 1 << 20


def test_a_title_takes_the_place_of_name_and_time() -> None:
    here, titled = room(), room(title="by hand")
    plain = here.render()
    here.set_title("by hand")
    assert np.array_equal(here.render(), titled.render())
    here.set_title(None)
    assert np.array_equal(here.render(), plain)


def test_what_is_not_drawn_changes_no_pixel() -> None:
    here, other = room(), room()
    here.draw.points([[1, 1]], once=True)
    here.draw.path([])
    here.render()
    for _ in range(3):
        here.step([0.5, 0.2])
        other.step([0.5, 0.2])
        assert np.array_equal(here.render(), other.render())


def everything(draw: Drawing) -> None:
    """Draw one of all there is."""
    places = np.array([[1.0, 9.0], [2.0, 8.3], [3.0, 9.1], [4.0, 8.2], [5.0, 9.3], [6.0, 8.6]])
    for k, style in enumerate(("r-", "g--", "C1-.", "k:")):
        draw.path(places - [0.0, 0.35 * k], style, width=1.0 + 0.7 * k)
    for k, marker in enumerate("o.s^v<>Ddph*|_+x"):
        draw.points([[0.6 + 0.58 * k, 5.7]], marker=marker, size=9, color=f"C{k % 10}", alpha=0.8)
    draw.polygon([[6, 1], [9, 1.5], [8, 4], [6.5, 3.3]], fill="orange", alpha=0.6)
    draw.polygon([[6.4, 6.2], [9, 6.5], [6.4, 7.4], [9, 7.3]], fill="C4", color="k", style=":")  # crosses itself
    draw.arrows([[1, 4.2], [2, 4.2], [3, 4.2]], [[0.8, 0.3], [0.1, 0.9], [0.0, -0.2]], color="purple")
    draw.text(3, 0.5, "a robot's plan", size=11)


def test_figures_show_them_as_frames_do() -> None:
    here = room()
    everything(here.draw)
    frame, figure = (of_world(here, how) for how in WAYS)
    assert similarity(frame, figure) > LEAST
    assert np.abs(figure.astype(int) - frame).mean() < 0.6
    assert similarity(frame, room().render()) < 0.95  # there is something to compare


@pytest.mark.parametrize("limits", [(4.0, 4.0, 9.0, 9.0), (-20.0, -20.0, 30.0, 30.0)])
def test_they_are_where_they_were_in_another_part_of_the_world(limits: tuple[float, float, float, float]) -> None:
    here = room()
    everything(here.draw)
    here._camera.show_part(limits)
    assert similarity(*(of_world(here, how) for how in WAYS)) > LEAST


def test_they_follow_a_viewpoint() -> None:
    here = room(viewpoint="robot_0")
    everything(here.draw)
    here.step([1.0, 0.5])
    frames = [of_world(here, how) for how in WAYS]
    for frame in frames:
        assert shows(colour(here, frame, 7.5, 2.0), (255, 201, 102))  # orange, 0.6 of it
    assert similarity(*frames) > LEAST


def test_figures_hold_them_as_vectors(tmp_path: Path) -> None:
    here = room()
    here.draw.path([[1, 1], [2, 2], [3, 1]], color="#12ab34", once=True)
    here.draw.points([[7, 7], [8, 7]], color="#56cd78")
    here.draw.text(5, 8, "a robot's plan")
    figure = here.save_figure(tmp_path / "one.svg").read_text()
    assert ("#12ab34" in figure, "#56cd78" in figure, "a robot's plan" in figure) == (True,) * 3
    assert here.save_figure(tmp_path / "one.pdf").read_bytes().startswith(b"%PDF")


def test_one_renderer_draws_other_marks_over_other_worlds() -> None:
    from irsim_gym.scenario import load_scenario
    from irsim_gym.simulator.engine import compile

    simulation = compile(load_scenario(ROOM), 3)
    simulation.reset(seed=0)
    drawing = Drawing()
    drawing.polygon([[6, 6], [9, 6], [9, 9]], fill="red")
    renderer = Renderer(simulation.scenario, simulation.model, simulation.state, simulation.sensors)
    plain = renderer.frame(0)
    renderer.lay_over(drawing.overlay(), world=1)
    first, second, third = renderer.frames([0, 1, 2])
    assert np.array_equal(first, plain)
    assert np.array_equal(third, plain)
    assert (second != plain).any(axis=2).sum() > 2000
    renderer.lay_over(replace(drawing.overlay(), marks=()), world=1)
    assert np.array_equal(renderer.frame(1), plain)
