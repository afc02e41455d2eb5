"""People: who sees whom, who does not yield, speeds that are drawn, and goals that change on the way."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.base import families
from irsim_gym.errors import ScenarioError

OMNI = {"kinematics": {"name": "omni"}}
ALONE, TOGETHER = "behavior", "group_behavior"


@pytest.fixture(autouse=True)
def own_registries(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forget what is registered here: a behaviour that moves aside for each body that it sees."""
    families.load()
    monkeypatch.setattr(families.BEHAVIORS, "_entries", dict(families.BEHAVIORS._entries))

    @ig.behavior("shy", kinematics=["omni"])
    def shy(ego: Any, others: list[Any]) -> list[float]:
        return [1.0, 0.5 * len(others)]


def walk(*, robot: dict[str, Any], kind: str, name: str, **person: Any) -> np.ndarray[Any, Any]:
    """Return the way of a person past a robot that stands."""
    group = {"group": 0} if kind == TOGETHER else {}
    scenario = {
        "world": {"width": 20, "height": 20},
        "robot": {"number": 1, **OMNI, "static": False, **group, **robot},
        "obstacle": {**OMNI, "state": [4, 5.05, 0], "goal": [9, 5, 0], kind: {"name": name}, **group, **person},
    }
    if kind == TOGETHER:
        scenario["robot"][kind] = {"name": name}
        scenario["robot"]["goal"] = robot["state"]
    sim = ig.compile(ig.load_scenario(scenario), check_starts=False)
    sim.reset(seed=0)
    way = []
    for _ in range(12):
        sim.step()
        way.append(sim.state.pose[0, 1].copy())
    return np.array(way)


HERE, FAR = {"state": [6, 5, 0]}, {"state": [19, 19, 0]}


@pytest.mark.parametrize(
    ("kind", "name"), [(ALONE, "rvo"), (ALONE, "sfm"), (ALONE, "shy"), (TOGETHER, "orca"), (TOGETHER, "sfm")]
)
def test_nobody_avoids_whom_it_does_not_see(kind: str, name: str) -> None:
    # A person goes past a robot that it does not see, or that it ignores, as past one that is out of sight.
    far = {**FAR, "seen_by": []} if name == "shy" else FAR  # a function sees all bodies, however far
    alone = walk(robot=far, kind=kind, name=name)
    assert not np.array_equal(walk(robot=HERE, kind=kind, name=name), alone)
    assert not np.array_equal(walk(robot={**HERE, "seen_by": "obstacle"}, kind=kind, name=name), alone)
    for words in ([], "robot", ["robot_0"]):
        assert np.array_equal(walk(robot={**HERE, "seen_by": words}, kind=kind, name=name), alone), words
    assert np.array_equal(walk(robot=HERE, kind=kind, name=name, unyielding=1.0), alone)


def test_lasers_see_what_behaviours_do_not() -> None:
    lidar = {"sensors": [{"name": "lidar2d", "number": 1, "range_max": 5}]}
    bodies = {"robot": {**OMNI, "state": [2, 2, 0], **lidar}, "obstacle": {"state": [4, 2], "seen_by": []}}
    sim = ig.compile(ig.load_scenario(bodies))
    sim.reset(seed=0)
    assert sim.sensors[0].arrays["ranges"][0, 0] == pytest.approx(1.8, abs=1e-6)  # a disc of radius 0.2 m, 2 m ahead


@pytest.mark.parametrize(
    ("drive", "limits", "least"),
    [
        ("diff", {"vel_max": [9, 1.5], "vel_min": [0, -1.5]}, lambda v: [0.0, -1.5]),
        ("diff", {}, lambda v: [-v, -1.0]),
        ("omni", {}, lambda v: [-v, -v]),
        ("omni_angular", {"vel_min": [-0.1, -2, -3]}, lambda v: [-0.1, -v, -3.0]),
    ],
)
def test_levels_draw_speeds(drive: str, limits: dict[str, Any], least: Callable[[float], list[float]]) -> None:
    person = {"kinematics": {"name": drive}, "speed_range": [0.5, 1.5], "goal": [9, 9], "state": [1, 1], **limits}
    sim = ig.compile(ig.load_scenario({"robot": {**person, "behavior": {"name": "dash"}}}), n_worlds=50)
    sim.reset(seed=0)
    fastest, slowest = sim.model.velocity_max[:, 0], sim.model.velocity_min[:, 0]
    n = len(least(1.0))
    n_speeds = 1 if drive == "diff" else 2
    speeds = fastest[:, 0]
    assert 0.5 <= speeds.min() < 0.6
    assert 1.4 < speeds.max() < 1.5
    assert np.array_equal(fastest[:, :n_speeds], np.repeat(speeds[:, None], n_speeds, axis=1))
    assert np.array_equal(slowest[:, :n], np.array([least(v) for v in speeds]))
    assert sim.scenario.bodies[0].vel_max[0] == 1.5
    if drive == "diff" and limits:
        assert (fastest[:, 1] == 1.5).all()


