"""Plays scenarios with bounds checks and prints what came of each, a line of JSON: a process of its own."""

from __future__ import annotations

import json
import sys
import time
import traceback
import warnings
from pathlib import Path
from typing import Any

TESTS = Path(__file__).parents[1]
sys.path[:0] = [str(TESTS / folder) for folder in ("bounds", "parity", "scenario", "simulator/engine")]


def chosen(what: dict[str, Any]) -> dict[str, Any]:
    """Return the scenarios that are asked for."""
    import corpus

    if "random" in what:
        return corpus.random_scenarios(*what["random"])
    every = corpus.listed()
    if "part" in what:
        part, parts = what["part"]
        return {name: every[name] for name in list(every)[part::parts]}
    return {name: every[name] for name in what["names"]}


def main() -> None:
    import guard

    guard.install()  # before anything that has kernels is imported
    warnings.simplefilter("ignore")  # scenarios may be odd
    import player

    player.look_coarsely()
    player.share_among_threads()
    what = json.loads(sys.argv[1])
    for name, source in chosen(what).items():
        begun, ways, error = time.process_time(), list[str](), ""
        try:
            for way in player.play(source, what["steps"]):
                ways.append(way)
        except Exception:
            error = traceback.format_exc()
        spent = round(time.process_time() - begun, 2)
        print(json.dumps({"name": name, "ways": ways, "error": error, "seconds": spent}), flush=True)


if __name__ == "__main__":
    main()
