"""What every peer's process does: say what it is, or play one work in rounds when asked.

    python NAME_peer.py --describe          who it is, what it plays, what it does not do: JSON, without its package
    python NAME_peer.py WORK GIVEN.json     plays; a line on its input means one round, and its answer is a line of JSON

Standard library alone, for it runs in each peer's own virtual environment. ``PYTHONPATH`` has to name ``benchmarks``
and ``benchmarks/peers``.
"""

from __future__ import annotations

import json
import os
import statistics
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

from timing import calibration

MOST_STEPS = 2**20
PARTS = 4
"""Parts of a round; after each the processor's pace is measured."""

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS")


@dataclass(frozen=True)
class Play:
    """A world, or many, ready to be stepped.

    Attributes:
        step: Plays one step.
        n_agents: Agent-steps of a call.
        rewind: Goes back to the start before each round; None where a run may go on for ever.
        n_steps: Calls from one rewinding to the next; 0 for as many as fit into the wanted time.
        places: Returns x, y of each agent, where those of others should be the same after a run.
    """

    step: Callable[[], Any]
    n_agents: int
    rewind: Callable[[], Any] | None = None
    n_steps: int = 0
    places: Callable[[], list[list[float]]] | None = None


@dataclass(frozen=True)
class Work:
    """One work that a peer plays.

    Attributes:
        build: Makes the worlds from what is given: ``scenario`` in IR-SIM's language, ``starts`` (x, y, heading and the
            goal's x, y of some levels), ``sizes``.
        differs: What the peer does not do, or does otherwise, in the same work.
    """

    build: Callable[[Mapping[str, Any]], Play]
    differs: tuple[str, ...] = ()


@dataclass(frozen=True)
class Peer:
    """A package that others could use.

    Attributes:
        name: How it is called in the results.
        package: Name of its distribution; empty for what has none.
        works: What it plays by the work's name; ``work@way`` for one more way to play the same.
    """

    name: str
    package: str
    works: Mapping[str, Work]

    def about(self) -> dict[str, Any]:
        """Return what a result says of it."""
        return {
            "package": self.package,
            "version": _version(self.package),
            "works": {name: list(work.differs) for name, work in self.works.items()},
        }


def serve(peer: Peer) -> None:
    """Do what the command line asks."""
    if sys.argv[1:] == ["--describe"]:
        print(json.dumps(peer.about()))
        return
    name, file = sys.argv[1:]
    # Packages print what they like; answers go where our output went.
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8", buffering=1)
    os.dup2(2, 1)
    _use_one_core()
    given = json.loads(Path(file).read_text(encoding="utf-8"))
    play = peer.works[name].build(given)
    play.step()  # the first may compile
    n_steps, n_runs = _sizes(play, given["round_s"])
    ready = {"version": peer.about()["version"], "n_steps": n_steps * n_runs}
    if play.places is not None:
        _run(play, n_steps)
        ready["poses"] = play.places()
    answers.write(json.dumps(ready) + "\n")
    for _ in sys.stdin:
        taken, calibration_s = _round(play, n_steps, n_runs)
        us = 1e6 * taken / (n_steps * n_runs * play.n_agents)
        answers.write(json.dumps({"us": us, "calibration_s": calibration_s}) + "\n")


def _round(play: Play, n_steps: int, n_runs: int) -> tuple[float, float]:
    """Return the CPU seconds of a round, and of the loop that calibrates: it runs in between, under the same load."""
    if play.rewind is None:
        parts = [(n_steps * (k + 1) // PARTS - n_steps * k // PARTS, 1) for k in range(PARTS)]
    else:
        parts = [(n_steps, n_runs * (k + 1) // PARTS - n_runs * k // PARTS) for k in range(PARTS)]
    taken, loops = 0.0, []
    for steps, runs in parts:
        if steps and runs:
            taken += sum(_run(play, steps) for _ in range(runs))
            loops.append(calibration())
    return taken, statistics.median(loops)


def _run(play: Play, n_steps: int) -> float:
    """Return the CPU seconds of so many steps."""
    if play.rewind is not None:
        play.rewind()
    begin = time.process_time()
    for _ in range(n_steps):
        play.step()
    return time.process_time() - begin


def _sizes(play: Play, round_s: float) -> tuple[int, int]:
    """Return steps of a run and runs of a round, so that a round takes about so long."""
    if play.n_steps:
        return play.n_steps, max(1, int(round_s / max(_run(play, play.n_steps), 1e-6)))
    count = 1
    while True:
        taken = _run(play, count)
        if taken >= 0.1 * round_s or count >= MOST_STEPS:
            return max(1, int(count * round_s / max(taken, 1e-6))), 1
        count *= 2


def _use_one_core() -> None:
    """Keep the process on one core, and tell libraries so before they are loaded."""
    for name in ONE_THREAD:
        os.environ[name] = "1"
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def _version(package: str) -> str | None:
    try:
        return metadata.version(package) if package else None
    except metadata.PackageNotFoundError:
        return None


def random_actions(count: int, size: int) -> list[list[float]]:
    """Return pseudo-random numbers in [-1, 1], the same in every process, ``count`` rows of ``size``."""
    import random

    numbers = random.Random(0)
    return [[numbers.uniform(-1.0, 1.0) for _ in range(size)] for _ in range(count)]
