"""Steps per CPU second of the libraries that are installed, beside Stable-Baselines3 in the same process.

    python benchmarks/libraries.py --json FILE        (in each environment of `make test-libraries`)

Each library collects experience with its own loop and a network of its own kind (two hidden layers of 64), in the same
worlds, without learning from it. They take turns, and the least time of several rounds counts. `torch_rows` is a loop
of one's own.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import library_pages
import results
import torch
from machine import describe
from rich.table import Table
from timing import seconds, summed_up
from torch import nn

import irsim_gym

SCENARIO = "cluttered_room"
Collect = Callable[[], Any]


def actor(n_in: int, n_out: int = 2) -> nn.Sequential:
    """Return a network of the size that all libraries use."""
    return nn.Sequential(nn.Linear(n_in, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh(), nn.Linear(64, n_out))


def stable_baselines3(n_worlds: int, n_steps: int, ppo: Any = None) -> Collect:
    """PPO's rollouts, by Stable-Baselines3 or, with another PPO, SBX."""
    from stable_baselines3 import PPO
    from stable_baselines3.common.callbacks import CallbackList

    env = irsim_gym.sb3.make_vec_env(SCENARIO, n_worlds, seed=0)
    given = {} if ppo else {"device": "cpu"}
    model = (ppo or PPO)("MlpPolicy", env, n_steps=n_steps, batch_size=n_steps * n_worlds, **given)
    model._setup_learn(1)
    callback = CallbackList([])
    callback.init_callback(model)
    return lambda: model.collect_rollouts(model.env, callback, model.rollout_buffer, n_steps)


def sbx(n_worlds: int, n_steps: int) -> Collect:
    """Rollouts of SBX's PPO."""
    from sbx import PPO

    return stable_baselines3(n_worlds, n_steps, PPO)


def torch_rows(n_worlds: int, n_steps: int) -> Collect:
    """A loop of one's own on tensors without copies."""
    rows = irsim_gym.torch_rows(irsim_gym.make_vec(SCENARIO, n_worlds, autoreset_mode="SameStep"))
    rows.reset(seed=0)
    net = actor(rows.observation.shape[1])

    def collect() -> None:
        with torch.no_grad():
            for _ in range(n_steps):
                mean = net(rows.observation.clone())
                rows.step(mean + 0.6 * torch.randn_like(mean))

    return collect


def torchrl(n_worlds: int, n_steps: int) -> Collect:
    """Rollouts of TorchRL around the native batch."""
    from tensordict.nn import TensorDictModule
    from torchrl.envs import GymWrapper

    env = GymWrapper(irsim_gym.make_vec(SCENARIO, n_worlds, autoreset_mode="Disabled"))
    policy = TensorDictModule(actor(env.observation_spec["observation"].shape[-1]), ["observation"], ["action"])
    return lambda: env.rollout(n_steps, policy, break_when_any_done=False)


def skrl(n_worlds: int, n_steps: int) -> Collect:
    """Steps of skrl's wrapper around the native batch."""
    from skrl.envs.wrappers.torch import wrap_env

    env = wrap_env(irsim_gym.make_vec(SCENARIO, n_worlds), wrapper="gymnasium")
    net, seen = actor(env.observation_space.shape[0]), [env.reset()[0]]

    def collect() -> None:
        with torch.no_grad():
            for _ in range(n_steps):
                mean = net(seen[0])
                seen[0] = env.step(mean + 0.6 * torch.randn_like(mean))[0]

    return collect


def tianshou(n_worlds: int, n_steps: int) -> Collect:
    """Tianshou's collector around the native batch, with its PPO."""
    page = library_pages.shown("tianshou")
    envs = page["Worlds"](irsim_gym.make_batch(SCENARIO, n_worlds, autoreset=False))
    buffer = page["VectorReplayBuffer"](n_steps * n_worlds, n_worlds)
    collector = page["Collector"](page["learner"](envs), envs, buffer)
    collector.reset()
    return lambda: collector.collect(n_step=n_steps * n_worlds)


def pufferlib(n_worlds: int, n_steps: int) -> Collect:
    """Steps of PufferLib's serial vector environment with robots as rows."""
    import pufferlib.vector

    rows = library_pages.shown("pufferlib")["Rows"]
    given = {"scenario": SCENARIO, "num_envs": n_worlds}
    envs = pufferlib.vector.make(rows, env_kwargs=given, num_envs=1, backend=pufferlib.vector.Serial)
    envs.reset(seed=0)
    net = actor(envs.single_observation_space.shape[0])

    def collect() -> None:
        with torch.no_grad():
            for _ in range(n_steps):
                mean = net(torch.from_numpy(envs.observations))
                envs.step((mean + 0.6 * torch.randn_like(mean)).clamp(-1, 1).numpy())

    return collect


CASES: dict[str, Callable[[int, int], Collect]] = {
    "stable_baselines3": stable_baselines3,
    "torch_rows": torch_rows,
    "sbx": sbx,
    "torchrl": torchrl,
    "skrl": skrl,
    "tianshou": tianshou,
    "pufferlib": pufferlib,
}
"""What is measured, by the name of the module that it needs."""


def measure(n_worlds: int, n_steps: int, rounds: int) -> dict[str, float]:
    """Return the steps per CPU second of each library that is installed: a first round of each does not count."""
    torch.set_num_threads(1)
    torch.manual_seed(0)
    here = {name: case for name, case in CASES.items() if name == "torch_rows" or find_spec(name)}
    collects = {name: case(n_worlds, n_steps) for name, case in here.items()}
    taken: dict[str, list[float]] = {name: [] for name in collects}
    for _ in range(rounds + 1):
        for name, collect in collects.items():
            taken[name].append(seconds(collect))
    return {name: n_worlds * n_steps / summed_up(values[1:]).least for name, values in taken.items()}


def main() -> None:
    """Measure, and show how many times as fast as Stable-Baselines3 each library is."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--worlds", type=int, default=64)
    parser.add_argument("--steps", type=int, default=32, help="of each world in a round")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--json", type=Path, help="write the figures, with machine and versions, to this file")
    asked = parser.parse_args()
    found = measure(asked.worlds, asked.steps, asked.rounds)
    table = Table("library", "steps per CPU second", "times Stable-Baselines3")
    for name, rate in found.items():
        table.add_row(name, f"{rate:,.0f}", f"{rate / found['stable_baselines3']:.2f}")
    results.console().print(table)
    if asked.json:
        results.write(asked.json, {"machine": describe(), "worlds": asked.worlds, "steps_per_cpu_s": found})


if __name__ == "__main__":
    main()
