"""Maps that each level draws: what a level costs, and a step beside one with a map that all worlds share."""

from __future__ import annotations

from typing import Any

from effort import Effort, Figures, repeat
from standard_worlds import DIFF, lidar
from timing import cost, summed_up

FREE = {"name": "random", "reachable": True}
MAPS: dict[str, dict[str, Any]] = {
    "cells": {"name": "cells"},
    "rooms": {"name": "rooms", "resolution": 0.25},
    "maze": {"name": "maze", "resolution": 0.25},
    "cellular": {"name": "cellular", "resolution": 0.25},
    "shelves": {"name": "shelves", "resolution": 0.25},
}
"""The first has 11 x 11 cells, with starts and goals in their middles; the others have 64 x 64."""
N_WORLDS = 256


def world(name: str, obstacle_map: Any) -> Any:
    """Return a compiled world with a robot whose start and goal are proved to be joined."""
    import irsim_gym as ig

    is_small = name == "cells"
    side, distribution = (11.0, {"name": "cells"}) if is_small else (16.0, FREE)
    robot = {**DIFF, "distribution": distribution, "sensors": lidar(180, 10.0)}
    data = {"world": {"width": side, "height": side, "obstacle_map": obstacle_map}, "robot": robot}
    return ig.compile(ig.load_scenario(data), N_WORLDS, agents=(0,))


def level_maps(effort: Effort) -> Figures:
    """Measure one thread, per world: a level drawn, proved and begun, and a step of robots that turn on the spot."""
    figures: Figures = {}
    for name in MAPS if effort.largest is None else ["cells"]:
        own = world(name, MAPS[name])
        seeds = iter(range(0, 10**9, N_WORLDS))
        figures[f"{name}_level_us"] = cost(lambda own=own, seeds=seeds: own.reset(next(seeds)), effort.rounds).times(
            1e6 / N_WORLDS
        )
        figures |= {f"{name}_step_{which}_us": taken for which, taken in steps(name, own, effort).items()}
    return figures


def steps(name: str, own: Any, effort: Effort) -> Figures:
    """Return what a step takes where all worlds have one map, as a row of each world and as one row for all [us]."""
    shared = world(name, [[bool(cell) for cell in column] for column in own.model.map_squares[0, 0] == 0])
    shared.reset(0)
    for field in ("map_squares", "map_boxes", "map_n_boxes", "map_room"):
        getattr(own.model, field)[:] = getattr(own.model, field)[0]
    for field in ("pose", "goal"):
        getattr(own.state, field)[:] = getattr(shared.state, field)
    worlds = {"own": own, "shared": shared}
    count = effort.steps(lambda: own.step([0.0, 0.5]))
    rounds: dict[str, list[float]] = {which: [] for which in worlds}
    for _ in range(effort.rounds):  # in turns
        for which, sim in worlds.items():
            taken = cost(lambda sim=sim: repeat(lambda: sim.step([0.0, 0.5]), count), 1)
            rounds[which].append(1e6 / count / N_WORLDS * taken.least)
    return {which: summed_up(taken) for which, taken in rounds.items()}
