"""Bodies that begin anew while their worlds go on."""

from __future__ import annotations

from typing import Any

import numpy as np

from irsim_gym.engine import Simulation, compile
from irsim_gym.scenario import load_scenario

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


def test_worlds_draw_nothing_for_bodies_that_begin_anew_in_others() -> None:
    ring = {**DISC, "number": 3, "distribution": {"name": "circle", "radius": 3, "turn": True}}
    robots = [ring, {**DISC, "state": [5, 5, 0]}]
    alone, both = begun(robots), begun(robots, 2)
    respawn(alone, [[False, False, False, True]])
    respawn(both, [[False, False, False, True], [True, False, False, False]])
    assert alone.state.random[0] == both.state.random[0]
