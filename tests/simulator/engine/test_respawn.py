"""Bodies that begin anew while their worlds go on."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym
from irsim_gym.scenario import load_scenario
from irsim_gym.simulator.engine import Simulation, compile
from irsim_gym.simulator.step import respawn as engine_respawn

DISC = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.4}}


def begun(robots: list[dict[str, Any]], n_worlds: int = 1) -> Simulation:
    """Return worlds in which all robots are commanded from outside, at the start of levels 0, 1, ..."""
    scenario = load_scenario({"world": {"width": 10, "height": 10}, "robot": robots})
    simulation = compile(scenario, n_worlds, agents=scenario.robots)
    simulation.reset()
    return simulation


def respawn(simulation: Simulation, chosen: list[list[bool]]) -> None:
    flags = np.array(chosen)
    worlds = np.flatnonzero(flags.any(axis=1))
    simulation.run(lambda shard: simulation.respawn(shard, simulation.agents, flags), worlds)


def test_who_came_to_any_free_place_stays_there_when_others_of_its_entry_begin_anew() -> None:
    narrow = {"name": "random", "range_low": [4, 5, 0], "range_high": [6, 5, 0]}
    wall = {**DISC, "shape": {"name": "rectangle", "length": 8, "width": 0.5}, "state": [5, 1, 0]}
    simulation = begun([{**DISC, "number": 2, "distribution": narrow}, wall])
    simulation.state.pose[0, 2] = [5, 5, 0]
    simulation.place(np.array([2]))
    respawn(simulation, [[True, False, False]])
    pose = simulation.state.pose[0, 0].copy()
    assert pose[1] != 5.0  # no place where its distribution wants it
    simulation.state.pose[0, 2] = [5, 1, 0]
    simulation.place(np.array([2]))
    respawn(simulation, [[False, True, False]])
    assert simulation.state.pose[0, 0].tolist() == pose.tolist()


@pytest.mark.parametrize("reachable", [False, True])
def test_who_comes_to_any_free_place_has_a_way_to_its_goal(reachable: bool) -> None:
    left = {"name": "random", "range_low": [2, 4, 0], "range_high": [2, 6, 0], "reachable": True}
    spot = {"distribution": left} if reachable else {"state": [2, 5], "goal": [3, 8]}
    taken = {"kinematics": {"name": "omni"}, "shape": {"name": "rectangle", "length": 1, "width": 4}, "state": [8, 2]}
    wall = {"shape": {"name": "linestring", "vertices": [[5, -1], [5, 11]]}}
    stone = {"distribution": {"name": "random", "range_low": [7, 8, 0]}}  # levels differ, so ways are looked after
    scenario = load_scenario({"robot": [{**DISC, **spot}, taken], "obstacle": [wall, stone]}, warn=False)
    simulation = compile(scenario, n_worlds=12, agents=[0, 1])
    simulation.reset()
    simulation.state.pose[:, 1] = [2, 5, 0]
    simulation.place(np.array([1]))
    respawn(simulation, [[True, False]] * 12)
    x, y = simulation.state.pose[:, 0, 0], simulation.state.pose[:, 0, 1]
    assert ((x != 2.0) | (np.abs(y - 5.0) > 2.0)).all(), "nobody came to the place that is taken"
    assert (x < 5.0).all(), "from the other side of the wall there is no way"


def test_the_level_begins_again_with_those_who_vanished_and_the_goals_that_it_had() -> None:
    robots = {**DISC, "number": 3, "distribution": {"name": "random", "min_goal_distance": 2}}
    simulation, untouched = begun([robots], 3), begun([robots], 3)
    flags = np.array([[True, False, False], [False, True, False], [False, False, False]])
    simulation.run(lambda shard: simulation.vanish(shard, simulation.agents, flags), np.array([0]))
    respawn(simulation, flags[[2, 1, 2]].tolist())
    simulation.step(np.zeros((3, 3, 2)))
    assert (simulation.state.goal[1] != untouched.state.goal[1]).any()
    assert not simulation.model.present[0, 0]
    for _ in range(2):
        simulation.reset_to_start()
        for name in ("pose", "goal", "random", "time"):
            np.testing.assert_array_equal(getattr(simulation.state, name), getattr(untouched.state, name), name)
        np.testing.assert_array_equal(simulation.model.present, untouched.model.present)
        assert not simulation.model.altered.any()


def test_who_begins_anew_has_forgotten_its_goals_contacts_and_motion_and_nobody_else() -> None:
    car = {
        **DISC,
        "kinematics": {"name": "acker", "wheelbase": 1},
        "state": [2, 2, 0, 0.1],
        "goal": [[4, 2, 0], [8, 2, 0]],
    }
    simulation = begun([car, {**car, "state": [2, 8, 0, 0.1]}])
    state = simulation.state
    for b in range(2):
        state.steering[0, b], state.hit[0, b], state.plan[0, b], state.velocity[0, b] = 0.3, 5, [0.4, 0.5], [1, 2, 3]
        state.arrived[0, b] = state.collided[0, b] = state.stopped[0, b] = True
        state.waypoint[0, b], state.goal[0, b], state.twist[0, b] = 1, [8, 2, 0], [0.7, 0.8, 0.9]
    respawn(simulation, [[True, False]])
    assert state.steering[0].tolist() == [0.1, 0.3]
    assert state.hit[0].tolist() == [-1, 5]
    assert state.plan[0].tolist() == [[0, 0], [0.4, 0.5]]
    assert state.velocity[0].tolist() == [[0, 0, 0], [1, 2, 3]]
    for flags in (state.arrived, state.collided, state.stopped):
        assert flags[0].tolist() == [False, True]
    assert state.twist[0].tolist() == [[0, 0, 0], [0.7, 0.8, 0.9]]
    assert state.waypoint[0].tolist() == [0, 1]
    assert state.goal[0].tolist() == [[4, 2, 0], [8, 2, 0]]


def test_starts_and_goals_without_a_way_between_them_are_drawn_again_from_the_same_distribution() -> None:
    """On a line that a wall cuts into halves, every other draw has its start on one side and its goal on the other."""
    wall = {"shape": {"name": "linestring", "vertices": [[5, -1], [5, 11]]}}
    line = {"name": "random", "range_low": [1, 5, 0], "range_high": [9, 5, 0]}
    scenario = load_scenario({"robot": [{**DISC, "distribution": line}], "obstacle": [wall]}, warn=False)
    simulation = compile(scenario, n_worlds=6, agents=[0])
    simulation.reset()
    respawn(simulation, [[True]] * 6)
    pose, goal = simulation.state.pose[:, 0], simulation.state.goal[:, 0]
    assert pose[:, 1].tolist() == goal[:, 1].tolist() == [5.0] * 6
    assert ((pose[:, 0] < 5) == (goal[:, 0] < 5)).all()
    assert len(set((pose[:, 0] < 5).tolist())) == 2


def test_only_goals_that_are_kept_need_a_way() -> None:
    """All three stand behind the wall; one has no goal, one draws other goals, and one keeps a goal beyond it."""
    wall = {"shape": {"name": "linestring", "vertices": [[5, -1], [5, 11]]}}
    wandering = {"behavior": {"name": "dash", "wander": True}, "goal": [8, 5]}
    robots = [
        {**DISC, "state": [2, 2]},
        {**DISC, "state": [2, 5], **wandering},
        {**DISC, "state": [2, 8], "goal": [8, 8]},
    ]
    simulation = compile(load_scenario({"robot": robots, "obstacle": [wall]}, warn=False))
    simulation.reset()
    model, state = simulation.model, simulation.state
    model.has_goal[0] = False
    model.waypoints[0, 1, 0], model.waypoint_count[0, 1] = [8, 5, 0], 1
    assert [engine_respawn._has_way(model, state, 0, b) for b in range(3)] == [True, True, False]


def test_worlds_draw_nothing_for_bodies_that_begin_anew_in_others() -> None:
    ring = {**DISC, "number": 3, "distribution": {"name": "circle", "radius": 3, "turn": True}}
    robots = [ring, {**DISC, "state": [5, 5, 0]}]
    alone, both = begun(robots), begun(robots, 2)
    respawn(alone, [[False, False, False, True]])
    respawn(both, [[False, False, False, True], [True, False, False, False]])
    assert alone.state.random[0] == both.state.random[0]


def test_who_was_held_in_place_moves_in_its_first_step_after_it_begins_anew() -> None:
    place = {"name": "random", "range_low": [2, 2, 0], "range_high": [2, 2, 0]}
    wall = {"shape": {"name": "rectangle", "length": 1, "width": 6}, "state": [8, 5, 0]}
    robot = {**DISC, "distribution": place, "vel_max": [1, 1]}
    scenario = load_scenario({"world": {"collision_mode": "stop"}, "robot": [robot], "obstacle": [wall]})
    simulation = compile(scenario, agents=scenario.robots)
    simulation.reset()
    simulation.state.pose[0, 0] = [7, 5, 0]
    simulation.place(np.array([0]))
    ahead = np.array([[[1.0, 0.0]]])
    for _ in range(3):
        simulation.step(ahead)
    assert simulation.state.stopped[0, 0]
    assert simulation.state.velocity[0, 0, 0] == 0.0
    respawn(simulation, [[True]])
    assert not simulation.state.stopped[0, 0]
    simulation.step(ahead)
    assert simulation.state.pose[0, 0].tolist() == [2.1, 2.0, 0.0]


def test_who_needs_no_way_takes_the_first_free_place(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine_respawn, "_has_way", lambda *_: pytest.fail("a way is looked for"))
    spot = {"name": "random", "range_low": [5, 5, 0], "range_high": [5, 5, 0]}
    simulation = compile(load_scenario({"robot": [{**DISC, "distribution": spot}, {**DISC, "state": [2, 2, 0]}]}))
    simulation.reset()
    simulation.state.pose[0, 1] = [5, 5, 0]
    simulation.place(np.array([1]))
    simulation.run(lambda shard: simulation.respawn(shard, np.array([0]), np.array([[True]])), np.array([0]))
    x, y = simulation.state.pose[0, 0, :2]
    assert np.hypot(x - 5, y - 5) > 0.8
    assert simulation.state.placed[0, 0]


@pytest.mark.parametrize("drive", ["diff", "omni_angular"])
def test_the_others_move_on_as_they_did(drive: str) -> None:
    robot = {**DISC, "kinematics": {"name": drive}}
    simulation = begun([{**robot, "state": [3, 3, 0]}, {**robot, "state": [7, 7, 1]}])
    command = [1.0, 1.0] if drive == "diff" else [1.0, 0.5, 1.0]
    simulation.step(np.array([[command, command]]))
    before = simulation.state.twist[0, 1].copy()
    assert before[2] == 1.0
    respawn(simulation, [[True, False]])
    assert simulation.state.twist[0, 1].tolist() == before.tolist()
    assert simulation.state.twist[0, 0].tolist() == [0.0, 0.0, 0.0]


def test_a_function_forgets_who_begins_anew_and_nobody_else() -> None:
    def counting(ego: Any, others: Any) -> Any:
        ego.memory["count"] = ego.memory.get("count", 0) + 1
        return [0.1 * ego.memory["count"], 0.0]

    irsim_gym.behavior("counting")(counting)
    robots = [{**DISC, "state": [x, 2, 0], "behavior": {"name": "counting"}} for x in (2, 7)]
    simulation = compile(load_scenario({"robot": robots}), 1)
    simulation.reset()
    for _ in range(3):
        simulation.step()
    chosen = np.array([[True, False]])
    simulation.run(lambda shard: simulation.respawn(shard, np.array([0, 1]), chosen), np.array([0]))
    simulation.step()
    assert simulation.state.command[0, :, 0] == pytest.approx([0.1, 0.4])
