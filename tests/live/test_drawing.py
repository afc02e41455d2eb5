"""What is drawn over a world by hand: shapes and looks that are taken, and how long a mark stays."""

from __future__ import annotations

import contextlib
import io
import logging
import warnings
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml
from matplotlib.colors import to_hex
from small_world import SCENARIO, world

import irsim_gym
from irsim_gym.live.drawing import looks
from irsim_gym.live.drawing.drawing import Drawing
from irsim_gym.simulator.readings.marks import LineMark, PointsMark, TextMark

COLUMNS = [np.array([[1.0], [2.0], [0.5]]), np.array([[3.0], [4.0], [0.5]]), np.array([[5.0], [5.0], [0.5]])]
PLACES = [[1.0, 2.0], [3.0, 4.0], [5.0, 5.0]]


def marks(drawing: Drawing) -> tuple[Any, ...]:
    return drawing.overlay().marks


@pytest.mark.parametrize(
    "points",
    [
        PLACES,
        np.array(PLACES).T,
        np.vstack([np.array(PLACES).T, [[0.1, 0.2, 0.3]]]),
        COLUMNS,
        [np.array([[1.0, 2.0]]), np.array([[3.0, 4.0]]), np.array([[5.0, 5.0]])],
        [(1, 2), (3, 4), (5, 5)],
        [np.array([1.0, 2.0, 0.0, 1.0]), [3.0, 4.0], np.array([[5.0], [5.0], [7.0]])],
    ],
    ids=["lists", "columns", "poses", "list of columns", "list of rows", "tuples", "mixed"],
)
def test_points_as_people_write_them(points: Any) -> None:
    here = world()
    here.draw_trajectory(points)
    here.draw_points(points)
    here.draw_box(points)
    assert [mark.points.tolist() for mark in marks(here.draw)] == [PLACES] * 3


def test_an_array_with_many_rows_has_a_row_for_each_point() -> None:
    here = world()
    rows = np.arange(14.0).reshape(7, 2)
    here.draw_trajectory(rows)
    here.draw.path(rows[:2])
    here.draw_trajectory(rows[:2])  # as IR-SIM reads two rows: abscissae, ordinates
    found = [mark.points.tolist() for mark in marks(here.draw)]
    assert found == [rows.tolist(), rows[:2].tolist(), rows[:2].T.tolist()]


def test_one_point_and_none() -> None:
    here = world()
    here.draw_points([2.0, 3.0])
    here.draw_points(np.array([[4.0], [5.0]]))
    for nothing in (None, [], np.zeros((2, 0)), np.zeros((0, 2))):
        here.draw_points(nothing)
    here.draw_quiver(None)
    here.draw_quivers([])
    here.draw_trajectory([])
    here.draw_trajectory([[1, 1]])  # a line needs two
    assert [mark.points.tolist() for mark in marks(here.draw)] == [[[2.0, 3.0]], [[4.0, 5.0]]]


def test_what_is_not_finite_interrupts_a_line_and_marks_no_point() -> None:
    drawing = Drawing()
    rows = [[0, 0], [1, 0], [np.nan, 1], [2, 0], [3, 0], [4, np.inf], [5, 0]]
    drawing.path(rows)
    drawing.points(rows)
    first, second, dots = marks(drawing)
    assert (first.points.tolist(), second.points.tolist()) == ([[0, 0], [1, 0]], [[2, 0], [3, 0]])
    assert dots.points.tolist() == [[0, 0], [1, 0], [2, 0], [3, 0], [5, 0]]


@pytest.mark.parametrize("points", [3.0, "ab", [[1], [2]], np.zeros((2, 3, 4)), np.zeros((5, 7)), [[1, "a"]], object()])
def test_what_is_no_point(points: Any) -> None:
    with pytest.raises(ValueError, match=r"points are rows \(x, y\) or a list of points, got"):
        world().draw_trajectory(points)


@pytest.mark.parametrize(
    ("text", "color", "style", "marker"),
    [
        ("-", None, "solid", ""),
        ("", None, "solid", ""),
        ("g--", "g", "dashed", ""),
        ("--g", "g", "dashed", ""),
        ("-.k", "k", "dashdot", ""),
        ("r", "r", "solid", ""),
        ("C1:", "C1", "dotted", ""),
        ("red", "red", "solid", ""),
        ("#12ab9f", "#12ab9f", "solid", ""),
        ("ro", "r", "", "o"),
        ("k.-", "k", "solid", "."),
        ("*", None, "", "*"),
        ("b+:", "b", "dotted", "+"),
    ],
)
def test_formats_are_those_of_matplotlib(text: str, color: str | None, style: str, marker: str) -> None:
    from matplotlib.axes._base import _process_plot_format  # an independent reading of the same words
    from matplotlib.colors import to_hex

    assert looks.parsed(text) == looks.Format(color, style, marker)
    theirs, mark, ink = _process_plot_format(text)
    assert (looks.line_style("-" if theirs is None else theirs), looks.marker(mark or "")) == (style, marker)
    assert (ink and to_hex(ink)) == (color and to_hex(color))


