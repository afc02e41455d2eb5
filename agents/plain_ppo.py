"""PPO (Schulman et al. 2017) in one file of plain PyTorch, on rows without copies: a start for a trainer of your own.

    python agents/plain_ppo.py cluttered_room --seed 0 --out policy.pt

It trains robots that observe and act with vectors. The policy is evaluated on levels that it has not met.
"""

import argparse
from collections import deque

import numpy as np
import torch
from torch import Tensor, nn

import irsim_gym

GAMMA, LAMBDA, CLIP, ENTROPY, EPOCHS, PARTS = 0.995, 0.95, 0.2, 0.005, 3, 4


class Agent(nn.Module):
    """An actor with a normal distribution around its action, and a critic."""

    def __init__(self, n_observed: int, n_actions: int, width: int = 64) -> None:
        super().__init__()
        self.actor = nn.Sequential(
            nn.Linear(n_observed, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU(), nn.Linear(width, n_actions)
        )
        self.critic = nn.Sequential(
            nn.Linear(n_observed, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU(), nn.Linear(width, 1)
        )
        self.log_std = nn.Parameter(torch.full((n_actions,), -0.5))
        for layer in (one for one in self.modules() if isinstance(one, nn.Linear)):
            nn.init.orthogonal_(layer.weight, 2**0.5)
            nn.init.zeros_(layer.bias)
        self.actor[-1].weight.data *= 0.01

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Return the mean actions, as ``irsim_gym.evaluate`` asks for them."""
        with torch.no_grad():
            return self.actor(torch.as_tensor(observations)).numpy()

    def value(self, observed: Tensor) -> Tensor:
        """Return the return that the critic expects."""
        return self.critic(observed).squeeze(-1)

    def log_prob(self, mean: Tensor, action: Tensor) -> Tensor:
        """Return the logarithm of the density of actions, up to a constant."""
        return -(0.5 * ((action - mean) / self.log_std.exp()).square() + self.log_std).sum(-1)


def advantages(value: Tensor, after: Tensor, reward: Tensor, terminated: Tensor, ended: Tensor) -> Tensor:
    """Return generalised advantages (Schulman et al. 2016); all arguments are ``(n_steps, n_worlds)``.

    Args:
        value: Value of what was observed before each step.
        after: Value of what was observed after it, before any restart.
        reward: What it was paid.
        terminated: The step ended its episode.
        ended: It ended or cut it.
    """
    gain = reward + GAMMA * after * ~terminated - value
    decay = GAMMA * LAMBDA * (~ended).float()
    for t in reversed(range(len(gain) - 1)):
        gain[t] += decay[t] * gain[t + 1]
    return gain


def collect(agent: Agent, rows, n_steps: int, arrived: deque) -> dict[str, Tensor]:
    """Drive, and return what was met: a row for each step of each world."""
    met = {"observed": [], "mean": [], "action": [], "reward": [], "terminated": [], "ended": []}
    finals = []
    for t in range(n_steps):
        observed = rows.observation.clone()  # the next step overwrites it
        mean = agent.actor(observed)
        action = mean + agent.log_std.exp() * torch.randn_like(mean)
        rows.step(action)
        ended = rows.terminated | rows.truncated
        row = (observed, mean, action, rows.reward.clone(), rows.terminated.clone(), ended)
        for column, value in zip(met.values(), row, strict=True):
            column.append(value)
        cut = rows.truncated.nonzero()[:, 0]
        finals.append((torch.full_like(cut, t), cut, rows.final_observation[cut]))
        arrived.extend(rows.episodes["is_success"].tolist())
    met = {name: torch.stack(column) for name, column in met.items()}
    value = agent.value(torch.cat([met["observed"], rows.observation[None]]))
    step, world, final = (torch.cat(column) for column in zip(*finals, strict=True))
    after = value[1:].clone()
    after[step, world] = agent.value(final)  # the time limit is no end of the task
    met["log_prob"] = agent.log_prob(met["mean"], met["action"])
    met["advantage"] = advantages(value[:-1], after, met["reward"], met["terminated"], met["ended"])
    met["target"] = met["advantage"] + value[:-1]
    return {name: met[name].flatten(0, 1) for name in ("observed", "action", "log_prob", "advantage", "target")}


def learn(agent: Agent, optimizer: torch.optim.Optimizer, met: dict[str, Tensor]) -> None:
    """Improve the agent by what was met."""
    for part in (part for _ in range(EPOCHS) for part in torch.randperm(len(met["target"])).chunk(PARTS)):
        observed, action, log_prob, advantage, target = (column[part] for column in met.values())
        advantage = (advantage - advantage.mean()) / (advantage.std() + 1e-8)
        ratio = (agent.log_prob(agent.actor(observed), action) - log_prob).exp()
        gain = torch.minimum(ratio * advantage, ratio.clamp(1 - CLIP, 1 + CLIP) * advantage).mean()
        error = (agent.value(observed) - target).square().mean()
        loss = 0.5 * error - gain - ENTROPY * agent.log_std.sum()
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(agent.parameters(), 0.5)
        optimizer.step()


def train(
    scenario: str, steps: int, seed: int = 0, n_worlds: int = 256, n_steps: int = 64, rate: float = 3e-3, save=None
):
    """Train an agent."""
    torch.set_num_threads(1)  # more do not help networks of this size
    torch.manual_seed(seed)
    rows = irsim_gym.torch_rows(irsim_gym.make_vec(scenario, n_worlds, autoreset_mode="SameStep"))
    rows.reset(seed=seed)
    agent = Agent(rows.observation.shape[-1], rows.batch.action_space.shape[0])
    optimizer = torch.optim.Adam(agent.parameters(), lr=rate, eps=1e-5, fused=True)
    arrived, updates = deque(maxlen=1000), -(-steps // (n_steps * n_worlds))
    for update in range(updates):
        optimizer.param_groups[0]["lr"] = rate * (1 - update / updates)
        with torch.no_grad():
            met = collect(agent, rows, n_steps, arrived)
        learn(agent, optimizer, met)
        if save:
            save(agent, (update + 1) * n_steps * n_worlds)
        if update % 10 == 9 or update + 1 == updates:
            done = (update + 1) * n_steps * n_worlds
            print(f"{done:>9,} steps: {np.mean(arrived):.1%} of the last episodes arrived", flush=True)
    return agent
