"""Mutants are played, some at a time, each by the tests that reach it, and their results are kept in the session."""

from __future__ import annotations

import contextlib
import difflib
import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import children
import parso
from cosmic_ray.ast import get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.work_db import WorkDB
from cosmic_ray.work_item import TestOutcome, WorkerOutcome, WorkItem, WorkResult
from mutants import operators
from selection import chosen_tests

SLACK_S = 20.0
"""A mutant that needs this much more than twice the time of its tests [s of the processor] runs in circles."""

PATIENCE = 15.0
"""A mutant that has not ended after so many times its processor time waits for something that never comes."""

COMPOUND = ("if_stmt", "for_stmt", "while_stmt", "try_stmt", "with_stmt", "funcdef", "classdef")


@dataclass
class Slot:
    """A place for one mutant at a time."""

    folder: Path
    item: WorkItem | None = None
    pid: int = 0
    deadline: float = 0.0
    diff: str = ""

    @property
    def log(self) -> Path:
        """What pytest has printed."""
        return self.folder / "log"

    @property
    def killer(self) -> Path:
        """Where the test that noticed the mutant is written."""
        return self.folder / "killer"


def play(
    repository: Path, folder: Path, db: WorkDB, known: dict[str, Any], names: set[str], budget: float, workers: int
) -> None:
    """Play the named mutants, and write each result into the database.

    Args:
        repository: What is mutated, in memory alone.
        folder: Where logs lie.
        db: The session; other mutants in it are left alone.
        known: What ``selection.read`` returns.
        names: The mutants.
        budget: Seconds that the tests of a mutant may take, as they were measured.
        workers: How many mutants are played at a time.
    """
    slots = [Slot(folder / f"slot-{k}") for k in range(workers)]
    for slot in slots:
        slot.folder.mkdir(parents=True, exist_ok=True)
    children.preload(repository, sorted({test.split("::")[0] for test in known["seconds"]}))
    waiting = sorted((item for item in db.work_items if item.job_id in names), key=lambda item: item.job_id)
    done, total, begun = 0, len(waiting), time.monotonic()
    while waiting or any(slot.item for slot in slots):
        for slot in slots:
            found = (
                _result(slot)
                if slot.item
                else _start(slot, waiting.pop(), repository, known, budget)
                if waiting
                else None
            )
            if found is not None:
                db.set_result(*found)
                done += 1
                print(f"{done}/{total} {time.monotonic() - begun:.0f} s {found[0]}: {found[1].output}", flush=True)
        time.sleep(0.02)


def statement_lines(source: str, position: tuple[int, int]) -> range:
    """Return the lines of the statement at a position: for one with a body its head; none outside of functions."""
    node = get_ast(source).get_leaf_for_position(position, include_prefixes=True)
    below = node
    while node.parent is not None and node.type != "simple_stmt" and node.type not in COMPOUND:
        below, node = node, node.parent
    if node.type in ("funcdef", "classdef") or parso.tree.search_ancestor(node, "funcdef") is None:
        return range(0)
    whole = node if node.type == "simple_stmt" else below
    return range(whole.start_pos[0], whole.end_pos[0] + 1)


def _start(
    slot: Slot, item: WorkItem, repository: Path, known: dict[str, Any], budget: float
) -> tuple[str, WorkResult] | None:
    """Fork a child for a mutant; return its result at once if no test reaches it."""
    spec = item.mutations[0]
    module = spec.module_path.as_posix()
    source = (repository / module).read_text(encoding="utf-8")
    mutated = mutate_code(source, operators()[spec.operator_name], spec.occurrence)
    assert mutated is not None, item.job_id
    slot.diff = _diff(source, mutated)
    tests = chosen_tests(known, module, statement_lines(source, spec.start_pos), budget)
    if not tests:
        alive = WorkResult(WorkerOutcome.NORMAL, "no test reaches it", TestOutcome.SURVIVED, slot.diff)
        return item.job_id, alive
    limit = int(2.0 * sum(known["seconds"][test] for test in tests) + SLACK_S)
    slot.killer.unlink(missing_ok=True)
    slot.item, slot.deadline = item, time.monotonic() + PATIENCE * limit
    slot.pid = os.fork()
    if slot.pid == 0:
        os.setsid()
        with slot.log.open("w") as log:
            for stream in (1, 2):
                os.dup2(log.fileno(), stream)
        children.run(repository, module, source, mutated, tests, slot.killer, limit)
    return None


def _result(slot: Slot) -> tuple[str, WorkResult] | None:
    """Return how the mutant of a slot ended, None while it runs."""
    pid, status = os.waitpid(slot.pid, os.WNOHANG)
    timed_out = not pid and time.monotonic() > slot.deadline
    if not pid and not timed_out:
        return None
    with contextlib.suppress(ProcessLookupError):
        os.killpg(slot.pid, signal.SIGKILL)
    if timed_out:
        os.waitpid(slot.pid, 0)
    assert slot.item is not None
    name, slot.item = slot.item.job_id, None
    code = -signal.SIGKILL if timed_out else os.waitstatus_to_exitcode(status)
    if code == 0:
        return name, WorkResult(WorkerOutcome.NORMAL, "survived", TestOutcome.SURVIVED, slot.diff)
    if code in (3, 5):
        raise RuntimeError(f"no test was run for {name}, see {slot.log}")
    if code < 0:
        found = f"killed: signal {-code}, it does not end" if code in (-24, -9) else f"killed: signal {-code}"
    elif slot.killer.exists():
        found = f"killed by {slot.killer.read_text(encoding='utf-8')}"
    else:
        found = f"killed: it cannot be imported, exit status {code}"
    return name, WorkResult(WorkerOutcome.NORMAL, found, TestOutcome.KILLED, slot.diff)


def _diff(source: str, mutated: str) -> str:
    """Return the lines that differ."""
    lines = difflib.unified_diff(source.splitlines(), mutated.splitlines(), n=0, lineterm="")
    return "\n".join(line for line in list(lines)[2:] if not line.startswith("@@"))
