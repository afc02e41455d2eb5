"""Drivers of an export in an interpreter of their own, which cannot import irsim_gym."""

from __future__ import annotations

import pickle
import runpy
import subprocess
import sys
from dataclasses import is_dataclass
from pathlib import Path
from time import process_time
from types import SimpleNamespace
from typing import Any

Said = list[tuple[Any, list[tuple[Any, ...]], float]]
"""For some robots: their number, the driver's methods with what they get, and the time of the tick."""


class LoneDrivers:
    """The other interpreter.

    Args:
        folder: The export.
        python: File of the interpreter.
    """

    def __init__(self, folder: Path, python: str = sys.executable) -> None:
        asked = [python, "-I", __file__, str(folder)]
        self.process = subprocess.Popen(asked, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=folder)

    def tick(self, said: Said) -> list[tuple[tuple[Any, ...], float]]:
        """Return what the driver of each robot commands, and the CPU time of its tick [s]; new ones begin."""
        given, found = self.process.stdin, self.process.stdout
        assert given is not None
        assert found is not None
        pickle.dump([(number, [plain(one) for one in calls], now) for number, calls, now in said], given)
        given.flush()
        return list(pickle.load(found))

    def close(self) -> None:
        """End the interpreter."""
        self.process.communicate()


def plain(message: Any) -> Any:
    """Return a message of rosbags as one that every interpreter can read."""
    if isinstance(message, tuple):
        return tuple(plain(one) for one in message)
    if not is_dataclass(message):
        return message
    return SimpleNamespace(**{name: plain(value) for name, value in vars(message).items() if name[0] != "_"})


def answer(folder: Path) -> None:
    """Drive by an export, as the standard input asks."""
    sys.modules["irsim_gym"] = None  # type: ignore[assignment]  # importing it is an ImportError
    new_driver = runpy.run_path(str(folder / "drive.py"))["Driver"]
    drivers: dict[Any, Any] = {}
    while sys.stdin.buffer.peek(1):
        found = []
        for number, calls, now in pickle.load(sys.stdin.buffer):
            driver = drivers[number] = drivers.get(number) or new_driver(folder / "contract.json")
            for name, *given in calls:
                getattr(driver, name)(*given)
            begin = process_time()
            found.append((driver.tick(now), process_time() - begin))
        pickle.dump(found, sys.stdout.buffer)
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    answer(Path(sys.argv[1]))
