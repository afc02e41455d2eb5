"""Environments leave no figure, thread or memory behind, and draw without a display whatever was imported before."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import threading
import weakref

import matplotlib.pyplot as plt
import pytest
from matplotlib.figure import Figure

import irsim_gym

WORLD = {"plot": {"figure_pixels": [80, 60]}}
SCENARIO = {"world": WORLD, "robot": {"kinematics": {"name": "diff"}, "state": [1, 5, 0], "goal": [9, 5, 0]}}


def drawn(*, closes: bool) -> weakref.ref:
    env = irsim_gym.make(SCENARIO, render_mode="rgb_array")
    env.reset(seed=0)
    assert env.render().any()
    if closes:
        env.close()
    return weakref.ref(env.unwrapped)


def resident() -> float:
    """Return the memory of this process [MB]."""
    with open("/proc/self/statm") as file:  # noqa: PTH123
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def test_a_hundred_environments_leave_nothing() -> None:
    figures, threads = plt.get_fignums(), threading.enumerate()
    for _ in range(10):
        drawn(closes=True)
    gc.collect()
    before = resident() if sys.platform == "linux" else 0.0
    known = sum(issubclass(type(thing), Figure) for thing in gc.get_objects())
    left = [drawn(closes=k % 2 == 0) for k in range(90)]
    gc.collect()
    assert [one for one in left if one() is not None] == []
    assert sum(issubclass(type(thing), Figure) for thing in gc.get_objects()) <= known
    assert plt.get_fignums() == figures == []
    assert threading.enumerate() == threads
    if sys.platform == "linux":
        assert resident() - before < 25.0  # a figure that stays is 0.3 MB and more, an environment likewise


DRAW = f"""
env = irsim_gym.make({SCENARIO!r}, render_mode="rgb_array")
env.reset(seed=0)
assert env.render().shape == (60, 80, 3)
"""
PYPLOT = "import matplotlib.pyplot as plt"
ORDERS = {
    "pyplot_after": f"import irsim_gym{DRAW}{PYPLOT}\nplt.figure()",
    "windows_before": f"import matplotlib; matplotlib.use('TkAgg', force=False)\nimport irsim_gym{DRAW}",
    "svg_before": (
        f"import matplotlib; matplotlib.use('svg')\n{PYPLOT}\nimport irsim_gym{DRAW}"
        "plt.figure()\nassert plt.get_backend() == 'svg'"
    ),
}


@pytest.mark.parametrize("code", ORDERS.values(), ids=ORDERS)
def test_pictures_need_no_display(code: str) -> None:
    outside = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    script = f"{code}\nimport matplotlib.pyplot as plt\nassert len(plt.get_fignums()) == {code.count('plt.figure()')}"
    command = [sys.executable, "-W", "error", "-c", script]
    result = subprocess.run(command, env=outside, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
