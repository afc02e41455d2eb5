"""Ray RLlib: what its runner samples, what its learners get, and a training that loses a worker and a node."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from needed import library
from scenes import ENDS, FORMS, LIMIT, paid_alone, team

os.environ["RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"] = "0"  # before Ray is imported: on the loopback alone
os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
GAMMA = 0.9
LONGEST_S = 500


@pytest.fixture(scope="module", autouse=True)
def ray():
    return library("ray")


def configured(scenario: Any, kind: str = "PPO", **chosen: Any) -> Any:
    from ray.rllib.algorithms.appo import APPOConfig
    from ray.rllib.algorithms.ppo import PPOConfig

    from irsim_gym import rllib

    config = rllib.configure({"PPO": PPOConfig, "APPO": APPOConfig}[kind](), scenario, **chosen)
    config.rl_module(model_config={"fcnet_hiddens": [16], "vf_share_layers": False})
    config.debugging(seed=0)
    config.training(gamma=GAMMA)
    return config


def networks(policy: str) -> Any:
    """Networks of Stable-Baselines3: they take dicts too, and have their values on runners."""
    from ray.rllib.core.rl_module.rl_module import RLModuleSpec
    from rllib_networks import PolicyModule
    from stable_baselines3 import ppo

    return RLModuleSpec(module_class=PolicyModule, model_config={"policy": getattr(ppo, policy)})


def runner(scenario: Any, **chosen: Any) -> Any:
    from irsim_gym.rllib import ArrayEnvRunner

    config = configured(scenario, first_level=5, **chosen)
    return ArrayEnvRunner(config=config.rl_module(rl_module_spec=networks("MlpPolicy")), worker_index=None)


def test_the_first_rollout_is_that_of_the_vec_env():
    """Same levels and actions: observations are equal bit for bit, and so are ends and rewards."""
    from irsim_gym import sb3

    sampler = runner("cluttered_room", worlds_per_worker=6, steps=250)
    (fragment,) = sampler.sample()
    env = sb3.make_vec_env("cluttered_room", 6, seed=5, render_mode=None)
    rows = len(fragment) // 6
    action, seen = (array.reshape(6, rows, *array.shape[1:]) for array in (fragment.action, fragment.observation))
    reward, ended = (array.reshape(6, rows) for array in (fragment.reward, fragment.terminated | fragment.cut))
    last = env.reset()
    for t in range(rows):
        np.testing.assert_array_equal(seen[:, t], last)
        last, paid, dones, _ = env.step(np.clip(action[:, t], -1.0, 1.0))
        np.testing.assert_array_equal(reward[:, t], paid)
        np.testing.assert_array_equal(ended[:, t], dones | (t == rows - 1))
    assert ended[:, :-1].any()


@pytest.mark.parametrize("form", ["vectors", *FORMS])
def test_the_team_is_rows_without_those_that_wait(form):
    from irsim_gym.rllib import ArrayEnvRunner

    large = {"observations": [{"name": "goal"}, {"name": "occupancy_image", "pixels": 40, "metres": 4}]}
    task = large if form == "pictures" else FORMS.get(form, {})
    config = configured(team(**task), team="episode", worlds_per_worker=2, steps=3 * LIMIT)
    if form in ("dicts", "pictures"):
        config.rl_module(rl_module_spec=networks("MultiInputPolicy"))
    (fragment,) = ArrayEnvRunner(config=config, worker_index=None).sample()
    assert len(fragment) == 2 * 3 * sum(ENDS.values())
    assert fragment.steps == 2 * 3 * 3 * LIMIT
    lengths = np.diff(np.append(-1, np.flatnonzero(fragment.terminated | fragment.cut)))
    assert lengths.tolist() == [end for end in ENDS.values() for _ in range(3)] * 2
    assert fragment.terminated.sum() == 2 * 3 * 2
    assert fragment.cut.sum() == 2 * 3


def test_rewards_of_an_episode_are_those_without_a_library():
    """The robots drive ahead whatever the policy does, within a hundredth."""
    sampler = runner(team(), team="episode", worlds_per_worker=1, steps=LIMIT)
    (fragment,) = sampler.sample()
    paid = np.split(fragment.reward, np.cumsum(list(ENDS.values()))[:-1])
    for own, expected in zip(paid, paid_alone().values(), strict=True):
        assert own.sum() == pytest.approx(expected, abs=0.05)


ONES = {"rewards": [{"name": "time", "weight": float(LIMIT)}], "audit": False}
"""Each step costs 1, so that the value of a state is known."""


def known_fragment(steps: int) -> Any:
    sampler = runner(team(**ONES), team="episode", worlds_per_worker=1, steps=steps)
    (fragment,) = sampler.sample()
    return sampler.module, fragment


def worth(steps: int) -> float:
    return -(1.0 - GAMMA**steps) / (1.0 - GAMMA)


def known_targets(module: Any, fragment: Any, after: np.ndarray, steps: int) -> list[float]:
    """Ends stop the sum of -1s; the time limit, and the end of the fragment, go on with the value of what follows."""
    targets, cuts = [], iter(after.tolist())
    for end in ENDS.values():
        rows = [step for step in range(steps) if step % LIMIT < end]
        values: dict[int, float] = {}
        for step in rows:
            left = end - step % LIMIT
            is_cut = step + left > steps or end == LIMIT
            left = min(left, steps - step)
            if is_cut and step + left not in values:
                values[step + left] = next(cuts)
            targets.append(worth(left) + (GAMMA**left * values[step + left] if is_cut else 0.0))
    return targets


@pytest.mark.parametrize("steps", [2 * LIMIT, LIMIT + 5])
def test_targets_of_ppo_on_a_task_of_known_value(steps):
    import torch
    from ray.rllib.core import DEFAULT_MODULE_ID

    from irsim_gym.envs.rllib.batches import advantage_batch

    module, fragment = known_fragment(steps)
    batch = advantage_batch(module, [fragment], GAMMA, 1.0)[DEFAULT_MODULE_ID]
    with torch.no_grad():
        after = module.compute_values({"obs": torch.from_numpy(fragment.following)}).numpy()
    np.testing.assert_allclose(batch["value_targets"], known_targets(module, fragment, after, steps), atol=1e-4)


@pytest.mark.parametrize("steps", [2 * LIMIT, LIMIT + 5])
def test_targets_of_appo_on_a_task_of_known_value(steps):
    """V-trace of a policy on its own rows is the sum of rewards."""
    import torch
    from ray.rllib.algorithms.impala.torch.vtrace_torch_v2 import vtrace_torch
    from ray.rllib.core import DEFAULT_MODULE_ID

    from irsim_gym.envs.rllib.batches import sequence_batch

    module, fragment = known_fragment(steps)
    batch = sequence_batch(module, [fragment], GAMMA)[DEFAULT_MODULE_ID]
    assert batch["loss_mask"].all()
    with torch.no_grad():
        values = module.compute_values({"obs": batch["obs"]})
        after = module.compute_values({"obs": torch.from_numpy(fragment.following)}).numpy()
    found, _ = vtrace_torch(
        target_action_log_probs=batch["action_logp"][:, None],
        behaviour_action_log_probs=batch["action_logp"][:, None],
        discounts=((1.0 - batch["terminateds"].float()) * GAMMA)[:, None],
        rewards=batch["rewards"][:, None],
        values=values[:, None],
        bootstrap_values=torch.zeros(1),
    )
    np.testing.assert_allclose(found[:, 0], known_targets(module, fragment, after, steps), atol=1e-4)


def test_targets_agree_with_stable_baselines():
    """The same weights, rollout and lambda give the advantages that its buffer computes."""
    import torch
    from ray.rllib.core import DEFAULT_MODULE_ID
    from stable_baselines3.common.buffers import RolloutBuffer

    from irsim_gym.envs.rllib.batches import advantage_batch

    steps, n_worlds = 150, 4
    sampler = runner("cluttered_room", worlds_per_worker=n_worlds, steps=steps, max_steps=20)
    (fragment,) = sampler.sample()
    batch = advantage_batch(sampler.module, [fragment], GAMMA, 0.8)[DEFAULT_MODULE_ID]
    with torch.no_grad():
        values = sampler.module.compute_values({"obs": torch.from_numpy(fragment.observation)}).numpy()
        after = sampler.module.compute_values({"obs": torch.from_numpy(fragment.following)}).numpy()
    env = sampler.env
    buffer = RolloutBuffer(steps, env.single_observation_space, env.single_action_space, "cpu", 0.8, GAMMA, n_worlds)
    of = {name: getattr(fragment, name).reshape(n_worlds, steps) for name in ("reward", "terminated", "cut")}
    following = np.zeros(len(fragment))
    following[fragment.cut] = after
    following = following.reshape(n_worlds, steps)
    started = np.ones(n_worlds)
    for t in range(steps):
        goes_on = of["cut"][:, t] & (t < steps - 1)
        paid = of["reward"][:, t] + GAMMA * np.where(goes_on, following[:, t], 0.0)
        seen = fragment.observation.reshape(n_worlds, steps, -1)[:, t]
        value = torch.from_numpy(values.reshape(n_worlds, steps)[:, t])
        buffer.add(seen, np.zeros((n_worlds, 2)), paid, started, value, value)
        started = (of["terminated"][:, t] | goes_on).astype(float)
    last = torch.from_numpy(following[:, -1].astype(np.float32))
    buffer.compute_returns_and_advantage(last, of["terminated"][:, -1])
    np.testing.assert_allclose(batch["value_targets"].reshape(n_worlds, steps).T, buffer.returns, atol=1e-4)


def test_fragments_are_shared_out_among_learners():
    from ray.rllib.utils.minibatch_utils import ShardEpisodesIterator

    sampler = runner("cluttered_room", worlds_per_worker=5, steps=31)
    fragments = [*sampler.sample(), *sampler.sample()]
    shards = list(ShardEpisodesIterator(fragments, num_shards=3, len_lookback_buffer=1))
    lengths = [sum(map(len, shard)) for shard in shards]
    assert sum(lengths) == 2 * 5 * 31
    assert max(lengths) - min(lengths) <= 1
    for shard in shards:
        for fragment in shard:
            assert (fragment.terminated | fragment.cut)[-1]
            assert len(fragment.following) == fragment.cut.sum()


@pytest.mark.parametrize("mode", ["sync", "vector_entry_point"])
def test_registered_environments_work_with_rllibs_own_runner(mode):
    from ray.rllib.algorithms.ppo import PPOConfig
    from ray.rllib.env.single_agent_env_runner import SingleAgentEnvRunner

    from irsim_gym import rllib

    rllib.register_environments("irsim_gym/empty_goal-v0")
    config = PPOConfig().environment("irsim_gym/empty_goal-v0", env_config={"max_steps": 7})
    config.env_runners(num_envs_per_env_runner=3, gym_env_vectorize_mode=mode)
    sampler = SingleAgentEnvRunner(config=config, worker_index=None)
    episodes = sampler.sample(num_timesteps=60)
    assert sum(map(len, episodes)) >= 60
    assert max(map(len, episodes)) == 7


@pytest.mark.parametrize("kind", ["PPO", "APPO"])
def test_an_algorithm_learns(kind):
    """Its weights change, and its metrics count what was sampled."""
    from ray.rllib.core import DEFAULT_MODULE_ID

    from irsim_gym.rllib import CPU_SECONDS, SUCCESS

    config = configured("empty_goal", kind, worlds_per_worker=16, steps=64, first_level=0)
    config.reporting(min_time_s_per_iteration=None, min_sample_timesteps_per_iteration=16 * 64)
    algorithm = config.build_algo()
    try:
        before = algorithm.learner_group.get_weights()[DEFAULT_MODULE_ID]
        before = {name: np.array(weights) for name, weights in before.items()}
        sampled: dict[str, Any] = {}
        while sampled.get("num_env_steps_sampled_lifetime", 0) < 4 * 16 * 64:
            sampled = algorithm.train()["env_runners"]
        after = algorithm.learner_group.get_weights()[DEFAULT_MODULE_ID]
        assert any(not np.array_equal(weights, after[name]) for name, weights in before.items())
        assert 0.0 <= sampled[SUCCESS] <= 1.0
        assert sampled[CPU_SECONDS] > 0.0
    finally:
        algorithm.stop()


def children(pid: int, name: str) -> list[int]:
    """Return the processes below one whose command begins with a name."""
    found = []
    for place in Path("/proc").glob("[0-9]*"):
        try:
            parent = int(place.joinpath("stat").read_text().rsplit(")", 1)[1].split()[1])
            command = place.joinpath("cmdline").read_bytes()
        except (OSError, ValueError):
            continue
        if parent == pid and command.startswith(name.encode()):
            found.append(int(place.name))
    return found


def workers_of(node: Any) -> list[int]:
    """Return the sampling processes on a node of a simulated cluster."""
    (raylet,) = node.all_processes["raylet"]
    return children(raylet.process.pid, "ray::ArrayEnvRunner")


@pytest.fixture
def cluster(ray):
    from ray.cluster_utils import Cluster

    ray.shutdown()  # an earlier test may have started one
    made = Cluster(initialize_head=True, head_node_args={"num_cpus": 2, "include_dashboard": False})
    yield made
    ray.shutdown()
    made.shutdown()


def waited_for(there: Any) -> Any:
    until = time.monotonic() + LONGEST_S
    while time.monotonic() < until:
        found = there()
        if found:
            return found
        time.sleep(0.5)
    raise AssertionError("it never came")


@pytest.mark.slow
def test_training_goes_on_without_a_worker_and_without_a_node(cluster):
    """A worker is killed, then its node leaves and comes back."""
    import ray

    node = cluster.add_node(num_cpus=1)
    ray.init(cluster.address)
    config = configured("empty_goal", workers=2, worlds_per_worker=8, steps=16, first_level=0)
    config.env_runners(sample_timeout_s=300.0)
    config.fault_tolerance(
        restart_failed_env_runners=True, max_num_env_runner_restarts=1_000_000, delay_between_env_runner_restarts_s=0.0
    )
    algorithm = config.build_algo()

    def sampled_more() -> bool:
        sampled = algorithm.train().get("env_runners", {})
        return int(sampled.get("num_env_steps_sampled_lifetime", 0)) >= goal

    try:
        goal = 256
        waited_for(sampled_more)
        (pid, *_) = workers_of(cluster.head_node)
        os.kill(pid, signal.SIGKILL)
        goal = 1024
        waited_for(sampled_more)
        assert workers_of(node)
        cluster.remove_node(node)
        goal = 2048
        waited_for(sampled_more)
        cluster.add_node(num_cpus=1)
        goal = 4096
        waited_for(sampled_more)
    finally:
        algorithm.stop()
