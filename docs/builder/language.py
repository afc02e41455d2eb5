"""Pages of the language: every option, from the declarations themselves."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from builder.tables import table
from irsim_gym.scenario.reference.option_tables import find_family, kind_summaries, markdown

TITLES = {
    "sections": ("Sections and drawing", "The sections of a file, and the keys of their entries."),
    "kinematics": ("Drives", "Kinds of `kinematics`: how a body moves."),
    "behavior": ("Behaviours", "Kinds of `behavior`: how a body decides."),
    "group behavior": ("Group behaviours", "Kinds of `group_behavior`: how the members of an entry decide together."),
    "shape": ("Shapes", "Kinds of `shape`: the area that a body occupies."),
    "distribution": ("Distributions", "Kinds of `distribution`: where bodies start."),
    "sensor": ("Sensors", "Kinds of `sensors`: what a robot perceives."),
    "disturbance": ("Disturbances", "Kinds of `disturbances`: what makes a robot drive and measure differently."),
    "obstacle map": ("Maps", "Kinds of `obstacle_map`: which cells are occupied."),
    "shield": ("Shields", "Kinds of a task's `shield`: what stands between a learner's commands and its drive."),
    "action": ("Actions", "Kinds of a task's `action`: what a learner gives."),
    "observation": ("Observations", "Kinds of a task's `observations`: what a learner gets."),
    "reward": ("Rewards", "Kinds of a task's `rewards`."),
    "ending": ("Endings", "Kinds of a task's `endings`."),
}
"""Title and first sentence of each page, by the first words of the titles of its tables."""


ALL_KINDS = """# All kinds

Every kind that ships, in one table; each name leads to its options. `irsim-gym options reward` prints those of a
family, and [plugins](../plugins.md) add kinds of your own.

"""


def pages() -> dict[str, str]:
    """Return a page for the sections, one for each family of kinds, and one with all kinds, by their places."""
    made = {key: [f"# {title}\n\n{sentence}\n"] for key, (title, sentence) in TITLES.items()}
    rows: list[tuple[str, str, str]] = []
    for key, (title, _) in TITLES.items():
        family = find_family(key)
        if family is not None:
            kinds = kind_summaries(family)
            made[key].append(table(("kind", "what it is"), _kinds(key, kinds)) + "\n")
            rows += ((f"[{title}]({_file(key)})", *row) for row in _kinds(key, kinds, _file(key)))
    for title, text in _tables():
        made[page_of(title)].append(without_empty_columns(text.replace(f"### {title}", f"## {title}", 1)))
    named = {f"options/{_file(key)}": "\n".join(parts) for key, parts in made.items()}
    return named | {"options/index.md": ALL_KINDS + table(("family", "kind", "what it is"), rows) + "\n"}


def _file(key: str) -> str:
    return f"{key.replace(' ', '_')}.md"


def _kinds(key: str, summaries: Mapping[str, str], page: str = "") -> Iterator[tuple[str, str]]:
    """Yield the name of each kind, with a link to its table, and what it is."""
    for name, about in summaries.items():
        anchor = f"{key} {name}".replace(" ", "-")
        yield f"[`{name}`]({page}#{anchor})", about


def without_empty_columns(text: str) -> str:
    """Return a page with a table, without the table's columns that are empty below their heads."""
    lines = text.split("\n")
    cells = {k: re.split(r"(?<!\\)\|", line)[1:-1] for k, line in enumerate(lines) if line.startswith("|")}
    rows = list(cells.values())[2:]
    kept = [column for column in range(len(rows[0]) if rows else 0) if any(row[column].strip() for row in rows)]
    for k, row in cells.items() if rows else ():
        lines[k] = "|" + "|".join(row[column] for column in kept) + "|"
    return "\n".join(lines)


def page_of(title: str) -> str:
    """Return the key in TITLES of the page that holds a table."""
    return next((key for key in TITLES if title.startswith(f"{key} ")), "sections")


def _tables() -> Iterator[tuple[str, str]]:
    """Yield the title and the Markdown of each table."""
    for part in markdown().split("\n### "):
        table = part if part.startswith("### ") else f"### {part}"
        yield table.split("\n", 1)[0].removeprefix("### "), table
