"""Disturbances of learners from outside of the file."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.errors import ScenarioError

TEXT = "latency:time=[0, 0.3]; drive_lag:tau=0.1:dead_band=[0,0.1]; lost_beams:chance=0.2:reads=zero"


def test_learners_alone_are_disturbed_from_outside() -> None:
    scenario = ig.load_scenario("crossing", {"disturbances": TEXT})
    assert [type(one).__name__ for one in scenario.disturbances] == ["Latency", "DriveLag", "LostBeams"]
    assert scenario.parameters["disturbances"] == TEXT
    sim = ig.compile(scenario, 1, agents=(0,))
    assert {int(b) for group in sim.parts.disturbances.groups for b in group.members} == {0}
    assert not ig.compile(scenario, 1).parts.disturbances.groups


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("latncy:time=1", "did you mean 'latency'?"),
        ("latency:time=", "disturbances[0].time: cannot be read, got ''"),
        ("latency:tim=1", "unknown key (did you mean 'time'?)"),
        ("latency", ""),
        ("drive_lag:tau=[0.2, 0.1]; latency:time=99", "[1].time: must lie from 0 to 10, got 99"),
        (3, "must be text such as 'latency:time=0.2; lost_beams:chance=0.1', got 3"),
    ],
)
def test_texts_are_read_or_say_what_is_wrong(text: Any, said: str) -> None:
    if not said:
        assert ig.load_scenario("corridor", {"disturbances": text}).disturbances
        return
    with pytest.raises(ScenarioError) as error:
        ig.load_scenario("corridor", {"disturbances": text})
    assert said in str(error.value)


def test_batch_single_and_threads_play_the_same_disturbed_episodes() -> None:
    envs = gymnasium.make_vec("irsim_gym/cluttered_room-v0", num_envs=5, disturbances=TEXT)
    threads = gymnasium.make_vec("irsim_gym/cluttered_room-v0", num_envs=5, num_threads=3, disturbances=TEXT)
    single = gymnasium.make("irsim_gym/cluttered_room-v0", disturbances=TEXT)
    seen, _ = envs.reset(seed=7)
    other, _ = threads.reset(seed=7)
    alone, _ = single.reset(seed=7 + 3)
    rng = np.random.default_rng(0)
    for _ in range(40):
        np.testing.assert_array_equal(seen, other)
        np.testing.assert_array_equal(seen[3], alone)
        actions = rng.uniform(-1, 1, (5, 2)).astype(np.float32)
        seen, _, ended, cut, _ = envs.step(actions)
        other, *_ = threads.step(actions)
        alone, *_ = single.step(actions[3])
        if ended[3] or cut[3]:
            break


def test_levels_stay_as_they_are() -> None:
    plain, disturbed = (
        ig.compile(ig.load_scenario("cluttered_room", given), 2, agents=(0,)) for given in ({}, {"disturbances": TEXT})
    )
    for sim in (plain, disturbed):
        sim.reset(seed=3)
    np.testing.assert_array_equal(plain.state.pose, disturbed.state.pose)
    np.testing.assert_array_equal(plain.state.goal, disturbed.state.goal)