@pytest.mark.parametrize(("kind", "name"), [(ALONE, "sfm"), (ALONE, "rvo"), (TOGETHER, "orca")])
def test_people_walk_at_the_speed_that_was_drawn(kind: str, name: str) -> None:
    person = {**OMNI, "speed_range": [0.6, 1.2], "state": [1, 1], "goal": [9, 7], kind: {"name": name}}
    sim = ig.compile(ig.load_scenario({"robot": person}), n_worlds=4)
    sim.reset(seed=3)
    for _ in range(60):
        sim.step()
    assert np.hypot(*sim.state.twist[:, 0, :2].T) == pytest.approx(sim.model.drawn_speed[:, 0], abs=0.06)


def test_a_share_of_people_does_not_yield() -> None:
    person = {**OMNI, "number": 40, "distribution": {"name": "circle", "radius": 8}, "unyielding": 0.25}
    world = {"width": 20, "height": 20}
    sim = ig.compile(ig.load_scenario({"world": world, "robot": person}), n_worlds=50)
    sim.reset(seed=0)
    assert sim.model.heedless.mean() == pytest.approx(0.25, abs=0.04)  # 4 standard deviations of 2000 draws
    assert len(np.unique(sim.model.heedless.sum(axis=1))) > 5


def wanderer(**goals: Any) -> ig.Simulation:
    behavior = {"name": "dash", "wander": True, "range_low": [2, 1, 0], "range_high": [8, 7, 1], "wander_goals": goals}
    sim = ig.compile(ig.load_scenario({"robot": {**OMNI, "state": [1, 1], "goal": [9, 9, 0], "behavior": behavior}}))
    sim.reset(seed=1)
    return sim


def test_goals_change_at_intervals() -> None:
    sim = wanderer(interval=0.5, keep_first=True, radius=2.0)
    goals = [sim.state.goal[0, 0].copy()]
    for _ in range(16):
        sim.step()
        goals.append(sim.state.goal[0, 0].copy())
    changed = [k for k in range(1, 17) if not np.array_equal(goals[k], goals[k - 1])]
    assert changed == [6, 11, 16]  # the step that begins at 0.5 s, at 1.0 s, at 1.5 s
    assert goals[0].tolist() == [9, 9, 0]
    for k in changed:  # around the middle of the bounds, (5, 4)
        assert np.hypot(goals[k][0] - 5, goals[k][1] - 4) == pytest.approx(2.0)
        assert 0 <= goals[k][2] < 1
    sim.reset_to_start()
    assert sim.state.goal[0, 0].tolist() == [9, 9, 0]


def test_some_give_up_their_goals_and_some_do_not() -> None:
    person = {**OMNI, "number": 30, "state": [1, 1], "unobstructed": True}
    behavior = {"name": "dash", "wander": True, "wander_goals": {"interval": 1.0, "chance": 0.5}}
    sim = ig.compile(ig.load_scenario({"obstacle": {**person, "behavior": behavior}}), n_worlds=20)
    sim.reset(seed=0)
    for _ in range(10):
        sim.step()
    before = sim.state.goal.copy()
    sim.step()
    changed = (sim.state.goal != before).any(axis=2).mean()
    assert changed == pytest.approx(0.5, abs=0.09)  # 4 standard deviations of 600 draws


def test_arrivals_draw_goals_on_the_circle_too() -> None:
    sim = wanderer(radius=3.0, jitter=0.5)
    gaps = []
    for _ in range(200):
        sim.step()
        gaps.append(float(np.hypot(sim.state.goal[0, 0, 0] - 5, sim.state.goal[0, 0, 1] - 4)))
    assert len(set(gaps)) > 2
    assert min(gaps) >= 2.5
    assert max(gaps) <= 3.5


