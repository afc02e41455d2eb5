"""BenchMARL: a scenario as a task, and an iteration of two of its algorithms."""

from __future__ import annotations

import library_pages as pages
import numpy as np
import pytest
from needed import library
from scenes import ENDS, LIMIT, paid_alone, team


@pytest.fixture(scope="module")
def task():
    library("benchmarl")
    return pages.shown("benchmarl")["Team"]("known", {"scenario": team(), "max_cycles": LIMIT})


def test_the_group_is_the_team(task):
    import torch

    env = task.get_env_fun(1, True, 0, "cpu")()
    assert task.group_map(env) == {"robot": list(ENDS)}
    row, paid, done = env.reset(), np.zeros(3), []
    assert row["state"].shape == (30,)
    for _ in range(LIMIT):
        row = env.step(row.set(("robot", "action"), torch.zeros(3, 2)))["next"]
        paid += row["robot", "reward"].squeeze(-1).numpy()
        done.append(row["done"].item())
    np.testing.assert_allclose(paid, list(paid_alone().values()), rtol=1e-5)
    assert done == [False] * (LIMIT - 1) + [True]


@pytest.mark.parametrize("name", ["MappoConfig", "IppoConfig"])
def test_it_trains(task, name, tmp_path):
    from benchmarl import algorithms
    from benchmarl.experiment import Experiment, ExperimentConfig
    from benchmarl.models import MlpConfig

    config = ExperimentConfig.get_from_yaml()
    config.max_n_frames = config.on_policy_collected_frames_per_batch = 4 * LIMIT
    config.on_policy_n_envs_per_worker, config.on_policy_minibatch_size = 2, 2 * LIMIT
    config.on_policy_n_minibatch_iters = 1
    config.loggers, config.create_json, config.evaluation, config.save_folder = [], False, False, str(tmp_path)
    models = {name: MlpConfig.get_from_yaml() for name in ("model_config", "critic_model_config")}
    algorithm = getattr(algorithms, name).get_from_yaml()
    trained = Experiment(task=task, algorithm_config=algorithm, seed=0, config=config, **models)
    before = [one.detach().clone() for one in trained.policy.parameters()]
    trained.run()
    assert trained.total_frames == 4 * LIMIT
    assert any((one != other).any() for one, other in zip(before, trained.policy.parameters(), strict=True))
