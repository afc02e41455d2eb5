"""Which test reaches which line in plain Python, and how long it takes."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Generator, Sequence
from pathlib import Path
from typing import Any

import pytest
from coverage import CoverageData

CORE = (
    "tests/bodies/drives",
    "tests/bodies/sensors",
    "tests/bodies/behaviors",
    "tests/tasks",
    "tests/bodies/placements",
    "tests/bodies/maps",
    "tests/live",
    "tests/simulator/engine",
    "tests/envs",
    "tests/envs/contracts",
    "tests/evaluation",
    "tests/scenario/test_reference_page.py",
)
TESTS = {
    "core": CORE,
    "recent": (
        *(
            f"tests/bodies/behaviors/test_{name}.py"
            for name in ("dwa", "local_ways", "hybrid_astar", "pursuit", "pursuit_parts", "own_scan", "map_discs")
        ),
        *(
            "tests/bodies/maps",
            "tests/simulator/paths",
            "tests/bodies/placements",
            "tests/evaluation/levels/test_certificates.py",
            "tests/evaluation/suite",
        ),
        *(
            f"tests/simulator/engine/test_{name}.py"
            for name in ("respawn", "solvable", "level_files", "level_history", "traits", "turns")
        ),
        *(f"tests/tasks/test_{name}.py" for name in ("observations", "clear_ways", "seen_map", "seen_ways")),
        *(f"tests/tasks/test_{name}.py" for name in ("ways_and_memory", "yielding_way", "team_navigation")),
        *(f"tests/tasks/test_{name}.py" for name in ("sight", "obstruction")),
        *("tests/evaluation/test_certificate_measures.py", "tests/envs/test_mirror.py", "tests/training/test_gru.py"),
        "tests/envs/contracts/test_levels_from_files.py",
        *("tests/envs/contracts/test_mirror_callback.py", "tests/scenario/test_option_limits.py"),
        "tests/robot/test_twins.py",
    ),
}
"""Files and folders of tests that are tried, by the part that is mutated."""

DECLARED = (
    "tests/scenario/test_reference_page.py::test_the_page_is_up_to_date",
    "tests/envs/contracts/test_kinds.py::test_every_shipped_kind",
)
"""Tests of what kinds declare, which their modules say when they are imported."""

COMPILED = {
    "irsim_gym/simulator/running/direct.py": ("tests/envs/test_alone.py",),
    "irsim_gym/simulator/running/fused.py": (
        "tests/simulator/engine/test_shared_programs.py",
        "tests/simulator/engine/test_fused.py",
    ),
}
"""What nobody reaches in plain Python, where nothing is recorded: files, and the tests that reach them compiled."""

SLOWEST = 6.0
"""A test that takes longer in plain Python [s] is left out, unless asked for."""

PLAIN = {"NUMBA_DISABLE_JIT": "1", "MPLBACKEND": "Agg", "OMP_NUM_THREADS": "1"}
MARKS = ("-m", "not slow and not gui and not libraries and not ros")
HERE = Path(__file__).parent


class Timing:
    """Notes how tests went, and ends those that take too long, as a plugin of pytest.

    Args:
        slowest: Processor time after which a test fails [s]; 0 for no limit.
    """

    def __init__(self, slowest: float = 0.0) -> None:
        self.slowest = slowest
        self.seconds: dict[str, float] = {}
        self.failed: set[str] = set()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: Any) -> Generator[None, object, object]:
        """Note the processor time of set-up, call and tear-down: other programs do not change it."""
        begin = time.process_time()
        signal.signal(signal.SIGVTALRM, _give_up)
        signal.setitimer(signal.ITIMER_VIRTUAL, self.slowest)
        answer = yield
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        self.seconds[item.nodeid] = time.process_time() - begin
        return answer

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Note a failure."""
        if report.outcome != "passed":
            self.failed.add(report.nodeid)


def _give_up(*_: object) -> None:
    raise TimeoutError("the test takes too long in plain Python")


