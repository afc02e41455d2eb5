"""Processes of ROS 1 that end with the tests."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any


@dataclass
class Robot:
    """The bridge, as functions of its methods."""

    process: subprocess.Popen[str]

    def ask(self, name: str, *given: Any) -> Any:
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(json.dumps([name, *given]) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())


@contextmanager
def running(command: str, variables: dict[str, str], **how: Any) -> Iterator[subprocess.Popen[str]]:
    """Start a command; at last end it and its children as Ctrl-C does, by force after ten seconds."""
    assert shutil.which("roscore", path=variables["PATH"]), "make test-ros installs ROS 1"
    shell = ["bash", "-c", command]
    with subprocess.Popen(shell, env=variables, text=True, start_new_session=True, **how) as process:
        try:
            yield process
        finally:
            end(process)


def end(process: subprocess.Popen[str]) -> None:
    """End a process and its children, if it is still there."""
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGINT)
        try:
            process.wait(10.0)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
