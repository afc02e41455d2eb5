"""Policies that see other bodies, on a robot with a tracker: twins, export, driver, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import run
from test_outcomes import DriverPolicy, levels_of, outcomes
from test_twins import CAR, DIFF, N_WORLDS, OMNI, TOLERANCE, Twin, differences

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.robot.drive import Driver
from irsim_gym.robot.export import RobotExport, export_for_robot
from irsim_gym.robot.inputs import tracked
from irsim_gym.scenario import load_scenario
from irsim_gym.simulator.engine import compile
from irsim_gym.tasks import Episodes, load_task

NEAREST, TIMES = {"name": "nearest_bodies", "count": 12}, {"name": "time_to_collision", "speeds": 2}
NOBODY = np.full((1, 5), np.nan)


def crowd(robot: dict[str, Any], observations: list[Any], obstacles: list[Any], shift: float) -> Episodes:
    """Return a robot among bodies that it passes through, in a world of 12 m whose corner is at ``shift`` [m]."""
    world = {"width": 12, "height": 12, "offset": [shift, shift], "step_time": 0.1, "collision_mode": "unobstructed"}
    scenario = load_scenario({"world": world, "robot": robot, "obstacle": obstacles})
    task = load_task(scenario, {"name": "blank", "observations": observations, "max_steps": 10_000})
    played = Episodes(compile(scenario, N_WORLDS, agents=task.agents), task)
    played.begin(np.arange(N_WORLDS), np.arange(N_WORLDS))
    return played


def wanderers(robot: dict[str, Any], shift: float, **options: Any) -> Episodes:
    """Return a robot among twelve discs that move and four that stand."""
    span = {"range_low": [shift + 0.5, shift + 0.5, -3.1], "range_high": [shift + 11, shift + 11, 3.1]}
    place = {"name": "random", **span}
    moving = {"kinematics": {"name": "diff"}, "behavior": {"name": "dash", "wander": True, **span}, "vel_max": [1, 3]}
    small, large = ({"shape": {"name": "circle", "radius": size}, "distribution": place} for size in (0.2, 0.4))
    obstacles = [{"number": 12, **small, **moving}, {"number": 4, **large}]
    kinds = [{**kind, **options} for kind in (NEAREST, TIMES)]
    return crowd({**robot, "distribution": place}, kinds, obstacles, shift)


CASES = [(DIFF, 0.0, {}), (DIFF, 0.0, {"moving": True}), (CAR, 1e5, {"range": 3.0}), (OMNI, -1e5, {})]


@pytest.mark.parametrize(("robot", "shift", "options"), CASES, ids=["diff", "only moving", "far car", "far omni"])
def test_twins_equal_their_kernels_among_many(robot: dict[str, Any], shift: float, options: dict[str, Any]) -> None:
    assert max(differences(wanderers(robot, shift, **options), 40)) < TOLERANCE


@pytest.mark.slow
@pytest.mark.parametrize(("robot", "shift", "options"), CASES, ids=["diff", "only moving", "far car", "far omni"])
def test_twins_equal_their_kernels_ten_thousand_times(
    robot: dict[str, Any], shift: float, options: dict[str, Any]
) -> None:
    assert max(differences(wanderers(robot, shift, **options), 1250)) < TOLERANCE


def test_equal_gaps_keep_the_order_of_the_rows_and_absent_rows_count_for_nothing() -> None:
    """Four discs at the same gap, of which three are seen, and one that holds the robot's origin."""
    around = {"shape": {"name": "circle", "radius": 0.25}, "number": 4}
    states = [[8, 6, 0], [4, 6, 0], [6, 8, 0], [6, 4, 0]]
    within = {"shape": {"name": "circle", "radius": 1.0}, "state": [6.5, 6, 0]}
    robot = {**DIFF, "state": [6, 6, 0.5], "goal": [9, 9, 0]}
    played = crowd(robot, [{**NEAREST, "count": 4}, TIMES], [{**around, "state": states}, within], 0.0)
    seen, rows = Twin(played).see(), tracked(played)
    assert np.abs(seen - played.view.observation[:, 0]).max() < TOLERANCE
    bearings = np.arctan2(seen[0, 1:20:5], seen[0, 0:20:5])
    np.testing.assert_allclose(np.unwrap(bearings + 0.5), [np.pi, 0.0, np.pi, 0.5 * np.pi], atol=1e-6)
    holes = np.full((N_WORLDS, 11, 5), np.nan)
    holes[:, 1::2] = rows
    np.testing.assert_array_equal(Twin(played).see(bodies=holes), seen)
    turned = Twin(played).see(bodies=rows[:, ::-1])
    assert np.abs(turned[:, :20] - seen[:, :20]).max() > 0.5


def test_nobody_around_reads_as_nobody() -> None:
    played = crowd({**DIFF, "state": [6, 6, 0], "goal": [9, 9, 0]}, [NEAREST, TIMES], [], 0.0)
    for rows in (np.zeros((N_WORLDS, 0, 5)), np.full((N_WORLDS, 3, 5), np.nan)):
        assert np.abs(Twin(played).see(bodies=rows) - played.view.observation[:, 0]).max() < TOLERANCE


