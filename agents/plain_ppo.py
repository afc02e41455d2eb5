"""PPO (Schulman et al. 2017) in one file of plain PyTorch, on rows without copies: a start for a trainer of your own.

It trains a robot that observes and acts with vectors, and evaluates it on levels that it has not met:

    python agents/plain_ppo.py cluttered_room --seed 0 --out policy.pt
"""

import argparse
from collections import deque
from collections.abc import Callable

import numpy as np
import torch
from torch import Tensor, nn

import irsim_gym

STEPS, RATE, N_WORLDS, N_STEPS = 1_000_000, 3e-3, 256, 64
GAMMA, LAMBDA, CLIP, ENTROPY, EPOCHS, PARTS = 0.99, 0.95, 0.2, 0.0, 2, 8


def network(n_in: int, n_out: int, last: float) -> nn.Sequential:
    """Return a network with two hidden layers; ``last`` scales the weights of the last one."""
    layers = nn.Sequential(nn.Linear(n_in, 64), nn.ReLU(), nn.Linear(64, 64), nn.ReLU(), nn.Linear(64, n_out))
    for layer, gain in zip(layers[::2], (2**0.5, 2**0.5, last), strict=True):
        nn.init.orthogonal_(layer.weight, gain)
        nn.init.zeros_(layer.bias)
    return layers


class Agent(nn.Module):
    """An actor with a normal distribution around its action, and a critic."""

    def __init__(self, n_observed: int, n_actions: int) -> None:
        super().__init__()
        self.actor, self.critic = network(n_observed, n_actions, 0.01), network(n_observed, 1, 1.0)
        self.log_std = nn.Parameter(torch.full((n_actions,), -0.5))

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Return the mean actions, as ``irsim_gym.evaluate`` asks for them."""
        with torch.no_grad():
            return self.actor(torch.as_tensor(observations)).numpy()

    def log_prob(self, mean: Tensor, action: Tensor) -> Tensor:
        """Return the logarithm of the density of actions, up to a constant."""
        return -(0.5 * ((action - mean) / self.log_std.exp()).square() + self.log_std).sum(-1)


def advantages(value: Tensor, after: Tensor, reward: Tensor, ended: Tensor) -> Tensor:
    """Return generalised advantages (Schulman et al. 2016); all arguments are ``(n_steps, n_worlds)``.

    Args:
        value: Value of what was observed before each step.
        after: Value of what followed it; 0 where the task ended.
        reward: What it was paid.
        ended: The step ended its episode, or cut it.
    """
    gain = reward + GAMMA * after - value
    decay = GAMMA * LAMBDA * (~ended).float()
    for t in reversed(range(len(gain) - 1)):
        gain[t] += decay[t] * gain[t + 1]
    return gain


def collect(agent: Agent, rows, n_steps: int, arrived: deque) -> dict[str, Tensor]:
    """Drive, and return what was met: a row for each step of each world.

    Args:
        agent: Who drives what ``irsim_gym.torch_rows`` returned.
        rows: The worlds.
        n_steps: Steps of each of them.
        arrived: Gets whether each episode that ended was successful.
    """
    columns, finals = [], []
    for t in range(n_steps):
        observed = rows.observation.clone()  # the next step overwrites it
        mean = agent.actor(observed)
        action = mean + agent.log_std.exp() * torch.randn_like(mean)
        rows.step(action)
        ended = rows.terminated | rows.truncated
        columns.append((observed, action, agent.log_prob(mean, action), rows.reward.clone(), ended))
        cut = rows.truncated.nonzero()[:, 0]
        finals.append((torch.full_like(cut, t), cut, rows.final_observation[cut]))
        arrived.extend(rows.episodes["is_success"].tolist())
    observed, action, log_prob, reward, ended = (torch.stack(column) for column in zip(*columns, strict=True))
    value = agent.critic(torch.cat([observed, rows.observation[None]]))[..., 0]
    after = value[1:] * ~ended
    step, world, final = (torch.cat(column) for column in zip(*finals, strict=True))
    after[step, world] = agent.critic(final)[:, 0]  # the time limit is no end of the task
    advantage = advantages(value[:-1], after, reward, ended)
    names = "observed", "action", "log_prob", "advantage", "target"
    met = observed, action, log_prob, advantage, advantage + value[:-1]
    return {name: one.flatten(0, 1) for name, one in zip(names, met, strict=True)}


def learn(agent: Agent, optimizer: torch.optim.Optimizer, met: dict[str, Tensor]) -> None:
    """Improve the agent by what was met."""
    for part in (part for _ in range(EPOCHS) for part in torch.randperm(len(met["target"])).chunk(PARTS)):
        observed, action, log_prob, advantage, target = (column[part] for column in met.values())
        advantage = (advantage - advantage.mean()) / (advantage.std() + 1e-8)
        ratio = (agent.log_prob(agent.actor(observed), action) - log_prob).exp()
        gain = torch.minimum(ratio * advantage, ratio.clamp(1 - CLIP, 1 + CLIP) * advantage).mean()
        error = (agent.critic(observed)[:, 0] - target).square().mean()
        optimizer.zero_grad()
        (0.5 * error - gain - ENTROPY * agent.log_std.sum()).backward()
        nn.utils.clip_grad_norm_(agent.parameters(), 0.5)
        optimizer.step()


def train(scenario: str, steps: int = STEPS, seed: int = 0, on_update: Callable = lambda agent, done: None) -> Agent:
    """Return an agent that has learned for some steps of all worlds; ``on_update`` gets it and the steps so far."""
    torch.set_num_threads(1)  # more do not help networks of this size
    torch.manual_seed(seed)
    rows = irsim_gym.torch_rows(irsim_gym.make_vec(scenario, N_WORLDS, autoreset_mode="SameStep"))
    rows.reset(seed=seed)
    agent = Agent(rows.observation.shape[-1], rows.batch.action_space.shape[0])
    optimizer = torch.optim.Adam(agent.parameters(), eps=1e-5, fused=True)
    arrived, updates = deque(maxlen=1000), -(-steps // (N_STEPS * N_WORLDS))
    for update in range(updates):
        optimizer.param_groups[0]["lr"] = RATE * (1 - update / updates)
        with torch.no_grad():
            met = collect(agent, rows, N_STEPS, arrived)
        learn(agent, optimizer, met)
        done = (update + 1) * N_STEPS * N_WORLDS
        on_update(agent, done)
        if update % 10 == 9 or update + 1 == updates:
            print(f"{done:>9,} steps: {np.mean(arrived):.1%} of the latest episodes arrive", flush=True)
    return agent


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="?", default="cluttered_room")
    parser.add_argument("--steps", type=int, default=STEPS)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--levels", type=int, default=1000, help="test levels of the evaluation")
    parser.add_argument("--out", help="file for the weights")
    given = parser.parse_args()
    trained = train(given.scenario, given.steps, given.seed)
    if given.out:
        torch.save(trained.state_dict(), given.out)
    print(irsim_gym.evaluate(given.scenario, {"plain_ppo": trained}, levels=given.levels))
