"""Write the tables of README.md here and of docs/speed.md, and draw the charts, from results/*.json.

    python benchmarks/charts.py [--check]

``cases.json`` is a result of run.py, ``peers.json`` one of peers.py; every other file is shown as it is.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import pictures
import results
import tables
from pictures import CASES, PEERS, Found

HERE = Path(__file__).parent
README, FRONT = HERE / "README.md", HERE.parent / "docs" / "speed.md"
BEGIN, END = "<!-- written by charts.py from here -->", "<!-- to here -->"


def load(folder: Path = results.FOLDER) -> Found:
    """Return all committed results by the names of their files."""
    return {file.name: results.read(file) for file in sorted(folder.glob("*.json"))}


def text(found: Found) -> str:
    """Return what README.md says of the results."""
    parts = []
    if PEERS in found or CASES in found:
        figures = {name: values for result in found.values() for name, values in result["results"].items()}
        parts += ["## Targets and figures", tables.targets(figures)]
    if PEERS in found:
        parts += ["## Figures beside others", "![agent-steps per second](charts/peers.png)"]
        parts.append(tables.beside_others(PEERS, found[PEERS]))
    if drawn := found.get(CASES, {}).get("results", {}).get("frames/everything"):
        parts += ["## Pictures", tables.drawing(drawn)]
    if CASES in found:
        parts += ["## Figures of all cases", "![growth](charts/growth.png)", "![phases](charts/phases.png)"]
        parts.append(tables.cases(CASES, found[CASES]))
    for name, result in found.items():
        if name not in (CASES, PEERS):
            parts += [f"## {name.removesuffix('.json').capitalize()}", tables.cases(name, result)]
    return "\n\n".join(parts)


def front(found: Found) -> str:
    """Return what docs/speed.md says of the results."""
    return tables.front(found[PEERS]) if PEERS in found else ""


def page(written: str, before: str) -> str:
    """Return a page with what is between the marks written anew."""
    head, _, rest = before.partition(BEGIN)
    _, _, tail = rest.partition(END)
    return f"{head}{BEGIN}\n\n{written}\n\n{END}{tail}"


def main() -> int:
    """Write the pages and the charts, or say whether the pages are as they should be."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if a page is out of date")
    asked = parser.parse_args()
    found = load()
    pages = {file: file.read_text(encoding="utf-8") for file in (README, FRONT)}
    after = {README: page(text(found), pages[README]), FRONT: page(front(found), pages[FRONT])}
    if asked.check:
        return int(pages != after)
    for file, written in after.items():
        file.write_text(written, encoding="utf-8")
    for drawn in pictures.draw(found):
        print(drawn)
    return 0


if __name__ == "__main__":
    sys.exit(main())
