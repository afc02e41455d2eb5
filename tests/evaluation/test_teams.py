"""Teams of scripted robots in a small world where everything happens that can become of an agent."""

from typing import Any

import numpy as np
import pytest

from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.measures.optimum import Optima
from irsim_gym.evaluation.measures.team_metrics import AgentRow, summarize_team
from irsim_gym.evaluation.policies.reference_policies import reference_policy
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.evaluation.protocol.teams import evaluate_team
from irsim_gym.tasks import Episodes

PI = 3.141592653589793
LANES: dict[str, tuple[list[float], list[float], list[float]]] = {
    # Start, goal, and the action: forward speed and turn rate as shares of 1 m/s and 1 rad/s.
    "arrives": ([2, 1, 0], [5, 1, 0], [1, 0]),
    "hits_disc": ([2, 3, 0], [9, 3, 0], [1, 0]),
    "meets_left": ([2, 5, 0], [9, 5, 0], [1, 0]),
    "meets_right": ([5.1, 5, PI], [1, 5, 0], [1, 0]),
    "strays": ([18.05, 7, 0], [9, 7, 0], [1, 0]),
    "waits": ([2, 9, 0], [5, 9, 0], [0, 0]),
    "circles": ([2, 11, 0], [5, 11, 0], [0.5, 1]),
    "hits_walker": ([2, 13, 0], [9, 13, 0], [1, 0]),
}
DISC = {"shape": {"name": "circle", "radius": 0.5}, "state": [4.05, 3, 0]}
WALKER = {
    "shape": {"name": "circle", "radius": 0.2},
    "kinematics": {"name": "diff"},
    "behavior": {"name": "dash"},
    "state": [6.1, 13, PI],
    "goal": [0, 13, 0],
    "vel_max": [1, 1],
}


def lanes(**task: Any) -> dict[str, Any]:
    robots = [
        {
            "name": name,
            "kinematics": {"name": "diff"},
            "shape": {"name": "circle", "radius": 0.2},
            "state": state,
            "goal": goal,
            "goal_threshold": 0.25,
            "vel_min": [-1, -1],
            "vel_max": [1, 1],
        }
        for name, (state, goal, _) in LANES.items()
    ]
    return {
        "world": {"height": 15, "width": 20, "step_time": 0.1},
        "robot": robots,
        "obstacle": [DISC, WALKER],
        "task": {"max_steps": 60, **task},
    }


def team(scenario: Any, n_worlds: int = 1, **options: Any) -> Episodes:
    return Worlds(scenario, n_worlds, team=True, **options).episodes


class Script:
    """Gives each agent its own action, always the same."""

    def begin(self, episodes: Episodes, worlds: np.ndarray, levels: np.ndarray) -> None:
        assert worlds.shape == levels.shape

    def act(self, episodes: Episodes, worlds: np.ndarray) -> np.ndarray:
        return np.tile([action for _, _, action in LANES.values()], (len(worlds), 1, 1))


def played(**task: Any) -> dict[str, AgentRow]:
    rows = evaluate_team(Script(), team(lanes(**task), 2), 1)
    assert [row.level for row in rows] == [0]
    return {row.agent: row for row in rows[0].agents}


def test_every_outcome_by_hand() -> None:
    found = played()
    assert list(found) == list(LANES)
    ends = {name: (row.episode.outcome, row.episode.hit, row.episode.steps) for name, row in found.items()}
    assert ends == {
        # 3 m in steps of 0.1 m until nearer than 0.25 m.
        "arrives": ("success", "", 28),
        # Contact after 4.05 - 0.5 - 2 - 0.2 = 1.35 m.
        "hits_disc": ("collision", "obstacle", 14),
        # Both drive: contact after (3.1 - 0.4) / 2 = 1.35 m.
        "meets_left": ("collision", "robot", 14),
        "meets_right": ("collision", "robot", 14),
        # Out of the world by more than its radius after 20 + 0.2 - 18.05 = 2.15 m.
        "strays": ("left_world", "", 22),
        "waits": ("timeout", "", 60),
        "circles": ("timeout", "", 60),
        # Both move: contact after (4.1 - 0.4) / 2 = 1.85 m.
        "hits_walker": ("collision", "moving obstacle", 19),
    }
    assert {name for name, row in found.items() if row.deadlocked} == {"waits"}
    first = found["arrives"]
    assert first.episode.path_length == pytest.approx(2.8)
    assert (first.straight_distance, first.top_speed) == (3.0, 1.0)
    assert first.episode.optimum == pytest.approx(3.0)
    assert first.extra_time == pytest.approx(-0.2)
    assert found["waits"].episode.path_length == 0.0


def test_figures_of_that_level() -> None:
    row = evaluate_team(Script(), team(lanes()), 1)[0]
    assert (row.arrived, row.is_success, row.deadlocked) == (1, False, 1)
    assert row.makespan == pytest.approx(6.0)
    assert row.flowtime == pytest.approx(2.8 + 7 * 6.0)
    found = summarize_team("script", [row])
    assert {name: rate.count for name, rate in found.collision_with.items()} == {
        "robot": 2,
        "obstacle": 1,
        "moving obstacle": 1,
        "map": 0,
    }
    assert (found.individual_success.value, found.cooperative_success.value) == (1 / 8, 0.0)


