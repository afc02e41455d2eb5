"""Plays random scenarios (``mixed``), each in a process of its own with a limit of time; prints a line of JSON each.

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
from pathlib import Path
from typing import Any

TESTS = Path(__file__).parents[1]
sys.path[:0] = [str(TESTS / folder) for folder in ("bounds", "parity")]

STEPS = 6
LIMIT = 20
"""CPU seconds of one scenario."""
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


def in_child(seed: int, steps: int) -> dict[str, Any]:
    """Play a scenario in a child, which is stopped after ``LIMIT`` CPU seconds."""
    with tempfile.TemporaryFile("w+") as told, tempfile.TemporaryFile("w+") as stack:
        child = os.fork()
        if child == 0:
            faulthandler.register(signal.SIGXCPU, file=stack, chain=True)
            used = int(time.process_time())
            resource.setrlimit(resource.RLIMIT_CPU, (used + LIMIT, used + LIMIT + 5))
            print(json.dumps(outcome(seed, steps)), file=told, flush=True)
            os._exit(0)
        _, status = os.waitpid(child, 0)
        told.seek(0)
        stack.seek(0)
        line = told.read()
        if line:
            return dict(json.loads(line))
        return {"seed": seed, "refused": "", "ways": [], "seconds": LIMIT, "error": f"{status=}\n{stack.read()}"}


def play(seed: int, steps: int) -> dict[str, Any]:
    """Play a scenario, again where it was stopped while it compiled."""
    for _ in range(TRIES):
        result = in_child(seed, steps)
        if not result["error"].startswith("status="):
            break
    return result


def main() -> None:
    """Play the scenarios that the arguments name."""
    first, count = map(int, sys.argv[1:3])
    steps = int(sys.argv[3]) if len(sys.argv) > 3 else STEPS
    warnings.simplefilter("ignore")  # scenarios may be odd
    import mixed  # noqa: F401
    import within_spaces  # noqa: F401

    for seed in range(first, first + count):
        print(json.dumps(play(seed, steps)), flush=True)


if __name__ == "__main__":
    main()
