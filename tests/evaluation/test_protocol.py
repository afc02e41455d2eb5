import math
from typing import Any

import numpy as np
import pytest

from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.errors import IrsimGymError, UnknownNameError
from irsim_gym.evaluation.measures.metrics import summarize
from irsim_gym.evaluation.measures.optimum import Optima
from irsim_gym.evaluation.policies.reference_policies import reference_policy
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.tasks import Episodes, Outcome


def worlds(scenario: Any, n_worlds: int, **options: Any) -> Episodes:
    return Worlds(scenario, n_worlds, **options).episodes


@pytest.mark.parametrize("name", ["dash", "random"])
@pytest.mark.parametrize("n_worlds", [1, 5, 16])
def test_results_do_not_depend_on_the_number_of_worlds(name: str, n_worlds: int) -> None:
    expected = evaluate(reference_policy(name), worlds("cluttered_room", 8), 12, "dev")
    assert [row.level for row in expected] == list(range(12))
    assert evaluate(reference_policy(name), worlds("cluttered_room", n_worlds), 12, "dev") == expected


def test_every_row_equals_the_level_played_alone() -> None:
    rows = evaluate(reference_policy("dash"), worlds("crossing", 4), [7, 3, 11], "test")
    alone, policy = worlds("crossing", 1), reference_policy("dash")
    here = np.array([0])
    for row, level in zip(rows, [7, 3, 11], strict=True):
        alone.begin(here, np.array([level]), "test")
        policy.begin(alone, here, np.array([level]))
        path, before, steps = 0.0, alone.simulation.state.pose[0, 0].copy(), 0
        while alone.view.infos["outcome"][0, 0] == Outcome.RUNNING:
            alone.step(policy.act(alone, here)[:, None])
            pose = alone.simulation.state.pose[0, 0]
            path += math.dist(pose[:2], before[:2])
            before, steps = pose.copy(), steps + 1
        assert row.level == level
        assert row.outcome == Outcome(int(alone.view.infos["outcome"][0, 0])).name.lower()
        assert row.steps == steps
        assert row.time == pytest.approx(0.1 * steps)
        assert row.path_length == pytest.approx(path)


def test_a_function_of_the_observation_is_a_policy() -> None:
    episodes = worlds("empty_goal", 3)
    seen: list[tuple[int, ...]] = []

    def stand(observation: np.ndarray) -> np.ndarray:
        seen.append(observation.shape)
        return np.tile(np.array([-1.0, 0.0], np.float32), (len(observation), 1))

    rows = evaluate(stand, episodes, 4, "dev")
    assert {row.outcome for row in rows} == {"timeout"}
    assert {row.steps for row in rows} == {episodes.task.max_steps}
    assert {row.path_length for row in rows} == {0.0}
    assert seen[0] == (3, episodes.n_features)
    assert seen[-1] == (1, episodes.n_features)


def test_progress_is_told() -> None:
    told: list[int] = []
    evaluate(reference_policy("dash"), worlds("empty_goal", 4), 10, "dev", on_episodes=told.append)
    assert sum(told) == 10


@pytest.mark.parametrize(
    ("obstacle", "hit"),
    [
        ({"shape": {"name": "circle", "radius": 0.5}, "state": [5, 2, 0]}, "obstacle"),
        (
            {
                "shape": {"name": "circle", "radius": 0.5},
                "kinematics": {"name": "diff"},
                "behavior": {"name": "dash"},
                "state": [5, 2, 0],
            },
            "moving obstacle",
        ),
    ],
)
def test_collisions_are_told_apart(obstacle: dict[str, Any], hit: str) -> None:
    rows = evaluate(reference_policy("dash"), worlds(lane(obstacle=[obstacle]), 2), 2, "test")
    assert [(row.outcome, row.hit) for row in rows] == [("collision", hit)] * 2
    # From x = 1 to contact at 5 - 0.5 - 0.2 = 4.3 in steps of 0.1 m.
    assert [row.steps for row in rows] == [33, 33]
    assert rows[0].min_clearance == 0.0
    assert rows[0].spl == 0.0


def test_collision_with_a_robot() -> None:
    scenario = lane()
    scenario["robot"].append({"name": "other", "shape": {"name": "circle", "radius": 0.5}, "state": [5, 2, 0]})
    rows = evaluate(reference_policy("dash"), worlds(scenario, 1), 1, "test")
    assert [row.hit for row in rows] == ["robot"]


