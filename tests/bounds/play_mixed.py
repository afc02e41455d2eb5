"""Plays random scenarios (``mixed``) in child processes, each with a limit of time; prints a line of JSON each.

``python tests/bounds/play_mixed.py FIRST COUNT [STEPS]``
"""

from __future__ import annotations

import faulthandler
import json
import os
import resource
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

TESTS = Path(__file__).parents[1]
sys.path[:0] = [str(TESTS / folder) for folder in ("bounds", "parity")]

STEPS = 6
LIMIT = 40
"""CPU seconds of one scenario: planners over poses may take half a second for each of dozens of levels."""
TOGETHER = 25
"""Scenarios of one process: most of the time of the first goes into reading compiled kernels."""
TRIES = 4
"""Compilation counts: a scenario that was stopped is played again, with what is cached by then."""


def outcome(seed: int, steps: int) -> dict[str, Any]:
    """Play a scenario in this process, and return what came of it."""
    import mixed
    import within_spaces

    from irsim_gym.errors import IrsimGymError, PlacementError

    ways: list[str] = []
    begun = time.process_time()
    told: dict[str, Any] = {"seed": seed, "refused": "", "error": ""}
    try:
        ways += within_spaces.check(mixed.mixed(seed), steps)
    except IrsimGymError as error:
        # A world that can be played may be too full for a body that begins anew; all else was accepted before.
        is_full = isinstance(error, PlacementError)
        told["refused" if is_full or "spaces" not in ways else "error"] = f"{type(error).__name__}: {error}"
    except Exception:
        told["error"] = traceback.format_exc()
    return {**told, "ways": ways, "seconds": round(time.process_time() - begun, 2)}


def in_child(seeds: Sequence[int], steps: int) -> list[dict[str, Any]]:
    """Play scenarios in a child, which is stopped after ``LIMIT`` CPU seconds of one of them: the last that is told."""
    with tempfile.TemporaryFile("w+") as told, tempfile.TemporaryFile("w+") as stack:
        child = os.fork()
        if child == 0:
            faulthandler.register(signal.SIGXCPU, file=stack, chain=True)
            for seed in seeds:
                used = int(time.process_time())
                resource.setrlimit(resource.RLIMIT_CPU, (used + LIMIT, resource.RLIM_INFINITY))
                print(json.dumps(outcome(seed, steps)), file=told, flush=True)
            os._exit(0)
        _, status = os.waitpid(child, 0)
        told.seek(0)
        stack.seek(0)
        played: list[dict[str, Any]] = [json.loads(line) for line in told.read().splitlines()]
        if len(played) < len(seeds):
            error = f"{status=}\n{stack.read()}"
            played.append({"seed": seeds[len(played)], "refused": "", "ways": [], "seconds": LIMIT, "error": error})
        return played


def main() -> None:
    """Play the scenarios that the arguments name."""
    first, count = map(int, sys.argv[1:3])
    steps = int(sys.argv[3]) if len(sys.argv) > 3 else STEPS
    warnings.simplefilter("ignore")  # scenarios may be odd
    import mixed  # noqa: F401
    import within_spaces  # noqa: F401

    left, tries = list(range(first, first + count)), 0
    while left:
        for result in in_child(left[:TOGETHER], steps):
            tries += 1
            if result["error"].startswith("status=") and tries < TRIES:
                break
            print(json.dumps(result), flush=True)
            left, tries = left[1:], 0


if __name__ == "__main__":
    main()
