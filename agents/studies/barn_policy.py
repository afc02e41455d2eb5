"""Play BARN-2D with trained policies and write agents/results/barn_policy.json.

    python agents/studies/barn_policy.py COPY POLICY...

COPY is a user's own copy of BARN's worlds, as in ``barn_row.py``; a POLICY is a run's folder or a name on the shelf.
The worlds are 0, 6, ..., 294. Nothing is random here, so each is driven once where the original drives it ten times.
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from barn_levels import barn_levels
from barn_row import PUBLISHED, score

from irsim_gym.evaluation import EpisodeRow, Perceived, as_policy, conditions, machine, make_episodes, play_levels

OUT = Path(__file__).parents[1] / "results" / "barn_policy.json"
WORLDS = range(0, 300, 6)
CALLED = {"success": "arrival"}
"""What ``score`` calls an outcome."""


def figures(rows: Sequence[EpisodeRow], lengths: Sequence[float]) -> dict[str, Any]:
    """Return success, time and score of a policy's runs.

    Args:
        rows: A run in each world.
        lengths: BARN's own path length in each [m].
    """
    scores = [
        score(CALLED.get(row.outcome, row.outcome), row.time, length) for row, length in zip(rows, lengths, strict=True)
    ]
    times = [row.time for row in rows if row.outcome == "success"]
    rates = {
        name: float(np.mean([row.outcome == name for row in rows])) for name in ("success", "collision", "timeout")
    }
    return {
        **{name: round(value, 4) for name, value in rates.items()},
        "time": round(float(np.mean(times)), 2) if times else None,
        "score": round(float(np.mean(scores)), 4),
        "worlds": {
            row.level: {"outcome": row.outcome, "time": round(row.time, 2), "score": value}
            for row, value in zip(rows, scores, strict=True)
        },
    }


def main(copy: Path, policies: Sequence[str]) -> None:
    """Play the worlds with each policy, and write the file."""
    path_length = np.load(copy)["path_length"]
    lengths = [float(path_length[world]) for world in WORLDS]
    with tempfile.TemporaryDirectory() as folder:
        levels = Path(folder, "barn.npz")
        np.savez_compressed(levels, **barn_levels(copy))
        worlds = Perceived(make_episodes(str(levels), n_worlds=len(WORLDS)))
        found = {}
        for name in policies:
            policy = as_policy(name)
            found[Path(name).name] = figures(play_levels(policy, worlds.of(policy), list(WORLDS)), lengths)
        named = conditions(worlds.episodes, "test", len(WORLDS))
    record = {
        "benchmark": "BARN-2D: worlds 0, 6, ..., 294 of a user's copy of BARN (bf5a226), each once",
        "command": f"python agents/studies/barn_policy.py {copy.name} {' '.join(Path(name).name for name in policies)}",
        "conditions": named,
        "machine": machine(),
        "published": PUBLISHED,
        "policies": found,
    }
    OUT.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    for name, row in found.items():
        print(name, {key: value for key, value in row.items() if key != "worlds"})


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
