"""``docs/making.md``: one table of the keywords of all functions that make something of a scenario."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import irsim_gym
from irsim_gym import sb3

PAGE = Path(__file__).parents[2] / "docs" / "making.md"
MAKERS = {
    **{name: getattr(irsim_gym, name) for name in ("make", "make_vec", "parallel_env", "make_batch", "load")},
    **{f"sb3.{name}": getattr(sb3, name) for name in ("make_vec_env", "make_multi_agent_vec_env")},
}


def table() -> dict[str, tuple[str, set[str]]]:
    """Return default and functions of each keyword of the page."""
    rows = re.findall(r"^\| `(\w+)` \| (?:`(.*?)`)? ?\| (.*?) \| ", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    return {keyword: (default, functions(of)) for keyword, default, of in rows}


def functions(cell: str) -> set[str]:
    named = set(re.findall(r"`([\w.]+)`", cell))
    return set(MAKERS) - named if cell.startswith("all") else named


def test_the_table_is_that_of_the_signatures() -> None:
    found = table()
    keywords = {name: inspect.signature(make).parameters for name, make in MAKERS.items()}
    taken = {keyword: {name for name in MAKERS if keyword in keywords[name]} for keyword in found}
    assert {keyword: of for keyword, (_, of) in found.items()} == taken
    everything = {
        name for declared in keywords.values() for name, one in declared.items() if one.kind != one.VAR_KEYWORD
    }
    assert set(found) == everything


def test_a_keyword_has_one_default() -> None:
    for keyword, (default, of) in table().items():
        found = {repr(inspect.signature(MAKERS[name]).parameters[keyword].default) for name in of}
        if keyword == "render_mode":
            assert found == {default, "'rgb_array'"}
        elif keyword != "scenario":
            assert found == {default}
