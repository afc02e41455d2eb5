"""What an arena's page holds."""

from pathlib import Path
from typing import Any

from replay_pages import held_data, inflated, main_data

from irsim_gym.evaluation.arena.page_data import SCHEMA, VERSION


def read_page(path: Path) -> dict[str, Any]:
    """Return the data of an arena's page, with its replays as ``episodes``."""
    found = held_data(path)
    data = main_data(found, SCHEMA, VERSION)
    return {**data, "episodes": [inflated(found[f"replay-{i}"]) for i in range(len(data["replays"]))]}
