"""PufferLib: robots as rows (world, slot) of its buffers."""

from __future__ import annotations

import library_pages as pages
import numpy as np
import pytest
from needed import library
from scenes import ENDS, LIMIT, paid_alone, team


@pytest.fixture(scope="module")
def rows_class():
    library("pufferlib")
    return pages.shown("pufferlib")["Rows"]


def test_a_team_pays_ends_and_waits_in_its_rows(rows_class):
    envs = rows_class(team(), num_envs=2)
    envs.reset(seed=0)
    assert envs.observations.shape[0] == 6
    paid, terminals, masks = np.zeros(6), [], []
    for _ in range(LIMIT):
        _, rewards, terminal, truncations, infos = envs.step(np.zeros((6, 2), np.float32))
        paid += rewards
        terminals.append(terminal.copy())
        masks.append(envs.masks.copy())
    assert bool(infos)
    np.testing.assert_allclose(paid, 2 * list(paid_alone().values()), rtol=1e-5)
    for slot, end in enumerate(ENDS.values()):
        for row in (slot, 3 + slot):
            steps = [k + 1 for k, terminal in enumerate(terminals) if terminal[row]]
            assert steps == ([end] if end < LIMIT else [])
            alive = [mask[row] for mask in masks]
            assert alive == [k + 1 < end for k in range(LIMIT - 1)] + [True]  # the world begins again at the end
    assert truncations.tolist() == [False, False, True] * 2


def test_its_vector_environments_share_the_buffers(rows_class):
    import pufferlib.vector

    envs = pufferlib.vector.make(
        rows_class, env_kwargs={"scenario": team(), "num_envs": 2}, num_envs=2, backend=pufferlib.vector.Serial
    )
    observations, _ = envs.reset(seed=0)
    assert observations.shape[0] == 12
    before = observations.copy()
    for one in envs.envs:
        assert np.shares_memory(one.observations, envs.observations)
    assert (envs.step(np.ones((12, 2), np.float32))[0] != before).any()
