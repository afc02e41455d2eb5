"""Twelve worlds, step by step as in ir-sim 2.12.0; a batch, threads and the plain path give the same bits."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import irsim_gym as ig

HERE = Path(__file__).parent
STEPS = 80
WEDGED = 43
"""From this step on, a disc in a corner presses on two walls alike: rounding decides who of them is told the force."""


@cache
def worlds() -> dict[str, Any]:
    described = yaml.safe_load((HERE / "worlds.yaml").read_text())
    common = described.pop("common")
    return {
        name: {
            "world": {**common["world"], **sections.get("world", {})},
            "robot": [{**common["robot"], **robot} for robot in sections.get("robot", [{}])],
            "obstacle": sections.get("obstacle", []),
        }
        for name, sections in described.items()
    }


def begun(name: str, n_worlds: int = 1, **options: Any) -> Any:
    simulation = ig.compile(ig.load_scenario(worlds()[name]), n_worlds, check_starts=False, **options)
    simulation.reset(seed=0)
    return simulation


def felt(simulation: Any) -> tuple[np.ndarray, ...]:
    push, state = simulation.parts.pushing, simulation.state
    return state.pose, state.velocity, state.twist, push.drive, *(push.felt[name] for name in push.felt.dtype.names)


NAMES = sorted(worlds())


@pytest.mark.parametrize("name", NAMES)
def test_a_world_is_that_of_ir_sim(name: str) -> None:
    simulation = begun(name)
    push, state = simulation.parts.pushing, simulation.state
    with np.load(HERE / "worlds.npz") as made:
        expected = {key: made[f"{name}/{key}"] for key in ("state", "velocity", "force", "times", "contacts")}
    for step in range(STEPS):
        simulation.step()
        assert state.pose[0] == pytest.approx(expected["state"][step], abs=1e-9)
        assert state.velocity[0] == pytest.approx(expected["velocity"][step], abs=1e-9)
        times = np.stack([push.felt["contact_time"][0], push.felt["air_time"][0]], axis=1)
        if name != "corner" or step < WEDGED:
            assert np.stack([push.felt["x"][0], push.felt["y"][0]], axis=1) == pytest.approx(
                expected["force"][step], abs=1e-6
            )
            assert times == pytest.approx(expected["times"][step], abs=1e-9)
            touches = np.zeros(expected["contacts"][step].shape, np.bool_)
            told = push.reports[0, : push.n_reports[0]]
            touches[told["a"], told["b"]] = touches[told["b"], told["a"]] = True
            assert (touches == expected["contacts"][step]).all()


@pytest.mark.parametrize("name", ["chain", "map", "parts", "bounce"])
def test_a_batch_threads_and_the_plain_path_give_the_same_bits(name: str) -> None:
    sims = [begun(name), begun(name, 3, num_threads=3), begun(name, 2, fused=False)]
    for _ in range(60):
        for simulation in sims:
            simulation.step()
    one = felt(sims[0])
    for simulation in sims[1:]:
        for expected, found in zip(one, felt(simulation), strict=True):
            assert all(np.array_equal(row, expected[0]) for row in found)


def test_an_episode_that_begins_again_is_the_same() -> None:
    simulation = begun("lag")
    runs = []
    for begin in (simulation.reset_to_start, lambda: simulation.reset(seed=0), lambda: None):
        states = []
        for _ in range(30):
            simulation.step()
            states.append([array.copy() for array in felt(simulation)])
        runs.append(states)
        begin()
        if begin is not None and len(runs) < 3:
            assert simulation.parts.pushing.n_reports[0] == 0
            assert not any(array.any() for array in felt(simulation)[1:])
    for run in runs[1:]:
        assert all(
            np.array_equal(a, b)
            for one, other in zip(runs[0], run, strict=True)
            for a, b in zip(one, other, strict=True)
        )
