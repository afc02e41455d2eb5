"""The numbers of a group's options, as kernels read them."""

from __future__ import annotations

import numpy as np
import pytest

from irsim_gym.bodies.behaviors.dash import Dash
from irsim_gym.simulator.world import group
from irsim_gym.simulator.world.group import records


def test_a_crowd_that_shares_its_options_is_read_once(monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[type] = []
    hints = group.get_type_hints
    monkeypatch.setattr(group, "get_type_hints", lambda kind: read.append(kind) or hints(kind))
    calm, wandering = Dash(), Dash(wander=True)
    table = records([calm] * 1000 + [wandering] + [calm] * 1000)
    assert read == [Dash]
    assert np.flatnonzero(table["wander"]).tolist() == [1000]
    assert table["index"].tolist() == list(range(2001))
