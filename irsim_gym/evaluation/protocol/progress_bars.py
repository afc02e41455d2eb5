"""Progress bars, which only a terminal shows."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn


def progress_bar(console: Console | None = None) -> Progress:
    """Return a progress bar for a console, or for standard error."""
    screen = console or Console(stderr=True)
    words = TextColumn("{task.description}", style="progress.description", markup=False)  # names are no markup
    columns = (words, BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    return Progress(*columns, console=screen, disable=not screen.is_terminal, transient=True)


@contextmanager
def counting(words: str, total: int) -> Iterator[Callable[[int], None]]:
    """Show a progress bar with some words, and yield a function that advances it by a number of steps."""
    with progress_bar() as bar:
        line = bar.add_task(words, total=total)
        yield lambda steps: bar.advance(line, steps)
