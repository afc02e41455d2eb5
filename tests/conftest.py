"""What holds for all tests."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from hypothesis import settings

from irsim_gym.simulator.running import shards

# PyTorch's threads only wait for each other where every core has a test of its own.
os.environ.setdefault("OMP_NUM_THREADS", "1")
# The same holds for workers that compile: the processes of tests share what is to be compiled among themselves.
os.environ.setdefault("IRSIM_GYM_COMPILERS", "1")

# The first example of a test may compile a kernel, and the machine may be busy.
settings.register_profile("fast", deadline=None, max_examples=30)
settings.register_profile("whole", deadline=None, max_examples=100)


def pytest_configure(config: pytest.Config) -> None:
    """Play all examples of properties only where slow tests run, too."""
    settings.load_profile("fast" if "not slow" in config.getoption("markexpr") else "whole")


# Programs in the background of a script ignore Ctrl-C, and so would those that the tests start.
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(autouse=True, scope="session")
def logs_of_learners(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Stable-Baselines3 makes a folder for each learner without a logger: not among the machine's temporary files."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SB3_LOGDIR", str(tmp_path_factory.mktemp("sb3")))
        yield


@pytest.fixture(autouse=True)
def threads_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Worlds are shared among threads however little there is to do, and threads get something of it."""
    monkeypatch.setattr(shards, "WORTH_S", 0.0)
    monkeypatch.setattr(shards, "HEAD_START_S", 1e-4)


@pytest.fixture
def interrupt(monkeypatch: pytest.MonkeyPatch) -> Callable[[int, int], None]:
    """Send this process a signal when a rollout begins after so many steps."""

    def arrange(steps: int, number: int) -> None:
        # PyTorch is slow to load, and few tests train.
        from irsim_gym.training.runs.monitoring import TrainingMonitor

        original, sent = TrainingMonitor._on_step, []

        def on_step(self: Any) -> bool:
            if not sent and self.num_timesteps > steps:
                sent.append(True)
                os.kill(os.getpid(), number)
            return original(self)

        monkeypatch.setattr(TrainingMonitor, "_on_step", on_step)

    return arrange
