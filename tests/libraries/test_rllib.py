"""Ray RLlib: what its runner samples, what its learners get, and trainings that lose workers and nodes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
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
    from stable_baselines3 import ppo

    from irsim_gym.training.rllib.module import PolicyModule

    return RLModuleSpec(module_class=PolicyModule, model_config={"policy": getattr(ppo, policy), "arguments": {}})


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


def settings(folder: Path, **own: Any) -> Any:
    from irsim_gym.training.requests.training_request import TrainingRequest
    from irsim_gym.training.settings.engines import Engine

    file = folder / "small.yaml"
    keys = "n_steps: 16, gamma: 0.9, learning_rate: lin_1e-3"
    if own.get("algorithm", "ppo") == "ppo":
        keys += ", batch_size: 64, n_epochs: 1"
    file.write_text(f"default: {{n_timesteps: 2048, n_envs: 16, checkpoint_every: 512, {keys}}}\n", encoding="utf-8")
    return TrainingRequest("empty_goal", hyperparameters=file, **{"engine": Engine(0), **own}).settings()


@pytest.mark.parametrize("algorithm", ["ppo", "appo"])
def test_a_run_leaves_what_one_of_stable_baselines_leaves(algorithm, tmp_path):
    from irsim_gym.evaluation.comparison.comparison import evaluate
    from irsim_gym.evaluation.saved_policies.checkpoint_files import list_checkpoints, load_progress
    from irsim_gym.training.requests.train import train

    run = train(settings(tmp_path, algorithm=algorithm), tmp_path / "run")
    steps = [int(path.name) for path in list_checkpoints(run.checkpoints)]
    assert steps[-1] >= 2048
    assert len(steps) >= 3
    progress = load_progress(list_checkpoints(run.checkpoints)[-1])
    assert progress.cpu_seconds > 0.0
    assert run.finished()
    assert (run.folder / "tensorboard").is_dir()
    found = evaluate("empty_goal", [run.folder], levels=4, references=False)
    assert found.summaries[0].episodes == 4


def test_the_exported_policy_acts_as_rllib_does(tmp_path):
    """What evaluate, record, arena and play load has the weights of the learner."""
    import torch
    from stable_baselines3 import PPO

    from irsim_gym.training.requests.train import train
    from irsim_gym.training.rllib.config import make_config

    wanted = settings(tmp_path)
    run = train(wanted, tmp_path / "run")
    model = PPO.load(run.policy, device="cpu")
    config = make_config(wanted, wanted.engine.chosen(16), model, 0)
    from irsim_gym.rllib import ArrayEnvRunner

    sampler = ArrayEnvRunner(config=config, worker_index=None)
    (fragment,) = sampler.sample(explore=False)
    action, _ = model.predict(fragment.observation, deterministic=True)
    np.testing.assert_allclose(np.clip(fragment.action, -1.0, 1.0), action, atol=1e-6)
    with torch.no_grad():
        seen = torch.from_numpy(fragment.observation)
        _, logp, _ = model.policy.evaluate_actions(seen, torch.from_numpy(fragment.action))
    np.testing.assert_allclose(fragment.log_probability, logp.numpy(), atol=1e-4)


def test_a_stopped_run_goes_on_from_its_checkpoint(tmp_path):
    from irsim_gym.evaluation.requests.interruption import TrainingInterruptedError
    from irsim_gym.evaluation.saved_policies.checkpoint_files import load_progress, newest_checkpoint
    from irsim_gym.training.requests.train import train
    from irsim_gym.training.settings.run import Run

    wanted, place = settings(tmp_path), tmp_path / "run"

    def stop(run: Run) -> None:
        os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(TrainingInterruptedError, match="nothing is lost"):
        train(wanted, place, on_checkpoint=stop)
    stopped = load_progress(newest_checkpoint(place / "checkpoints"))
    assert 0 < stopped.steps < 2048
    run = train(wanted, place, resume=True)
    assert run.finished()
    steps = [row["steps"] for row in load_progress(newest_checkpoint(run.checkpoints)).history]
    assert steps == sorted(set(steps))
    assert steps[0] <= stopped.steps < steps[-1]


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
def test_training_goes_on_without_a_worker_and_without_a_node(cluster, tmp_path):
    """A worker is killed, then its node leaves and comes back."""
    from irsim_gym.evaluation.saved_policies.checkpoint_files import list_checkpoints
    from irsim_gym.training.requests.train import train
    from irsim_gym.training.settings.engines import Engine

    node = cluster.add_node(num_cpus=1)
    events: list[str] = []

    def disturb(run: Any) -> None:
        number = len(list_checkpoints(run.checkpoints))
        if number == 1:
            (pid, *_) = workers_of(cluster.head_node)
            os.kill(pid, signal.SIGKILL)
            events.append("killed")
        elif number == 2:
            events.append(f"a node with {len(workers_of(node))} left")
            cluster.remove_node(node)
        elif number == 3:
            cluster.add_node(num_cpus=1)
            events.append("came back")

    wanted = settings(tmp_path, engine=Engine(2, 8))
    run = train(wanted, tmp_path / "run", address=cluster.address, on_checkpoint=disturb)
    assert run.finished()
    assert [event.split()[0] for event in events] == ["killed", "a", "came"]
    assert int(list_checkpoints(run.checkpoints)[-1].name) >= 2048


@pytest.mark.slow
def test_ctrl_c_stops_the_command_and_all_its_processes(tmp_path):
    """The signal goes to the whole group, as from a terminal; nothing listens beyond the loopback."""
    place = tmp_path / "run"
    words = ["train", "empty_goal", "--engine", "rllib", "--workers", "1", "--dev-levels", "0", "--out", str(place)]
    started = subprocess.Popen([sys.executable, "-m", "irsim_gym", *words], start_new_session=True)
    try:
        waited_for(lambda: list(place.glob("tensorboard/*")))
        assert beyond_the_loopback(started.pid) == []
        os.killpg(started.pid, signal.SIGINT)
        assert started.wait(LONGEST_S) == 130
    finally:
        if started.poll() is None:
            os.killpg(started.pid, signal.SIGKILL)
    assert list(place.glob("checkpoints/*/state.pkl"))
    waited_for(lambda: not family(started.pid))


def family(session: int) -> list[int]:
    """Return the processes of a session."""
    found = []
    for place in Path("/proc").glob("[0-9]*"):
        try:
            own = int(place.joinpath("stat").read_text().rsplit(")", 1)[1].split()[3])
        except (OSError, ValueError):
            continue
        if own == session:
            found.append(int(place.name))
    return found


def beyond_the_loopback(session: int) -> list[str]:
    """Return the addresses at which processes of a session listen to other machines."""
    sockets = set()
    for pid in family(session):
        for link in Path(f"/proc/{pid}/fd").glob("*"):
            try:
                sockets.add(str(link.readlink()))
            except OSError:
                continue
    found = []
    for table in ("tcp", "tcp6"):
        for line in Path(f"/proc/net/{table}").read_text().splitlines()[1:]:
            _, local, _, state, *rest = line.split()
            here = local.split(":")[0] in ("0100007F", "0000000000000000FFFF00000100007F", "0" * 24 + "01000000")
            if state == "0A" and f"socket:[{rest[5]}]" in sockets and not here:
                found.append(local)
    return found