def test_parties_walk_side_by_side() -> None:
    circle = {"name": "circle", "center": [0, 0], "radius": 8, "scatter": True}
    behavior = {
        "name": "orca",
        "wander": True,
        "range_low": [-1, -1, 0],
        "range_high": [1, 1, 0],
        "wander_goals": {"keep_first": True, "radius": 8.0},
    }
    people = {**OMNI, "number": 8, "party": 3, "goal_threshold": 0.5, "distribution": circle}
    world = {"width": 24, "height": 24, "offset": [-12, -12]}
    sim = ig.compile(ig.load_scenario({"world": world, "obstacle": {**people, "group_behavior": behavior}}), 4)
    sim.reset(seed=2)
    abreast = 2 * 0.2 + 0.3  # two radii and the gap
    for first in (0, 3, 6):
        middle = sim.state.pose[:, first, :2]
        assert np.hypot(*middle.T) == pytest.approx(8.0)
        for other in range(first + 1, min(first + 3, 8)):
            offset = sim.state.pose[:, other, :2] - middle
            assert np.hypot(*offset.T) == pytest.approx(abreast)
            assert (offset * middle).sum(axis=1) == pytest.approx(0.0, abs=1e-9)  # beside it, on its way to the centre
    goals = set()
    for _ in range(400):
        sim.step()
        goals.update(np.round(sim.state.goal[0, :, 0], 6).tolist())
    between = sim.state.goal[:, [1, 2, 4, 5, 7], :2] - sim.state.goal[:, [0, 0, 3, 3, 6], :2]
    assert np.hypot(between[..., 0], between[..., 1]) == pytest.approx(abreast)
    assert len(goals) > 16  # all have had more than one


def test_a_bound_of_the_speed_holds_in_any_direction() -> None:
    drive = {"name": "omni", "bound": "speed"}
    sim = ig.compile(
        ig.load_scenario({"robot": {"kinematics": drive, "state": [1, 1], "vel_max": [1.5, 1.5]}}), agents=[0]
    )
    sim.reset(seed=0)
    sim.step(np.array([[[1.5, 0.9]]]))
    velocity = sim.state.velocity[0, 0, :2]
    assert np.hypot(*velocity) == pytest.approx(1.5)
    assert velocity[1] / velocity[0] == pytest.approx(0.6)


def test_circular_forces_are_those_of_helbing_and_molnar() -> None:
    # At rest, 1 m apart, radii 0.2: pull (1 - 0) / 0.5 s to the goal, push 3 exp((0.4 - 1) / 0.7) along -x; dt 0.1 s.
    force = {
        "name": "sfm",
        "interaction": "circular",
        "interaction_range": 0.7,
        "force_factor_social": 3.0,
        "vmax": 1.0,
    }
    robot = {**OMNI, "state": [1, 1], "goal": [1, 9], "behavior": force}
    sim = ig.compile(ig.load_scenario({"robot": robot, "obstacle": {"state": [2, 1]}}))
    sim.reset(seed=0)
    sim.step()
    push = 3.0 * np.exp((0.4 - 1.0) / 0.7)
    assert sim.state.velocity[0, 0, :2] == pytest.approx([-0.1 * push, 0.1 * 1.0 / 0.5])


BAD = {
    "obstacle: {seen_by: [robots]}": "no role, body or group named 'robots' (did you mean 'robot'",
    "obstacle: {seen_by: 3}": "must be a list of texts",
    "obstacle: {kinematics: {name: omni}, speed_range: [2, 1]}": "must be [low, high] with 0 <= low <= high",
    "obstacle: {kinematics: {name: omni}, unyielding: 1.5}": "must be <= 1",
    "obstacle: {behavior: {name: dash, wander_goals: {radius: 2}}, kinematics: {name: omni}}": "needs wander: true",
    "obstacle: {behavior: {name: dash, wander: true, wander_goals: {jitter: 1}}, kinematics: {name: omni}}": (
        "needs a radius"
    ),
    "obstacle: {behavior: {name: dash, wander: true, wander_goals: {chance: 0.5}}, kinematics: {name: omni}}": (
        "needs an interval"
    ),
    "obstacle: {behavior: {name: dash, wander: true, wander_goals: {intervall: 5}}, kinematics: {name: omni}}": (
        "interval"
    ),
}


@pytest.mark.parametrize("text", BAD)
def test_what_cannot_be_is_told_with_its_line(text: str, tmp_path: Any) -> None:
    file = tmp_path / "people.yaml"
    file.write_text(f"robot: {{kinematics: {{name: diff}}}}\n{text}\n", encoding="utf-8")
    with pytest.raises(ScenarioError) as refused:
        ig.load_scenario(file)
    assert BAD[text] in str(refused.value)
    assert "people.yaml:2" in str(refused.value) or ":2" in str(refused.value)
