"""Recorded episodes: what a page is given to play, and the page itself."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import get_args

import numpy as np
import pytest
from hand_made import SHOWN, Body, World, disc, make_world, standard_world
from replay_pages import read_html, unpacked

from irsim_gym.live.drawing.drawing import Drawing
from irsim_gym.rendering.looks.packing import packed
from irsim_gym.rendering.looks.styles import BodyStyle
from irsim_gym.rendering.replay.replay_data import Recording
from irsim_gym.rendering.replay.replay_items import Items, SharedItems, css
from irsim_gym.rendering.replay.replay_page import save_html
from irsim_gym.rendering.replay.replay_tracks import FogTrack, map_figure, marks_seen
from irsim_gym.rendering.scene import primitives, vocabulary
from irsim_gym.rendering.scene.scene import FogView, GoalView, MapView
from irsim_gym.scenario.specs.plot_spec import ObjectPlot, WorldPlot
from irsim_gym.simulator.readings.marks import Overlay


def recorded(world: World, moves: list[tuple[float, float, float]], **options) -> Recording:
    """Record the world's first body as it stands at some poses."""
    renderer, recording = world.renderer(), Recording(world.scenario, **options)
    for k, move in enumerate(moves):
        world.move(0, *move)
        values = [
            {"outcome": "running", "speed": 0.5 * k, "clearance": np.inf, "reward": 0.25, "terms": {"time": 0.25}}
        ]
        recording.note(renderer.scene(0, "running"), world.state.pose[0], values * bool(options))
        world.step()
    return recording


def drawn(recording: Recording) -> tuple[dict, list[dict]]:
    """Return an episode, and its items with the pens and shapes that they have."""
    shared = SharedItems()
    data = recording.data(shared)
    tables = shared.data()
    known = {"pen": tables["pens"], "shape": tables["shapes"]}
    items = [{**item, **{name: known[name][item[name]] for name in known if name in item}} for item in data["items"]]
    return {**data, "shapes": tables["shapes"]}, items


