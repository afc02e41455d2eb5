"""Compare two results: python benchmarks/compare.py BEFORE.json AFTER.json [-f REGEX] [--tolerance SHARE] [--all].

A figure counts as changed when it moved by more than the tolerance and by more than three times the noise of both
measurements. The exit status is 1 when anything got worse, so that a change can be stopped.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import results
from rich.table import Table

Verdict = Literal["better", "worse", "same", "gone", "new"]

LESS_IS_BETTER = ("_us", "_ms", "_s", "_kib", "_kernels", "_over_twin", "_over_plain")
MORE_IS_BETTER = ("_per_cpu_s", "_times_faster", "_times_slower", "_share_of_noop")
"""Endings of names; ``times_slower`` is said of a peer. What ends otherwise describes the run and is not judged."""

TOLERANCE = 0.05
NOISES = 3.0


@dataclass(frozen=True)
class Change:
    """A figure in two results.

    Attributes:
        case: The case.
        figure: The figure.
        before: Its value in the first result; None if it is not there.
        after: The same in the second.
        threshold: Least change that counts, as a share.
    """

    case: str
    figure: str
    before: float | None
    after: float | None
    threshold: float

    @property
    def ratio(self) -> float | None:
        """After over before; None where one is not there or before is 0."""
        return None if self.before is None or self.after is None or self.before == 0.0 else self.after / self.before

    @property
    def verdict(self) -> Verdict:
        """What to think of it."""
        if self.before is None:
            return "new"
        if self.after is None:
            return "gone"
        ratio = self.ratio
        if ratio is None or 1.0 / (1.0 + self.threshold) <= ratio <= 1.0 + self.threshold:
            return "same"
        return "better" if (ratio > 1.0) == (sense(self.figure) > 0) else "worse"


def sense(figure: str) -> int:
    """Return 1 where more is better, -1 where less is better, 0 for what is not judged."""
    if figure.endswith(MORE_IS_BETTER):
        return 1
    return -1 if figure.endswith(LESS_IS_BETTER) else 0


def compare(before: Mapping[str, Any], after: Mapping[str, Any], tolerance: float = TOLERANCE) -> Iterator[Change]:
    """Yield all figures that are judged, in the order of the first result, then what is new in the second."""
    old, new = before["results"], after["results"]
    for case in [*old, *(case for case in new if case not in old)]:
        was, now = old.get(case, {}), new.get(case, {})
        for figure in [*was, *(figure for figure in now if figure not in was)]:
            if sense(figure):
                noises = [one.get("noise", {}).get(case, {}).get(figure, 0.0) for one in (before, after)]
                threshold = max(tolerance, NOISES * max(noises))
                yield Change(case, figure, was.get(figure), now.get(figure), threshold)


def machines_differ(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[str]:
    """Return what should be the same for times to be comparable, and is not."""
    keys = ("processor", "cores", "python")
    pairs = [(key, before["machine"].get(key), after["machine"].get(key)) for key in keys]
    return [f"{key}: {old} and {new}" for key, old, new in pairs if old != new]


def main() -> int:
    """Show what changed; return 1 when anything got worse."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("-f", "--filter", default="", help="only figures whose 'case figure' matches")
    parser.add_argument("--tolerance", type=float, default=TOLERANCE, help="least change that counts, as a share")
    parser.add_argument("--all", action="store_true", help="show what stayed the same too")
    asked = parser.parse_args()
    before, after = results.read(asked.before), results.read(asked.after)
    console = results.console()
    for difference in machines_differ(before, after):
        console.print(f"[yellow]The machines differ: {difference}")
    found = [
        change
        for change in compare(before, after, asked.tolerance)
        if re.search(asked.filter, f"{change.case} {change.figure}")
    ]
    table = Table("case", "figure", "before", "after", "ratio", "counts from", "")
    for change in found:
        if asked.all or change.verdict != "same":
            cells = ["" if value is None else f"{value:.4g}" for value in (change.before, change.after, change.ratio)]
            table.add_row(change.case, change.figure, *cells, f"{100.0 * change.threshold:.0f} %", change.verdict)
    console.print(table)
    counts = {verdict: sum(change.verdict == verdict for change in found) for verdict in ("better", "worse", "same")}
    console.print(", ".join(f"{count} {verdict}" for verdict, count in counts.items()))
    return int(counts["worse"] > 0)


if __name__ == "__main__":
    sys.exit(main())