def test_agents_that_wait_may_be_ended_by_the_task() -> None:
    found = played(endings=["deadlocked"], audit=False)
    assert (found["waits"].episode.outcome, found["waits"].episode.steps) == ("deadlock", 50)
    assert found["waits"].deadlocked
    assert found["circles"].episode.outcome == "timeout"


def test_standing_for_a_shorter_time_is_no_deadlock() -> None:
    assert not played(max_steps=45)["waits"].deadlocked


def test_a_function_of_the_observations_drives_all_agents() -> None:
    seen: list[tuple[int, ...]] = []

    def forward(observation: np.ndarray) -> np.ndarray:
        seen.append(observation.shape)
        return np.tile(np.array([1.0, 0.0], np.float32), (len(observation), 1))

    episodes = team(lanes(), 3)
    rows = evaluate_team(forward, episodes, 3)
    assert set(seen) == {(3 * 8, episodes.n_features)}
    assert rows[0].agents[0].episode.outcome == "success"


SWAP = {
    "world": {"height": 8, "width": 8, "step_time": 0.1},
    "robot": {
        "number": 3,
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": 0.25},
        "distribution": {"name": "random", "range_low": [0.5, 0.5, -PI], "range_high": [7.5, 7.5, PI]},
        "goal_threshold": 0.3,
        "vel_min": [0, -2],
        "vel_max": [1, 2],
    },
    "task": {"max_steps": 80},
}


@pytest.mark.parametrize("name", ["random", "dash", "rvo", "orca"])
def test_results_do_not_depend_on_the_number_of_worlds(name: str) -> None:
    expected = evaluate_team(reference_policy(name), team(SWAP, 4), 6, "dev")
    assert [row.level for row in expected] == list(range(6))
    assert len({row.agents[0].straight_distance for row in expected}) == 6
    for n_worlds in (1, 6):
        assert evaluate_team(reference_policy(name), team(SWAP, n_worlds), 6, "dev") == expected
    assert evaluate_team(reference_policy(name), team(SWAP, 2), [5, 2], "dev") == [expected[5], expected[2]]


def test_a_team_of_one_is_an_agent_alone() -> None:
    optima = Optima("dev")
    rows = evaluate_team(reference_policy("dash"), team("crossing", 3, task={"agents": "robot_0"}), 4, "dev")
    alone = evaluate(reference_policy("dash"), Worlds("crossing", 4).episodes, 4, "dev", optima=optima)
    assert [row.agents[0].episode for row in rows] == alone


def test_mistakes() -> None:
    with pytest.raises(IrsimGymError, match="evaluate it as a team"):
        evaluate(reference_policy("dash"), team(lanes()), 1)
    with pytest.raises(ValueError, match=r"must have shape \(2, 8, 2\), got \(2, 8, 1\)"):
        evaluate_team(lambda seen: np.zeros((len(seen), 1)), team(lanes(), 2), 2)
    with pytest.raises(ValueError, match="split 'dev'"):
        evaluate_team(Script(), team(lanes()), 1, "test", optima=Optima("dev"))


def test_a_map_is_told_apart_from_obstacles() -> None:
    scenario = lanes()
    cells = np.zeros((40, 30), np.bool_)
    cells[8:10] = True
    # 0.5 m cells: a wall from x = 4 to 5 across all lanes.
    scenario["world"]["obstacle_map"] = cells
    scenario["robot"] = [robot for robot in scenario["robot"] if robot["name"] in ("arrives", "waits")]
    scenario["obstacle"] = []

    def forward(observation: np.ndarray) -> np.ndarray:
        return np.tile(np.array([1.0, 0.0], np.float32), (len(observation), 1))

    row = evaluate_team(forward, team(scenario), 1)[0]
    # Contact after 4 - 2 - 0.2 = 1.8 m.
    assert [(agent.episode.outcome, agent.episode.hit) for agent in row.agents] == [("collision", "map")] * 2
    assert {agent.episode.steps for agent in row.agents} <= {18, 19}
    assert summarize_team("forward", [row]).collision_with["map"].count == 2


@pytest.mark.parametrize(("ended", "arrives"), [("stay", False), ("vanish", True)])
def test_who_has_ended_is_in_the_way_or_gone(ended: str, arrives: bool) -> None:
    scenario = lanes(ended=ended)
    first, second = scenario["robot"][:2]
    # Two on one lane: the goal of the first lies on the way of the second.
    second["state"], second["goal"] = [1, 1, 0], [6, 1, 0]
    scenario["robot"], scenario["obstacle"] = [first, second], []
    row = evaluate_team(reference_policy("dash"), team(scenario), 1)[0]
    assert row.agents[0].episode.outcome == "success"
    assert (row.agents[1].episode.outcome == "success") is arrives
    assert row.agents[1].episode.hit == ("" if arrives else "robot")


@pytest.mark.parametrize("name", ["rvo", "orca"])
def test_those_who_vanish_are_avoided_no_longer(name: str) -> None:
    scenario = lanes(ended="vanish")
    first, second = scenario["robot"][:2]
    second["state"], second["goal"] = [1, 1, 0], [6, 1, 0]
    scenario["robot"], scenario["obstacle"] = [first, second], []
    row = evaluate_team(reference_policy(name), team(scenario), 1)[0]
    assert [agent.episode.outcome for agent in row.agents] == ["success", "success"]
    # It drives straight on, through where the first has been.
    assert row.agents[1].episode.path_length < 5.0
