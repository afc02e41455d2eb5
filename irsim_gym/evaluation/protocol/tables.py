"""Results on the terminal and in files, which are written atomically."""

import csv
import glob
import io
import json
import math
import os
import re
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import MISSING, asdict, fields, is_dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar, get_type_hints

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from irsim_gym.base.errors import UnreadableFileError
from irsim_gym.base.outside_files import json_object, reading, writing
from irsim_gym.evaluation.measures.metrics import HITS, OUTCOMES, EpisodeRow, Rate

WIDTH = 160
COMPACT: Mapping[str, Any] = MappingProxyType({"box": SIMPLE_HEAD, "pad_edge": False})
NARROW: Mapping[str, Any] = MappingProxyType({**COMPACT, "padding": (0, 1, 0, 0)})
"""Layouts of tables with many columns."""
PLAIN: Mapping[str, Any] = MappingProxyType({"markup": False, "highlight": False, "soft_wrap": True})
"""Arguments of ``Console.print`` for text that is printed as it is."""
LEGEND = Path(__file__).with_name("legend.json")
"""Meaning of columns, by the beginning of their heads in one line."""
COPIES = "95 % interval: none (-), because all levels are the same, and every episode is a copy of the first"
ROWS, ROW = "table of episodes", "row of an episode"
Row = TypeVar("Row")
PlacedRow = tuple[str, dict[str, str]]
"""File and line of a row, and its cells by column."""
EPISODE_COLUMNS = (*(field.name for field in fields(EpisodeRow)), "spl", "sct", "path_ratio")


def write_text(path: Path, text: str) -> None:
    """Write a text file atomically."""
    write_bytes(path, text.encode())


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file atomically: to a temporary file in the same folder, which is then renamed."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with writing(path), os.fdopen(handle, "wb") as file:
            file.write(content)
        Path(temporary).chmod(0o644)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def remove_leftovers(path: Path) -> None:
    """Remove the temporary files of attempts to write a file during which the process was killed."""
    ours = re.compile(rf"\.{re.escape(path.name)}\.[a-z0-9_]{{8}}")  # as tempfile names them
    for neighbour in path.parent.glob(f".{glob.escape(path.name)}.*"):
        if ours.fullmatch(neighbour.name) and neighbour.is_file():
            neighbour.unlink(missing_ok=True)


def write_figure(path: Path, figure: Any) -> None:
    """Write a figure of Matplotlib as PNG."""
    content = io.BytesIO()
    figure.savefig(content, format="png")
    write_bytes(path, content.getvalue())


def write_json(path: Path, data: object) -> None:
    """Write plain data as JSON; NaN and infinities become null."""
    write_text(path, json.dumps(plain(data), indent=2, allow_nan=False) + "\n")


def write_csv(path: Path, columns: Sequence[str], rows: Iterable[Mapping[str, object]]) -> None:
    """Write rows as CSV with a header line."""
    text = io.StringIO()
    writer = csv.DictWriter(text, fieldnames=list(columns), lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: _rounded(row[name]) for name in columns} for row in rows)
    write_text(path, text.getvalue())


def write_episodes(path: Path, results: Mapping[str, Sequence[EpisodeRow]]) -> None:
    """Write one CSV row per episode of every policy."""
    rows = (
        {"policy": policy, **{name: getattr(row, name) for name in EPISODE_COLUMNS}}
        for policy, episodes in results.items()
        for row in episodes
    )
    write_csv(path, ("policy", *EPISODE_COLUMNS), rows)


def read_rows(path: Path, *kinds: type) -> list[PlacedRow]:
    """Return the rows of a CSV file with a header line: the place of each, for messages, and its cells by column.

    Args:
        *kinds: Dataclasses that ``read_cells`` will make of the rows; fields without a default must be columns.

    Raises:
        IrsimGymError: If the file cannot be read, or a column is missing.
    """
    with reading(path, ROWS), path.open(encoding="utf-8", newline="") as file:
        reader = csv.DictReader(file)
        needed = [field.name for kind in kinds for field in fields(kind) if field.default is MISSING]
        columns = {name for kind in kinds for name in _readers(kind)}.difference(reader.fieldnames or ())
        if missing := [name for name in dict.fromkeys(needed) if name in columns]:
            raise UnreadableFileError(f"{path}:1", ROWS, f"no column {', '.join(missing)} of this version")
        rows = [(f"{path}:{reader.line_num}", row) for row in reader]
    for place, row in rows:
        if None in row or None in row.values():
            raise UnreadableFileError(place, ROW, f"a row must have {len(reader.fieldnames or ())} cells")
    return rows


def read_cells(place: str, kind: type[Row], row: Mapping[str, str], **values: object) -> Row:
    """Make a dataclass of numbers, strings and booleans from the cells of a row.

    Args:
        place: File and line, for messages.
        kind: The dataclass; fields with a default need no column.
        row: Its cells by column.
        **given: Values of fields that are not columns.

    Raises:
        IrsimGymError: If a column is missing, or a cell holds an invalid value.
    """
    every = _readers(kind)  # type: ignore[arg-type]  # every class can be hashed
    readers = {name: read for name, read in every.items() if name in row and name not in values}
    cells: dict[str, Any] = {}
    for name, read in readers.items():
        try:
            cells[name] = read(row[name])
        except (KeyError, TypeError, ValueError):
            wish = _WORDS[get_type_hints(kind)[name]]
            raise UnreadableFileError(place, ROW, f"{name} must be {wish}, got {row[name][:40]!r}") from None
    for name, words in (("outcome", OUTCOMES), ("hit", ("", *HITS, "map"))):
        if name in cells and cells[name] not in words:
            wish = ", ".join(word or "none" for word in words)
            raise UnreadableFileError(place, ROW, f"{name} must be one of {wish}, got {cells[name][:40]!r}")
    needed = [field.name for field in fields(kind) if field.default is MISSING]  # type: ignore[arg-type]
    for name in needed:
        least = -math.inf if name == "min_clearance" else 1e-9 if name == "top_speed" else 0
        if name in cells and not isinstance(cells[name], str) and not cells[name] >= least:
            raise UnreadableFileError(place, ROW, f"{name} must be a number >= {least:g}, got {row[name] or 'none'}")
    return kind(**values, **cells)


