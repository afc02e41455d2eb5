"""Score a policy in JaxNav's levels as SFL does, and add the score to a file.

    python agents/studies/jaxnav_score.py LEVELS POLICY [--task TASK] [--windows N] [--levels N] [--mean] [--out FILE]

LEVELS is a user's own copy after ``jaxnav_pickle.py``, or the name of a benchmark; POLICY a run's folder,
or with ``--mean``, which takes the mean actions, the name of a shipped policy. Without TASK, episodes end as the
benchmark says. SFL (Rutherford et al. 2024, sampling-for-learnability 8b14e2e) drives each level in ten windows of as
many steps as the time limit. Actions are drawn, not taken at their mean. Where all robots have ended, the level begins
again; an episode that is not over at the end of its window does not count, which favours short ones. A level's success
is the share of robots that arrive, over all its episodes. A second set of windows scores the levels that are worst in
the first.
"""

from __future__ import annotations

import argparse
import json
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from irsim_gym.evaluation import (
    Perceived,
    Policy,
    SavedPolicy,
    as_policy,
    by_agent,
    conditions,
    machine,
    make_episodes,
    worst_shares,
    write_json,
)
from irsim_gym.tasks import Episodes, Outcome

Floats, Ints = NDArray[np.float64], NDArray[np.int64]

OUT = Path(__file__).parents[1] / "results" / "jaxnav_score.json"
PUBLISHED = {1: {"success": 0.980, "worst 5 %": 0.605}, 4: {"success": 0.922, "worst 5 %": 0.459}}
"""What SFL reaches, by the number of robots."""


def main() -> None:
    """Drive the levels, write the file, and print the score."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("levels_of", metavar="LEVELS")
    parser.add_argument("policy", metavar="POLICY")
    parser.add_argument("--task")
    parser.add_argument("--windows", type=int, default=10)
    parser.add_argument("--levels", type=int, default=1000)
    parser.add_argument("--mean", action="store_true")
    parser.add_argument("--out", type=Path, default=OUT, help="default: results/jaxnav_score.json beside this file")
    options = parser.parse_args()
    played = make_episodes(options.levels_of, task=options.task, n_worlds=options.levels, team=True)
    policy: Policy = as_policy(options.policy)
    policy = policy if options.mean else drawing(policy)
    episodes = Perceived(played).of(policy)
    torch.manual_seed(0)
    passes = np.stack([rates(episodes, policy, options.windows) for _ in range(2)])
    row = {
        "task": options.task,
        "windows": options.windows,
        "actions": "mean" if options.mean else "drawn",
        "conditions": conditions(episodes, "test", options.levels),
        "machine": machine(),
        "published": PUBLISHED[episodes.n_agents],
        "success": round(float(passes.mean()), 4),
        **{f"worst {name}": round(value, 4) for name, value in worst_shares(passes).items()},
    }
    rows = json.loads(options.out.read_text(encoding="utf-8")) if options.out.exists() else {}
    name = f"{Path(options.levels_of).name} {Path(options.policy).name}"
    write_json(options.out, {**rows, name: row})
    print(name, {key: value for key, value in row.items() if key not in ("conditions", "machine")})


def drawing(policy: Policy) -> Policy:
    """Return the policy of a run with actions that are drawn."""
    if isinstance(policy, SavedPolicy):
        policy.model.predict = partial(_drawn, policy.model.predict)  # type: ignore[method-assign,union-attr]
    return policy


def _drawn(predict: Any, *arguments: Any, deterministic: bool) -> Any:
    return predict(*arguments, deterministic=False)


def rates(episodes: Episodes, policy: Policy, windows: int) -> Floats:
    """Return the success of each level over some windows, ``(n_levels,)``."""
    arrived, driven = np.stack([window(episodes, policy) for _ in range(windows)]).sum(axis=0)
    share: Floats = arrived / driven
    return share


def window(episodes: Episodes, policy: Policy) -> Ints:
    """Drive each level for as many steps as the time limit, again and again.

    Returns:
        Robots that arrived and robots that were driven, in episodes that ended, ``(2, n_levels)``.
    """
    levels = np.arange(episodes.n_worlds)
    found = np.zeros((2, episodes.n_worlds), np.int64)
    again = levels
    for _ in range(episodes.task.max_steps):
        if len(again):
            episodes.begin(again, again, "test")
            policy.begin(episodes, again, again)
        episodes.step(by_agent(policy.act(episodes, levels), episodes, levels))
        again = levels[~episodes.view.live.any(axis=1)]
        found[0, again] += (episodes.state.outcome[again] == Outcome.SUCCESS).sum(axis=1)
        found[1, again] += episodes.n_agents
    return found


if __name__ == "__main__":
    main()
