from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from irsim_gym.errors import ScenarioError
from irsim_gym.scenario import Scenario, load_scenario

Load = Callable[[str], Scenario]
Problems = Callable[[str], list[str]]


@pytest.fixture
def load(tmp_path: Path) -> Load:
    """Load YAML text as the file ``my.world.yaml``."""

    def loaded(text: str) -> Scenario:
        file = tmp_path / "my.world.yaml"
        file.write_text(text, encoding="utf-8")
        return load_scenario(file)

    return loaded


@pytest.fixture
def problems(load: Load) -> Problems:
    """Return the problems of YAML text as ``line path: message``."""

    def told(text: str) -> list[str]:
        with pytest.raises(ScenarioError) as caught:
            load(text)
        return [f"{p.line} {p.path + ': ' if p.path else ''}{p.message}" for p in caught.value.problems]

    return told
