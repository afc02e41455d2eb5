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


class LoneDrivers:
    """The other interpreter; ``python`` is its file."""

    def __init__(self, folder: Path, python: str = sys.executable) -> None:
        asked = [python, "-I", __file__, str(folder)]
        self.process = subprocess.Popen(asked, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=folder)
        self.count = 0

    def driver(self) -> LoneDriver:
        """Return another driver."""
        self.count += 1
        return LoneDriver(self, self.count)

    def close(self) -> None:
        """End the interpreter."""
        self.process.communicate()


class LoneDriver:
    """A driver there, with the methods that tests use; ``spent`` is the CPU time of its latest tick [s]."""

    def __init__(self, home: LoneDrivers, number: int) -> None:
        self.home, self.number, self.spent = home, number, 0.0
        self.said: list[tuple[str, tuple[Any, ...]]] = []

    def goal(self, message: Any) -> None:
        self.said.append(("goal", (plain(message),)))

    def scan(self, message: Any) -> None:
        self.said.append(("scan", (plain(message),)))

    def odometry(self, message: Any) -> None:
        self.said.append(("odometry", (plain(message),)))

    def bodies(self, rows: Any, stamp: float) -> None:
        self.said.append(("bodies", (rows, stamp)))

    def tick(self, now: float) -> tuple[Any, ...]:
        given, found = self.home.process.stdin, self.home.process.stdout
        assert given is not None
        assert found is not None
        pickle.dump((self.number, self.said, now), given)
        given.flush()
        self.said = []
        command, self.spent = pickle.load(found)
        return tuple(command)


def plain(message: Any) -> Any:
    """Return a message of rosbags as one that every interpreter can read."""
    if not is_dataclass(message):
        return [plain(one) for one in message] if isinstance(message, list) else message
    return SimpleNamespace(**{name: plain(value) for name, value in vars(message).items() if name[0] != "_"})


def answer(folder: Path) -> None:
    """Drive by an export, as the lines of the standard input ask."""
    sys.modules["irsim_gym"] = None  # type: ignore[assignment]  # importing it is an ImportError
    driver_class = runpy.run_path(str(folder / "drive.py"))["Driver"]
    drivers: dict[int, Any] = {}
    while True:
        try:
            number, said, now = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        if number not in drivers:
            drivers[number] = driver_class(folder / "contract.json")
        for name, given in said:
            getattr(drivers[number], name)(*given)
        begin = process_time()
        command = drivers[number].tick(now)
        pickle.dump((command, process_time() - begin), sys.stdout.buffer)
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    answer(Path(sys.argv[1]))
