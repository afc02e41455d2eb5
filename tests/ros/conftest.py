"""ROS 1 on the loopback: a master, the node of an exported package, and the ROS side of a simulated robot."""

from __future__ import annotations

import os
import shlex
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from ros_processes import Robot, running

HERE = Path(__file__).parent
SYSTEM = Path(__file__).parents[2] / "build" / "ros"
"""A virtual environment of the system's Python, with onnxruntime and what Debian has of ROS."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.ros)


@pytest.fixture(scope="session")
def variables(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return the environment of all processes: a master on a free port, and no other address than the loopback."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    found = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
    return {
        **found,
        "PATH": f"{SYSTEM.resolve() / 'bin'}:/usr/bin:/bin",
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_IP": "127.0.0.1",
        "ROS_HOME": str(tmp_path_factory.mktemp("ros")),
        "OMP_NUM_THREADS": "1",
    }


@pytest.fixture(scope="session")
def master(variables: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    port = variables["ROS_MASTER_URI"].rsplit(":", 1)[1]
    with (
        (tmp_path_factory.mktemp("master") / "log").open("w") as log,
        running(f"exec roscore -p {port}", variables, stdout=log, stderr=log),
    ):
        for _ in range(300):
            with socket.socket() as trial:
                if trial.connect_ex(("127.0.0.1", int(port))) == 0:
                    break
            time.sleep(0.1)
        yield


@pytest.fixture(scope="session")
def robot(variables: dict[str, str], master: None) -> Iterator[Robot]:
    command = f"exec python3 {shlex.quote(str(HERE / 'bridge.py'))}"
    with running(command, variables, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        yield Robot(process)
