"""The driver's shield: ways to a stop worked out by hand, and that nobody touches what stands still."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import messages
import numpy as np
import onnxruntime
import pytest
from test_driver import FAR, N_BEAMS, PERIOD, feed
from test_outcomes import outcomes

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.requests.episode_setup import make_episodes
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy, load_policy
from irsim_gym.robot.contract import read_export
from irsim_gym.robot.drive import Driver
from irsim_gym.robot.export import export_for_robot
from irsim_gym.robot.inputs import measured
from irsim_gym.tasks import Outcome

ANGLES = np.linspace(-np.pi, np.pi, N_BEAMS)
CONDITIONS: dict[str, dict[str, float]] = {
    "": {},
    "latency:time=0.3": {"latency": 0.3},
    "drive_lag:tau=0.5": {"lag": 0.5},
}


@pytest.fixture(scope="module")
def shielded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("shielded") / "robot"
    export_for_robot("cluttered_room", folder, levels=1, shield="stop_in_time:margin=0.0")
    return folder / "contract.json"


@pytest.fixture(autouse=True)
def one_session_for_all_drivers(monkeypatch: pytest.MonkeyPatch) -> None:
    sessions: dict[bytes, Any] = {}
    load = onnxruntime.InferenceSession

    def session(model: bytes, *given: Any, **how: Any) -> Any:
        return sessions.get(model) or sessions.setdefault(model, load(model, *given, **how))

    monkeypatch.setattr(onnxruntime, "InferenceSession", session)


def driver_of(contract: Path, pilot: Any = None, **form: float) -> Driver:
    """Return a driver with a goal, for a robot of other times, whose network may be another ``pilot``."""
    driver = Driver(contract)
    if driver.shield:
        driver.shield.form.update(form)
    driver.goal(messages.goal(8.0, 1.0))
    if pilot:
        run = lambda names, given: [np.array([pilot()]), *(given[name[:-5]] for name in names[1:])]  # noqa: E731
        driver.session = SimpleNamespace(run=run)
    return driver


def wall(distance: float) -> Any:
    """Return the ranges before a wall ahead."""
    ahead = np.cos(ANGLES) > 0.1
    return np.where(ahead, np.minimum(distance / np.where(ahead, np.cos(ANGLES), 1.0), FAR), FAR)


@pytest.mark.parametrize(
    ("form", "reach"),
    # 1 m/s for a period; with latency for 3 more, and with lag 1 m/s times (1 - exp(-0.2)) and what is left after it.
    [({}, 0.1), ({"latency": 0.3}, 0.4), ({"lag": 0.5}, 0.1), ({"margin": 0.3}, 0.4)],
)
def test_it_slows_down_where_the_way_to_a_stop_is_longer_than_the_gap(
    shielded: Path, form: dict[str, float], reach: float
) -> None:
    for gap, acts in ((reach + 0.002, False), (reach - 0.002, True)):
        driver = driver_of(shielded, lambda: (1.0, 0.4), **form)
        for k in range(4):  # three commands are under way
            v, w, reason = feed(driver, PERIOD * k, wall(5.0))
            assert (v, w, reason) == (1.0, 0.4, "")
        v, w, reason = feed(driver, PERIOD * 4, wall(0.2 + gap))
        assert (reason == "slowed by stop_in_time") == acts
        assert w == 0.4
        assert v == 1.0 if not acts else v < 1.0


def test_turning_on_the_spot_stays_and_nobody_drives_where_the_scanner_does_not_look(shielded: Path) -> None:
    driver = driver_of(shielded, lambda: (1.0, 0.4))
    assert feed(driver, 0.0, wall(0.2))[:2] == (0.0, 0.4)
    behind = driver_of(shielded, lambda: (-0.5, 0.4))
    behind.contract["scan"]["tested"]["field_of_view"] = [2.0, 7.0]
    assert feed(behind, 0.0)[:2] == (-0.5, 0.4)
    assert feed(behind, 0.1, view=np.pi)[:2] == (0.0, 0.4)


def test_behind_the_last_beam_of_a_full_circle_comes_the_first(shielded: Path) -> None:
    """N beams, each in the middle of its share: none looks straight back."""
    for view, v in ((2.0 * np.pi * (1.0 - 1.0 / N_BEAMS), -0.5), (2.0 * np.pi * (1.0 - 2.0 / N_BEAMS), 0.0)):
        driver = driver_of(shielded, lambda: (-0.5, 0.4))
        driver.contract["scan"]["tested"]["field_of_view"] = [6.0, 7.0]
        assert feed(driver, 0.0, view=view)[:2] == (v, 0.4)


def test_an_odometry_between_that_is_not_finite_counts_as_rest(shielded: Path) -> None:
    driver = driver_of(shielded, lambda: (1.0, 0.4), lag=0.5)
    driver.odometry(messages.odometry(0.0, (1.0, 1.0, 0.0), np.nan, np.inf))
    assert feed(driver, 0.0)[:2] == (1.0, 0.4)


def test_lost_beams_hide_no_wall(shielded: Path) -> None:
    ranges = wall(0.25)
    ranges[N_BEAMS // 2 - 10 : N_BEAMS // 2 + 10] = np.nan
    driver = driver_of(shielded, lambda: (1.0, 0.0))
    v, _, reason = feed(driver, 0.0, ranges)
    assert reason == "slowed by stop_in_time"
    assert 0.4 < v < 0.5  # 5 cm in a period


def test_the_contract_says_it_and_the_predictor_learns_of_slower_commands(tmp_path: Path) -> None:
    made = export_for_robot("cluttered_room", tmp_path / "robot", levels=1, predict=0.2, shield="stop_in_time", lag=0.1)
    expected = {"name": "stop_in_time", "margin": 0.0, "latency": 0.2, "lag": 0.1}
    assert made.contract.shield is not None
    assert made.contract.shield.model_dump() == expected
    assert read_export(made.folder)[0] == made.contract
    assert (made.folder / "shield.py").exists()
    assert "| `shield.py` |" in (made.folder / "README.md").read_text(encoding="utf-8")
    driver = driver_of(made.folder / "contract.json", lambda: (1.0, 0.4))
    v, w, reason = feed(driver, 0.0, wall(0.21))
    assert reason == "slowed by stop_in_time"
    assert driver.states["pending"][0].tolist() == [[0.0, 0.0], [v, w]]


@pytest.mark.parametrize(
    ("policy", "shield", "said"),
    [
        ("cluttered_room", "stop_in_tim", "no shield named 'stop_in_tim' (did you mean 'stop_in_time'?)"),
        ("cluttered_room", "velocity_obstacle", "drivers know stop_in_time for discs with the drive diff, omni"),
        ("parking", "stop_in_time", "this is stop_in_time for a rectangle with the drive acker"),
    ],
)
def test_what_drivers_do_not_know_is_refused(policy: str, shield: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(IrsimGymError) as error:
        export_for_robot(policy, tmp_path / "robot", levels=1, shield=shield)
    assert said in str(error.value)
    assert not (tmp_path / "robot").exists()


def pilots(name: str) -> Any:
    """Return what drives in place of the network, if anything."""
    rng = np.random.default_rng(2)
    return {"network": None, "ahead": lambda: (1.0, 0.0), "random": lambda: rng.uniform([0.0, -1.5], [1.0, 1.5])}[name]


def ends(contract: Path, n_levels: int, steps: int, pilot: str, condition: str = "") -> Any:
    """Return how levels end by drivers; a fifth of the scans comes after a tick, and 2 % do not come at all."""
    given = {"disturbances": condition} if condition else None
    played, rng = make_episodes("cluttered_room", n_worlds=n_levels, parameters=given), np.random.default_rng(1)
    played.begin(np.arange(n_levels), np.arange(n_levels), "test")
    drivers = [driver_of(contract, pilots(pilot), **CONDITIONS[condition]) for _ in range(n_levels)]
    for driver, place in zip(drivers, measured(played)["goal"], strict=True):
        driver.goal(messages.goal(*place[:2]))
    low, high = (np.array(drivers[0].contract["robot"][end]) for end in ("low", "high"))
    for k in range(steps):
        values, actions = measured(played), np.zeros((n_levels, 1, 2))
        for w in np.flatnonzero(played.view.infos["outcome"][:, 0] == Outcome.RUNNING):
            driver, sent = drivers[w], PERIOD * k + rng.uniform(0.0, 0.02)
            scan = messages.scan(sent, values["ranges"][w])
            is_late, is_lost = rng.random(2) < (0.2 if k else 0.0, 0.02 if k else 0.0)
            driver.odometry(messages.odometry(sent, values["pose"][w], *values["velocity"][w]))
            if not (is_late or is_lost):
                driver.scan(scan)
            v, turn, _ = driver.tick(PERIOD * k + 0.02)
            if is_late and not is_lost:
                driver.scan(scan)
            actions[w, 0] = (np.array([v, turn]) - 0.5 * (low + high)) / (0.5 * (high - low))
        played.step(actions)
    return played.view.infos["outcome"][:, 0]


def ends_in_the_simulator(n_levels: int, condition: str) -> Any:
    """Return how levels end by the policy with the simulator's shield."""
    parameters = {"shield": "stop_in_time", **({"disturbances": condition} if condition else {})}
    policy = load_policy("cluttered_room")
    assert isinstance(policy, SavedPolicy)
    played = ScenarioRequest("cluttered_room", None, False, parameters).episodes(n_levels)
    return outcomes(policy, Perceived(played).of(policy), n_levels)[:, 0]


