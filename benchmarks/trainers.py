"""CPU seconds to 98 % in cluttered_room: agents/plain_ppo.py and Stable-Baselines3's PPO, in turns.

    python benchmarks/trainers.py --seeds 0 1 2 --json benchmarks/results/trainers.json

Each training is a process of its own. Its CPU time counts from its start, so that imports, compiled code read from the
disk, new levels and everything else are in it. Policies are kept on the way. At the end they drive the first 1,000
`dev` levels, which does not count. A mark is reached at the first policy after which success never falls below it.
"""

from __future__ import annotations

import argparse
import copy
import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import results
from machine import describe
from rich.table import Table

AGENTS = Path(__file__).parents[1] / "agents"
SCENARIO, EVERY, LEVELS, MARK = "cluttered_room", 65_536, 1000, 0.98
TRAINERS = ("plain", "sb3_same", "sb3_shipped")
"""The example, Stable-Baselines3 with the same settings, and with those of agents/hyperparameters/ppo.yaml."""


def main() -> None:
    """Run trainings in turns, show their figures and write them down."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trainers", nargs="+", choices=TRAINERS, default=TRAINERS)
    parser.add_argument("--seeds", nargs="+", type=int, default=[0, 1, 2])
    parser.add_argument("--steps", type=int, help="steps of the example and of the same settings; fewer to try it")
    parser.add_argument("--json", type=Path, help="write the figures, with machine and versions, to this file")
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.child:
        print(json.dumps(curve(asked.trainers[0], asked.seeds[0], asked.steps)))
        return
    table = Table("trainer", "seed", "CPU s to 98 %", "CPU s", "steps", "success at the end")
    found: dict[str, Any] = {"machine": describe(), "runs": []}
    for seed in asked.seeds:
        for trainer in asked.trainers:
            rows = _in_a_process(trainer, seed, asked.steps)
            seconds = reached(rows)
            found["runs"].append({"trainer": trainer, "seed": seed, "cpu_s_to_98": seconds, "curve": rows})
            last = rows[-1]
            told = "-" if seconds is None else f"{seconds:.1f}"
            table.add_row(trainer, str(seed), told, f"{last[1]:.1f}", f"{last[0]:,}", f"{last[2]:.1%}")
            if asked.json:
                results.write(asked.json, found)
    results.console().print(table)


def reached(rows: list[list[float]]) -> float | None:
    """Return the CPU seconds of the first policy from which on success is never below the mark."""
    below = [k for k, (_, _, success) in enumerate(rows) if success < MARK]
    first = below[-1] + 1 if below else 0
    return rows[first][1] if first < len(rows) else None


def _in_a_process(trainer: str, seed: int, steps: int | None) -> list[list[float]]:
    more = [] if steps is None else ["--steps", str(steps)]
    command = [sys.executable, __file__, "--child", "--trainers", trainer, "--seeds", str(seed), *more]
    said = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
    rows: list[list[float]] = json.loads(said.splitlines()[-1])
    return rows


def curve(trainer: str, seed: int, steps: int | None) -> list[list[float]]:
    """Train, and return steps, CPU seconds and success on `dev` levels on the way."""
    kept: list[tuple[int, float, Any]] = []

    def keep(policy: Any, done: int) -> None:
        if done // EVERY > (kept[-1][0] // EVERY if kept else 0):
            kept.append((done, time.process_time(), copy.deepcopy(policy)))

    (_plain if trainer == "plain" else _sb3)(trainer, seed, steps, keep)
    import irsim_gym

    policies = {str(done): policy for done, _, policy in kept}
    found = irsim_gym.evaluate(SCENARIO, policies, levels=LEVELS, split="dev", references=False)
    return [[done, s, one.success.value] for (done, s, _), one in zip(kept, found.summaries, strict=True)]


def _plain(trainer: str, seed: int, steps: int | None, keep: Any) -> None:
    sys.path.insert(0, str(AGENTS))
    import plain_ppo

    plain_ppo.train(SCENARIO, steps or plain_ppo.STEPS, seed, on_update=keep)


def _sb3(trainer: str, seed: int, steps: int | None, keep: Any) -> None:
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.callbacks import BaseCallback

    from irsim_gym import sb3
    from irsim_gym.training import load_hyperparameters

    class Keep(BaseCallback):
        def _on_rollout_start(self) -> None:
            if self.num_timesteps:
                keep(Predict(self.model.policy), self.num_timesteps)

        def _on_training_end(self) -> None:
            keep(Predict(self.model.policy), self.num_timesteps)

        def _on_step(self) -> bool:
            return True

    torch.set_num_threads(1)
    shipped = load_hyperparameters("ppo", f"irsim_gym/{SCENARIO}-v0")
    arguments, n_worlds, n_steps = shipped.algorithm_arguments(), shipped.n_envs, shipped.n_timesteps
    if trainer == "sb3_same":
        changed, n_worlds, n_steps = same_settings(steps)
        arguments.update(changed)
    env = sb3.make_vec_env(SCENARIO, n_worlds, seed)
    PPO("MlpPolicy", env, seed=seed, device="cpu", **arguments).learn(n_steps, callback=Keep())


def same_settings(steps: int | None) -> tuple[dict[str, Any], int, int]:
    """Return the settings of the example in the words of Stable-Baselines3, its worlds and its steps."""
    sys.path.insert(0, str(AGENTS))
    import plain_ppo as ours

    settings = {
        "learning_rate": lambda left: left * ours.RATE,
        "n_epochs": ours.EPOCHS,
        "batch_size": ours.N_WORLDS * ours.N_STEPS // ours.PARTS,
        "gamma": ours.GAMMA,
        "gae_lambda": ours.LAMBDA,
        "clip_range": ours.CLIP,
        "ent_coef": ours.ENTROPY,
    }
    return {"n_steps": ours.N_STEPS, **settings}, ours.N_WORLDS, steps or ours.STEPS


class Predict:
    """The mean actions of a policy of Stable-Baselines3, whose distribution cannot be copied."""

    def __init__(self, policy: Any) -> None:
        self.layers = policy.mlp_extractor.policy_net, policy.action_net

    def __call__(self, observations: Any) -> Any:
        """Return the actions."""
        import torch

        with torch.no_grad():
            hidden, last = self.layers
            return last(hidden(torch.as_tensor(observations))).numpy()


if __name__ == "__main__":
    main()
