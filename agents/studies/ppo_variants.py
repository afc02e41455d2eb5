"""Train variants of agents/plain_ppo.py with several seeds, score them on `dev` levels, and write what was found.

    python agents/studies/ppo_variants.py cluttered_room --steps 1000000 --seeds 5 --out variants.json

Variants, each a single change:

- plain: as agents/plain_ppo.py.
- larger: four times as many worlds and as large minibatches, so a quarter of the updates, and a clipping range that
  falls to 0 (arXiv 2603.06009: more samples and a smaller step of the outer loop).
- annealed: the falling clipping range alone.
- muon: Muon for the weights of hidden layers, Adam for all others.
- values: the critic learns normalised targets.
- mirrored: half of the rows are learnt as if left and right were exchanged, and as if the agent had drawn their actions
  itself.
- weighted: the same, with the densities with which these actions were in fact drawn.
"""

import argparse
import json
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median

import numpy as np
import torch
from torch import Tensor, nn

import irsim_gym
from irsim_gym.envs import Mirror
from irsim_gym.evaluation import write_text

sys.path.insert(0, str(Path(__file__).parents[1]))

import plain_ppo

MOST = 10.0
"""Largest logarithm of a ratio of densities."""


@dataclass(frozen=True)
class Variant:
    """What differs from agents/plain_ppo.py."""

    scale: int = 1
    annealed: bool = False
    muon: bool = False
    values: bool = False
    mirrored: bool = False
    weighted: bool = False
    rate: float = plain_ppo.RATE


VARIANTS = {
    "plain": Variant(),
    "larger": Variant(scale=4, annealed=True),
    "annealed": Variant(annealed=True),
    "muon": Variant(muon=True),
    "values": Variant(values=True),
    "mirrored": Variant(mirrored=True),
    "weighted": Variant(mirrored=True, weighted=True),
}


class Optimizers:
    """Adam, or Muon and Adam, with one learning rate that falls to 0."""

    def __init__(self, agent: plain_ppo.Agent, variant: Variant) -> None:
        hidden = [] if not variant.muon else [net[2].weight for net in (agent.actor, agent.critic)]
        others = [one for one in agent.parameters() if not any(one is other for other in hidden)]
        self.all: list[torch.optim.Optimizer] = [torch.optim.Adam(others, variant.rate, eps=1e-5, fused=True)]
        if hidden:
            # Updates of the same size as Adam's, so that both share a learning rate (Liu et al. 2025).
            self.all.append(torch.optim.Muon(hidden, variant.rate, weight_decay=0.0, adjust_lr_fn="match_rms_adamw"))
        self.rate = variant.rate

    def anneal(self, share: float) -> None:
        """Set the learning rate to a share of that at the start."""
        for one in self.all:
            one.param_groups[0]["lr"] = self.rate * share

    def zero_grad(self) -> None:
        """Forget the gradients."""
        for one in self.all:
            one.zero_grad()

    def step(self) -> None:
        """Make a step."""
        for one in self.all:
            one.step()


class Scaled(nn.Module):
    """A critic whose network predicts normalised values."""

    def __init__(self, network: nn.Sequential) -> None:
        super().__init__()
        self.network, self.mean, self.deviation = network, 0.0, 1.0

    def __getitem__(self, layer: int) -> nn.Module:
        return self.network[layer]

    def forward(self, observed: Tensor) -> Tensor:
        """Return values, ``(n, 1)``."""
        return self.network(observed) * self.deviation + self.mean

    def follow(self, targets: Tensor, share: float = 0.1) -> None:
        """Move mean and deviation towards those of new targets, and keep all predictions (van Hasselt et al. 2016)."""
        mean = self.mean + share * (float(targets.mean()) - self.mean)
        deviation = max(self.deviation + share * (float(targets.std()) - self.deviation), 1e-4)
        last = self.network[-1]
        with torch.no_grad():
            last.weight *= self.deviation / deviation
            last.bias.copy_((last.bias * self.deviation + self.mean - mean) / deviation)
        self.mean, self.deviation = mean, deviation