@pytest.mark.parametrize("text", ["rr", "g---", "q", "--:", "oo", "xyz", "r-g"])
def test_formats_that_say_nothing(text: str) -> None:
    with pytest.raises(ValueError, match="a format is a colour, a marker and a line style"):
        world().draw_trajectory(PLACES, text)


def test_looks_of_a_trajectory() -> None:
    here = world()
    here.draw_trajectory(PLACES, "r--", linewidth=3, alpha=0.4, zorder=7, label="mine")
    here.draw_trajectory(PLACES, "-", color=(0.0, 1.0, 0.0, 0.5), ls=":", marker="s", ms=4)
    line, other, squares = marks(here.draw)
    assert (line.color, line.style, line.width, line.alpha, line.layer) == ("r", "dashed", 3.0, 0.4, 7.0)
    assert (line.closed, line.fill) == (False, "")
    assert (other.color, other.style, squares.size) == ("#00ff0080", "dotted", 4.0)
    assert np.abs(squares.form[0]).max() == 0.5


@pytest.mark.parametrize(
    ("call", "error", "said"),
    [
        (lambda w: w.draw_trajectory(PLACES, color="gren"), ValueError, r"no colour named 'gren'.*green"),
        (lambda w: w.draw_trajectory(PLACES, colour="g"), TypeError, "takes no colour='g'; it takes color, c,"),
        (lambda w: w.draw_trajectory(PLACES, lw=1, linewidth=2), TypeError, "'linewidth' twice, under two names"),
        (lambda w: w.draw_trajectory(PLACES, lw=-1), ValueError, "width is a number of at least 0, got -1"),
        (lambda w: w.draw_trajectory(PLACES, alpha=2), ValueError, "alpha is a number from 0 to 1, got 2"),
        (lambda w: w.draw_trajectory(PLACES, zorder="top"), ValueError, "layer is a number, got 'top'"),
        (lambda w: w.draw_trajectory(PLACES, ls="~"), ValueError, "a line style is '-', '--'"),
        (lambda w: w.draw_trajectory(PLACES, show_direction=True), ValueError, "needs the heading of each point"),
        (lambda w: w.draw_points(PLACES, marker="8"), ValueError, "the form of a point is one of o"),
        (lambda w: w.draw_points(PLACES, s=-4), ValueError, "s is a number of at least 0"),
        (lambda w: w.draw_points(PLACES, c=["r", "g"]), ValueError, "one for each of 3 points, got 2"),
        (lambda w: w.draw_points(PLACES, c=[0.1, 0.2, 3.0]), ValueError, r"a colour is a name such as 'red'"),
        (lambda w: w.draw_points(PLACES, cmap="jet"), TypeError, "takes no cmap='jet'"),
        (lambda w: w.draw_box(PLACES[:2]), ValueError, "a polygon has at least 3 corners, got 2"),
        (lambda w: w.draw_quiver((1, 2, 3)), ValueError, r"rows \(x, y, u, v\)"),
        (lambda w: w.draw_quivers(PLACES), ValueError, r"rows \(x, y, u, v\)"),
        (lambda w: w.draw_quiver((1, 2, 1, 0), scale=3), TypeError, "takes no scale=3; it takes color"),
        (lambda w: w.set_title("a\nb"), ValueError, "one line of text"),
        (lambda w: w.draw.text(np.nan, 1, "a"), ValueError, "x is a number, got nan"),
        (lambda w: w.draw.text(1, 1, "a", size=0.01), ValueError, "size is a number from 1 to 200, got 0.01"),
        (lambda w: w.draw.text(1, 1, "a", align="top"), ValueError, "align is 'left', 'center' or 'right'"),
        (lambda w: w.draw.arrows(PLACES, [[1, 0]]), ValueError, "3 tails and 1 vectors"),
    ],
)
def test_what_is_refused_draws_nothing(call: Any, error: type[Exception], said: str) -> None:
    here = world()
    with pytest.raises(error, match=said):
        call(here)
    assert marks(here.draw) == ()


