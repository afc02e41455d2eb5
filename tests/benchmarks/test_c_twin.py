"""The C twin of S1 does the same work as our environment: from the same state the same step."""

from __future__ import annotations

import c_twin
import numpy as np
import pytest
from c_twin import OUTCOMES, Twin
from standard_worlds import s1

from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.tasks import Outcome

pytestmark = pytest.mark.skipif(c_twin.compiler() is None, reason="there is no C compiler")

N_WORLDS, N_STEPS = 16, 120


def test_a_step_of_the_twin_is_ours() -> None:
    worlds, twin = Worlds(s1(), N_WORLDS), Twin(N_WORLDS)
    worlds.begin(range(N_WORLDS), range(N_WORLDS), [{}] * N_WORLDS, lambda w: w)
    state, view = worlds.simulation.state, worlds.episodes.view
    numbers = np.random.default_rng(0)
    apart, outcomes, nearest = [], set(), np.full(N_WORLDS, np.inf)
    for _ in range(N_STEPS):
        twin.pose[:], twin.goal[:] = state.pose[:, 0], state.goal[:, 0, :2]
        twin.way[:], twin.steps[:] = np.hypot(*(twin.goal - twin.pose[:, :2]).T), view.infos["steps"][:, 0]
        twin.path[:], twin.min_clearance[:] = (view.infos[name][:, 0] for name in ("path_length", "min_clearance"))
        actions = numbers.uniform(-1.2, 1.2, (N_WORLDS, 2)).astype(np.float32)
        worlds.step(actions[:, None])
        twin.step(actions, restarts=False)
        np.testing.assert_allclose(twin.pose, state.pose[:, 0], rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(twin.path, view.infos["path_length"][:, 0], rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(twin.min_clearance, view.infos["min_clearance"][:, 0], rtol=0.0, atol=1e-9)
        nearest = np.minimum(nearest, twin.min_clearance)
        np.testing.assert_allclose(twin.reward, view.reward[:, 0], rtol=0.0, atol=1e-12)
        told = [Outcome[OUTCOMES[k].upper()] for k in twin.ended]
        assert told == [Outcome(k) for k in view.infos["outcome"][:, 0].tolist()]
        outcomes |= set(told)
        apart.append(np.abs(twin.observation - view.observation[:, 0]))
        ended = np.flatnonzero(~view.live[:, 0])
        if len(ended):
            worlds.begin_next(ended)
    beams, rest = np.split(np.array(apart), [180], axis=2)
    assert rest.max() < 1e-6
    # A beam that grazes an edge may hit or miss either way.
    assert np.mean(beams > 1e-5) < 5e-4
    assert {Outcome.RUNNING, Outcome.COLLISION} <= outcomes
    assert nearest.min() == 0.0


def test_an_arrival_and_a_time_limit_are_ours_too() -> None:
    worlds, twin = Worlds(s1(), 2), Twin(2)
    worlds.begin(range(2), range(2), [{}] * 2, lambda w: w)
    state, view = worlds.simulation.state, worlds.episodes.view
    state.goal[0, 0, :2] = state.pose[0, 0, :2] + [0.05, 0.05]
    worlds.episodes.state.steps[1, 0] = worlds.task.max_steps - 1
    twin.pose[:], twin.goal[:] = state.pose[:, 0], state.goal[:, 0, :2]
    twin.steps[1] = worlds.task.max_steps - 1
    still = np.full((2, 2), [-1.0, 0.0], np.float32)
    worlds.step(still[:, None])
    twin.step(still, restarts=False)
    assert view.infos["outcome"][:, 0].tolist() == [Outcome.SUCCESS, Outcome.TIMEOUT]
    assert [OUTCOMES[k] for k in twin.ended] == ["success", "timeout"]


def test_ended_worlds_begin_anew_clear_of_everything() -> None:
    twin = Twin(64)
    discs = np.column_stack([twin.tables[name] for name in ("disc_x", "disc_y", "disc_r")])
    begins, extents = (np.column_stack([twin.tables[name] for name in names]) for names in (("ax", "ay"), ("dx", "dy")))
    numbers, begun = np.random.default_rng(1), 0
    for _ in range(60):
        twin.step(numbers.uniform(-1.0, 1.0, (64, 2)).astype(np.float32))
        fresh = twin.steps == 0
        begun += int(fresh.sum())
        for x, y, told in np.column_stack([twin.pose[fresh, :2], twin.min_clearance[fresh]]):
            gap = (np.hypot(discs[:, 0] - x, discs[:, 1] - y) - discs[:, 2]).min()
            aside = [x, y] - begins
            share = np.clip(np.sum(extents * aside, axis=1) / np.sum(extents * extents, axis=1), 0.0, 1.0)
            gap = min(gap, np.linalg.norm(aside - share[:, None] * extents, axis=1).min())
            assert gap >= 0.3
            assert told == pytest.approx(gap - 0.2, abs=1e-12)
        assert (twin.path[fresh] == 0.0).all()
        assert (twin.way[fresh] >= 4.0).all()
        assert (np.abs(twin.observation) <= 1.0 + 1e-6).all()
    assert begun > 10


def test_loading_it_leaves_the_arithmetic_of_the_process_alone() -> None:
    Twin(1)
    assert float(np.float64(1e-310) * 0.5) > 0.0  # denormal numbers are not flushed to 0
