"""What `irsim-gym record` writes: films whose frames are counted, and pages whose episodes are read."""

from __future__ import annotations

from pathlib import Path

import imageio.v2 as imageio
import imageio_ffmpeg
import numpy as np
import pytest
from command_line import run
from replay_pages import read_html, unpacked

from irsim_gym.evaluation.comparison.players import load_players
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest

STRAIGHT = """
world: {height: 3, width: 6, step_time: 0.25}
robot:
  - kinematics: {name: diff}
    shape: {name: circle, radius: 0.2}
    vel_max: [1, 1]
    state: [1, 1.5, 0]
    goal: [4.1, 1.5, 0]
    goal_threshold: 0.2
    sensors: [{name: lidar2d, number: 8, range_max: 2}]
obstacle: [{shape: {name: circle, radius: 0.3}, state: [2.5, 2.6]}]
task: {name: navigation, max_steps: 40}
"""
STEPS = 12
"""A quarter of a metre a step, until less than 0.2 of 3.1 m are left."""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    Path("straight.yaml").write_text(STRAIGHT, encoding="utf-8")
    return "straight.yaml"


def test_a_replay(file: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(monkeypatch, "record", file, "dash", "random", "--level", "0", "--level", "3", "--html") == 0
    said = capsys.readouterr()
    assert said.out.strip() == "runs/replay.html"
    first = Path("runs/replay.html").read_bytes()
    assert run(monkeypatch, "record", file, "dash", "--html") == 0
    assert capsys.readouterr().out.strip() == "runs/replay-2.html"
    assert Path("runs/replay.html").read_bytes() == first
    assert "recording" not in said.err  # no progress bar where nobody watches
    data = read_html("runs/replay.html")
    first, other, *later = data["episodes"]
    assert first["name"] == "dash, level 0: success, 3.0 s"
    assert [episode["details"]["policy"] for episode in (first, other, *later)] == ["dash", "random"] * 2
    assert (first["count"], first["details"]) == (STEPS + 1, {"policy": "dash", "level": "0 (test)"})
    assert first["status"] == [[0, "running"], [STEPS, "success"]]
    (agent,) = first["agents"]
    values = {name: unpacked(table, STEPS + 1).ravel() for name, table in agent["values"].items()}
    assert values["goal_distance"] == pytest.approx(3.1 - 0.25 * np.arange(STEPS + 1), abs=1e-6)
    assert values["speed"][[0, 1, STEPS]].tolist() == [0.0, 1.0, 1.0]
    nearest = np.hypot(1.5 - 0.25 * np.arange(STEPS + 1), 1.1) - 0.5
    assert values["clearance"] == pytest.approx(nearest, abs=1e-6)
    terms = sum(unpacked(table, STEPS + 1).ravel() for table in agent["terms"].values())
    assert terms == pytest.approx(values["reward"], abs=1e-5)
    assert {"progress", "arrival", "collision"} <= set(agent["terms"])
    action = unpacked(agent["action"], STEPS + 1)
    assert np.isnan(action[0]).all()
    assert action[1:, 0] == pytest.approx(1.0)
    (robot,) = [body for body in first["bodies"] if body["name"] == "robot_0"]
    assert unpacked(robot["poses"][0], STEPS + 1)[:, 0] == pytest.approx(1.0 + 0.25 * np.arange(STEPS + 1))


def test_a_name_may_ask_for_a_replay(file: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert run(monkeypatch, "record", file, "dash", "--out", "one.html", "--team") == 0
    assert [agent["name"] for agent in read_html("one.html")["episodes"][0]["agents"]] == ["robot_0"]


def test_a_replay_is_no_film(file: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(monkeypatch, "record", file, "dash", "--html", "--out", "film.mp4") == 1
    assert "a replay's name ends in .html, got 'film.mp4'" in capsys.readouterr().err


def test_a_film_shows_samples_and_the_end(file: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A sample each 1.25 s is one each five steps: the start, steps 5 and 10, the end after step 12."""
    Path(file).write_text(STRAIGHT.replace("step_time: 0.25", "step_time: 0.25, sample_time: 1.25"), encoding="utf-8")
    cast = load_players(ScenarioRequest(file), ["dash"])
    assert cast.steps_per_frame == 5
    shown = [(int(cast.simulation.state.step[0]), status) for status in cast.play(0, 0) if cast.is_frame(0)]
    assert shown == [(0, "running"), (5, "running"), (10, "running"), (12, "success")]
    (trail,) = cast.renderer.scene(0).trails
    assert trail.points[:, 0] == pytest.approx(1.0 + 0.25 * np.arange(STEPS + 1))
    assert run(monkeypatch, "record", file, "dash") == 0
    with imageio.get_reader("runs/film.mp4") as film:
        assert film.get_meta_data()["fps"] == pytest.approx(0.8)
        assert film.count_frames() == 4 + 1  # the end is held for 1.2 s


def test_a_film_has_a_frame_for_each_step(file: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert run(monkeypatch, "record", file, "dash", "--out", "film.mp4") == 0
    count, seconds = imageio_ffmpeg.count_frames_and_secs("film.mp4")
    held = round(1.2 * 4)  # the end is shown for 1.2 s, at four frames a second
    assert count == STEPS + 1 + held
    assert seconds == pytest.approx(count / 4, abs=0.02)
    assert sorted(entry.name for entry in Path().iterdir()) == ["film.mp4", "straight.yaml"]
