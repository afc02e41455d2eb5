"""Bags: written from episodes, replayed through an export, fitted, and refused where they are broken."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from command_line import run

pytest.importorskip("rosbags")

import messages
from simulated_bags import Robot, command, write, write_bags

from irsim_gym.base.errors import IrsimGymError, UnreadableFileError
from irsim_gym.evaluation.measures.statistics import Estimate
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.robot.bags.check import check_bag
from irsim_gym.robot.bags.fit import fit_bag, section
from irsim_gym.robot.bags.read import Bag, read_bag
from irsim_gym.robot.bags.write import write_bag
from irsim_gym.robot.export import RobotExport
from irsim_gym.scenario import load_scenario

ROOM = ScenarioRequest("cluttered_room")
FREE = np.full(180, 6.0)


def replayed(exported: RobotExport, folder: Path, level: int) -> float:
    """Return how far commands of a policy are from those of its export that sees the bag."""
    counts = write_bag(ROOM, "cluttered_room", folder / f"level_{level}", level)
    found = check_bag(read_bag(folder / f"level_{level}", {}), exported.folder)
    assert len(found.times) == counts["/cmd_vel"] > 20
    assert not found.stops()
    return float(np.abs(found.commands - found.recorded).max())


def test_a_replayed_bag_gives_the_commands_that_were_recorded(exported: RobotExport, tmp_path: Path) -> None:
    assert max(replayed(exported, tmp_path, level) for level in range(2)) < 1e-6


@pytest.mark.slow
def test_twenty_replayed_bags_give_the_commands_that_were_recorded(exported: RobotExport, tmp_path: Path) -> None:
    assert max(replayed(exported, tmp_path, level) for level in range(2, 20)) < 1e-6


def drive_of(times: Any, *, scans: Any = None, shift: float = 0.0) -> list[tuple[float, str, Any]]:
    """Return scans, odometry and commands at some times [s], and a goal ahead."""
    rows: list[tuple[float, str, Any]] = [(shift, "/goal_pose", messages.goal(8.0, 1.0))]
    for time in times:
        rows.append((time + shift, "/odom", messages.odometry(time, (1.0, 1.0, 0.0))))
        if scans is None or time in scans:
            rows.append((time + shift, "/scan", messages.scan(time, FREE)))
        rows.append((time + shift, "/cmd_vel", command(0.25, -0.5)))
    return rows


def test_stops_ages_and_lost_beams_are_told(exported: RobotExport, tmp_path: Path) -> None:
    """No scans from 1.0 to 1.5 s, messages 0.05 s late, a scan at 2.0 s that loses half of its beams."""
    times = [round(0.1 * k, 1) for k in range(30)]
    rows = drive_of(times, scans=[time for time in times if not 0.95 < time < 1.55], shift=0.05)
    (halved,) = [message for time, topic, message in rows if topic == "/scan" and abs(time - 2.05) < 0.01]
    halved.ranges[::2] = np.nan
    found = check_bag(read_bag(write(tmp_path / "bag", rows), {}), exported.folder)
    assert found.recorded[0].tolist() == [0.25, 0.0, -0.5]
    assert found.ages[:9] == pytest.approx(np.full((9, 2), 0.05))
    assert found.ages[15] == pytest.approx([0.65, 0.05])
    assert found.lost[14] == pytest.approx([2.0, 0.5])
    assert found.lost[:, 1].sum() == 0.5
    stops = [(round(first, 2), round(last, 2), reason) for first, last, reason, _ in found.stops()]
    assert stops == [
        (1.2, 1.5, "the scan is 0.35 s old"),
        (1.6, 1.7, "waits for good scans"),
        (2.0, 2.0, "50% of the beams are lost"),
        (2.1, 2.2, "waits for good scans"),
    ]


def test_zeros_may_mean_that_nothing_is_in_range(exported: RobotExport, tmp_path: Path) -> None:
    """Half of the beams read 0, with a range_min of 0.1 m."""
    rows = drive_of([0.0, 0.1, 0.2])
    for _, topic, message in rows:
        if topic == "/scan":
            message.ranges[::2], message.range_min = 0.0, 0.1
    bag = read_bag(write(tmp_path / "bag", rows), {})
    assert check_bag(bag, exported.folder).lost[:, 1] == pytest.approx([0.5, 0.5, 0.5])
    found = check_bag(bag, exported.folder, "zero")
    assert found.lost[:, 1].tolist() == [0.0, 0.0, 0.0]
    assert found.reasons == ["", "", ""]


def test_a_bag_without_commands_is_driven_by_a_clock(exported: RobotExport, tmp_path: Path) -> None:
    rows = [row for row in drive_of([0.0, 0.1, 0.2, 0.3]) if row[1] != "/cmd_vel"]
    found = check_bag(read_bag(write(tmp_path / "bag", rows), {}), exported.folder)
    assert found.times == pytest.approx([0.1, 0.2, 0.3, 0.4])
    assert np.isnan(found.recorded).all()
    assert (found.commands[:, 0] > 0.0).all()


def robots(count: int, seed: int) -> list[Robot]:
    rng = np.random.default_rng(seed)
    return [
        Robot(
            wait=0.005 * int(rng.integers(0, 13)),
            delay=0.005 * int(rng.integers(0, 81)),
            tau=rng.uniform(0.05, 0.6),
            noise=rng.uniform(0.0, 0.05),
            lost=rng.uniform(0.0, 0.4),
            reads=(np.inf, np.nan, 0.0)[k % 3],
        )
        for k in range(count)
    ]


def check_fit(robot: Robot, bag: Bag) -> None:
    """Compare what a bag says with the truth: as the printed section says it, and by intervals three times as wide."""
    found = fit_bag(bag)
    said = yaml.safe_load("\n".join(section(found, bag)))
    assert len(load_scenario({"robot": {"sensors": [{"name": "lidar2d"}], **said}}).bodies[0].disturbances) == 3
    told = {one["name"]: one for one in said["disturbances"]}
    assert told["latency"]["time"] == pytest.approx(robot.wait + robot.delay, abs=0.02)
    assert told["drive_lag"]["tau"] == pytest.approx(robot.tau, rel=0.2)
    assert told["lost_beams"]["chance"] == pytest.approx(robot.lost, abs=0.02)
    assert told["lost_beams"]["reads"] == ("zero" if robot.reads == 0.0 else "none")
    truths = (robot.wait + robot.delay, robot.tau, robot.noise, robot.lost)
    for one, truth in zip((found.latency, found.tau, found.noise, found.lost), truths, strict=True):
        assert isinstance(one, Estimate)
        width = one.high - one.low
        assert one.low - width <= truth <= one.high + width
    assert found.wait == pytest.approx(robot.wait, abs=1e-6)
    assert found.periods["command"].value == pytest.approx(0.1)
    assert found.periods["odometry"].value == pytest.approx(0.02)


def test_a_bag_tells_latency_lag_noise_and_losses(tmp_path: Path) -> None:
    some = robots(2, seed=3)
    for robot, file in zip(some, write_bags(some, tmp_path), strict=True):
        check_fit(robot, read_bag(file, {}))


@pytest.mark.slow
def test_twenty_bags_tell_latency_lag_noise_and_losses(tmp_path: Path) -> None:
    some = robots(20, seed=1)
    for robot, file in zip(some, write_bags(some, tmp_path), strict=True):
        check_fit(robot, read_bag(file, {}))


@pytest.mark.parametrize(("name", "storage"), [("sqlite", "sqlite3"), ("one.bag", "")])
def test_other_forms_of_bags_are_read(exported: RobotExport, tmp_path: Path, name: str, storage: str) -> None:
    """SQLite of ROS 2, and a bag of ROS 1, which the library itself converts."""
    from rosbags.convert import convert
    from rosbags.typesys import Stores, get_typestore

    write_bag(ROOM, "cluttered_room", tmp_path / "bag", 3)
    store = None if storage else get_typestore(Stores.ROS1_NOETIC)
    how = {"compress": None, "compress_mode": "none", "default_typestore": None, "typestore": store}
    all_of: dict[str, Any] = dict.fromkeys(
        ("exclude_topics", "include_topics", "exclude_msgtypes", "include_msgtypes"), ()
    )
    convert([tmp_path / "bag"], tmp_path / name, dst_storage=storage, dst_version=8, **how, **all_of)
    found = check_bag(read_bag(tmp_path / name, {}), exported.folder)
    assert len(found.times) > 20
    assert np.abs(found.commands - found.recorded).max() < 1e-6


def test_what_a_bag_cannot_tell_is_said(tmp_path: Path) -> None:
    """Commands that do not change say nothing of a lag, and a robot that only drives nothing of noise."""
    rows = drive_of([round(0.1 * k, 1) for k in range(80)])
    for _, topic, message in rows:
        if topic == "/odom":
            message.twist.twist.linear.x = 0.25
    bag = read_bag(write(tmp_path / "bag", rows), {})
    text = "\n".join(section(fit_bag(bag), bag))
    assert "latency: cannot be told from this bag (its commands hardly change)" in text
    assert "drive_lag: cannot be told from this bag (its commands hardly change)" in text
    assert "lost_beams: cannot be told from this bag (no beams see the same surface twice)" in text
    assert "noise of ranges: cannot be told from this bag (the robot hardly stands still)" in text
    assert yaml.safe_load(text) == {"disturbances": None}
    assert "# For an entry in robot of a scenario." in text
    assert not load_scenario({"robot": {"kinematics": {"name": "diff"}, **yaml.safe_load(text)}}).bodies[0].disturbances


def test_an_undisturbed_episode_is_neither_late_nor_slow(tmp_path: Path) -> None:
    """Commands and odometry of every 0.1 s leave open when, between two of them, a command acts."""
    write_bag(ROOM, "cluttered_room", tmp_path / "bag")
    found = fit_bag(read_bag(tmp_path / "bag", {}))
    assert isinstance(found.latency, Estimate)
    assert isinstance(found.tau, Estimate)
    assert isinstance(found.lost, Estimate)
    assert found.latency.low < 0.01
    assert 0.05 < found.latency.high < 0.1
    assert found.tau.high < 0.03
    assert found.lost.high < 0.005


def test_a_topic_of_another_name_is_named(exported: RobotExport, tmp_path: Path) -> None:
    rows = [(time, "/front" if topic == "/scan" else topic, message) for time, topic, message in drive_of([0.0, 0.1])]
    file = write(tmp_path / "bag", rows)
    with pytest.raises(IrsimGymError, match="has no scan, which the policy needs: name its topic with --topic"):
        check_bag(read_bag(file, {}), exported.folder)
    assert len(read_bag(file, {"scan": "/front"}).of("scan")) == 2
    with pytest.raises(UnreadableFileError, match=r"no bag with messages of /back: its topics are /goal_pose \(Pose"):
        read_bag(file, {"scan": "/back"})
    with pytest.raises(UnreadableFileError, match=r"bag is no bag of ROS: .*has no attribute 'ranges'"):
        check_bag(read_bag(file, {"scan": "/goal_pose"}), exported.folder)


def test_what_is_no_bag_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UnreadableFileError, match="no such file"):
        read_bag(tmp_path / "none", {})
    with pytest.raises(UnreadableFileError, match=r"the folder has no metadata\.yaml"):
        read_bag(tmp_path, {})
    (tmp_path / "text.mcap").write_text("no bag")
    with pytest.raises(UnreadableFileError, match=r"text\.mcap is no bag of ROS"):
        read_bag(tmp_path / "text.mcap", {})
    (whole,) = write(tmp_path / "bag", drive_of([0.0, 0.1])).glob("*.mcap")
    content = whole.read_bytes()
    for size in (10, len(content) // 2, len(content) - 10):
        whole.write_bytes(content[:size])
        with pytest.raises(UnreadableFileError, match="bag is no bag of ROS"):
            read_bag(tmp_path / "bag", {})
    paths = write(tmp_path / "paths", [(0.0, "/way", messages.path([(0.0, 0.0)]))])
    with pytest.raises(UnreadableFileError, match=r"messages of /scan, /odom, .*: its topics are /way \(Path\)"):
        read_bag(paths, {})


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda folder: (folder / "contract.json").unlink(), r"contract\.json is no contract of an exported policy"),
        (lambda folder: (folder / "contract.json").write_text("{}"), r"contract\.json .* policy: Field required"),
        (lambda folder: (folder / "policy.onnx").unlink(), r"policy\.onnx is no graph of .*: no such file"),
        (
            lambda folder: (folder / "policy.onnx").write_bytes(b"?"),
            r"policy\.onnx is no graph of .* their hashes differ",
        ),
        (
            lambda folder: (folder / "check.npz").write_bytes(b"?"),
            r"check\.npz .* its hash is not that in the contract",
        ),
    ],
)
def test_a_broken_export_is_refused(exported: RobotExport, tmp_path: Path, damage: Any, words: str) -> None:
    shutil.copytree(exported.folder, tmp_path / "export")
    damage(tmp_path / "export")
    bag = read_bag(write(tmp_path / "bag", drive_of([0.0, 0.1])), {})
    with pytest.raises(UnreadableFileError, match=words):
        check_bag(bag, tmp_path / "export")


def test_the_commands_write_check_and_fit(
    exported: RobotExport, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    written = ("bag", "write", "cluttered_room", "cluttered_room", "drive", "--level", "3")
    assert run(monkeypatch, *written) == 0
    assert "1 /goal_pose" in capsys.readouterr().out
    assert run(monkeypatch, *written) == 1
    assert "drive exists: choose another name for the bag" in capsys.readouterr().err
    assert run(monkeypatch, "bag", "check", "drive", exported.folder) == 0
    said = capsys.readouterr().out
    assert "from the recorded ones: " in said
    assert "age of scans: 0.000 s (median)" in said
    assert Path("drive-check.png").read_bytes().startswith(b"\x89PNG")
    assert run(monkeypatch, "bag", "fit", "drive", "--topic", "scan=/scan") == 0
    assert "disturbances:" in capsys.readouterr().out
    assert run(monkeypatch, "bag", "fit", "drive", "--topic", "scn=/scan") == 1
    assert "no role 'scn' (did you mean 'scan'?)" in capsys.readouterr().err
