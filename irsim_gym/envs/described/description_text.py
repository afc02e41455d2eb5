"""A description as tables: in a terminal, as plain text, and for notebooks."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from io import StringIO
from typing import Any

from irsim_gym.envs.described.parts import Block, Described

WIDTH = 120
"""Characters in a line of plain text."""
MOST_NAMES = 6
MOST_CHOICES = 50
"""More choices than this are not listed one by one."""


@dataclass(frozen=True)
class Sheet:
    """One table.

    Attributes:
        title: What stands above it.
        heads: Names of its columns.
        rows: Its cells.
        widest: The column that gets the room that is left.
    """

    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    widest: int


def as_text(description: Described) -> str:
    """Return plain text, without colours or lines."""
    from rich.console import Console

    out = StringIO()
    _write(Console(file=out, width=WIDTH, force_terminal=False, color_system=None), description, lined=False)
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines())


def show(description: Described) -> None:
    """Print tables where the output is a terminal, else plain text."""
    from rich.console import Console

    console = Console()
    if console.is_terminal:
        _write(console, description, lined=True)
    else:
        print(as_text(description))


def as_html(description: Described) -> str:
    """Return the tables for a notebook."""
    parts = [f"<b>{escape(line)}</b><br>" for line in headlines(description)]
    for sheet in sheets(description):
        heads = "".join(f"<th>{escape(head)}</th>" for head in sheet.heads)
        rows = "".join(f"<tr>{''.join(f'<td>{_cell(cell)}</td>' for cell in row)}</tr>" for row in sheet.rows)
        parts.append(f"<p>{escape(sheet.title)}</p><table><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table>")
    return "\n".join(parts)


def _cell(text: str) -> str:
    return escape(text).replace("\n", "<br>")


def _write(console: Any, description: Described, *, lined: bool) -> None:
    from rich.box import ROUNDED
    from rich.table import Table
    from rich.text import Text

    for line in headlines(description):
        console.print(Text(line), highlight=False)
    for sheet in sheets(description):
        box = ROUNDED if lined else None
        table = Table(title=Text(sheet.title), title_justify="left", box=box, show_lines=False, pad_edge=lined)
        for k, head in enumerate(sheet.heads):
            table.add_column(Text(head), ratio=1 if k == sheet.widest else None, no_wrap=k == 0)
        for row in sheet.rows:
            table.add_row(*map(Text, row))
        console.print()
        console.print(table, highlight=False)


def headlines(description: Described) -> list[str]:
    """Return what stands above the tables."""
    said = description
    others = f" (the same for {_some(said.same_for)})" if said.same_for else ""
    seconds = said.max_steps * said.step_time
    return [
        f"{said.scenario}: {said.agent} learns{others}, task {said.task}",
        f"time limit: {said.max_steps} steps of {said.step_time:g} s = {seconds:g} s",
        f"observation: {said.observation_space}, {said.form}",
        f"action: {said.action.space}",
        f"needed on a robot: {_needed(said)}",
    ]


def _needed(description: Described) -> str:
    """Return what a robot must have, and which observations of plugins do not say."""
    unsaid = [block.name for block in description.blocks if block.needs is None]
    unknown = [f"not said by {', '.join(unsaid)} (declare 'needs')"] if unsaid else []
    return "; ".join([", ".join(description.needs) or "nothing", *unknown])


def _some(names: Sequence[str]) -> str:
    more = f" and {len(names) - MOST_NAMES} others" if len(names) > MOST_NAMES else ""
    return ", ".join(names[:MOST_NAMES]) + more


def sheets(description: Described) -> Iterator[Sheet]:
    """Yield the tables of a description."""
    rows = [row for block in description.blocks for row in _block_rows(block, description.form)]
    yield Sheet("observation", ("columns", "block", "from", "to", "what it holds"), tuple(rows), 4)
    yield from _action_sheets(description)
    paid = [(item.name, item.role, f"{item.sign}, weight {item.weight:g}", item.when) for item in description.rewards]
    yield Sheet("reward: the sum of", ("term", "role", "sign", "when it pays"), tuple(paid), 3)
    ends = [(item.name, item.outcome, item.when) for item in description.endings]
    ends.append(("time limit", "TIMEOUT", f"after {description.max_steps} steps; truncated, the others terminate"))
    yield Sheet("an episode ends, of several the first counts", ("ending", "outcome", "when"), tuple(ends), 2)
    yield Sheet("numbers of the task", ("key", "value"), description.numbers, 1)
    infos = tuple((item.key, item.unit, item.meaning) for item in description.infos)
    yield Sheet("info", ("key", "unit", "meaning"), infos, 2)


def _block_rows(block: Block, form: str) -> Iterator[tuple[str, ...]]:
    """Yield a row for each part of a block; the name of the block stands in the first."""
    shape = f" {block.shape}" if block.is_image or form == "dict" else ""
    place = f" in {block.key}" if block.key not in ("", block.name) else ""
    yield "", f"{block.name}{shape}{place}", "", "", f"{block.summary} {block.view}".strip()
    for part in block.parts:
        span = f"{part.start}" if part.stop == part.start + 1 else f"{part.start}:{part.stop}"
        meaning = "\n".join(filter(None, (f"- {part.meaning}", part.scale, part.directions)))
        yield span, "", f"{part.low:.3g}", f"{part.high:.3g}", meaning


def _action_sheets(description: Described) -> Iterator[Sheet]:
    action = description.action
    heads = ("component", "-1 means", "1 means", "changes at most")
    rows = []
    for k, item in enumerate(action.components):
        change = f"{item.most_change:g} {item.unit}/s".strip() if math.isfinite(item.most_change) else "without a limit"
        rows.append((f"{k}  {item.name}", f"{item.low:g} {item.unit}", f"{item.high:g} {item.unit}", change))
    if action.choices:
        heads = ("component", "least", "greatest", "changes at most")
    yield Sheet(f"action {action.name}: {action.summary}", heads, tuple(rows), 3)
    if 0 < len(action.choices) <= MOST_CHOICES:
        names = tuple(f"{item.name} [{item.unit}]" for item in action.components)
        choices = [(str(k), *(f"{value:.4g}" for value in row)) for k, row in enumerate(action.choices)]
        yield Sheet("choices", ("choice", *names), tuple(choices), len(names))
