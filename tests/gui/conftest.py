"""A screen of our own for tests with real windows: nothing appears on the screen of whoever runs them.

`make test` imports these files too, without the packages of the extra `test-gui`: import those inside functions.
"""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from screen import Screen

HERE = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.gui)


@pytest.fixture(scope="session")
def display() -> Iterator[str]:
    """Start a virtual screen of 1280 x 1024 pixels; return the name of its display."""
    reader, writer = os.pipe()
    command = [
        "Xvfb",
        "-displayfd",
        str(writer),
        "-screen",
        "0",
        "1280x1024x24",
        "-nolisten",
        "tcp",
        "-noreset",
        "-dpi",
        "96",
    ]
    server = subprocess.Popen(command, pass_fds=[writer], stderr=subprocess.DEVNULL)
    os.close(writer)
    with os.fdopen(reader) as told:
        name = f":{told.readline().strip()}"
    before = {key: os.environ.get(key) for key in ("DISPLAY", "WAYLAND_DISPLAY")}
    os.environ["DISPLAY"] = name
    os.environ.pop("WAYLAND_DISPLAY", None)
    yield name
    for key, value in before.items():
        os.environ.pop(key, None)
        if value is not None:
            os.environ[key] = value
    server.terminate()
    server.wait()


@pytest.fixture
def screen(display: str) -> Iterator[Screen]:
    """Keys, mouse and pictures of the virtual screen; keys that a test left down are released."""
    seen = Screen()
    seen.release_all()
    seen.move(1270, 1015)
    yield seen
    seen.release_all()
    seen.close()


@pytest.fixture
def until() -> Callable[..., None]:
    """Return a function that waits, letting events come in, until something holds."""

    def wait_until(holds: Callable[[], bool], wait: Callable[[float], None] = time.sleep, most: float = 5.0) -> None:
        end = time.monotonic() + most
        while not holds():
            assert time.monotonic() < end, "what was waited for has not come"
            wait(0.02)

    return wait_until


@pytest.fixture
def kept_picture(request: pytest.FixtureRequest) -> Callable[[np.ndarray], None]:
    """Return a function that keeps a picture for people to look at, in the folder that IRSIM_GYM_PICTURES names."""

    def keep(picture: np.ndarray) -> None:
        from PIL import Image

        folder = os.environ.get("IRSIM_GYM_PICTURES")
        if folder:
            count = len(list(Path(folder).glob(f"{request.node.name}*")))
            Image.fromarray(picture).save(Path(folder) / f"{request.node.name}-{count}.png")

    return keep