def points(table: dict) -> list[list[float]]:
    """Return the rows of a packed table of different rows."""
    return unpacked(table, len(table["values"]) // table["width"]).round(4).tolist()


def marks(overlays: list[Overlay]) -> list[tuple[primitives.Primitive, list[int]]]:
    """Return what is drawn of marks, and when."""
    return [(vocabulary.mark(mark), spans) for mark, spans in marks_seen(overlays).things.values()]


def test_numbers_come_back() -> None:
    rows = np.array([[np.nan, 1.0], [2.0004, 1.5], [np.nan, 1.5], [2.5, -7.0]])
    data = packed(rows, 1e-3)
    assert data == {"unit": 1e-3, "width": 2, "values": [None, 1000, 2000, 500, None, 0, 500, -8500]}
    assert np.allclose(unpacked(json.loads(json.dumps(data)), 4), np.round(rows, 3), equal_nan=True)


def test_equal_rows_are_told_once() -> None:
    data = packed(np.full((300, 3), 4.0), 0.5)
    assert data["values"] == [8, 8, 8]
    assert np.array_equal(unpacked(data, 300), np.full((300, 3), 4.0))


def test_a_body_keeps_its_outline_and_has_a_pose_at_each_moment() -> None:
    moves = [(2.0, 3.0, 0.0), (2.5, 3.0, 0.3), (3.0, 3.25, 3.0)]
    data, items = drawn(recorded(standard_world(), moves, agents=["robot_0"]))
    robot, box, *_ = sorted(data["bodies"], key=lambda body: int(body["name"][-1]))
    place, heading = (unpacked(part, 3) for part in robot["poses"])
    assert np.allclose(place, np.array(moves)[:, :2])
    assert np.allclose(heading, np.column_stack([[0.0, 0.3, 3.0], np.zeros(3)]))
    footprint, corners = (data["shapes"][body["shape"]] for body in (robot, box))
    assert (list(footprint), points(footprint["discs"]), robot["fixed"]) == (["discs"], [[0.0, 0.0, 0.4]], False)
    assert [points(line) for line in corners["chains"]] == [
        [[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5], [-1.0, -0.5]]
    ]
    assert box["poses"][0]["values"] == [7000, 3000]
    assert box["fixed"]
    number = data["bodies"].index(robot)
    (mark,) = [item for item in items if (item["rank"], item.get("body")) == ("headings", number)]
    assert points(mark["shape"]["chains"][0])[0] == [0.28, 0.0]  # the tip, 0.7 radii ahead
    assert (data["count"], unpacked(data["time"], 3).ravel().round(6).tolist()) == (3, [0.0, 0.1, 0.2])
    (goal,) = [item for item in items if item["rank"] == "goals"]
    assert (points(goal["places"])[0][0], goal["spans"]) == (8.0, [0, 3])


def test_a_body_of_another_outline_is_another_body() -> None:
    world = make_world([Body(disc(0.4), robot=True, movable=True)])
    renderer, recording = world.renderer(), Recording(world.scenario)
    recording.note(renderer.scene(0, ""), world.state.pose[0])
    world.model.local_discs[0, 0, 2] = world.state.discs[0, 0, 2] = 0.7
    recording.note(renderer.scene(0, ""), world.state.pose[0])
    data, _ = drawn(recording)
    small, large = data["bodies"]
    assert [points(data["shapes"][body["shape"]]["discs"])[0][2] for body in (small, large)] == [0.4, 0.7]
    assert unpacked(small["poses"][0], 2)[:, 0].tolist()[0] == 0.0
    assert np.isnan(unpacked(small["poses"][0], 2)[1]).all()
    assert np.isnan(unpacked(large["poses"][0], 2)[0]).all()


def test_a_scan_is_ranges_along_its_beams() -> None:
    data = recorded(standard_world(), [(2.0, 3.0, 0.0), (2.0, 3.0, 1.0)]).data()
    (scan,) = data["scans"]
    ranges = unpacked(scan["ranges"], 2)
    assert np.allclose(ranges[0], [1.0] * 8 + [2.0] * 16)
    assert (ranges < scan["far"]).sum() == 16
    assert np.allclose(unpacked(scan["places"][1], 2).ravel(), [0.0, 1.0])
    assert (scan["body"], scan["near"], scan["surrounds"], scan["speeds"]) == ("robot_0", -1.0, True, None)


def test_agents_tell_their_numbers() -> None:
    recording = recorded(standard_world(), [(2.0, 3.0, 0.0)] * 3, agents=["robot_0"])
    (agent,) = recording.data()["agents"]
    assert unpacked(agent["values"]["speed"], 3).ravel().tolist() == [0.0, 0.5, 1.0]
    assert np.isnan(unpacked(agent["values"]["clearance"], 3)).all()  # nothing else is there: endless
    assert np.allclose(unpacked(agent["terms"]["time"], 3), 0.25)
    assert agent["outcome"] == [[0, "running"]]
    with pytest.raises(ValueError, match="1 agents"):
        recording.note(standard_world().renderer().scene(0, ""), np.zeros((5, 3)))


def test_trails_of_outlines_and_colours_are_what_browsers_draw() -> None:
    plot = ObjectPlot(show_trail=True, trail_type="rectangle", trail_edgecolor="r", trail_freq=3, show_trajectory=True)
    world = make_world([Body(disc(0.4), (1.0, 1.0, 0.0), robot=True, movable=True, color="C1", plot=plot)])
    _, items = drawn(recorded(world, [(1.0, 1.0, 0.0)]))
    footprint, ghost = ([item for item in items if item["rank"] == rank] for rank in ("bodies", "ghosts"))
    assert (footprint[0]["pen"]["fill"], ghost[0]["past"]) == ("#ff7f0e", [3, 0])
    assert ghost[0]["pen"]["edge"].startswith("#ff0000")
    assert np.allclose(np.abs(points(ghost[0]["shape"]["chains"][0])), 0.4)  # a square around the disc


def test_a_map_is_boxes_of_its_cells() -> None:
    occupied = np.zeros((5, 4), np.bool_)
    occupied[1:3, 1:4] = True
    occupied[4, 0] = occupied[4, 2] = True
    shape = map_figure(MapView((0.0, 0.0, 10.0, 8.0), occupied, "#334155", 0.5)).shape
    found = np.zeros_like(occupied)
    for first, low, end, high in np.asarray(shape.boxes).tolist():
        assert not found[first:end, low:high].any()
        found[first:end, low:high] = True
    assert np.array_equal(found, occupied)
    assert (np.shape(shape.boxes), shape.cell) == ((3, 4), (0.0, 0.0, 2.0, 2.0))


def test_fog_is_what_changes_of_it() -> None:
    covered = np.ones((2, 3), np.bool_)
    track = FogTrack(FogView((0.0, 0.0, 2.0, 3.0), covered, "#ffffff", 1.0))
    track.note(FogView((0.0, 0.0, 2.0, 3.0), covered, "#ffffff", 1.0), 0)
    later = covered.copy()
    later[0, 1] = later[1, 2] = False
    for moment in (1, 2):
        track.note(FogView((0.0, 0.0, 2.0, 3.0), later, "#ffffff", 1.0), moment)
    assert track.data()["changes"] == [[0, [0, 1, 1, 1, 1, 1]], [1, [1, 4]]]


def test_a_page_holds_everything_and_loads_nothing(tmp_path: Path) -> None:
    recordings = [recorded(standard_world(), [(2.0, 3.0, 0.0), (2.5, 3.0, 0.0)]) for _ in range(2)]
    recordings[1].name = "</script> & <b>another</b>"
    path = save_html(tmp_path / "new" / "replay.html", recordings, title="Two <episodes>")
    text = path.read_text(encoding="utf-8")
    assert not re.search(r"https?:|url\(|@import|src=|<link[^>]*href=\"[^d]", text)
    assert text.count("</script>") == 2
    assert "<title>Two &lt;episodes&gt;</title>" in text
    assert "{{" not in text
    data = read_html(path)
    assert (data["schema"], data["version"], len(data["episodes"])) == ("irsim_gym replay", 2, 2)
    assert data["episodes"][1] == json.loads(json.dumps(recordings[1].data()))
    assert [file.name for file in path.parent.iterdir()] == ["replay.html"]


def test_an_episode_of_a_crowd_is_small(tmp_path: Path) -> None:
    """300 steps of 20 bodies that wind their way, and 120 beams of noise: far below a megabyte."""
    rng = np.random.default_rng(0)
    bodies = [Body(disc(0.3), robot=b == 0, movable=True, plot=SHOWN) for b in range(20)]
    world = make_world(bodies)
    world.sensors[0].arrays["angles"] = np.linspace(-np.pi, np.pi, 120)
    renderer, recording = world.renderer(), Recording(world.scenario)
    for _ in range(300):
        world.state.pose[0] += rng.normal(0.0, 0.05, (20, 3))
        world.state.discs[0, :, :2] = world.state.pose[0, :, :2]
        world.sensors[0].arrays["ranges"] = rng.uniform(0.5, 2.0, (1, 1, 120)).astype(np.float32)
        recording.note(renderer.scene(0, ""), world.state.pose[0])
    assert save_html(tmp_path / "crowd.html", [recording]).stat().st_size < 300_000


def test_what_cannot_be_written(tmp_path: Path) -> None:
    scenario = SimpleNamespace(world=SimpleNamespace(plot=WorldPlot()))
    with pytest.raises(ValueError, match="nothing was recorded"):
        save_html(tmp_path / "a.html", [Recording(scenario)])
    with pytest.raises(ValueError, match="needs an episode"):
        save_html(tmp_path / "a.html", [])
    with pytest.raises(ValueError, match=r"ends in \.html, got 'a\.mp4'"):
        save_html(tmp_path / "a.mp4", [Recording(scenario)])
    assert not list(tmp_path.iterdir())


def test_marks_are_told_with_the_moments_at_which_they_are_seen() -> None:
    drawing, overlays = Drawing(), []
    route = drawing.path([[1, 2], [3, 4.0004], [3, 5]], "r--", width=2)
    for moment in range(6):
        if moment == 2:
            drawing.points([[moment, 1], [moment, 1]], marker="x", once=True)
            drawing.title("two")
        if moment == 4:
            route.remove()
            drawing.text(1.5, 2.5, "gone", align="left", color="#ff000080")
        overlays.append(drawing.overlay())
        drawing.shown()
    (line, *_), (crosses, *_), (words, *_) = found = marks(overlays)
    assert [spans for _, spans in found] == [[0, 4], [2, 3], [4, 6]]
    assert line.shape.chains[0] == pytest.approx(np.array([[1, 2], [3, 4.0004], [3, 5]]))
    red = primitives.Ink("r", 1.0)
    assert line.pen == primitives.Pen(None, red, 2.0, "dashed", cap="butt")
    assert (crosses.places.tolist(), len(crosses.shape.offsets)) == ([[2, 1], [2, 1]], 2)
    assert (words.text, words.align, css(words.ink)) == ("gone", "left", "#ff000080")


def test_what_is_drawn_anew_as_it_was_is_one_mark() -> None:
    """A script that draws its plan at each step does not make the page larger while the plan stays."""
    drawing, overlays = Drawing(), []
    for moment in range(50):
        if moment not in (20, 21):
            drawing.path([[1, 2], [3, 4]], once=True)
            drawing.path([[1, 2], [3, 4]], "k", once=True)
        if moment == 30:
            drawing.path([[1, 2], [3, 4]], "k", once=True)  # twice at one moment
        overlays.append(drawing.overlay())
        drawing.shown()
    assert [spans for _, spans in marks(overlays)] == [[0, 20, 22, 50], [0, 20, 22, 50], [30, 31]]


def test_marks_that_stay_are_seen_as_long_as_they_do() -> None:
    overlays = [Drawing().overlay()]
    drawing = Drawing()
    drawing.path([[1, 2], [3, 4]])
    overlays += [drawing.overlay()] * 3 + overlays * 2 + [drawing.overlay()] * 2
    assert [spans for _, spans in marks(overlays)] == [[1, 4, 6, 8]]


def test_the_script_draws_every_primitive() -> None:
    """The page's script knows each by its name, and no others."""
    text = (Path(vocabulary.__file__).parents[1] / "replay" / "page" / "primitives.js").read_text(encoding="utf-8")
    names = re.search(r"const PRIMITIVES = {(.*?)}", text, re.DOTALL)[1]
    assert set(re.findall(r"(\w+):", names)) == {kind.__name__ for kind in get_args(primitives.Primitive)}


def test_an_arrow_at_a_goal_is_a_shape_with_a_least_length() -> None:
    """Its shaft ends at the circle, but is at least 7 points long; its head is 6 points long."""
    view = GoalView(3.0, 4.0, 1.5, 0.25, np.zeros((0, 2)), False, "robot_0", BodyStyle("C0", goal_colour="#102030"))
    shared = SharedItems()
    items = Items(shared)
    for thing in vocabulary.goal(view):
        items.add(thing, spans=[0, 1])
    _, arrow, pole, _ = items.list()
    tables = shared.data()
    shape = tables["shapes"][arrow["shape"]]
    assert (points(arrow["places"]), shape["least"]) == ([[3.0, 4.0, 1.5]], 7.0)
    assert (points(shape["chains"][0])[3], points(shape["offsets"][0])[3]) == ([0.25, 0.0], [6.0, 0.0])
    assert tables["pens"][arrow["pen"]] == {"fill": "#102030e6"}
    assert pole["rank"] == "flags"


def test_a_page_holds_the_marks_of_a_run(tmp_path: Path) -> None:
    from irsim_gym import load

    room = {"world": {"height": 4, "width": 4}, "robot": {"kinematics": {"name": "diff"}, "state": [1, 1, 0]}}
    with load(room, record=True) as world:
        world.draw_trajectory([[1, 1], [3, 3]], "-k")
        for k in range(4):
            world.draw_points(np.array([[k, k], [1, 2]]), refresh=True)
            world.render()
            world.step()
        world.set_title("end")
        data = read_html(world.save_html(tmp_path / "run.html"))["episodes"][0]
    spans = [item["spans"] for item in data["items"] if item["rank"] == "marks"]
    assert sorted(spans) == [[0, 1], [0, 5], [1, 2], [2, 3], [3, 4]]
    assert data["titles"] == [[0, None], [4, "end"]]
