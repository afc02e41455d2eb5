"""What came of a session, as a result to keep: ``PART.json`` and, to be read, ``PART.md``."""

from __future__ import annotations

import json
import platform
from collections import Counter
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from typing import Any

from cosmic_ray.work_db import WorkDB
from cosmic_ray.work_item import TestOutcome
from mutants import EXCLUDED

HERE = Path(__file__).parent
WORDS = HERE / "words.json"
"""For a survivor, by its name: what is equivalent, with the reason, or what no test asserts."""

EQUIVALENT = "equivalent: "


def write(db: WorkDB, about: dict[str, Any], folder: Path = HERE) -> None:
    """Write the result of a session, with the words that somebody found for its survivors."""
    words: dict[str, str] = json.loads(WORDS.read_text(encoding="utf-8"))
    results = dict(db.results)
    rows = []
    for item in sorted(db.work_items, key=lambda item: (item.mutations[0].module_path, item.mutations[0].start_pos)):
        result = results.get(item.job_id)
        row = {"mutant": item.job_id, "result": "not played" if result is None else result.output}
        if result is not None:
            row["diff"] = result.diff
            if result.test_outcome is TestOutcome.SURVIVED:
                row["word"] = words.get(item.job_id, "")
        rows.append(row)
    facts = {
        "tool": f"cosmic-ray {version('cosmic-ray')}",
        "python": platform.python_version(),
        "excluded": list(EXCLUDED),
        **about,
        "mutants": rows,
    }
    (folder / f"{about['part']}.json").write_text(json.dumps(facts, indent=1) + "\n", encoding="utf-8")
    (folder / f"{about['part']}.md").write_text(page(facts), encoding="utf-8")


def equivalents() -> set[str]:
    """Return the mutants that somebody has found to change nothing."""
    words: dict[str, str] = json.loads(WORDS.read_text(encoding="utf-8"))
    return {name for name, word in words.items() if word.startswith(EQUIVALENT)}


def fate(row: dict[str, Any]) -> str:
    """Return ``killed``, ``equivalent``, ``alive`` or ``not played``."""
    if row["result"] == "not played" or row["result"].startswith("killed"):
        return str(row["result"].split(":")[0].split(" by")[0])
    return "equivalent" if row.get("word", "").startswith(EQUIVALENT) else "alive"


def page(facts: dict[str, Any]) -> str:
    """Return the page: a table by folder, and the survivors."""
    rows = facts["mutants"]
    folders: dict[str, list[dict[str, Any]]] = {}
    for row in rows:
        folders.setdefault(row["mutant"].split("/")[1], []).append(row)
    lines = [
        "# Mutation testing",
        "",
        f"Written by `make mutate ARGS='--part {facts['part']}'`. {len(rows)} mutants of "
        f"{sum(facts['population'].values())}, drawn with seed {facts['seed']} from commit",
        f"{facts['commit'][:10]} by {facts['tool']} under Python {facts['python']}, played by today's tests.",
        "",
        "Not mutated:",
        "",
        *(f"- {what}" for what in facts["excluded"]),
        "",
        "An equivalent mutant changes nothing that can be seen; the last column leaves those out. Operators that leave",
        "no program which may run, such as `<<` between floats, are not used (`mutants.py`); statements left out are",
        "added. Tests ran in plain Python, those of `direct` and `fused` compiled; each test that killed",
        "a mutant has passed without one in the same way.",
        "",
        "| folder | mutants | killed | equivalent | alive | killed of all | killed of those that can be |",
        "|---|---|---|---|---|---|---|",
        *(_table_row(f"`{name}/`", some) for name, some in folders.items()),
        _table_row("all", rows),
        "",
    ]
    waiting = sum(fate(row) == "not played" for row in rows)
    if waiting:
        lines += [f"{waiting} have not been played yet: `make mutate` goes on.", ""]
    for title, kind in (("Alive", "alive"), ("Equivalent", "equivalent")):
        some = [row for row in rows if fate(row) == kind]
        if some:
            lines += [f"## {title}", "", *(line for row in some for line in _entry(row)), ""]
    return "\n".join(lines).rstrip("\n") + "\n"


def _table_row(name: str, rows: Iterable[dict[str, Any]]) -> str:
    count = Counter(fate(row) for row in rows)
    played = count["killed"] + count["equivalent"] + count["alive"]
    shares = [f"{100 * count['killed'] / of:.1f} %" if of else "" for of in (played, played - count["equivalent"])]
    cells = [name, *(str(n) for n in (played, count["killed"], count["equivalent"], count["alive"])), *shares]
    return f"| {' | '.join(cells)} |"


def _entry(row: dict[str, Any]) -> list[str]:
    word = row.get("word", "").removeprefix(EQUIVALENT) or row["result"]
    diff = [line if len(line) <= 110 else line[:107] + "..." for line in row["diff"].splitlines()]
    return [f"- `{row['mutant']}`:", f"  {word}", "", "  ```diff", *(f"  {line}" for line in diff), "  ```", ""]
