"""``irsim-gym fit``: other robots are played as the driver drives them, and the contract notes those that fit."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import messages
import numpy as np
import pytest
from command_line import run

from irsim_gym.base.errors import IrsimGymError, UnreadableFileError
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.robot import fitting as fit
from irsim_gym.robot.contract import Results, RobotContract, read_export
from irsim_gym.robot.drive import Driver
from irsim_gym.robot.fitting import Variant, own_values, read_values, told, usual, widened
from irsim_gym.robot.graph_policy import rescaled
from irsim_gym.robot.inputs import measured
from irsim_gym.robot.scans import as_beams

TURN = 2.0 * np.pi
OWN = {"beams": 360, "first": -np.pi, "step": TURN / 360, "mount": (0.0, 0.0, 0.0)}
"""Beams of a whole turn, each looking another way: beam 180 looks ahead."""


@pytest.fixture
def robot(contract: Path, tmp_path: Path) -> Path:
    """A copy of an export."""
    return Path(shutil.copytree(contract.parent, tmp_path / "robot"))


def content(folder: Path) -> RobotContract:
    return read_export(folder)[0]


def solved(share: float) -> Results:
    return Results(success=share, low=0.0, high=1.0, levels=200, split="test")


def test_a_policy_is_played_with_other_scanners_and_the_contract_notes_those_that_fit(robot: Path) -> None:
    half = fit.own_values(content(robot))["field_of_view"] / 2
    variants = [
        Variant("some", {"beams": 90, "field_of_view": 1.5 * np.pi}),
        Variant("front", {"field_of_view": half / 2}),
    ]
    own, some, front = fit.fit(robot, variants, levels=60)
    assert (own.fits, some.fits, front.fits) == (True, True, False)
    assert own.results.success >= some.results.success - fit.MOST_LOST
    assert front.results.success < 0.9
    tested = content(robot).scan.tested
    assert tested.beams == (90, 180)
    assert tested.range_max == (6.0, 6.0)
    assert tested.field_of_view == pytest.approx((1.5 * np.pi, TURN))


def test_the_driver_refuses_what_was_not_tested_and_notes_what_was(robot: Path) -> None:
    file = robot / "contract.json"
    wider = widened(content(robot), [replace(Variant("a", {**own_values(content(robot)), "beams": 360}), fits=True)])
    file.write_text(wider.model_dump_json(by_alias=True), encoding="utf-8")
    driver = Driver(file)
    driver.scan(messages.scan(0.0, np.full(360, 5.0)))
    assert (driver.scan_fault, driver.note) == ("", "scanner: beams 360, tested from 180 to 360, trained with 180")
    driver.scan(messages.scan(0.1, np.full(180, 5.0)))
    assert driver.note == ""
    driver.scan(messages.scan(0.2, np.full(400, 5.0)))
    assert driver.scan_fault == "scanner: beams 400, tested from 180 to 360"


def test_tested_values_hold_no_robot_that_does_not_fit(contract: Path) -> None:
    before = content(contract.parent)
    own = own_values(before)
    few, short = {**own, "beams": 90}, {**own, "range_max": 3.0}
    both = {**few, **short}
    found = [Variant("", own, fits=True), Variant("", few, fits=True), Variant("", short, fits=True)]
    assert widened(before, found).scan.tested.range_max == (3.0, 6.0)
    after = widened(before, [*found, Variant("", both, fits=False)])
    assert (after.scan.tested.beams, after.scan.tested.range_max) == ((90, 180), (6.0, 6.0))
    after = widened(before, [Variant("", {**own, "x": 0.2, "turn": 1.0, "radius": 0.1, "period": 0.2}, fits=True)])
    assert after.scan.mounts == ((0.0, 0.2), (0.0, 0.0), (0.0, 1.0))
    assert (after.robot.radii, after.periods) == ((0.1, 0.2), (0.1, 0.2))


def test_the_driver_refuses_a_mount_that_was_not_tested(robot: Path) -> None:
    driver = Driver(robot / "contract.json", mount=(0.0, 0.0, 0.5 * np.pi))
    driver.scan(messages.scan(0.0, np.full(180, 5.0)))
    assert driver.scan_fault == "scanner: turn 1.571, tested from 0 to 0"


def test_a_scan_is_seen_from_where_the_contract_has_the_scanner() -> None:
    ranges = np.full((2, 4), np.inf)
    ranges[:, 0], ranges[1, 1] = 1.0, 2.0  # it looks ahead, to the left, behind, to the right
    quarter = (0.0, 0.5 * np.pi)
    ahead = as_beams(ranges, quarter, (0.5, 0.0, 0.0), OWN)
    assert ahead[0, 180] == pytest.approx(1.5)
    aside = round(np.degrees(np.arctan2(2.0, 0.5)))
    assert ahead[1, 180 + aside] == pytest.approx(np.hypot(2.0, 0.5))
    turned = as_beams(ranges, quarter, (0.0, 0.0, 0.5 * np.pi), OWN)
    assert (turned[1, 270], turned[1, 0]) == (1.0, 2.0)
    place = (0.5, 0.0, 0.5 * np.pi)  # the same for a contract whose scanner is there
    np.testing.assert_allclose(
        as_beams(ranges, quarter, place, {**OWN, "mount": place}), as_beams(ranges, quarter, OWN["mount"], OWN)
    )


def test_what_is_played_is_what_the_driver_makes_of_messages(contract: Path) -> None:
    before = content(contract.parent)
    asked, mount = ScenarioRequest("cluttered_room"), {"x": 0.1, "y": -0.05, "turn": 1.0}
    values = {**own_values(before), "beams": 300, "range_max": 3.5, **mount}
    scenario = fit._changed(asked.load(), asked.episodes(1), Variant("", values))
    played = replace(asked, scenario=scenario).episodes(3)
    played.begin(np.arange(3), np.arange(3), "test")
    driver = Driver(contract, mount=tuple(mount.values()))
    together = fit._measured(before, played, 0)["ranges"]
    for w, ranges in enumerate(measured(played)["ranges"]):
        driver.scan(messages.scan(0.0, ranges, range_max=3.5))
        assert np.isfinite(driver.ranges).any()
        np.testing.assert_allclose(driver.ranges[0], together[w], rtol=1e-6)


@pytest.mark.parametrize("mount", [(0.0, 0.0, 0.0), (0.1, -0.05, 1.0)])
@pytest.mark.parametrize("size", [90, 700])
def test_a_batch_of_scans_is_read_like_each_alone(size: int, mount: tuple[float, float, float]) -> None:
    ranges = np.random.default_rng(0).uniform(0.2, 8.0, (5, size))
    ranges[ranges > 6.0] = np.inf
    angles = (-2.0, 4.0 / size)
    together = as_beams(ranges, angles, mount, OWN)
    for k in range(5):
        np.testing.assert_array_equal(together[k], as_beams(ranges[k : k + 1], angles, mount, OWN)[0])


def test_commands_beyond_the_limits_of_another_robot_are_clipped() -> None:
    before, now = (np.array([0.0, -1.5]), np.array([1.0, 1.5])), (np.array([-0.5, -3.0]), np.array([0.5, 3.0]))
    actions = rescaled(np.array([[-0.2, 1.0], [1.0, 0.0]]), before, now)  # 0.4 m/s and 1.5 rad/s; 1 m/s and 0 rad/s
    np.testing.assert_allclose(actions, [[0.8, 0.5], [1.0, 0.0]])


def test_what_options_say() -> None:
    assert read_values("--scanner", "beams=360, fov=270deg,range=3.5", fit.SCANNER) == {
        "beams": 360,
        "field_of_view": pytest.approx(1.5 * np.pi),
        "range_max": 3.5,
    }
    assert read_values("--mount", "turn=pi/2", fit.MOUNT) == {"turn": pytest.approx(0.5 * np.pi)}
    for text in ("beam=360", "beams", "beams=many", "", "beams=0", "range=-1"):
        with pytest.raises(
            IrsimGymError, match=r"--scanner: write numbers for beams, range, fov, such as beams=\.\.\."
        ):
            read_values("--scanner", text, fit.SCANNER)


def test_without_options_scanners_and_periods_are_played(contract: Path) -> None:
    assert [told(variant.values) for variant in usual(own_values(content(contract.parent)))] == [
        "beams 90",
        "beams 360",
        "range_max 3.5",
        "range_max 12",
        "field_of_view 270 deg",
        "beams 90, range_max 3.5, field_of_view 270 deg",
        "period 0.05",
        "period 0.2",
    ]
    assert len(usual({"period": 0.1, "radius": 0.2})) == 2


def test_the_command_prints_a_table_and_takes_presets(
    robot: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shares = iter([0.99, 0.97, 0.969])
    monkeypatch.setattr(fit, "results_of", lambda *played: solved(next(shares)))
    assert run(monkeypatch, "fit", robot, "--radius", "0.15", "--robot", "turtlebot4") == 0
    shown = capsys.readouterr().out
    rows = [[cell.strip() for cell in line.split("│")[1:4]] for line in shown.splitlines() if line.startswith("│")]
    assert [(row[0], row[2]) for row in rows] == [
        ("as in the contract", "yes"),
        ("radius 0.15", "yes"),
        ("turtlebot4", "no"),
    ]
    assert content(robot).robot.radii == (0.15, 0.2)
    assert content(robot).scan.tested.beams == (180, 180)


def test_a_preset_brings_its_footprint_its_limits_and_its_period(robot: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Any] = []
    monkeypatch.setattr(fit, "results_of", lambda policy, played, levels: (seen.append(played), solved(1.0))[1])
    fit.fit(robot, [fit.preset_variant("turtlebot4")], levels=2)
    model, scenario, task = seen[1].simulation.model, seen[1].simulation.scenario, seen[1].task
    assert model.reach[0, 0] == pytest.approx(0.171)
    assert model.velocity_max[0, 0, :2].tolist() == [0.306, 1.9]
    assert model.acceleration_limit[0, 0, :2].tolist() == [0.9, 7.725]
    assert scenario.world.step_time == 0.18
    assert scenario.bodies[0].sensors[0].offset == pytest.approx((-0.04, 0.0, 0.5 * np.pi))
    assert task.max_steps == round(300 * 0.1 / 0.18 / 0.306)  # a slow robot gets more time
    assert content(robot).robot.radii == pytest.approx((0.171, 0.2))
    assert content(robot).periods == (0.1, 0.18)


@pytest.mark.parametrize(
    ("variant", "words"),
    [
        (lambda: fit.preset_variant("go2"), "cluttered_room drives 'diff', go2 is 'omni_angular'"),
        (lambda: fit.preset_variant("turtlebot"), "no robot named 'turtlebot' .did you mean 'turtlebot4'"),
    ],
)
def test_a_robot_that_the_policy_cannot_drive_is_refused(
    robot: Path, variant: Callable[[], Variant], words: str
) -> None:
    with pytest.raises(IrsimGymError, match=words):
        fit.fit(robot, [variant()], levels=1)


def change(folder: Path, act: Callable[[Any], None]) -> None:
    found = json.loads((folder / "contract.json").read_text(encoding="utf-8"))
    act(found)
    (folder / "contract.json").write_text(json.dumps(found), encoding="utf-8")


def test_a_predictor_keeps_its_period(robot: Path) -> None:
    change(robot, lambda found: found.update(predict=0.2))
    with pytest.raises(IrsimGymError, match=r"made for a period of 0\.1 s: export with --period"):
        fit.fit(robot, [Variant("", {"period": 0.2})], levels=1)


def test_a_scenario_that_has_changed_since_the_export_is_refused(robot: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fit, "scenario_hash", lambda asked: "0" * 64)
    with pytest.raises(
        IrsimGymError, match=r"cluttered_room has changed since .* was written: export the policy again"
    ):
        fit.fit(robot, [], levels=1)


def rename(folder: Path, name: str) -> None:
    """Let a contract say that its graph was made of something else."""
    change(folder, lambda found: found["hashes"].update({name: "0" * 64}))


BROKEN: dict[str, tuple[Callable[[Path], object], str]] = {
    "no json": (lambda folder: (folder / "contract.json").write_text("{"), "contract.json.*"),
    "no contract": (lambda folder: (folder / "contract.json").write_text("{}"), "contract.json.*hashes"),
    "a list": (lambda folder: (folder / "contract.json").write_text("[]"), "contract.json"),
    "a newer format": (lambda folder: change(folder, lambda found: found.update(format=2)), "contract.json.*format"),
    "no states": (lambda folder: change(folder, lambda found: found.pop("states")), "contract.json.*states"),
    "another graph": (lambda folder: (folder / "policy.onnx").write_bytes(b"\n"), "policy.onnx.*hash"),
    "another policy": (lambda folder: rename(folder, "policy"), "policy.onnx.*made of another policy"),
    "another task": (lambda folder: rename(folder, "scenario"), "policy.onnx.*made of another scenario"),
    "no graph": (lambda folder: (folder / "policy.onnx").unlink(), "policy.onnx.*[Nn]o such file"),
    "no contract file": (lambda folder: (folder / "contract.json").unlink(), "contract.json.*[Nn]o such file"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_export_is_one_error_that_names_the_file(robot: Path, name: str) -> None:
    act, words = BROKEN[name]
    act(robot)
    with pytest.raises(UnreadableFileError, match=words):
        read_export(robot)
    with pytest.raises((ValueError, OSError), match=r"contract\.json|policy\.onnx"):
        Driver(robot / "contract.json")


def test_another_check_is_refused(robot: Path) -> None:
    (robot / "check.npz").write_bytes(b"")
    with pytest.raises(UnreadableFileError, match=r"check\.npz is no check of .*: its hash is not that"):
        read_export(robot)