def test_a_straight_lane_by_hand() -> None:
    row = evaluate(reference_policy("dash"), worlds(lane(), 1), 1, "test")[0]
    # 8 m at 0.1 m a step, until closer than 0.25 m: 78 steps leave 0.2 m.
    assert (row.outcome, row.steps, row.time) == ("success", 78, pytest.approx(7.8))
    assert row.path_length == pytest.approx(7.8)
    assert row.optimum == pytest.approx(8.0)
    assert row.spl == 1.0
    assert row.path_ratio == pytest.approx(7.8 / 8.0)


def test_optima_are_kept_between_evaluations(monkeypatch: pytest.MonkeyPatch) -> None:
    optima, episodes = Optima("dev"), worlds("empty_goal", 2)
    first = evaluate(reference_policy("dash"), episodes, 3, "dev", optima=optima)
    monkeypatch.setattr(Optima, "_measure", None)
    again = evaluate(reference_policy("random"), episodes, 3, "dev", optima=optima)
    assert [row.optimum for row in first] == [row.optimum for row in again]
    with pytest.raises(ValueError, match="split 'dev'"):
        evaluate(reference_policy("random"), episodes, 3, "test", optima=optima)


def test_dash_and_random_on_the_default_room() -> None:
    episodes = worlds("cluttered_room", 64)
    dash, random = (
        summarize(name, evaluate(reference_policy(name), episodes, 64, "dev")) for name in ("dash", "random")
    )
    assert 0.2 < dash.success.value < 0.75
    assert random.success.value < 0.1
    assert dash.collision.count == dash.collision_with["obstacle"].count


def test_mistakes() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'dash'"):
        reference_policy("dsh")
    several = lane()
    several["robot"].append({**several["robot"][0], "name": "second", "state": [1, 3, 0]})
    several["task"] = {"name": "navigation", "agents": "all"}
    with pytest.raises((IrsimGymError, ValueError)):
        evaluate(reference_policy("dash"), worlds(several, 1), 1)


def lane(**more: Any) -> dict[str, Any]:
    """A robot of radius 0.2 m at (1, 2) that faces its goal at (9, 2)."""
    return {
        "world": {"height": 4, "width": 10, "step_time": 0.1},
        "robot": [
            {
                "kinematics": {"name": "diff"},
                "shape": {"name": "circle", "radius": 0.2},
                "state": [1, 2, 0],
                "goal": [9, 2, 0],
                "goal_threshold": 0.25,
                "vel_max": [1, 1],
                "sensors": [{"name": "lidar2d", "number": 36, "angle_range": "2 * pi", "range_max": 6}],
            }
        ],
        **more,
    }


def test_optimum_around_a_disc_by_hand() -> None:
    wall = {"shape": {"name": "circle", "radius": 0.8}, "state": [5, 2, 0]}
    row = evaluate(reference_policy("dash"), worlds(lane(obstacle=[wall]), 1), 1, "test")[0]
    # Around a disc of radius R = 0.8 + 0.2 from 4 m on either side: two tangents and the arc between them.
    tangent = math.sqrt(4.0**2 - 1.0)
    arc = math.pi - 2.0 * math.acos(1.0 / 4.0)
    assert row.optimum == pytest.approx(2.0 * tangent + arc, rel=0.01)
    assert row.optimum >= 2.0 * tangent + arc - 1e-9


def test_optimum_leads_through_all_goals() -> None:
    scenario = lane()
    scenario["robot"][0]["goal"] = [[[9, 2, 0], [9, 3, 0], [1, 3, 0]]]
    row = evaluate(reference_policy("dash"), worlds(scenario, 1), 1, "test")[0]
    assert row.optimum == pytest.approx(8.0 + 1.0 + 8.0)


def test_a_way_that_is_walled_off_has_no_optimum() -> None:
    wall = {"shape": {"name": "linestring", "vertices": [[5, -1], [5, 5]]}}
    row = evaluate(reference_policy("dash"), worlds(lane(obstacle=[wall]), 1), 1, "test")[0]
    assert (row.outcome, row.optimum, row.spl) == ("collision", math.inf, 0.0)
