"""Recorded episodes: what a page is given to play, and the page itself."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hand_made import SHOWN, Body, World, disc, make_world, standard_world

from irsim_gym.live.drawing import Drawing
from irsim_gym.render.packing import packed, unpacked
from irsim_gym.render.replay import Recording
from irsim_gym.render.replay_marks import overlay_data
from irsim_gym.render.replay_page import read_html, save_html
from irsim_gym.render.replay_tracks import FogTrack, map_data
from irsim_gym.render.scene import FogView, MapView
from irsim_gym.scenario.plot_spec import ObjectPlot, WorldPlot


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
    data = recorded(standard_world(), moves, agents=["robot_0"]).data()
    robot, box, *_ = sorted(data["bodies"], key=lambda body: int(body["name"][-1]))
    place, heading = (unpacked(part, 3) for part in robot["poses"])
    assert np.allclose(place, np.array(moves)[:, :2])
    assert np.allclose(heading, np.column_stack([[0.0, 0.3, 3.0], np.zeros(3)]))
    assert (robot["discs"], robot["lines"], robot["fixed"]) == ([[0.0, 0.0, 0.4]], [], False)
    assert np.allclose(robot["mark"][:2], [0.28, 0.0])  # the tip, 0.7 radii ahead
    assert box["lines"] == [[-1.0, -0.5, 1.0, -0.5, 1.0, 0.5, -1.0, 0.5, -1.0, -0.5]]
    assert box["poses"][0]["values"] == [7000, 3000]
    assert box["fixed"]
    assert (data["count"], unpacked(data["time"], 3).ravel().round(6).tolist()) == (3, [0.0, 0.1, 0.2])
    assert [(goal["x"], goal["heading"]) for _, goals in data["goals"] for goal in goals] == [(8.0, None)]


def test_a_body_of_another_outline_is_another_body() -> None:
    world = make_world([Body(disc(0.4), robot=True, movable=True)])
    renderer, recording = world.renderer(), Recording(world.scenario)
    recording.note(renderer.scene(0, ""), world.state.pose[0])
    world.model.local_discs[0, 0, 2] = world.state.discs[0, 0, 2] = 0.7
    recording.note(renderer.scene(0, ""), world.state.pose[0])
    small, large = recording.data()["bodies"]
    assert [small["discs"][0][2], large["discs"][0][2]] == [0.4, 0.7]
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
    plot = ObjectPlot(show_trail=True, trail_type="rectangle", trail_color="r", trail_freq=3, show_trajectory=True)
    world = make_world([Body(disc(0.4), (1.0, 1.0, 0.0), robot=True, movable=True, color="C1", plot=plot)])
    data = recorded(world, [(1.0, 1.0, 0.0)]).data()
    (body,) = data["bodies"]
    style = data["styles"][body["style"]]
    assert (style["colour"], style["ghost"]["colour"], style["ghost_every"]) == ("#ff7f0eff", "#ff0000ff", 3)
    assert np.allclose(np.abs(body["ghost"]["lines"][0]), 0.4)  # a square around the disc


def test_a_map_is_boxes_of_its_cells() -> None:
    occupied = np.zeros((5, 4), np.bool_)
    occupied[1:3, 1:4] = True
    occupied[4, 0] = occupied[4, 2] = True
    data = map_data(MapView((0.0, 0.0, 10.0, 8.0), occupied, "#334155", 0.5))
    found = np.zeros_like(occupied)
    for first, low, end, high in np.reshape(data["boxes"], (-1, 4)).tolist():
        assert not found[first:end, low:high].any()
        found[first:end, low:high] = True
    assert np.array_equal(found, occupied)
    assert len(data["boxes"]) == 4 * 3


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
    assert (data["schema"], data["version"], len(data["episodes"])) == ("irsim_gym replay", 1, 2)
    assert data["episodes"][1] == recordings[1].data()
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
    (tmp_path / "other.html").write_text("<html></html>")
    with pytest.raises(ValueError, match="no replay of version 1"):
        read_html(tmp_path / "other.html")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["other.html"]


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
    data = json.loads(json.dumps(overlay_data(overlays)))
    line, crosses, words = data["marks"]
    assert [mark["spans"] for mark in data["marks"]] == [[[0, 4]], [[2, 3]], [[4, 6]]]
    assert data["titles"] == [[0, None], [2, "two"]]
    assert unpacked(line["points"], line["count"]) == pytest.approx(np.array([[1, 2], [3, 4], [3, 5]]))
    assert (line["colour"], line["width"], line["style"], line["closed"], line["fill"]) == (
        "#ff0000", 2.0, "dashed", False, "",
    )  # fmt: skip
    assert (crosses["count"], len(crosses["form"]), crosses["points"]["values"]) == (2, 2, [2000, 1000])
    assert (words["text"], words["align"], words["colour"]) == ("gone", "left", "#ff0000")
    assert words["alpha"] == pytest.approx(128 / 255)


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
    spans = [mark["spans"] for mark in overlay_data(overlays)["marks"]]
    assert spans == [[[0, 20], [22, 50]], [[0, 20], [22, 50]], [[30, 31]]]


def test_a_recording_without_marks_says_so_in_short() -> None:
    data = recorded(standard_world(), [(2.0, 3.0, 0.0), (2.5, 3.0, 0.3)]).data()
    assert (data["marks"], data["titles"]) == ([], [[0, None]])


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
    assert [mark["spans"] for mark in data["marks"]] == [[[0, 5]], [[0, 1]], [[1, 2]], [[2, 3]], [[3, 4]]]
    assert data["titles"] == [[0, None], [4, "end"]]
