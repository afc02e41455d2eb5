"""Play BARN-2D with ``dwa`` and write agents/results/barn_dwa.json.

    python agents/studies/barn_row.py COPY [ROW ...]

COPY is a user's own copy of BARN's worlds, an ``.npz`` as ``barn_levels.py`` reads it, with
``path_length`` (300,) [m] beside the cylinders. The worlds are 0, 6, ..., 294. Nothing is random here, so each is
driven once where the original drives it ten times. Further rows leave out how BARN's DWA goes on where no way ahead
is free. The score of a run is success * OT / clip(AT, 2 OT, 8 OT), where OT is the path length divided by 2 m/s and AT
the time it takes. All rows take some 20 minutes of CPU; with ROWs, only these are played, and the others stay.
"""

from __future__ import annotations

import json
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from barn_levels import barn_levels

import irsim_gym
from irsim_gym.evaluation import machine

HERE = Path(__file__).parents[1]
RESULT = HERE / "results" / "barn_dwa.json"
PUBLISHED = {"success": 0.88, "collision": 0.048, "timeout": 0.072, "time": 33.5, "score": 0.169}
SPEED, LIMIT, JOBS = 0.5, 100.0, 2
GIVEN: dict[str, Any] = {
    "samples": [6, 20], "sim_time": 2.0, "sim_granularity": 0.02, "min_speed": 0.1, "obstacle_weight": 0.1,
    "path_weight": 0.75, "goal_weight": 1.0, "footprint_padding": 0.1, "obstacle_range": 2.5, "inflation_radius": 0.3,
    "min_turn_rate": 0.314, "escape_speed": -0.5, "oscillation_distance": 0.05,
}  # fmt: skip
"""As published with BARN (base_local_planner_params.yaml, costmap_common_params.yaml)."""
OURS: dict[str, Any] = {"free_time": 2.0, "forward_point": 0.325, "cost_scaling": 10.0, "spacing": 0.05,
                        "path_clearance": 0.1}  # fmt: skip
"""What is not published: chosen by us, in part by runs in some of these worlds. Other options have their defaults."""
SEEN, MAP = "around what its own scans have shown", "the shortest way past all cylinders, known from the start"
TURNS, STANDS = {"oscillation_distance": 0.25}, {"escape_speed": 0.0}
ROWS: dict[str, tuple[str, dict[str, Any]]] = {
    "seen": (SEEN, {"path": "seen"}),
    "map": (MAP, {"path": "map"}),
    "seen, never backwards": (SEEN, {"path": "seen", **STANDS}),
    "seen, turns again after 0.25 m": (SEEN, {"path": "seen", **TURNS}),
    "seen, both": (SEEN, {"path": "seen", **STANDS, **TURNS}),
    "map, both": (MAP, {"path": "map", **STANDS, **TURNS}),
}
"""What the path is, and settings of the row. The last four have defaults of ``dwa`` in the place of published ones."""


def run(levels: Path, settings: dict[str, Any], world: int) -> tuple[str, float]:
    """Return how ``dwa`` ends in a world, and after which time [s]."""
    data = yaml.safe_load((HERE.parent / "configs" / "benchmarks" / "barn.yaml").read_text(encoding="utf-8"))
    data["robot"][0]["behavior"] = {"name": "dwa", **GIVEN, **OURS, **settings}
    data = {**data, "levels": str(levels), "world": {**data["world"], "name": "barn"}}
    data.pop("task")
    simulation = irsim_gym.compile(irsim_gym.load_scenario(data, {"speed": SPEED}))
    simulation.reset(world, "test")
    state, bounds = simulation.state, simulation.model.bounds
    step_time = float(simulation.model.step_time[0])
    for step in range(1, round(LIMIT / step_time) + 1):
        simulation.step()
        x, y, _ = state.pose[0, 0]
        is_out = not (bounds[0] <= x <= bounds[2] and bounds[1] <= y <= bounds[3])
        for outcome, is_so in (("collision", state.collided[0, 0]), ("left", is_out), ("arrival", state.arrived[0, 0])):
            if is_so:
                return outcome, round(step * step_time, 2)
    return "timeout", LIMIT


def score(outcome: str, time: float, path_length: float) -> float:
    """Return the score of a run."""
    optimum = path_length / 2.0
    return round(float(optimum / np.clip(time, 2.0 * optimum, 8.0 * optimum)), 4) if outcome == "arrival" else 0.0


def play(levels: Path, lengths: dict[int, float], row: str) -> dict[str, Any]:
    """Return a row."""
    path, settings = ROWS[row]
    with ProcessPoolExecutor(JOBS) as pool:
        ends = dict(zip(lengths, pool.map(partial(run, levels, settings), lengths), strict=True))
    worlds = {
        world: {"outcome": outcome, "time": time, "score": score(outcome, time, lengths[world])}
        for world, (outcome, time) in ends.items()
    }
    runs: list[dict[str, Any]] = list(worlds.values())
    rates = {
        key: round(float(np.mean([row["outcome"] == name for row in runs])), 4)
        for key, name in (("success", "arrival"), ("collision", "collision"), ("timeout", "timeout"), ("left", "left"))
    }
    times = [row["time"] for row in runs if row["outcome"] == "arrival"]
    return {
        "path": path,
        "settings": settings,
        **rates,
        "time": round(float(np.mean(times)), 2),
        "score": round(float(np.mean([row["score"] for row in runs])), 4),
        "worlds": worlds,
    }


def main(copy: Path, names: list[str]) -> None:
    """Play all worlds with the settings of the named rows, of all rows if none is named, and write the file."""
    if unknown := set(names) - set(ROWS):
        raise SystemExit(f"no row {', '.join(sorted(unknown))}; there are: {'; '.join(ROWS)}")
    lengths = {world: float(np.load(copy)["path_length"][world]) for world in range(0, 300, 6)}
    played = json.loads(RESULT.read_text(encoding="utf-8"))["rows"] if names else {}
    with tempfile.TemporaryDirectory() as folder:
        levels = Path(folder, "barn.npz")
        np.savez_compressed(levels, **barn_levels(copy))
        for row in names or ROWS:
            played[row] = play(levels, lengths, row)
            print(row, {key: value for key, value in played[row].items() if key != "worlds"}, flush=True)
    record = {
        "benchmark": "BARN-2D: worlds 0, 6, ..., 294 of a user's copy of BARN (bf5a226), each once",
        "command": f"python agents/studies/barn_row.py {copy.name}",
        "machine": {**machine(), "processes": JOBS},
        "settings": {"robot": {"scenario": "barn", "speed": SPEED}, "published": GIVEN, "ours": OURS},
        "published": PUBLISHED,
        "rows": {row: played[row] for row in ROWS if row in played},
    }
    RESULT.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
