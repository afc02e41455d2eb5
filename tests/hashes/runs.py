"""Hashes of runs of all shipped scenarios; run this file to compare them with those of another commit.

``python tests/hashes/runs.py --out FILE`` writes one hash for each array of each scenario, and
``--against FILE`` lists what differs from such a file. Hashes depend on the processor and on the versions of NumPy and
Numba, so both files have to come from the same machine.
"""

from __future__ import annotations

import argparse
import hashlib
import json
from pathlib import Path

import numpy as np

import irsim_gym as ig
from irsim_gym.tasks import Episodes, load_task

STEPS, WORLDS = 100, 3
ROOT = Path(__file__).parents[2]
SCRATCH = {"room", "nearby", "bucket", "bucket_first", "bucket_next", "direction", "placed"}
"""Fields of the state that hold no result."""


def hashes(name: str) -> dict[str, str]:
    """Play a scenario in three worlds with fixed actions; return a hash of every array at every step."""
    scenario = ig.load_scenario(name)
    task = load_task(scenario) if scenario.task else None
    simulation = ig.compile(scenario, WORLDS, agents=task.agents if task else ())
    digests: dict[str, hashlib._Hash] = {}

    def note(name: str, value: np.ndarray) -> None:
        digests.setdefault(name, hashlib.sha256()).update(np.ascontiguousarray(value).tobytes())

    def note_state() -> None:
        for field in simulation.state.columns():
            if field not in SCRATCH:
                note(field, getattr(simulation.state, field))
        for number, group in enumerate(simulation.sensors):
            for reading in ("ranges", "hit", "velocity", "radial_velocity"):
                if reading in group.arrays:
                    note(f"sensor {number} {reading}", group.arrays[reading])

    numbers = np.random.default_rng(0)
    if task is None:
        simulation.reset(7)
        for step in range(STEPS):
            if step == STEPS // 2:
                simulation.reset(70)
            simulation.step()
            note_state()
    else:
        episodes = Episodes(simulation, task)
        episodes.begin(np.arange(WORLDS), np.arange(WORLDS))
        for _ in range(STEPS):
            shape = episodes.view.reward.shape
            episodes.step(numbers.uniform(-0.6, 1.0, (*shape, int(episodes.action_sizes.max()))))
            note_state()
            note("observation", episodes.view.observation)
            note("reward", episodes.view.reward)
            for key, value in episodes.view.infos.items():
                note(f"info {key}", np.asarray(value))
            ended = np.flatnonzero(episodes.view.infos["outcome"].all(axis=1))
            if len(ended):
                episodes.begin_next(ended)
                note("next observation", episodes.view.observation)
    return {name: digest.hexdigest()[:16] for name, digest in sorted(digests.items())}


def main() -> None:
    """Write or compare the hashes of all scenarios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--against", type=Path)
    parser.add_argument("scenarios", nargs="*")
    options = parser.parse_args()
    names = options.scenarios or sorted(file.stem for file in (ROOT / "configs" / "scenarios").glob("*.yaml"))
    found = {name: hashes(name) for name in names}
    if options.out:
        options.out.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    if options.against:
        before = json.loads(options.against.read_text(encoding="utf-8"))
        pairs = [(name, key) for name in names for key in before[name]]
        differing = [f"{name}: {key}" for name, key in pairs if found[name].get(key) != before[name][key]]
        print("\n".join(differing) or f"{len(names)} scenarios: all equal")
        raise SystemExit(bool(differing))


if __name__ == "__main__":
    main()