def _run(root: Path, folder: Path, *arguments: str, slowest: float = 0.0) -> dict[str, float]:
    """Run pytest in a process of its own; return the seconds of each test that passed."""
    listed = folder / "timing.json"
    listed.unlink(missing_ok=True)
    code = (
        "import json, sys, pytest; from selection import Timing; timing = Timing(float(sys.argv[2]));"
        "pytest.main(sys.argv[3:], plugins=[timing]);"
        "passed = {k: v for k, v in timing.seconds.items() if k not in timing.failed};"
        "file = open(sys.argv[1], 'w'); json.dump(passed, file); file.close()"
    )
    paths = os.pathsep.join([str(root), str(HERE)])
    command = [
        sys.executable,
        "-c",
        code,
        str(listed),
        str(slowest),
        "-q",
        "--tb=no",
        "-p",
        "no:cacheprovider",
        *MARKS,
        *arguments,
    ]
    subprocess.run(command, cwd=root, env={**os.environ, **PLAIN, "PYTHONPATH": paths}, check=True)
    found: dict[str, float] = json.loads(listed.read_text(encoding="utf-8"))
    return found


def measure(root: Path, folder: Path, tests: Sequence[str] = TESTS, slowest: float = SLOWEST) -> None:
    """Time tests, then run those under coverage that take at most ``slowest`` [s]; what is known of others stays.

    Two runs, because a test cannot be interrupted safely while coverage is looking.
    """
    folder.mkdir(parents=True, exist_ok=True)
    seconds = _run(root, folder, *tests, slowest=slowest)
    chosen, data = folder / "chosen", folder / "coverage"
    chosen.write_text("\n".join(seconds), encoding="utf-8")
    settings = folder / "coveragerc"
    settings.write_text(f"[run]\nsource = irsim_gym\ndata_file = {data}\n", encoding="utf-8")
    covered = _run(
        root, folder, f"--cov-config={settings}", "--cov=irsim_gym", "--cov-context=test", "--cov-report=", f"@{chosen}"
    )
    merge(root, folder, data, {test: seconds[test] for test in covered if test in seconds})


def merge(root: Path, folder: Path, data: Path, seconds: dict[str, float]) -> None:
    """Add what coverage has seen to ``tests.json``: ``seconds`` of tests and the ``lines`` that each reaches."""
    file = folder / "tests.json"
    known = read(folder) if file.exists() else {"seconds": {}, "lines": {}}
    known["seconds"].update(seconds)
    lines: dict[str, dict[str, list[str]]] = known["lines"]
    seen = CoverageData(str(data))
    seen.read()
    for path in seen.measured_files():
        module = "irsim_gym/" + Path(path).as_posix().rpartition("/irsim_gym/")[2]
        rows = lines.setdefault(module, {})
        for line, contexts in seen.contexts_by_lineno(path).items():
            tests = {context.rpartition("|")[0] for context in contexts} & seconds.keys()
            if tests:
                rows[str(line)] = sorted(tests.union(rows.get(str(line), ())))
    file.write_text(json.dumps(known), encoding="utf-8")


def read(folder: Path) -> dict[str, Any]:
    """Return what ``measure`` has found."""
    found: dict[str, Any] = json.loads((folder / "tests.json").read_text(encoding="utf-8"))
    return found


def chosen_tests(known: dict[str, Any], module: str, lines: range, budget: float) -> list[str]:
    """Return the tests to run for a mutant: those that reach its statement, near and fast ones first.

    Args:
        known: What ``read`` returns.
        module: The mutated file.
        lines: Lines of the statement; empty for one that runs when the module is imported, which all tests of the
            module and of its folder may notice.
        budget: Seconds that all tests together may take.
    """
    rows, folder = known["lines"].get(module, {}), f"tests/{module.split('/')[1]}/"
    reached = [rows.get(str(line), ()) for line in lines] if lines else rows.values()
    tests = {test for row in reached for test in row}
    near: tuple[str, ...] = (folder,)
    if not lines:
        near = (*tests, *DECLARED)
        tests |= {test for test in known["seconds"] if test.startswith((*DECLARED, folder))}
    ordered = sorted((known["seconds"][test] * (1 if test.startswith(near) else 3), test) for test in tests)
    chosen, total = [], 0.0
    for _, test in ordered:
        total += known["seconds"][test]
        if chosen and total > budget:
            break
        chosen.append(test)
    return chosen