@pytest.mark.parametrize("condition", CONDITIONS)
def test_nobody_touches_what_stands_still(shielded: Path, condition: str) -> None:
    assert not np.any(ends(shielded, 8, 70, "ahead", condition) == Outcome.COLLISION)


def test_without_it_they_do(contract: Path) -> None:
    assert np.any(ends(contract, 8, 70, "ahead") == Outcome.COLLISION)


@pytest.mark.slow
@pytest.mark.parametrize("pilot", ["ahead", "random"])
def test_nobody_touches_what_stands_still_in_200_levels(shielded: Path, pilot: str) -> None:
    assert not np.any(ends(shielded, 200, 120, pilot, "latency:time=0.3") == Outcome.COLLISION)


@pytest.mark.parametrize("n_levels", [20, pytest.param(200, marks=pytest.mark.slow)])
@pytest.mark.parametrize("condition", ["", "latency:time=0.3"])
def test_levels_end_as_behind_the_simulators_shield(shielded: Path, n_levels: int, condition: str) -> None:
    driven, simulated = ends(shielded, n_levels, 600, "network", condition), ends_in_the_simulator(n_levels, condition)
    assert not np.any(driven == Outcome.COLLISION)
    assert abs(np.sum(driven == Outcome.SUCCESS) - np.sum(simulated == Outcome.SUCCESS)) <= 0.01 * n_levels
