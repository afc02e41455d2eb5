"""Tables in Markdown of what an environment says of itself."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from irsim_gym.envs.described.description import Action, Block, Description, Part


def table(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table in Markdown; a pipe within a cell is escaped."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(
        "| " + " | ".join(str(cell).replace("|", "\\|").replace("\n", " ") for cell in line) + " |" for line in lines
    )


def number(value: float) -> str:
    """Return a number with up to four decimals; infinity as a word."""
    if math.isinf(value):
        return "infinity" if value > 0 else "-infinity"
    return f"{round(value, 4):g}"


def observation(description: Description) -> str:
    """Return names, shapes, ranges and meanings of an observation's numbers."""
    rows = [_row(block, part) for block in description.blocks for part in block.parts]
    heads = ("observation", "shape", "columns", "meaning", "scale", "range")
    return f"`{description.observation_space}`\n\n" + table(heads, rows)


def _row(block: Block, part: Part) -> Sequence[object]:
    is_first = part is block.parts[0]
    columns = str(part.start) if part.stop == part.start + 1 else f"{part.start} - {part.stop - 1}"
    shape = " x ".join(map(str, block.shape)) if is_first else ""
    where = f"{part.meaning}; {part.directions}" if part.directions else part.meaning
    span = f"{number(part.low)} to {number(part.high)}"
    return (f"`{block.name}`" if is_first else "", shape, columns, where, part.scale, span)


def action(given: Action) -> str:
    """Return the components of an action, and its choices where it has some."""
    rows = [
        (one.name, one.unit, number(one.low), number(one.high), number(one.most_change)) for one in given.components
    ]
    text = f"`{given.space}`: {given.summary}\n\n"
    text += table(("component", "unit", "at -1", "at 1", "greatest change in a second"), rows)
    if given.choices:
        choices = [(k, *map(number, choice)) for k, choice in enumerate(given.choices)]
        text += "\n\n" + table(("choice", *(one.name for one in given.components)), choices)
    return text


def rewards(description: Description) -> str:
    """Return the terms of the reward."""
    rows = [(f"`{one.name}`", one.role, one.sign, number(one.weight), one.when) for one in description.rewards]
    return table(("term", "role", "sign", "weight", "when"), rows) if rows else "None."


def endings(description: Description) -> str:
    """Return what ends an episode, the time limit at last."""
    limit = f"after {description.max_steps} steps of {description.step_time:g} s"
    rows = [(f"`{one.name}`", f"`{one.outcome}`", one.when) for one in description.endings]
    return table(("ending", "outcome", "when"), [*rows, ("time limit", "`TIMEOUT`", limit)])
