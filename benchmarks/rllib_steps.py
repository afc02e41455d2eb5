"""Steps per CPU second of PPO on cluttered_room: RLlib and Stable-Baselines3, in turns.

Needs ``pip install "irsim_gym[rllib]"``. Both learn in one process, with the same networks and batches.
"""

from __future__ import annotations

import argparse
import logging
import os
import time
import warnings
from collections.abc import Callable
from statistics import median

os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
os.environ["RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"] = "0"

import ray
import torch
from ray.rllib.algorithms.algorithm import Algorithm
from ray.rllib.algorithms.ppo import PPOConfig
from stable_baselines3 import PPO

from irsim_gym import rllib, sb3

SCENARIO, WORLDS, STEPS, EPOCHS, MINIBATCH = "cluttered_room", 128, 64, 3, 2048
ID = f"irsim_gym/{SCENARIO}-v0"


def from_rllib() -> Algorithm:
    rllib.register_environments(ID)
    config = PPOConfig().environment(ID)
    config.env_runners(
        num_env_runners=0,
        num_envs_per_env_runner=WORLDS,
        rollout_fragment_length=STEPS,
        gym_env_vectorize_mode="vector_entry_point",
    )
    config.training(train_batch_size_per_learner=WORLDS * STEPS, minibatch_size=MINIBATCH, num_epochs=EPOCHS)
    config.training(lr=3e-3, gamma=0.995, use_kl_loss=False)
    config.rl_module(model_config={"fcnet_hiddens": [64, 64], "fcnet_activation": "relu", "vf_share_layers": False})
    return config.build_algo()


def baselines() -> PPO:
    env = sb3.make_vec_env(SCENARIO, WORLDS, seed=0, render_mode=None)
    layers = {"net_arch": {"pi": [64, 64], "vf": [64, 64]}, "activation_fn": torch.nn.ReLU}
    sizes = {"n_steps": STEPS, "batch_size": MINIBATCH, "n_epochs": EPOCHS}
    return PPO("MlpPolicy", env, policy_kwargs=layers, device="cpu", learning_rate=3e-3, gamma=0.995, **sizes)


def cpu_seconds(action: Callable[[], object]) -> float:
    begun = time.process_time()
    action()
    return time.process_time() - begun


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    warnings.simplefilter("ignore")
    logging.disable(logging.WARNING)
    torch.set_num_threads(1)
    ray.init("local", num_cpus=1, include_dashboard=False, logging_level=logging.ERROR, log_to_driver=False)
    algorithm, model = from_rllib(), baselines()
    n_steps = WORLDS * STEPS
    actions: dict[str, Callable[[], object]] = {
        "PPO, RLlib": algorithm.train,
        "PPO, Stable-Baselines3": lambda: model.learn(n_steps, reset_num_timesteps=False),
        "sampling, RLlib": algorithm.env_runner_group.local_env_runner.sample,
    }
    speeds: dict[str, list[float]] = {name: [] for name in actions}
    for turn in range(rounds + 1):
        for name, action in actions.items():
            seconds = cpu_seconds(action)
            if turn:
                speeds[name].append(n_steps / seconds)
    for name, found in speeds.items():
        print(f"{name:<28} {median(found):>10,.0f} steps per CPU second (median of {rounds})", flush=True)
    ray.shutdown()


if __name__ == "__main__":
    main()