def learn(agent: plain_ppo.Agent, optimizers: Optimizers, met: dict[str, Tensor], clip: float) -> None:
    """Improve the agent by what was met; see ``plain_ppo.learn``."""
    scale = getattr(agent.critic, "deviation", 1.0)
    for part in (
        part for _ in range(plain_ppo.EPOCHS) for part in torch.randperm(len(met["target"])).chunk(plain_ppo.PARTS)
    ):
        observed, action, log_prob, advantage, target = (column[part] for column in met.values())
        advantage = (advantage - advantage.mean()) / (advantage.std() + 1e-8)
        # A mirrored action may be so improbable that its ratio overflows; beyond the limit it teaches nothing.
        ratio = (agent.log_prob(agent.actor(observed), action) - log_prob).clamp(max=MOST).exp()
        gain = torch.minimum(ratio * advantage, ratio.clamp(1 - clip, 1 + clip) * advantage).mean()
        error = ((agent.critic(observed)[:, 0] - target) / scale).square().mean()
        optimizers.zero_grad()
        (0.5 * error - gain).backward()
        nn.utils.clip_grad_norm_(agent.parameters(), 0.5)
        optimizers.step()


def exchange_sides(agent: plain_ppo.Agent, met: dict[str, Tensor], mirror: Mirror, weighted: bool) -> None:
    """Mirror a random half of the rows.

    Their actions were drawn with the densities in ``met``, which stay if ``weighted``; else they become the densities
    with which the agent would draw the mirrored actions.
    """
    half = torch.rand(len(met["target"])) < 0.5
    for name, change in (("observed", mirror.observation), ("action", mirror.actions)):
        met[name][half] = torch.from_numpy(change(met[name][half].numpy()))
    if weighted:
        return
    mean = agent.actor(met["observed"][half])
    met["log_prob"][half] = agent.log_prob(mean, met["action"][half])


def train(scenario: str, steps: int, seed: int, variant: Variant) -> tuple[plain_ppo.Agent, float]:
    """Return an agent of a variant, and the CPU seconds that it took; see ``plain_ppo.train``."""
    torch.manual_seed(seed)
    n_worlds = plain_ppo.N_WORLDS * variant.scale
    rows = irsim_gym.torch_rows(irsim_gym.make_vec(scenario, n_worlds, autoreset_mode="SameStep"))
    rows.reset(seed=seed)
    agent = plain_ppo.Agent(rows.observation.shape[-1], rows.batch.action_space.shape[0])
    if variant.values:
        agent.critic = Scaled(agent.critic)
    optimizers, arrived = Optimizers(agent, variant), []
    updates, begun = -(-steps // (plain_ppo.N_STEPS * n_worlds)), time.process_time()
    for update in range(updates):
        left = 1 - update / updates
        optimizers.anneal(left)
        with torch.no_grad():
            met = plain_ppo.collect(agent, rows, plain_ppo.N_STEPS, arrived)
            if variant.mirrored:
                exchange_sides(agent, met, rows.batch.mirror(), variant.weighted)
            if variant.values:
                agent.critic.follow(met["target"])
        learn(agent, optimizers, met, plain_ppo.CLIP * (left if variant.annealed else 1.0))
    return agent, time.process_time() - begun


def play(scenario: str, steps: int, seeds: int, names: list[str], levels: int, out: Path) -> None:
    """Train and score all variants, and write what was found after each of them."""
    found = {}
    for name in names:
        rates, seconds = [], []
        for seed in range(seeds):
            agent, took = train(scenario, steps, seed, VARIANTS[name])
            scores = irsim_gym.evaluate(scenario, {name: agent}, levels=levels, split="dev", references=False)
            rates.append(round(100.0 * float(np.mean(scores.solved[name])), 2))
            seconds.append(round(took, 1))
        found[name] = {"success": rates, "cpu_seconds": seconds, "settings": asdict(VARIANTS[name])}
        print(f"{scenario:16} {name:10} median {median(rates):6.2f} %  {rates}  {median(seconds):.0f} s", flush=True)
        data = {"scenario": scenario, "steps": steps, "levels": levels, "variants": found}
        write_text(out, json.dumps(data, indent=1) + "\n")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="?", default="cluttered_room")
    parser.add_argument("--steps", type=int, default=plain_ppo.STEPS)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--levels", type=int, default=1000)
    parser.add_argument("--variants", nargs="+", default=list(VARIANTS), choices=list(VARIANTS))
    parser.add_argument("--out", type=Path, default=Path("variants.json"))
    given = parser.parse_args()
    torch.set_num_threads(1)
    play(given.scenario, given.steps, given.seeds, given.variants, given.levels, given.out)