def test_a_tracker_gives_discs_and_no_walls() -> None:
    box = {"shape": {"name": "rectangle", "length": 0.6, "width": 0.8}}
    moving = {**box, "kinematics": {"name": "diff"}, "behavior": {"name": "dash"}, "goal": [9, 9, 0]}
    discs = {"shape": {"name": "circle", "radius": 0.3}, "state": [3, 4, 0]}
    obstacles = [{**moving, "state": [2, 2, 0]}, {**box, "state": [8, 8, 0]}, discs]
    rows = tracked(crowd({**DIFF, "state": [6, 6, 0], "goal": [9, 9, 0]}, [NEAREST], obstacles, 0.0))
    np.testing.assert_allclose(rows[0, :, [0, 1, 4]].T, [[2.0, 2.0, 0.5], [3.0, 4.0, 0.3]])


@pytest.fixture(scope="module")
def rvo(tmp_path_factory: pytest.TempPathFactory) -> RobotExport:
    return export_for_robot("rl_rvo", tmp_path_factory.mktemp("tracked") / "rl_rvo", levels=2, bodies="tracked")


def test_the_contract_says_how_many_bodies_were_there(rvo: RobotExport) -> None:
    contract = rvo.contract
    assert contract.bodies is not None
    assert contract.bodies.model_dump() == {"source": "tracked", "most": 19, "moving": False}
    assert contract.inputs["bodies"].shape == ("batch", "n_bodies", 5)
    assert contract.stop.bodies_age == pytest.approx(3 * contract.period)
    assert rvo.difference <= 1e-5


def test_drivers_with_a_tracker_end_levels_as_the_package_does(rvo: RobotExport) -> None:
    policy, played = levels_of("rl_rvo", 2)
    driven = DriverPolicy(rvo.folder / "contract.json")
    np.testing.assert_array_equal(outcomes(driven, played, 2), outcomes(policy, played, 2))


def test_the_driver_stops_without_bodies_of_now(rvo: RobotExport) -> None:
    import messages

    driver, scan = Driver(rvo.folder / "contract.json"), rvo.contract.scan
    assert scan is not None
    view = scan.step * (scan.beams - 1)
    driver.goal(messages.goal(8.0, 1.0))

    def tick(time: float, rows: Any = None) -> str:
        free = np.full(scan.beams, scan.range_max)
        driver.scan(messages.scan(time, free, range_max=scan.range_max, view=view))
        driver.odometry(messages.odometry(time, (1.0, 1.0, 0.0)))
        if rows is not None:
            driver.bodies(rows, time)
        return str(driver.tick(time)[-1])

    assert tick(0.0) == "no bodies yet"
    assert [tick(0.1 * k, []) for k in (1, 2, 3)][-1] == ""
    assert tick(0.4, [[3.0, 1.0, -0.5, 0.0, 0.2], [np.nan] * 5]) == ""
    assert [tick(0.1 * k) for k in (5, 6)] == ["", ""]
    assert tick(0.8) == "the bodies are 0.40 s old"
    assert [tick(0.1 * k, NOBODY) for k in (9, 10, 11)] == ["waits for good scans", "waits for good scans", ""]
    assert tick(1.2, [[3.0, 1.0, np.nan, 0.0, 0.2]]) == "the bodies are not finite"
    with pytest.raises(ValueError, match="cannot reshape"):
        driver.bodies(np.zeros((5, 4)), 1.3)


def test_what_is_no_disc_in_the_training_is_played_as_a_disc_or_left_out(tmp_path: Path) -> None:
    """The walls of crossing_10 are bodies to its policy: commands are compared without, the result is with them."""
    made = export_for_robot("crossing_10", tmp_path / "out", levels=2, bodies="tracked")
    assert made.difference <= 1e-5
    assert made.contract.bodies is not None
    assert made.contract.bodies.most == 13
    assert made.contract.results.levels == 2


@pytest.mark.parametrize(
    ("policy", "how", "words"),
    [
        ("crowd_nav", {}, ["'nearest_bodies' needs bodies", "add '--bodies tracked'"]),
        ("crowd_nav", {"bodies": "seen"}, ["--bodies: there is no 'seen': write tracked"]),
        ("crowd_nav", {"bodies": "tracked", "node": "ros2"}, ["--node: the nodes hear no tracker"]),
        ("jaxnav_four", {"bodies": "tracked"}, ["'neighbors' needs bodies", "messages"]),
    ],
)
def test_what_a_tracker_cannot_give_is_refused_by_name(
    policy: str, how: dict[str, Any], words: list[str], tmp_path: Path
) -> None:
    with pytest.raises(IrsimGymError) as error:
        export_for_robot(policy, tmp_path / "out", levels=1, **how)
    assert all(word in str(error.value) for word in words)
    assert not (tmp_path / "out").exists()


def test_the_command_takes_the_option(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "robot"
    assert run(monkeypatch, "export", "crowd_nav", "--out", out, "--levels", "2", "--bodies", "tracked") == 0
    assert "needs odometry, bodies" in capsys.readouterr().out
    assert "Driver.bodies" in (out / "README.md").read_text(encoding="utf-8")
