"""What a world by hand keeps of its course: films, pages, sheets, pictures of ways."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from command_line import run
from replay_pages import read_html, unpacked
from small_world import world

SMALL = {"plot": {"figure_pixels": [240, 200]}}


def test_a_page_holds_all_episodes(tmp_path: Path) -> None:
    here = world(world=SMALL, record=True)
    for _ in range(4):
        here.step()
    here.reset()
    here.step([1.0, 0.5])
    here.add("robot", name="late", kinematics={"name": "diff"}, state=[5, 8, 0])
    here.step()
    here.remove("robot_1")
    here.step()
    page = here.save_html(tmp_path / "run")
    assert page == tmp_path / "run.html"
    first, second = read_html(page)["episodes"]
    assert (first["count"], second["count"]) == (5, 4)
    assert (first["name"], second["name"]) == ("episode 1: running, 0.4 s", "episode 2: running, 0.3 s")
    assert (first["status"], second["status"]) == ([[0, "Running"]], [[0, "Reset"], [1, "Running"]])
    assert [agent["name"] for agent in first["agents"]] == ["robot_0", "robot_1"]
    distance = unpacked(first["agents"][0]["values"]["goal_distance"], 5).ravel()
    assert distance[0] == pytest.approx(np.hypot(8, 8), abs=1e-6)
    assert (np.diff(distance) < 0).all()
    gone = next(body for body in second["bodies"] if body["name"] == "robot_1")
    assert np.isnan(unpacked(gone["poses"][0], 4)[:, 0]).tolist() == [False, False, False, True]
    late = next(body for body in second["bodies"] if body["name"] == "late")
    assert np.isnan(unpacked(late["poses"][0], 4)[:, 0]).tolist() == [True, True, False, False]
    here.save_animation(tmp_path / "run.gif")
    assert len(read_html(here.save_html(tmp_path / "again.html"))["episodes"]) == 2


def test_a_page_has_a_body_that_was_added_before_something_was_drawn(tmp_path: Path) -> None:
    here = world(world=SMALL, record=True)
    here.add("obstacle", name="pillar", shape={"name": "circle", "radius": 0.4}, state=[8, 2, 0])
    here.draw.path([[1, 1], [2, 2]])
    for _ in range(2):
        here.step()
    (episode,) = read_html(here.save_html(tmp_path / "run.html"))["episodes"]
    pillar = next(body for body in episode["bodies"] if body["name"] == "pillar")
    assert unpacked(pillar["poses"][0], 3)[1:, :2].tolist() == [[8, 2], [8, 2]]


@pytest.mark.parametrize("what", ["save_html", "save_animation"])
def test_without_record_there_is_nothing(what: str, tmp_path: Path) -> None:
    here = world(world=SMALL)
    here.step()
    with pytest.raises(ValueError, match="record=True"):
        getattr(here, what)(tmp_path / "run")
    assert list(tmp_path.iterdir()) == []


def test_names_that_are_wrong(tmp_path: Path) -> None:
    here = world(world=SMALL, record=True)
    with pytest.raises(ValueError, match=r"must end in \.html, got 'run\.mp4'"):
        here.save_html(tmp_path / "run.mp4")


def test_recording_changes_nothing() -> None:
    states = []
    for record in (False, True):
        here = world(world=SMALL, record=record)
        for _ in range(20):
            here.step()
        state = here.simulation.state
        states.append(np.concatenate([state.pose.ravel(), state.random.view(np.float64).ravel(), state.twist.ravel()]))
    assert np.array_equal(states[0].view(np.uint64), states[1].view(np.uint64))


def test_run_writes_films_and_pages(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("run.mp4", "run.html"):
        assert run(monkeypatch, "run", "empty_goal", "--steps", 9, "--film", name) == 0
        assert capsys.readouterr().out.splitlines()[-1] == name
    assert imageio_ffmpeg.count_frames_and_secs("run.mp4") == (10, pytest.approx(1.0))
    assert read_html("run.html")["episodes"][0]["count"] == 10


def test_progress_is_for_terminals_alone(tmp_path: Path) -> None:
    program = "import irsim_gym; from irsim_gym.rendering.films.video import write_video; import numpy as np\n"
    program += f"write_video(np.zeros((5, 16, 16, 3), np.uint8), {str(tmp_path / 'a.gif')!r}, 5.0, total=5)"
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert (result.stdout, result.stderr) == ("", "")
