"""Plays scenarios with bounds checks, and prints what was played as JSON: a process of its own, see ``test_bounds``."""

from __future__ import annotations

import json
import os
import sys
import time
import traceback
from pathlib import Path
from typing import Any

TESTS = Path(__file__).parents[1]
sys.path[:0] = [str(TESTS / folder) for folder in ("bounds", "parity", "scenario", "engine")]

if os.environ.get("NUMBA_DISABLE_JIT") == "1":
    import guard

    guard.install()  # before anything that has kernels is imported

import corpus
import player


def chosen(what: dict[str, Any]) -> dict[str, Any]:
    """Return the scenarios that are asked for."""
    if "names" in what:
        every = corpus.listed()
        return {name: every[name] for name in what["names"]}
    if "part" in what:
        every, (part, parts) = corpus.listed(), what["part"]
        return {name: every[name] for name in list(every)[part::parts]}
    return corpus.random_scenarios(*what["random"])


def main() -> None:
    what = json.loads(sys.argv[1])
    player.share_among_threads()
    for name, source in chosen(what).items():
        begun, ways, error = time.process_time(), [], ""
        try:
            for way in player.play(source, what["steps"]):
                ways.append(way)
        except Exception:
            error = traceback.format_exc()
        spent = round(time.process_time() - begun, 2)
        print(json.dumps({"name": name, "ways": ways, "error": error, "seconds": spent}), flush=True)


main()
