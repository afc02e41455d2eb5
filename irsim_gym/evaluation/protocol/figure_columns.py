"""The columns of tables of figures, on the terminal and on the pages of arenas."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rich.table import Table

from irsim_gym.base.outside_files import json_object
from irsim_gym.evaluation.measures.metrics import HITS, Rate
from irsim_gym.evaluation.measures.team_metrics import TEAM_HITS, ExtraTime, TeamSummary
from irsim_gym.evaluation.protocol.tables import NARROW, figure_table, interval, number, percent

FILE = Path(__file__).with_name("columns.json")
"""The columns, by place (``terminal`` or ``page``), and of single robots or of teams."""


class FigureColumn(NamedTuple):
    """A column of a table of figures.

    Attributes:
        head: Its heading.
        field: Name in ``Summary`` or ``TeamSummary``.
        about: Explanation of the column, on a page.
        digits: Number of decimals; 0 for a share.
        scale: Factor on a number.
        interval: Whether a cell holds the interval of a share in its place.
        needs: Field without whose values in any summary the column is left out; empty if it is always shown.
        hit: Key of the share in ``collision_with``; empty for other fields.
    """

    head: str
    field: str
    about: str = ""
    digits: int = 0
    scale: float = 1.0
    interval: bool = False
    needs: str = ""
    hit: str = ""

    def value(self, summary: Any) -> Any:
        """Return the figure of a summary."""
        figure = getattr(summary, self.field)
        return figure[self.hit] if self.hit else figure

    def text(self, summary: Any) -> str:
        """Return the cell of a summary."""
        value = self.value(summary)
        if isinstance(value, ExtraTime):
            return percentiles(value)
        if isinstance(value, Rate):
            return interval(value) if self.interval else percent(value)
        return number(self.scale * value, self.digits)


def figure_columns(place: str, summaries: Sequence[Any]) -> list[FigureColumn]:
    """Return the columns for summaries, without what never occurred; collisions are split by what was hit."""
    is_team = isinstance(summaries[0], TeamSummary)
    columns = (FigureColumn(**entry) for entry in json_object(FILE)[place]["team" if is_team else "single"])
    shown: list[FigureColumn] = []
    for column in columns:
        if not column.needs or any(_occurs(getattr(each, column.needs)) for each in summaries):
            shown.append(column)
        if column.field == "collision":
            hits = TEAM_HITS if is_team else HITS
            seen = [hit for hit in hits if any(each.collision_with[hit].count for each in summaries)]
            unit = "\n[%]" if column.head.endswith("\n[%]") else ""
            split = [(f"with {hit}{unit}", f"Share that collided with: {hit}", hit) for hit in seen]
            shown += [FigureColumn(head, "collision_with", told, hit=hit) for head, told, hit in split if len(seen) > 1]
    return shown


def summary_table(summaries: Sequence[Any], title: str) -> Table:
    """Lay out the figures of several policies, one row each; narrow enough for a terminal of 80 columns."""
    columns = figure_columns("terminal", summaries)
    rows = [(each.policy, *(column.text(each) for column in columns)) for each in summaries]
    return figure_table(title, ["policy", *(column.head for column in columns)], rows, **NARROW)


def percentiles(time: ExtraTime) -> str:
    """Return the percentiles of extra times, or a dash if there are none."""
    return "/".join(number(value, 1) for value in (time.p50, time.p75, time.p90)) if time.arrivals else "-"


def _occurs(value: Any) -> bool:
    return value.count > 0 if isinstance(value, Rate) else math.isfinite(value)