@cache
def _readers(kind: type) -> Mapping[str, Callable[[str], object]]:
    """Return the function that reads the cell of each field of a dataclass, for fields of readable types."""
    return {name: _READERS[hint] for name, hint in get_type_hints(kind).items() if hint in _READERS}


def plain(data: object) -> Any:
    """Convert dataclasses, paths, NumPy values and non-finite floats to JSON data."""
    if is_dataclass(data) and not isinstance(data, type):
        return plain(asdict(data))
    if isinstance(data, Mapping):
        return {str(key): plain(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [plain(value) for value in data]
    if hasattr(data, "tolist"):
        return plain(data.tolist())
    if isinstance(data, float):
        return data if math.isfinite(data) else None
    return str(data) if isinstance(data, Path) else data


def titled_table(title: str, **layout: Any) -> Table:
    """Return a table with a title that is printed as it is, also where it looks like markup."""
    return Table(title=Text(title, "table.title"), title_justify="left", **layout)


def figure_table(title: str, heads: Sequence[str], rows: Iterable[Sequence[str]], **layout: Any) -> Table:
    """Return a table whose first column names its rows, and whose other columns hold figures."""
    table = titled_table(title, **layout)
    for k, head in enumerate(heads):
        table.add_column(Text(head), justify="right" if k else "left", no_wrap=not k)
    for cells in rows:
        table.add_row(*map(Text, cells))
    return table


def worst_table(worst: Mapping[str, Mapping[str, float]], seeds: Mapping[str, Sequence[str]]) -> Table:
    """Lay out the success on the worst levels, one row per policy, and one per method with several policies.

    Args:
        worst: Success by policy or method and by share of the levels, see ``worst_of_policies``.
        seeds: Names of the policies of each method that has several.
    """
    title = "success [%] on the worst levels: each policy on its own"
    title += "; a method on those that are worst for the other half of its policies" if seeds else ""
    heads = ["policy", *(f"worst {share}" for share in next(iter(worst.values())))]
    rows = []
    for name, shares in worst.items():
        label = f"{name} ({len(seeds[name])} policies)" if name in seeds else name
        rows.append((label, *(number(100.0 * value, 1) for value in shares.values())))
    return figure_table(title, heads, rows, **NARROW)


def legend(tables: Iterable[Table], shares: Iterable[Rate] = ()) -> str:
    """Return a line for each column of tables whose head needs one.

    Args:
        tables: The tables.
        shares: Shares with intervals in them, where these might be missing.
    """
    meanings = json_object(LEGEND)
    heads = [str(column.header).replace("-\n", "").replace("\n", " ") for table in tables for column in table.columns]
    lines = [f"{name}: {text}" for name, text in meanings.items() if any(head.startswith(name) for head in heads)]
    if any("set " in str(table.title) for table in tables):
        lines.append("set: hash of the levels; certified: they were measured beforehand (`irsim-gym levels certify`)")
    return "\n".join([*lines, *([COPIES] if any(share.is_exact for share in shares) else [])])


def table_text(table: Table) -> str:
    """Return a table as plain text."""
    console = Console(width=WIDTH, file=io.StringIO(), record=True, force_jupyter=False)
    console.print(table)
    return "\n".join(line.rstrip() for line in console.export_text().splitlines()) + "\n"


def print_table(table: Table) -> None:
    """Print a table, at full width if the output is not a terminal."""
    console = Console()
    if console.is_terminal:
        console.print(table)
    else:
        print(table_text(table), end="")


def percent(share: Rate) -> str:
    """Return a share in percent."""
    return f"{100.0 * share.value:.1f}"


def interval(share: Rate) -> str:
    """Return the interval of a share in percent; a dash where all episodes are copies of one."""
    return "-" if share.is_exact else f"{100.0 * share.low:.1f}-{100.0 * share.high:.1f}"


def number(value: float, digits: int) -> str:
    """Return a number as text, or a dash if it is not finite."""
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"


def markdown_table(title: str, notes: Sequence[str], heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table with its heading and notes; the first column holds text."""
    lines = [f"### {title}", "", *(line for note in notes for line in (note, ""))]
    if rows:
        lines += [_markdown_line(heads), "|---" + "|---:" * (len(heads) - 1) + "|"]
    return "\n".join([*lines, *map(_markdown_line, rows), ""])


def _markdown_line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", r"\|") for cell in cells) + " |"


_READERS: dict[type, Callable[[str], object]] = {int: int, str: str, bool: {"True": True, "False": False}.__getitem__}
_READERS |= {float: lambda text: float(text) if text else math.nan}
_WORDS = {int: "a whole number", float: "a number", bool: "True or False"}


def _rounded(value: object) -> object:
    """Round a float to 6 decimals; NaN becomes an empty cell."""
    if not isinstance(value, float):
        return value
    return "" if math.isnan(value) else f"{value:.6g}" if math.isinf(value) else repr(round(value, 6))
