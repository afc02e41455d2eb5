"""Pages of the language: every option, from the declarations themselves."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from builder.tables import table
from irsim_gym.scenario.option_tables import find_family, kind_summaries, markdown

TITLES = {
    "sections": ("Sections and drawing", "The sections of a file, and the keys of their entries."),
    "kinematics": ("Drives", "Kinds of `kinematics`: how a body moves."),
    "behavior": ("Behaviours", "Kinds of `behavior`: how a body decides."),
    "group behavior": ("Group behaviours", "Kinds of `group_behavior`: how the members of an entry decide together."),
    "shape": ("Shapes", "Kinds of `shape`: the area that a body occupies."),
    "distribution": ("Distributions", "Kinds of `distribution`: where bodies start."),
    "sensor": ("Sensors", "Kinds of `sensors`: what a robot perceives."),
    "obstacle map": ("Maps", "Kinds of `obstacle_map`: which cells are occupied."),
    "action": ("Actions", "Kinds of a task's `action`: what a learner gives."),
    "observation": ("Observations", "Kinds of a task's `observations`: what a learner gets."),
    "reward": ("Rewards", "Kinds of a task's `rewards`."),
    "ending": ("Endings", "Kinds of a task's `endings`."),
}
"""Title and first sentence of each page, by the first words of the titles of its tables."""


def pages() -> dict[str, str]:
    """Return a page for the sections and one for each family of kinds, by their places."""
    made = {key: [f"# {title}\n\n{sentence}\n"] for key, (title, sentence) in TITLES.items()}
    for key in made:
        family = find_family(key)
        if family is not None:
            made[key].append(table(("kind", "what it is"), _kinds(kind_summaries(family))) + "\n")
    for title, text in _tables():
        made[page_of(title)].append(text.replace(f"### {title}", f"## {title}", 1))
    return {f"options/{key.replace(' ', '_')}.md": "\n".join(parts) for key, parts in made.items()}


def _kinds(summaries: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Yield the name of each kind, which is that of its table, and what it is."""
    yield from ((f"`{name}`", about) for name, about in summaries.items())


def page_of(title: str) -> str:
    """Return the key in TITLES of the page that holds a table."""
    return next((key for key in TITLES if title.startswith(f"{key} ")), "sections")


def _tables() -> Iterator[tuple[str, str]]:
    """Yield the title and the Markdown of each table."""
    for part in markdown().split("\n### "):
        table = part if part.startswith("### ") else f"### {part}"
        yield table.split("\n", 1)[0].removeprefix("### "), table
