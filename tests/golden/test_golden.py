"""What the ids mean today: a change here is a change of behaviour, and policies have to be evaluated again."""

from __future__ import annotations

import numpy as np
import pytest
from rollout import HERE, SCENARIOS, rollout


@pytest.mark.parametrize("name", SCENARIOS)
def test_rollouts_are_as_they_were(name: str) -> None:
    kept, found = np.load(HERE / f"{name}.npz"), rollout(name)
    np.testing.assert_array_equal(found["level"], kept["level"])
    np.testing.assert_allclose(found["reward"], kept["reward"], atol=1e-9)
    np.testing.assert_allclose(found["observation"], kept["observation"], atol=2e-5)
