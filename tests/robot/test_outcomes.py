"""Exports of the shelf: drivers end levels as their policies do in the package."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import messages
import numpy as np
import pytest
from lone_drivers import LoneDrivers

pytest.importorskip("onnx")
pytest.importorskip("onnxruntime")

from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.protocol.protocol import drive
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy, load_policy
from irsim_gym.evaluation.saved_policies.shelf import card_of
from irsim_gym.robot.export import export_for_robot
from irsim_gym.robot.inputs import measured
from irsim_gym.tasks import Episodes, Outcome

ONE_FILE = ("cluttered_room", "cluttered_room_robot", "dense_room", "crossing", "circle_swap", "random_swap", "parking")
WITH_MAP = (
    "barn",
    "bug_trap",
    "cluttered_room_memory",
    "dense_room_memory",
    "dense_room_memory_robot",
    "jaxnav_single",
    "maze",
    "maze_robot",
    "narrow_door",
)


def levels_of(name: str, n_levels: int) -> tuple[SavedPolicy, Episodes]:
    """Return a policy of the shelf, and as many worlds of its training, without disturbances."""
    policy, card = load_policy(name), card_of(name)
    assert isinstance(policy, SavedPolicy)
    assert card is not None
    own = card.scenario
    parameters = {key: value for key, value in (own.parameters or {}).items() if key != "disturbances"}
    request = ScenarioRequest(own.name, own.task, own.team is not None, parameters)
    played = Perceived(request.episodes(n_levels)).of(policy)
    return policy, Episodes(played.simulation, replace(played.task, predict=False))


class DriverPolicy:
    """Drives all robots by drivers without irsim_gym, which get messages and return velocities."""

    def __init__(self, contract: Path, python: str = sys.executable) -> None:
        self.contract = json.loads(contract.read_text(encoding="utf-8"))
        self.drivers = LoneDrivers(contract.parent, python)
        self.levels: dict[int, int] = {}
        self.times: dict[int, float] = {}
        self.spent: list[float] = []

    def begin(self, episodes: Episodes, worlds: Any, levels: Any) -> None:
        self.levels.update(zip(worlds.tolist(), levels.tolist(), strict=True))
        self.times.update(dict.fromkeys(worlds.tolist(), 0.0))

    def act(self, episodes: Episodes, worlds: Any) -> Any:
        actions, places, said = np.zeros((len(worlds), episodes.n_agents, 2)), [], []
        for agent in range(episodes.n_agents):
            values = measured(episodes, agent)
            for k, w in enumerate(worlds.tolist()):
                if episodes.view.infos["outcome"][w, agent] == Outcome.RUNNING:
                    known = {name: rows[w] for name, rows in values.items()}
                    places.append((k, agent))
                    said.append(((self.levels[w], agent), self.messages(self.times[w], known), self.times[w]))
        for place, (command, spent) in zip(places, self.drivers.tick(said), strict=True):
            actions[place] = self.action(*command)
            self.spent.append(spent)
        for w in worlds.tolist():
            self.times[w] += self.contract["period"]
        return actions

    def messages(self, time: float, known: dict[str, Any]) -> list[tuple[Any, ...]]:
        """Return what a robot tells its driver."""
        scan, (v, w), robot = self.contract["scan"], known["velocity"], self.contract["robot"]
        w = v * np.tan(w) / robot["wheelbase"] if robot["steers"] else w
        said = [("odometry", messages.odometry(time, known["pose"], v, w))]
        if scan:
            view = scan["step"] * (scan["beams"] - 1)
            said.append(("scan", messages.scan(time, known["ranges"], range_max=scan["range_max"], view=view)))
        if time == 0.0:
            said.append(("goal", messages.goal(*np.nan_to_num(known["goal"]))))
        return [*said, ("bodies", known["bodies"].tolist(), time)] if self.contract["bodies"] else said

    def action(self, v: float, w: float, reason: str) -> Any:
        """Return velocities as an action in [-1, 1]."""
        robot = self.contract["robot"]
        assert reason in ("", "arrived")
        if robot["steers"]:
            w = np.arctan(w * robot["wheelbase"] / v) if v else 0.0
        low, high = np.array(robot["low"]), np.array(robot["high"])
        return (np.array([v, w]) - 0.5 * (low + high)) / (0.5 * (high - low))


def outcomes(policy: Any, played: Episodes, n_levels: int) -> Any:
    """Return how the levels end for each robot, ``(n_levels, n_agents)``."""
    ends = np.zeros((n_levels, played.n_agents), int)
    for _, worlds, levels in drive(policy, played, n_levels, "test"):
        ends[levels] = played.view.infos["outcome"][worlds]
    if isinstance(policy, DriverPolicy):
        policy.drivers.close()
    return ends


def test_a_driver_with_a_map_ends_levels_as_the_package_does(tmp_path: Path) -> None:
    export_for_robot("maze", tmp_path / "maze", levels=1)
    policy, played = levels_of("maze", 4)
    driven = DriverPolicy(tmp_path / "maze" / "contract.json")
    np.testing.assert_array_equal(outcomes(driven, played, 4), outcomes(policy, played, 4))


@pytest.mark.slow
@pytest.mark.parametrize("name", [*ONE_FILE, *WITH_MAP])
def test_drivers_end_levels_as_the_package_does(name: str, tmp_path: Path) -> None:
    n_levels = 200
    made = export_for_robot(name, tmp_path / name)
    assert made.difference <= 1e-5
    assert (made.contract.seen_map is not None) == (tmp_path / name / "perceive.py").exists() == (name in WITH_MAP)
    policy, played = levels_of(name, n_levels)
    driven = DriverPolicy(tmp_path / name / "contract.json")
    expected, ends = outcomes(policy, played, n_levels), outcomes(driven, played, n_levels)
    spent = 1e3 * np.array(driven.spent)
    print(
        f"{name}: differ {made.difference:.1e}, package {np.mean((expected == Outcome.SUCCESS).all(axis=1)):.1%}, "
        f"drivers {np.mean((ends == Outcome.SUCCESS).all(axis=1)):.1%}, {np.sum((ends != expected).any(axis=1))} "
        f"other outcomes; a decision: median {np.median(spent):.3f} ms, mean {spent.mean():.3f} ms, "
        f"99 % {np.percentile(spent, 99):.2f} ms, at most {spent.max():.2f} ms"
    )
    np.testing.assert_array_equal(ends, expected)
    assert np.median(spent) < 2.0
