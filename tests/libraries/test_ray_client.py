"""A cluster that is reached through Ray Client (``--address ray://``), on the loopback."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from needed import library

LONGEST_S = 500
LOOPBACK = {"RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER": "0", "RAY_USAGE_STATS_ENABLED": "0", "RAY_AUTH_MODE": "disabled"}


@pytest.fixture(scope="module", autouse=True)
def ray():
    return library("ray")


@pytest.fixture
def head() -> Iterator[str]:
    """Start a cluster in a process group of its own, and return the address of its server for clients."""
    port, client = _free_port(), _free_port()
    folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)  # the path of a socket has 107 bytes at most
    ports = [f"--port={port}", f"--ray-client-server-port={client}", "--node-ip-address=127.0.0.1"]
    options = ["--num-cpus=3", "--include-dashboard=false", "--disable-usage-stats", f"--temp-dir={folder.name}"]
    command = [str(Path(sys.executable).with_name("ray")), "start", "--head", "--block", *ports, *options]
    started = subprocess.Popen(command, env={**os.environ, **LOOPBACK}, start_new_session=True)
    try:
        _wait_for(client, started)
        yield f"ray://127.0.0.1:{client}"
    finally:
        if started.poll() is None:
            os.killpg(started.pid, signal.SIGTERM)
            started.wait(LONGEST_S)
        folder.cleanup()


def _free_port() -> int:
    with socket.socket() as tried:
        tried.bind(("127.0.0.1", 0))
        return int(tried.getsockname()[1])


def _wait_for(port: int, started: subprocess.Popen[bytes]) -> None:
    until = time.monotonic() + LONGEST_S
    while time.monotonic() < until:
        assert started.poll() is None
        with socket.socket() as tried:
            if tried.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.5)
    raise AssertionError("the server for clients never came")


@pytest.mark.slow
def test_a_training_through_ray_client_ends_with_a_policy(head: str, tmp_path: Path) -> None:
    words = ["train", "empty_goal", "--engine", "rllib", "--workers", "2", "--steps", "8000", "--dev-levels", "4"]
    place = ["--address", head, "--out", str(tmp_path / "run")]
    command = [sys.executable, "-m", "irsim_gym", *words, *place]
    subprocess.run(command, env={**os.environ, **LOOPBACK}, check=True, timeout=LONGEST_S)
    assert (tmp_path / "run" / "policy.zip").exists()
