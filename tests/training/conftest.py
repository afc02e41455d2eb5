from __future__ import annotations

import os
from collections.abc import Callable

import pytest
from irsim_gym.training.runs.monitoring import TrainingMonitor


@pytest.fixture
def interrupt(monkeypatch: pytest.MonkeyPatch) -> Callable[[int, int], None]:
    """Send this process a signal when a rollout begins after so many steps."""

    def arrange(steps: int, number: int) -> None:
        original, sent = TrainingMonitor._on_step, []

        def on_step(self: TrainingMonitor) -> bool:
            if not sent and self.num_timesteps > steps:
                sent.append(True)
                os.kill(os.getpid(), number)
            return original(self)

        monkeypatch.setattr(TrainingMonitor, "_on_step", on_step)

    return arrange
