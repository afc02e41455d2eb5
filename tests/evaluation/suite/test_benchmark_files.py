"""The scenario files of the suite: each loads, learns and steps; the folder is known everywhere."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest

import irsim_gym
from irsim_gym.evaluation.suite.members import shipped_suite
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.specs.library import benchmark_names, every_scenario, names, scenario_names
from irsim_gym.tasks import load_task

NO_MEMBERS = {"recorded_people": "its people walk the same ways in every level: the file is a small one, drawn by us"}
"""Files of configs/benchmarks that the suite does not play, and why."""


def test_every_file_is_played_by_the_suite_or_named_with_the_reason() -> None:
    played = {member.scenario for member in shipped_suite().members.values()}
    assert set(names("benchmarks")) - played == set(NO_MEMBERS)
    assert all(NO_MEMBERS.values())


def test_names_are_unique_over_both_folders() -> None:
    assert not set(scenario_names()) & set(benchmark_names())
    assert set(every_scenario()) == set(names("scenarios")) | set(names("benchmarks"))


@pytest.mark.parametrize("name", benchmark_names())
def test_a_benchmark_is_an_environment(name: str) -> None:
    """It loads without a warning, its task holds for teams too, and world 1 of a batch is a single environment."""
    scenario = load_scenario(name)
    load_task(scenario, team=len(scenario.robots) > 1)
    single, batch = gymnasium.make(f"irsim_gym/{name}-v0"), irsim_gym.make_vec(name, 2)
    alone, together = single.reset(seed=4)[0], batch.reset(seed=3)[0]
    for _ in range(2):
        np.testing.assert_array_equal(together[1], alone)
        alone, together = (
            single.step(np.ones_like(alone, shape=single.action_space.shape))[0],
            batch.step(np.ones(batch.action_space.shape, np.float32))[0],
        )
    single.close()
    batch.close()
