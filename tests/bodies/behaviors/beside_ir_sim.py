"""What bodies decide at one moment, here and in ir-sim 2.12.0, and whether ir-sim's own decision is a tie."""

from __future__ import annotations

import contextlib
import copy
import io
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import shapely
import yaml

from irsim_gym import compile, load_scenario
from irsim_gym.simulator.engine.simulation import Simulation

SAME = 1e-9
SHAKES = (1e-9, 1e-13)
"""Sizes; what is at rest stays at rest, where rounding alone decides whether a social force pushes to a side."""
TRIES = 400

Description = dict[str, Any]


@contextlib.contextmanager
def silent() -> Iterator[None]:
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        yield


def ours(scenario: Description) -> Simulation:
    """Return the scenario here, with all decisions made and nothing moved yet by another's."""
    described = copy.deepcopy(scenario)
    described["world"] = {**described.get("world", {}), "update": "simultaneous"}
    sim = compile(load_scenario(described), n_worlds=1)
    sim.reset(seed=0)
    sim.step()
    return sim


def theirs(scenario: Description, folder: Path) -> Any:
    """Return ir-sim's environment; its omni is ours with ``frame: body``."""
    described = copy.deepcopy(scenario)
    for body in described["robot"]:
        body["kinematics"].pop("frame", None)
    file = folder / "scenario.yaml"
    file.write_text(yaml.safe_dump(described, sort_keys=False))
    with silent():
        import irsim

        return irsim.make(str(file), headless=True, display=False, log_level="CRITICAL")


def decisions(env: Any) -> list[np.ndarray[Any, Any]]:
    """Return what ir-sim's robots decide now: each for itself, or as their group."""
    robots = env.robot_list
    group = env._object_groups[0]
    with silent():
        if robots[0].group_behavior_dict:
            return [np.asarray(action, float)[:, 0] for action in group.gen_group_vel()]
        return [np.asarray(one.obj_behavior.gen_vel(one, one.external_objects), float)[:, 0] for one in robots]


def count_ties(scenario: Description, folder: Path) -> tuple[int, int]:
    """Compare all robots' decisions; return how many there are and how many are ties.

    A decision that differs has to be a tie: ir-sim decides as we do when its own state is moved by a billionth.
    """
    sim, env = ours(scenario), theirs(scenario, folder)
    expected = decisions(env)
    found = sim.state.command[0, : len(expected), : len(expected[0])]
    apart = [b for b in range(len(expected)) if np.abs(found[b] - expected[b]).max() > SAME]
    unexplained = set(apart)
    states = [(one._state.copy(), one._velocity.copy()) for one in env.objects]
    random = np.random.default_rng(0)
    for attempt in range(TRIES):
        if not unexplained:
            break
        size = SHAKES[attempt % len(SHAKES)]
        shake(env, states, size, random)
        shaken = decisions(env)
        unexplained -= {b for b in unexplained if np.abs(found[b] - shaken[b]).max() < max(100.0 * size, SAME)}
    for b in sorted(unexplained):
        raise AssertionError(f"robot {b} decides {found[b]}, ir-sim {expected[b]}: {scenario['robot'][b]}")
    return len(expected), len(apart)


def shake(env: Any, states: list[Any], size: float, random: np.random.Generator) -> None:
    """Move ir-sim's moving objects a little away from their states and velocities."""
    for one, (state, velocity) in zip(env.objects, states, strict=True):
        if not one.static:
            one._state = state + size * random.uniform(-1, 1, state.shape)
            one._velocity = velocity * (1.0 + size * random.uniform(-1, 1, velocity.shape))
            one._geometry = one.gf.step(one._state)
        one._invalidate_reactive_cache()


def crowd(random: np.random.Generator, behavior: Description, drive: str, n: int = 6) -> Description:
    """Return a scenario: robots at random among discs that stand and walls, all with random velocities."""
    walls = [random.uniform(-2, 8, (3, 2)) for _ in range(int(random.integers(0, 2)))]
    discs = random.uniform(0, 6, (2, 2))
    taken = shapely.union_all([*shapely.points(discs), *(shapely.linestrings(wall) for wall in walls)])
    starts = [place for place in random.uniform(0, 6, (1000, 2)) if taken.distance(shapely.Point(place)) > 0.75]
    robots = []
    for start, goal in zip(starts[:n], random.uniform(0, 6, (n, 2)), strict=True):
        shape: Description = {"name": "circle", "radius": float(random.uniform(0.1, 0.4))}
        if random.random() < 0.3:
            shape = {"name": "rectangle", "length": 0.5, "width": 0.3}
        robots.append(
            {
                "kinematics": {"name": drive, **({"frame": "body"} if drive == "omni" else {})},
                "shape": shape,
                "state": [*start.tolist(), float(random.uniform(-3, 3))],
                "velocity": (random.uniform(-1, 1, 2) * (random.random() < 0.8)).tolist(),
                "goal": [*goal.tolist(), 0],
                "vel_max": [1.0, 1.5],
                "vel_min": [-1.0, -1.5],
                "behavior": behavior,
            }
        )
    obstacles = [{"shape": {"name": "circle", "radius": 0.3}, "state": [*disc.tolist(), 0.0]} for disc in discs]
    obstacles += [{"shape": {"name": "linestring", "vertices": wall.tolist()}, "state": [0, 0, 0]} for wall in walls]
    return {"world": {"width": 10, "height": 10}, "robot": robots, "obstacle": obstacles}
