"""A cluster that is reached through Ray Client (``--address ray://``), on the loopback."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from needed import library

LONGEST_S = 500
LOOPBACK = {"RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER": "0", "RAY_USAGE_STATS_ENABLED": "0"}


@pytest.fixture(scope="module", autouse=True)
def ray():
    return library("ray")


@pytest.fixture
def head() -> Iterator[str]:
    """Start a cluster of its own process, and return the address of its server for clients."""
    ports = [_free_port() for _ in range(2)]
    _ray("start", "--head", "--node-ip-address=127.0.0.1", f"--port={ports[0]}", f"--ray-client-server-port={ports[1]}",
         "--include-dashboard=false", "--num-cpus=3", "--disable-usage-stats")  # fmt: skip
    yield f"ray://127.0.0.1:{ports[1]}"
    _ray("stop", "--force")


def _free_port() -> int:
    with socket.socket() as tried:
        tried.bind(("127.0.0.1", 0))
        return int(tried.getsockname()[1])


def _ray(*words: str) -> None:
    command = Path(sys.executable).with_name("ray")
    subprocess.run([command, *words], env={**os.environ, **LOOPBACK}, check=True, timeout=LONGEST_S)


@pytest.mark.slow
def test_a_training_through_ray_client_ends_with_a_policy(head: str, tmp_path: Path) -> None:
    words = ["train", "empty_goal", "--engine", "rllib", "--workers", "2", "--steps", "8000", "--dev-levels", "4"]
    place = ["--address", head, "--out", str(tmp_path / "run")]
    command = [sys.executable, "-m", "irsim_gym", *words, *place]
    subprocess.run(command, env={**os.environ, **LOOPBACK}, check=True, timeout=LONGEST_S)
    assert (tmp_path / "run" / "policy.zip").exists()
