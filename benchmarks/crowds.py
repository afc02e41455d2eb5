"""Crowds that avoid each other, at constant density; beside IR-SIM, where it is installed, on the same file."""

from __future__ import annotations

import importlib.util
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import yaml

SPACING = 3.0
"""Side of the square that each agent has for itself [m]."""

SIZES = (10, 100, 1000, 4000)
PEER_SIZES = (10, 100)
BATCH_SIZE, BATCH_WORLDS = 10, 256
ROUNDS = 7


def crowd(behavior: dict[str, Any], n_agents: int) -> dict[str, Any]:
    """Return a scenario: omnidirectional discs, one in each square of a board, with goals anywhere on it."""
    rng = np.random.default_rng(0)
    columns = int(np.ceil(np.sqrt(n_agents)))
    squares = rng.permutation(columns * columns)[:n_agents]
    starts = SPACING * (
        np.stack([squares % columns, squares // columns], axis=1) + rng.uniform(0.3, 0.7, (n_agents, 2))
    )
    goals = rng.uniform(0.0, SPACING * columns, (n_agents, 2))
    robots = {
        "number": n_agents,
        "kinematics": {"name": "omni"},
        "shape": {"name": "circle", "radius": 0.2},
        "distribution": {"name": "manual"},
        "state": [[x, y, 0.0] for x, y in starts.tolist()],
        "goal": [[x, y, 0.0] for x, y in goals.tolist()],
        "vel_max": [1.0, 1.0],
        "vel_min": [-1.0, -1.0],
        **behavior,
    }
    side = SPACING * columns
    return {"world": {"width": side, "height": side, "collision_mode": "unobstructed"}, "robot": [robots]}


def cost(behavior: dict[str, Any]) -> dict[str, float]:
    """Microseconds of CPU per agent and step, least of all rounds; beside IR-SIM the ratio of medians."""
    figures = {}
    for n_agents in SIZES:
        scenario = crowd(behavior, n_agents)
        ours, n_steps = _our_step(scenario), max(2, 2000 // n_agents)
        theirs = _peer_step(scenario) if n_agents in PEER_SIZES else None
        times: dict[str, list[float]] = {"": [], "_irsim": []}
        for _ in range(ROUNDS):
            times[""].append(_seconds(ours, n_steps))
            if theirs is not None:
                times["_irsim"].append(_seconds(theirs, 3))
        for who, seconds in times.items():
            if seconds:
                figures[f"{n_agents}_agents{who}_us"] = 1e6 * min(seconds) / n_agents
        if theirs is not None:
            medians = [statistics.median(seconds) for seconds in times.values()]
            figures[f"{n_agents}_agents_times_faster"] = medians[1] / medians[0]
    batch = _our_step(crowd(behavior, BATCH_SIZE), BATCH_WORLDS)
    least = min(_seconds(batch, 4) for _ in range(ROUNDS))
    figures[f"{BATCH_SIZE}_agents_{BATCH_WORLDS}_worlds_us"] = 1e6 * least / BATCH_SIZE / BATCH_WORLDS
    return figures


def _our_step(scenario: dict[str, Any], n_worlds: int = 1) -> Callable[[], Any]:
    import irsim_gym as ig

    sim = ig.compile(ig.load_scenario(scenario), n_worlds)
    sim.reset()
    sim.step()
    return sim.step


def _peer_step(scenario: dict[str, Any]) -> Callable[[], Any] | None:
    if importlib.util.find_spec("irsim") is None:
        return None
    import irsim

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "crowd.yaml"
        file.write_text(yaml.safe_dump(scenario), encoding="utf-8")
        peer = irsim.make(str(file), display=False, log_level="ERROR")
    peer.step()
    return peer.step


def _seconds(step: Callable[[], Any], n_steps: int) -> float:
    begin = time.process_time()
    for _ in range(n_steps):
        step()
    return (time.process_time() - begin) / n_steps
