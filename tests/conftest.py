"""What holds for all tests."""

from __future__ import annotations

import pytest

from irsim_gym.engine import shards


@pytest.fixture(autouse=True)
def threads_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Worlds are shared among threads however little there is to do, and threads get something of it."""
    monkeypatch.setattr(shards, "WORTH_S", 0.0)
    monkeypatch.setattr(shards, "HEAD_START_S", 1e-4)
