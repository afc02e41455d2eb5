"""What robots achieve by the behaviours of the language alone, moving one after another as in IR-SIM.

    python agents/studies/behavior_baselines.py

writes results/behavior_baselines.json beside this file: the levels that policies are tested on, without any learner.
`irsim-gym evaluate --team` shows the same behaviours in the place of learners, all deciding at the same moment.
"""

import json
from pathlib import Path

import numpy as np
import yaml

import irsim_gym

HERE = Path(__file__).parents[1]
CASES = (("circle_swap", 4), ("circle_swap", 8), ("random_swap", 8))
BEHAVIORS = {
    "rvo": {"behavior": {"name": "rvo", "vxmax": 1, "vymax": 1}},
    "orca": {"group_behavior": {"name": "orca"}},  # IR-SIM's own options: 20 s ahead, no stepping aside
}


def play(scenario: str, n_robots: int, behavior: dict[str, object], levels: int = 1000, steps: int = 300) -> dict:
    """Return the shares of levels and of robots that succeed, and the mean time of the last arrival."""
    data = yaml.safe_load((HERE.parent / "configs" / "scenarios" / f"{scenario}.yaml").read_text(encoding="utf-8"))
    robots = {key: value for key, value in data["robot"][0].items() if key not in ("behavior", "sensors")}
    data = {**data, "robot": [{**robots, **behavior}], "world": {**data["world"], "name": scenario}}
    data.pop("task")
    simulation = irsim_gym.compile(irsim_gym.load_scenario(data, {"n_robots": n_robots}), levels)
    simulation.reset(0, "test")
    arrival = np.full((levels, n_robots), steps)
    under_way, arrived = np.ones((levels, n_robots), bool), np.zeros((levels, n_robots), bool)
    for step in range(1, steps + 1):
        simulation.step()
        collided = simulation.state.collided[:, :n_robots]
        now = under_way & simulation.state.arrived[:, :n_robots] & ~collided
        arrival[now], arrived = step, arrived | now
        under_way &= ~(now | collided)
    seconds = np.where(arrived.all(1), arrival.max(1), steps) * float(simulation.model.step_time[0])
    rates = {"cooperative_success": arrived.all(1).mean(), "individual_success": arrived.mean()}
    return {"levels": levels, **{key: float(rate) for key, rate in rates.items()}, "makespan": float(seconds.mean())}


def main() -> None:
    """Play all cases, and write the file."""
    rows = [
        {"scenario": scenario, "n_robots": n_robots, "behavior": name, **play(scenario, n_robots, behavior)}
        for scenario, n_robots in CASES
        for name, behavior in BEHAVIORS.items()
    ]
    (HERE / "results" / "behavior_baselines.json").write_text(
        json.dumps({"split": "test", "rows": rows}, indent=1) + "\n", encoding="utf-8"
    )
    for row in rows:
        print(f"{row['scenario']} {row['n_robots']} {row['behavior']}: CSR {row['cooperative_success']:.1%}")


if __name__ == "__main__":
    main()
