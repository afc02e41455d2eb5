"""PPO with a Lagrangian multiplier (Ray et al. 2019): as few costs per episode as told, and then as much reward.

python agents/studies/lagrangian_ppo.py crossing --near 0.1 --limit 0.5
python agents/studies/lagrangian_ppo.py crossing --near 0.1              # no limit: plain PPO
"""

import argparse
import sys
from collections import deque
from pathlib import Path

import numpy as np
import torch
from torch import nn

import irsim_gym

sys.path.insert(0, str(Path(__file__).parents[1]))

import plain_ppo
from plain_ppo import N_STEPS, N_WORLDS, RATE, Agent, advantages, learn

MULTIPLIER_RATE = 0.05


class Rows:
    """Rows for ``plain_ppo.collect`` that keep the costs of each step."""

    def __init__(self, rows) -> None:
        self.rows, self.costs, self.spent, self.episodes_cost = rows, [], torch.zeros(N_WORLDS), deque(maxlen=1000)

    def __getattr__(self, name: str):
        return getattr(self.rows, name)

    def step(self, actions: torch.Tensor) -> None:
        """Step, and note the costs: those of the step, and those of episodes that end."""
        self.rows.step(actions)
        self.costs.append((self.rows.cost.clone(), self.rows.terminated | self.rows.truncated))
        self.spent += self.rows.cost
        ended = self.costs[-1][1]
        self.episodes_cost.extend(self.spent[ended].tolist())
        self.spent[ended] = 0.0


def train(scenario: str, near: float, limit: float, steps: int, seed: int = 0) -> tuple[Agent, float]:
    """Return an agent and the last multiplier; costs per episode above ``limit`` make it grow."""
    torch.set_num_threads(1)
    torch.manual_seed(seed)
    env = irsim_gym.make_vec(scenario, N_WORLDS, autoreset_mode="SameStep", task={"near": near})
    rows = Rows(irsim_gym.torch_rows(env))
    rows.reset(seed=seed)
    agent = Agent(rows.observation.shape[-1], rows.batch.action_space.shape[0])
    critic = plain_ppo.network(rows.observation.shape[-1], 1, 1.0)  # of the costs
    optimizer, judge = (torch.optim.Adam(one.parameters(), lr=RATE, eps=1e-5) for one in (agent, critic))
    arrived, multiplier, updates = deque(maxlen=1000), 0.0, -(-steps // (N_STEPS * N_WORLDS))
    for update in range(updates):
        optimizer.param_groups[0]["lr"] = RATE * (1 - update / updates)
        rows.costs = []
        with torch.no_grad():
            met = plain_ppo.collect(agent, rows, N_STEPS, arrived)
            cost, ended = (torch.stack(column) for column in zip(*rows.costs, strict=True))
            value = critic(torch.cat([met["observed"], rows.observation]))[:, 0].view(N_STEPS + 1, N_WORLDS)
            extra = advantages(value[:-1], value[1:] * ~ended, cost, ended).flatten()
            target = extra + value[:-1].flatten()
            multiplier = max(0.0, multiplier + MULTIPLIER_RATE * (np.mean(rows.episodes_cost or [0.0]) - limit))
            met["advantage"] = (met["advantage"] - multiplier * extra) / (1.0 + multiplier)
        learn(agent, optimizer, met)
        for part in torch.randperm(len(target)).chunk(plain_ppo.PARTS):
            judge.zero_grad()
            nn.functional.mse_loss(critic(met["observed"][part])[:, 0], target[part]).backward()
            judge.step()
    print(f"{np.mean(arrived):.1%} arrive, {np.mean(rows.episodes_cost):.2f} costs per episode, x {multiplier:.2f}")
    return agent, multiplier


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="?", default="cluttered_room")
    parser.add_argument("--near", type=float, default=0.1, help="a step nearer to another body costs 1 [m]")
    parser.add_argument("--limit", type=float, default=np.inf, help="costs per episode")
    parser.add_argument("--steps", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    train(**vars(parser.parse_args()))