def test_colours_of_points() -> None:
    drawing = Drawing()
    drawing.points(PLACES, color=["r", "C0", "r"])
    drawing.points(PLACES, color=(0.5, 0.5, 0.5))
    drawing.points(PLACES, color="tab:blue", marker="x", size=8)
    red, blue, grey, crosses = marks(drawing)
    assert (red.color, red.points.tolist()) == ("r", [PLACES[0], PLACES[2]])
    assert (blue.color, blue.points.tolist()) == ("C0", [PLACES[1]])
    assert (grey.color, grey.form) == ("#808080", ())
    assert (crosses.color, len(crosses.form), crosses.width) == ("tab:blue", 2, 1.5)


def test_arrows_are_as_long_as_their_vectors() -> None:
    drawing = Drawing()
    drawing.arrows([[1, 1], [2, 2], [3, 3]], [[2, 0], [0, 1], [0, 0]])
    right, up = marks(drawing)
    assert right.points[:, 0].max() == 3.0
    assert right.points[3].tolist() == [3.0, 1.0]  # the tip
    assert up.points[3] == pytest.approx([2.0, 3.0])
    assert np.ptp(right.points[:, 1]) == pytest.approx(3 * 1.5 / 16)  # three times the shaft
    assert (right.closed, right.fill, right.width) == (True, "black", 0.0)
    drawing.clear()
    drawing.arrows([[1, 1], [2, 2]], [[2, 0], [0, 0.1]], length=0.5, width=0.4)
    for mark in marks(drawing):
        assert np.hypot(*(mark.points[3] - 0.5 * (mark.points[0] + mark.points[-1]))) == pytest.approx(0.5)
        assert np.hypot(*(mark.points[0] - mark.points[-1])) == pytest.approx(0.1)  # not longer than the arrow


def test_ir_sims_arrows_are_an_eighteenth_of_the_world() -> None:
    here = world()
    here.draw_quivers([[1, 1, 5, 0], np.array([[2.0], [2.0], [0.0], [0.1]])], color="g")
    dots, right, up = marks(here.draw)
    assert (dots.points.tolist(), dots.color, dots.size) == ([[1, 1], [2, 2]], "g", 7.0)
    assert right.points[3] == pytest.approx([1 + 10 / 18, 1])
    assert up.points[3] == pytest.approx([2, 2 + 10 / 18])


# How long a mark stays.


def test_a_mark_for_one_picture_is_gone_after_it() -> None:
    here = world()
    here.draw_points(PLACES)
    here.draw_trajectory(PLACES, refresh=True)
    here.draw_trajectory(PLACES)
    here.step()
    assert len(here.draw) == 3
    shown = here.render()
    assert len(here.draw) == 1
    assert not np.array_equal(here.render(), shown)
    here.draw.clear()
    assert len(here.draw) == 0


def test_pictures_in_files_show_marks_and_use_none_up(tmp_path: Path) -> None:
    here = world(world={"plot": {"saved_figure": {"format": "svg"}}})
    here.draw_trajectory(PLACES, color="#abc123", refresh=True)
    for _ in range(2):
        assert "#abc123" in here.save_figure(tmp_path / "one").read_text()
    here.render()
    assert "#abc123" not in here.save_figure(tmp_path / "two").read_text()


@pytest.mark.parametrize("begin", [lambda w: w.reset(), lambda w: w.reset(random=True), lambda w: w.reload()])
def test_a_reset_ends_titles_and_marks_for_one_picture(begin: Any) -> None:
    here = world()
    here.draw_points(PLACES)
    here.draw_box(PLACES)
    here.set_title("one")
    begin(here)
    (box,) = marks(here.draw)
    assert isinstance(box, LineMark)
    assert here.draw.overlay().title is None


def test_one_call_is_taken_away() -> None:
    drawing = Drawing()
    first = drawing.points(PLACES, color=["r", "g", "b"])
    drawing.text(1, 2, "words")
    assert len(drawing) == 4
    first.remove()
    first.remove()
    (words,) = marks(drawing)
    assert isinstance(words, TextMark)


def test_marks_nobody_renders_do_not_pile_up() -> None:
    here = world(world={"sample_time": 0.2})
    for _ in range(50):
        here.draw_points(PLACES)
        here.step()
        assert len(here.draw) <= 4
    here.draw_points(PLACES)
    assert len(marks(here.draw)) > 1  # those that wait for a picture are in it
    here.render()
    assert len(here.draw) == 0


