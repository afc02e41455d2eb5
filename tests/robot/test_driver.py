"""The driver beside an export: what it makes of messages, when it stops, and that it drives like the simulator."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import messages
import numpy as np
import pytest
import yaml

from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.evaluation.requests.episode_setup import make_episodes
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy
from irsim_gym.evaluation.saved_policies.shelf import read_policy, shelf_file
from irsim_gym.robot.drive import Driver
from irsim_gym.robot.inputs import measured
from irsim_gym.scenario.specs.library import find
from irsim_gym.tasks import Episodes, Outcome

PERIOD, N_BEAMS, FAR = 0.1, 180, 6.0
FREE = np.full(N_BEAMS, FAR)


def feed(driver: Driver, time: float, ranges: Any = FREE, place: Any = (1.0, 1.0, 0.0), **how: Any) -> tuple[Any, ...]:
    """Give a scan and an odometry of now, and return what the driver commands."""
    driver.scan(messages.scan(time, ranges, **how))
    driver.odometry(messages.odometry(time, place))
    return driver.tick(time)


@pytest.fixture
def driver(contract: Path) -> Driver:
    made = Driver(contract)
    made.goal(messages.goal(8.0, 1.0))
    return made


def loosened(contract: Path, folder: Path, **tested: Any) -> Path:
    """Return a copy of an export whose contract says that it was tested with other scanners, too."""
    found = json.loads(contract.read_text(encoding="utf-8"))
    found["scan"]["tested"].update(tested)
    for name in ("policy.onnx", "contract.schema.json"):
        shutil.copy(contract.with_name(name), folder)
    (folder / "contract.json").write_text(json.dumps(found), encoding="utf-8")
    return folder / "contract.json"


def test_it_drives_towards_a_goal_ahead(driver: Driver) -> None:
    v, w, reason = feed(driver, 0.0)
    assert reason == ""
    assert v > 0.5
    assert abs(w) < 1.0


@pytest.mark.parametrize("clockwise", [False, True])
@pytest.mark.parametrize("zeros", [False, True])
def test_the_same_scanner_is_taken_beam_by_beam(contract: Path, clockwise: bool, zeros: bool) -> None:
    driver = Driver(contract, no_return="zero" if zeros else "")
    ranges = np.random.default_rng(0).uniform(0.3, 8.0, N_BEAMS).astype(np.float32)
    driver.scan(messages.scan(0.0, ranges, clockwise=clockwise, zeros=zeros))
    np.testing.assert_array_equal(driver.ranges[0], np.where(ranges >= FAR, np.inf, ranges))


def test_of_a_finer_scanner_the_shortest_range_of_a_share_counts(contract: Path, tmp_path: Path) -> None:
    driver = Driver(loosened(contract, tmp_path, beams=[90, 360]))
    ranges = np.full(359, 5.0)
    ranges[178] = 1.0  # one step of 1.0056 degrees to the right of straight ahead, nearest to beam 89
    driver.scan(messages.scan(0.0, ranges))
    assert np.flatnonzero(driver.ranges[0] < 2.0).tolist() == [89]
    assert driver.scan_fault == ""


def test_of_a_coarser_scanner_the_nearest_beam_counts(contract: Path, tmp_path: Path) -> None:
    driver = Driver(loosened(contract, tmp_path, beams=[90, 360]))
    driver.scan(messages.scan(0.0, np.full(90, 5.0)))
    np.testing.assert_array_equal(driver.ranges[0], np.full(N_BEAMS, 5.0))


def test_a_narrow_scanner_sees_nothing_behind(contract: Path, tmp_path: Path) -> None:
    driver = Driver(loosened(contract, tmp_path, beams=[90, 180], field_of_view=[3.0, 6.3]))
    half = messages.scan(0.0, np.full(91, 2.0))
    half.angle_min, half.angle_increment = -0.5 * np.pi, np.pi / 90
    driver.scan(half)
    seen = np.degrees(driver.own["first"] + driver.own["step"] * np.flatnonzero(np.isfinite(driver.ranges[0])))
    assert np.abs(seen).max() < 92.0
    assert len(seen) in (90, 91)


def test_ranges_are_read_as_rep_117_says(driver: Driver) -> None:
    message = messages.scan(0.0, np.full(N_BEAMS, 3.0))
    message.range_min = 0.2
    message.ranges[:4] = [np.nan, -np.inf, 0.1, 7.0]
    driver.scan(message)
    assert driver.ranges[0, :5].tolist() == [np.inf, 0.0, np.inf, np.inf, 3.0]
    assert driver.scan_fault == ""


STOPS: dict[str, tuple[str, Any]] = {
    "scan too old": (r"the scan is 0\.40 s old", lambda driver: stale(driver, "odometry")),
    "odometry too old": (r"the odometry is 0\.40 s old", lambda driver: stale(driver, "scan")),
    "clock": ("the clock jumps back", lambda driver: feed(driver, 0.0)),
    "beams": ("scanner: beams 720, tested from 180 to 180", lambda driver: feed(driver, 1.1, np.ones(720))),
    "range": ("scanner: range_max 12,", lambda driver: feed(driver, 1.1, range_max=12.0)),
    "lost": ("50% of the beams are lost", lambda driver: feed(driver, 1.1, np.tile([np.nan, 2.0], 90))),
    "pose": ("the odometry is not finite", lambda driver: feed(driver, 1.1, place=(np.nan, 1.0, 0.0))),
}


def stale(driver: Driver, fresh: str) -> tuple[Any, ...]:
    if fresh == "odometry":
        driver.odometry(messages.odometry(1.4, (1.0, 1.0, 0.0)))
    else:
        driver.scan(messages.scan(1.4, FREE))
    return driver.tick(1.4)


@pytest.mark.parametrize("name", STOPS)
def test_it_stops_at_once_and_goes_on_after_three_good_scans(driver: Driver, name: str) -> None:
    assert feed(driver, 1.0)[2] == ""
    expected, act = STOPS[name]
    v, w, reason = act(driver)
    assert (v, w) == (0.0, 0.0)
    assert reason.startswith(expected.replace("\\", ""))
    after = driver.now
    later = [feed(driver, after + PERIOD * k)[2] for k in (1, 2, 3)]
    assert later == ["waits for good scans", "waits for good scans", ""]


@pytest.mark.parametrize("fresh", ["odometry", "scan"])
def test_it_stands_three_periods_after_the_first_message_that_fails_to_come(driver: Driver, fresh: str) -> None:
    for k in range(3):
        assert feed(driver, PERIOD * k)[2] == ""
    stood = []
    for k in range(3, 8):
        time = PERIOD * k
        if fresh == "odometry":
            driver.odometry(messages.odometry(time, (1.0, 1.0, 0.0)))
        else:
            driver.scan(messages.scan(time, FREE))
        stood.append(driver.tick(time)[:2] == (0.0, 0.0))
    assert stood.index(True) <= 3
    assert all(stood[3:])


def test_who_stands_has_no_latest_action(driver: Driver) -> None:
    first = driver.states["action"].copy()
    assert feed(driver, 0.0)[2] == ""
    assert np.any(driver.states["action"] != first)
    nearest = driver.states["record_nearest"].copy()
    assert stale(driver, "scan")[2] != ""
    np.testing.assert_array_equal(driver.states["action"], first)
    np.testing.assert_array_equal(driver.states["record_nearest"], nearest)


def test_stamps_of_ros_1_are_read(driver: Driver) -> None:
    scan, odometry = messages.scan(0.0, FREE), messages.odometry(0.0, (1.0, 1.0, 0.0))
    scan.header.stamp = odometry.header.stamp = SimpleNamespace(secs=7, nsecs=500_000_000, to_sec=lambda: 7.5)
    driver.scan(scan)
    driver.odometry(odometry)
    assert driver.tick(7.6)[2] == ""
    assert driver.tick(7.9)[2] == "the scan is 0.40 s old"


def test_what_is_no_fault_needs_no_good_scans(contract: Path) -> None:
    driver = Driver(contract)
    assert feed(driver, 0.0) == (0.0, 0.0, "no goal")
    driver.goal(messages.goal(8.0, 1.0, frame="map"))
    assert feed(driver, 0.1)[2] == "the goal is in frame 'map', the odometry in 'odom'"
    driver.goal(messages.goal(np.inf, 1.0))
    assert feed(driver, 0.2)[2] == "the goal is not finite"
    driver.goal(messages.goal(1.2, 1.0))
    assert feed(driver, 0.3)[2] == "arrived"
    driver.goal(messages.goal(8.0, 1.0))
    assert feed(driver, 0.4)[2] == ""


def test_of_a_path_the_point_two_metres_on_is_the_goal(contract: Path) -> None:
    driver = Driver(contract)
    seen: list[Any] = []
    session = driver.session
    driver.session = SimpleNamespace(
        run=lambda names, given: (seen.append(given["goal"]), session.run(names, given))[1]
    )
    driver.path(messages.path([(0.0, 1.0), (1.0, 1.0), (2.0, 1.0), (3.0, 1.0), (3.0, 2.0), (3.0, 3.0)]))
    assert feed(driver, 0.0, place=(1.1, 1.0, 0.0))[2] == ""
    assert feed(driver, 0.1, place=(3.0, 2.0, 1.5))[2] == ""
    assert [goal[0, :2].tolist() for goal in seen] == [[3.0, 2.0], [3.0, 3.0]]


def test_messages_of_ir_sim_will_do(driver: Driver) -> None:
    msg = pytest.importorskip("irsim.msg")
    step = 2.0 * np.pi / (N_BEAMS - 1)
    head = SimpleNamespace(stamp=2.0, frame_id="laser")
    angles = {"angle_min": -np.pi, "angle_max": np.pi, "angle_increment": step, "range_min": 0.0, "range_max": FAR}
    fields = {name: value for name, value in angles.items() if name in msg.LaserScan.__dataclass_fields__}
    scan = SimpleNamespace(header=head, ranges=FREE.tolist(), **fields)
    assert set(fields) == set(angles)
    driver.scan(scan)
    driver.odometry(messages.odometry(2.0, (1.0, 1.0, 0.0)))
    assert driver.tick(2.0)[2] == ""


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("stop.scan_age", None, "stop.scan_age is null: it must be number. [s]"),
        ("stop.scan_age", ..., "stop.scan_age is missing. [s]"),
        ("stop.lost_beams", True, "stop.lost_beams is true: it must be number. A share."),
        ("scan", 3, "scan is 3: it must be object."),
        ("scan.beams", "180", 'scan.beams is "180": it must be integer.'),
        ("scan.tested.beams", [90], "scan.tested.beams.1 is missing."),
        ("scan.tested.beams", [90, 180, 360], "scan.tested.beams has 3 items: it must have 2."),
        ("scan.mounts", [[0, 0], [0, 0], [0, "x"]], 'scan.mounts.2.1 is "x": it must be number.'),
        ("scan.no_return", "nan", 'scan.no_return is "nan": it must be "inf" or "zero".'),
        ("robot.low", "fast", 'robot.low is "fast": it must be array. Least command, in the units of the output.'),
        ("states.trail.start", ..., "states.trail.start is missing. Before the first step;"),
        ("states.action", ..., "and its policy.onnx differ in inputs or states: action_next"),
        ("inputs.pose", ..., "and its policy.onnx differ in inputs or states: pose"),
        ("hashes", ..., "hashes is missing."),
        ("format", 2, "format is 2: it must be 1."),
    ],
)
def test_a_broken_contract_is_refused(contract: Path, tmp_path: Path, path: str, value: Any, said: str) -> None:
    file = loosened(contract, tmp_path)
    content = json.loads(file.read_text(encoding="utf-8"))
    *way, last = path.split(".")
    place = content
    for name in way:
        place = place[name]
    if value is ...:
        del place[last]
    else:
        place[last] = value
    file.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(ValueError, match=re.escape(said)) as error:
        Driver(file)
    assert str(file) in str(error.value)


def test_a_contract_that_is_no_json_is_refused(contract: Path, tmp_path: Path) -> None:
    file = loosened(contract, tmp_path)
    file.write_text("{", encoding="utf-8")
    with pytest.raises(ValueError, match=r"contract\.json is not JSON: "):
        Driver(file)
    file.write_text("[]", encoding="utf-8")
    with pytest.raises(ValueError, match=r"contract\.json: the contract is \[\]: it must be object"):
        Driver(file)


def test_another_graph_than_the_contracts_is_refused(contract: Path, tmp_path: Path) -> None:
    for name in ("contract.json", "contract.schema.json"):
        shutil.copy(contract.with_name(name), tmp_path)
    (tmp_path / "policy.onnx").write_bytes(contract.with_name("policy.onnx").read_bytes() + b"\n")
    with pytest.raises(ValueError, match="belongs to another policy"):
        Driver(tmp_path / "contract.json")


def hall(n_beams: int, n_worlds: int) -> Episodes:
    """Return worlds of ``cluttered_room`` whose robots have other scanners."""
    data = yaml.safe_load(Path(find("cluttered_room")).read_text(encoding="utf-8"))
    data["robot"][0]["sensors"][0]["number"] = n_beams
    return make_episodes(data, n_worlds=n_worlds)


def outcomes(contract: Path, n_levels: int, n_beams: int, **scanner: Any) -> list[bool]:
    """Return which levels drivers solve; a fifth of the messages comes after a tick, and 2 % do not come at all."""
    played, rng = hall(n_beams, n_levels), np.random.default_rng(1)
    played.begin(np.arange(n_levels), np.arange(n_levels), "test")
    drivers = [Driver(contract, no_return="zero" if scanner.get("zeros") else "") for _ in range(n_levels)]
    for driver, place in zip(drivers, measured(played)["goal"], strict=True):
        driver.goal(messages.goal(*place[:2]))
    low, high = (np.array(drivers[0].contract["robot"][end]) for end in ("low", "high"))
    for k in range(played.task.max_steps):
        values, time, actions = measured(played), PERIOD * k, np.zeros((n_levels, 1, 2))
        running = np.flatnonzero(played.view.infos["outcome"][:, 0] == Outcome.RUNNING)
        if not len(running):
            break
        for w in running:
            driver, sent = drivers[w], time + rng.uniform(0.0, 0.02)
            scan = messages.scan(sent, values["ranges"][w], **scanner)
            odometry = messages.odometry(sent, values["pose"][w], *values["velocity"][w])
            is_late, is_lost = rng.random(2) < (0.2 if k else 0.0, 0.02 if k else 0.0)
            driver.odometry(odometry)
            if not (is_late or is_lost):
                driver.scan(scan)
            v, turn, _ = driver.tick(time + 0.02)
            if is_late and not is_lost:
                driver.scan(scan)
            actions[w, 0] = (np.array([v, turn]) - 0.5 * (low + high)) / (0.5 * (high - low))
        played.step(actions)
    return (played.view.infos["outcome"][:, 0] == Outcome.SUCCESS).tolist()


def test_drivers_solve_levels_of_the_simulator(contract: Path) -> None:
    assert sum(outcomes(contract, 8, N_BEAMS)) >= 7


@pytest.mark.slow
@pytest.mark.parametrize(("n_beams", "scanner"), [(180, {}), (360, {"clockwise": True, "zeros": True})])
def test_drivers_solve_as_many_levels_as_the_simulator(
    contract: Path, tmp_path: Path, n_beams: int, scanner: dict[str, bool]
) -> None:
    """At most one point in a hundred less."""
    policy, n_levels = SavedPolicy(read_policy(shelf_file("cluttered_room"))), 200
    rows = evaluate(policy, Perceived(make_episodes("cluttered_room", n_worlds=n_levels)).of(policy), n_levels, "test")
    expected = sum(row.outcome == "success" for row in rows)
    assert expected >= 0.97 * n_levels
    file = loosened(contract, tmp_path, beams=[180, 360])
    assert sum(outcomes(file, n_levels, n_beams, **scanner)) >= expected - n_levels // 100
