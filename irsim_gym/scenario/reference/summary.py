"""Short summaries of scenario and task files, without loading them."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from irsim_gym.scenario.reading.parameters import fill_in
from irsim_gym.scenario.text.messages import show
from irsim_gym.scenario.text.source import read_file

SENTENCE_END = (". ", ": ", "; ")


@dataclass(frozen=True)
class FileSummary:
    """The summary of a file.

    Attributes:
        about: First sentence of the comment at its top; empty without one.
        robots: Number of robots for the given parameters.
        parameters: Value of each parameter, as text.
    """

    about: str
    robots: int
    parameters: Mapping[str, str]


def summarize_file(file: Path, parameters: Mapping[str, object] | None = None) -> FileSummary:
    """Summarise a file; a file with mistakes is summarised as far as it can be read.

    Args:
        parameters: Values for its parameters.

    Raises:
        ScenarioError: If the file is not valid YAML.
    """
    source, values = fill_in(read_file(file), dict(parameters or {}))
    entries = source.data.get("robot", ()) if isinstance(source.data, Mapping) else ()
    robots = sum(map(_count, entries if isinstance(entries, list) else [entries]))
    return FileSummary(first_sentence(file), robots, {name: show(value) for name, value in values.items()})


def first_sentence(file: Path) -> str:
    """Return the first sentence of the comment at the top of a file, up to a full stop, colon or semicolon."""
    words = []
    for line in file.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        words += line.lstrip("#").split()
    text = " ".join(words) + " "
    ends = [text.find(mark) for mark in SENTENCE_END if mark in text]
    return text[: min(ends, default=len(text))].strip()


def _count(entry: object) -> int:
    number = entry.get("number", 1) if isinstance(entry, Mapping) else 0
    return number if isinstance(number, int) else 1
