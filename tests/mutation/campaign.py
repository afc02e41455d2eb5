"""Mutants are played, some at a time, each by the tests that reach it, and their results are kept in the session."""

from __future__ import annotations

import contextlib
import difflib
import os
import shutil
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
from selection import COMPILED, chosen_tests

SLACK_S = 20.0
"""A mutant that needs this much more than twice the time of its tests [s of the processor] runs in circles."""

PATIENCE = 15.0
"""A mutant that has not ended after so many times its processor time waits for something that never comes."""

COMPILED_S = 120
"""Time of the processor for each file of tests of a mutant that is played compiled [s]."""

BY = "killed by "
COMPOUND = ("if_stmt", "for_stmt", "while_stmt", "try_stmt", "with_stmt", "funcdef", "classdef")


@dataclass(frozen=True)
class Rules:
    """How mutants are played.

    Attributes:
        repository: What is mutated, in memory alone.
        folder: Where logs lie.
        known: What ``selection.read`` returns.
        budget: Seconds that the tests of a mutant may take, as they were measured.
        workers: How many mutants are played at a time.
        is_compiled: Play those of ``selection.COMPILED``, which are passed over else.
    """

    repository: Path
    folder: Path
    known: dict[str, Any]
    budget: float = 15.0
    workers: int = 2
    is_compiled: bool = False


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
    def failures(self) -> Path:
        """Where the tests that failed are written."""
        return self.folder / "failures"

    @property
    def cache(self) -> Path:
        """What is compiled: of each mutant by itself."""
        return self.folder / "cache"


def play(db: WorkDB, names: set[str], rules: Rules) -> None:
    """Play the named mutants, and write each result into the database; then see whether their killers can be believed.

    Args:
        db: The session; other mutants in it are left alone.
        names: The mutants.
        rules: How.
    """
    mine = (item for item in db.work_items if item.job_id in names and is_compiled(item) == rules.is_compiled)
    waiting = sorted(mine, key=lambda item: item.job_id)
    if not waiting:
        return
    kind = "compiled" if rules.is_compiled else "plain"
    slots = [Slot(rules.folder / f"{kind}-{k}") for k in range(rules.workers)]
    for slot in slots:
        slot.folder.mkdir(parents=True, exist_ok=True)
    tests = (test for some in COMPILED.values() for test in some) if rules.is_compiled else rules.known["seconds"]
    children.preload(rules.repository, sorted({test.split("::")[0] for test in tests}), rules.is_compiled)
    done, total, begun = 0, len(waiting), time.monotonic()
    while waiting or any(slot.item for slot in slots):
        for slot in slots:
            found = None
            if slot.item:
                found = _result(slot)
            elif waiting:
                found = _start(slot, waiting.pop(), rules)
            if found is not None:
                db.set_result(*found)
                done += 1
                print(f"{done}/{total} {time.monotonic() - begun:.0f} s {found[0]}: {found[1].output}", flush=True)
        time.sleep(0.02)
    _doubt(db, slots[0], rules)


def is_compiled(item: WorkItem) -> bool:
    """Return whether a mutant has to be played compiled."""
    return item.mutations[0].module_path.as_posix() in COMPILED


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


def _start(slot: Slot, item: WorkItem, rules: Rules) -> tuple[str, WorkResult] | None:
    """Fork a child for a mutant; return its result at once if no test reaches it."""
    spec, known = item.mutations[0], rules.known
    module = spec.module_path.as_posix()
    source = (rules.repository / module).read_text(encoding="utf-8")
    mutated = mutate_code(source, operators()[spec.operator_name], spec.occurrence)
    assert mutated is not None, item.job_id
    slot.diff = _diff(source, mutated)
    if rules.is_compiled:
        tests = list(COMPILED[module])
        limit = COMPILED_S * len(tests)
    else:
        tests = chosen_tests(known, module, statement_lines(source, spec.start_pos), rules.budget)
        limit = int(2.0 * sum(known["seconds"][test] for test in tests) + SLACK_S)
    if not tests:
        alive = WorkResult(WorkerOutcome.NORMAL, "no test reaches it", TestOutcome.SURVIVED, slot.diff)
        return item.job_id, alive
    slot.item = item
    _fork(slot, rules.repository, module, source, mutated, tests, limit)
    return None


def _fork(slot: Slot, repository: Path, module: str, source: str, mutated: str, tests: list[str], limit: int) -> None:
    """Let a child of this process run tests, see ``children.run``."""
    slot.failures.unlink(missing_ok=True)
    shutil.rmtree(slot.cache, ignore_errors=True)
    slot.deadline = time.monotonic() + PATIENCE * limit
    slot.pid = os.fork()
    if slot.pid == 0:
        os.setsid()
        os.environ["NUMBA_CACHE_DIR"] = str(slot.cache)
        with slot.log.open("w") as log:
            for stream in (1, 2):
                os.dup2(log.fileno(), stream)
        children.run(repository, module, source, mutated, tests, slot.failures, limit)


def _doubt(db: WorkDB, slot: Slot, rules: Rules) -> None:
    """Run the tests that killed something without any mutant; what one killed that fails then has survived."""
    killers: dict[str, list[str]] = {}
    items = {item.job_id: item for item in db.work_items}
    for name, result in db.results:
        if is_compiled(items[name]) == rules.is_compiled and result.output.startswith(BY):
            killers.setdefault(result.output.removeprefix(BY), []).append(name)
    if not killers:
        return
    _fork(slot, rules.repository, next(iter(COMPILED)), "", "", sorted(killers), COMPILED_S * 10)
    _, status = os.waitpid(slot.pid, 0)
    if os.waitstatus_to_exitcode(status) not in (0, 1):
        raise RuntimeError(f"the tests could not be run without a mutant, see {slot.log}")
    failed = slot.failures.read_text(encoding="utf-8").split("\n") if slot.failures.exists() else []
    results = dict(db.results)
    for test in filter(None, failed):
        for name in killers.get(test, ()):
            why = f"survived: {test} fails without it too"
            print(f"{name}: {why}", flush=True)
            db.set_result(name, WorkResult(WorkerOutcome.NORMAL, why, TestOutcome.SURVIVED, results[name].diff))


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
    elif slot.failures.exists():
        found = BY + slot.failures.read_text(encoding="utf-8").split("\n")[0]
    else:
        found = f"killed: it cannot be imported, exit status {code}"
    return name, WorkResult(WorkerOutcome.NORMAL, found, TestOutcome.KILLED, slot.diff)


def _diff(source: str, mutated: str) -> str:
    """Return the lines that differ."""
    lines = difflib.unified_diff(source.splitlines(), mutated.splitlines(), n=0, lineterm="")
    return "\n".join(line for line in list(lines)[2:] if not line.startswith("@@"))