class Window:
    """Stands for the window: it keeps what is shown."""

    def __init__(self, _: str, picture: Any, *__: Any) -> None:
        self.pictures, self.picture = [picture], picture
        self.keyboard = SimpleNamespace(key_id=0)

    def show(self, picture: Any) -> None:
        self.pictures.append(picture)

    def wait(self, _: float) -> None:
        pass

    def execute(self, *_: Any, **__: Any) -> None:
        pass

    def close(self) -> None:
        pass


def test_in_a_window_marks_wait_for_the_next_sample(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in IR-SIM, where ``render`` draws at samples alone: what was drawn in between is in the next picture."""
    monkeypatch.setattr("irsim_gym.live.pictures.viewer.Driver", Window)
    here = irsim_gym.load({**SCENARIO, "world": {**SCENARIO["world"], "sample_time": 0.3}}, render_mode="human")
    here.render(0.0)
    counts = []
    for k in range(6):
        here.draw_points([[k + 1, 7]], c="red")
        here.step()
        here.render(0.0)
        counts.append(len(here.draw))
    assert counts == [1, 2, 0, 1, 2, 0]
    assert here._viewer.driver is not None
    red = [int(((one[..., 0] > 200) & (one[..., 1:].max(axis=2) < 60)).sum()) for one in here._viewer.driver.pictures]
    assert len(red) == 3
    assert red[0] == 0
    assert min(red[1:]) > 3 * 25  # three discs with a diameter of nine pixels


def test_marks_are_drawn_in_the_order_of_the_calls() -> None:
    drawing = Drawing()
    drawing.points(PLACES, once=True)
    drawing.path(PLACES)
    drawing.text(1, 2, "words", once=True)
    assert [type(mark) for mark in marks(drawing)] == [PointsMark, LineMark, TextMark]


def filmed(here: Any) -> list[list[str]]:
    """Return the colours of the marks that a replay shows at each moment."""
    overlays = here._camera._reel._recordings[-1]._overlays
    return [[to_hex(mark.color) for mark in overlay.marks] for overlay in overlays]


def test_a_film_shows_marks_when_they_were_drawn() -> None:
    """Nobody renders: each moment has what was drawn before the next step."""
    here = world(record=True)
    for k, color in enumerate(("red", "lime", "blue")):
        if k == 1:
            here.draw_box(PLACES)
        here.draw_points(PLACES, c=color)
        here.step()
    here.draw_points(PLACES, c="white")
    here._camera._catch_up()
    stays = "#0072b2"
    assert filmed(here) == [["#ff0000"], [stays, "#00ff00"], [stays, "#0000ff"], [stays, "#ffffff"]]


@pytest.mark.parametrize("order", ["draw, step, render", "draw, render, step"])
def test_a_film_shows_what_render_showed(order: str) -> None:
    here = world(record=True)
    here.render()
    for color in ("red", "lime", "blue"):
        here.draw_points(PLACES, c=color)
        for word in order.split(", ")[1:]:
            getattr(here, word)()
    seen = [["#ff0000"], ["#00ff00"], ["#0000ff"]]
    assert filmed(here) == ([[], *seen] if order.endswith("render") else [*seen, []])


def test_a_film_has_the_marks_in_its_pictures(tmp_path: Path) -> None:
    """The frame that was kept before a mark was drawn is drawn again; one without marks is not."""
    import imageio.v3 as iio

    here = world(record=True, world={"plot": {"figure_pixels": [200, 200]}})
    for k in range(3):
        if k == 1:
            here.draw.polygon([[4, 7], [9, 7], [9, 9], [4, 9]], fill="#ff0000", once=True)
        here.step()
    frames = iio.imread(here.save_animation(tmp_path / "run.gif"), index=None)
    red = [int(((frame[..., 0] > 200) & (frame[..., 1] < 60)).sum()) for frame in frames[..., :3]]
    assert len(red) == 4
    assert red[1] > 500
    assert max(red[0], red[2], red[3]) == 0


def test_drawing_changes_nothing_in_the_world() -> None:
    plain, drawn = world(), world()
    for _ in range(20):
        drawn.draw_trajectory(PLACES, refresh=True)
        drawn.draw_quiver((1, 1, 1, 0))
        drawn.render()
        plain.step()
        drawn.step()
    for name in ("pose", "twist", "command", "goal", "collided", "arrived"):
        assert np.array_equal(getattr(plain.simulation.state, name), getattr(drawn.simulation.state, name)), name


# Side by side with ir-sim.


@pytest.fixture
def peers(tmp_path: Path) -> Iterator[tuple[Any, Any]]:
    file = tmp_path / "yard.yaml"
    file.write_text(yaml.safe_dump(SCENARIO))
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        import irsim

        theirs = irsim.make(str(file), display=False, log_level="CRITICAL")
        yield theirs, irsim_gym.load(file)
        theirs.end(0.0)
    logging.getLogger("irsim").handlers.clear()


def script(env: Any) -> None:
    """What IR-SIM's users draw, in its own words."""
    env.draw_trajectory(COLUMNS, "r", refresh=True)
    env.draw_trajectory(COLUMNS, traj_type="-k")
    env.draw_trajectory(np.hstack(COLUMNS), "b--", linewidth=2, alpha=0.5)
    env.draw_trajectory(COLUMNS, "g", show_direction=True)
    env.draw_points(np.hstack(COLUMNS), s=25, c="g", refresh=True)
    env.draw_points(COLUMNS, refresh=False)
    env.draw_box(np.hstack(COLUMNS)[:2], refresh=True)
    env.draw_box(np.hstack(COLUMNS)[:2], color="-b")
    env.draw_quiver(np.array([4.0, 2.0, 0.3, 0.4]), refresh=True)
    env.draw_quivers([np.array([[4.0], [2.0], [0.3], [0.4]])], refresh=False, color="m")


def told(theirs: Any) -> list[Any]:
    """Return what lies on IR-SIM's axes of what was drawn by hand: kind, places, colour, and width or size."""
    from matplotlib.colors import to_hex

    found: list[Any] = []
    for artist in theirs._env_plot.ax.get_children():
        match type(artist).__name__:
            case "Line2D":
                style = {"-": "solid", "--": "dashed", "-.": "dashdot", ":": "dotted"}[artist.get_linestyle()]
                places = np.column_stack(artist.get_data()).tolist()
                found.append(("line", places, to_hex(artist.get_color()), artist.get_linewidth(), style))
            case "PathCollection":
                size = float(np.sqrt(artist.get_sizes()[0]) + artist.get_linewidths()[0])
                found.append(("points", artist.get_offsets().tolist(), to_hex(artist.get_facecolor()[0]), size, ""))
            case "Quiver":
                heads = np.arctan2(artist.V, artist.U).tolist()
                found += [
                    ("arrow", [xy], to_hex(artist.get_facecolor()[0]), round(head, 9), "")
                    for xy, head in zip(artist.XY.tolist(), heads, strict=True)
                ]
    return sorted(found, key=repr)


def ours_told(here: Any) -> list[Any]:
    """Return the same of our marks."""
    from matplotlib.colors import to_hex

    found: list[Any] = []
    for mark in marks(here.draw):
        color = to_hex(mark.color)
        if isinstance(mark, PointsMark):
            found.append(("points", mark.points.tolist(), color, mark.size, ""))
        elif mark.fill:
            tail = 0.5 * (mark.points[0] + mark.points[-1])
            ahead = mark.points[3] - tail
            found.append(("arrow", np.round([tail], 9).tolist(), color, round(float(np.arctan2(*ahead[::-1])), 9), ""))
        else:
            places = mark.points.tolist()
            found.append(("line", places + places[:1] * mark.closed, color, mark.width, mark.style))
    return sorted(found, key=repr)


def test_the_same_calls_draw_the_same_as_in_irsim(peers: tuple[Any, Any]) -> None:
    theirs, ours = peers
    theirs.render(0.0)
    before = told(theirs)
    for env in peers:
        script(env)
    added = [one for one in told(theirs) if one not in before]
    assert len(added) == 4 + 3 + 2 + 2 + 4  # lines, their arrows, points, boxes, and arrows with a dot each
    assert ours_told(ours) == added
    for act in (lambda env: env.step(), lambda env: env.render(0.0)):
        for env in peers:
            act(env)
        moving = {repr(one) for one in told(theirs)}
        assert all(repr(one) in moving for one in ours_told(ours))
    stays = [one for one in added if repr(one) in moving]
    assert ours_told(ours) == stays
    assert 0 < len(stays) < len(added)
    for env in peers:
        env.reset()
    assert ours_told(ours) == [one for one in told(theirs) if one in added] == stays


def test_a_title_ends_with_a_reset_as_in_irsim(peers: tuple[Any, Any]) -> None:
    theirs, ours = peers
    for env in peers:
        env.set_title("by hand")
        env.render(0.0)
        env.step()
        env.render(0.0)
    assert theirs._env_plot.ax.title.get_text() == ours.draw.overlay().title == "by hand"
    for env in peers:
        env.reset()
        env.render(0.0)
    assert theirs._env_plot.ax.title.get_text() != "by hand"
    assert ours.draw.overlay().title is None
