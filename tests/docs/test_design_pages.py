"""Pages about rooms, and the one of measured choices, name files and folders that are there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "irsim_gym"
PAGES = [*sorted((ROOT / "docs" / "design").glob("*.md")), ROOT / "benchmarks" / "choices.md"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_places_are_in_the_room_in_the_package_or_in_the_repository(page: Path) -> None:
    """A name without a folder may stand anywhere in its room."""
    room, missing = PACKAGE / page.stem, []
    named = re.findall(r"`([\w./]+?(?:\.py|/))`", page.read_text(encoding="utf-8"))
    for place in sorted(set(named)):
        is_there = any((above / place).exists() for above in (room, PACKAGE, ROOT, page.parent))
        if not is_there and ("/" in place.rstrip("/") or not list(room.rglob(place.rstrip("/")))):
            missing.append(place)
    assert named
    assert missing == []
