"""Processes that compile together: one list of kernels, and nothing that stays behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from irsim_gym.base import kernels as jit
from irsim_gym.base.compiled.watch import Watch
from irsim_gym.base.kernels import hooks, workers
from irsim_gym.base.kernels.replay import Packer, is_possible
from irsim_gym.scenario import load_scenario
from irsim_gym.simulator.engine import compile
from irsim_gym.tasks import Episodes, load_task

pytestmark = pytest.mark.skipif(jit.config.DISABLE_JIT or hooks.is_plain(), reason="there is nothing to share")

# Four kernels of a few lines each. The script has no main guard.
JOBS = """
import os, sys, time
import numpy as np
from irsim_gym.simulator.contact.contact import fill
from irsim_gym.base.kernels import workers
from irsim_gym.base.compiled.watch import compilation
from irsim_gym.base.kernels.replay import Packer
from irsim_gym.tasks.terms.term import overwrite
worlds = np.zeros(1, np.int64)
jobs = [Packer(worlds).job(fill, (worlds, 1.0, np.zeros((2, 2))))]
for kind in (np.float64, np.int64, np.bool_):
    arguments = worlds, np.zeros((2, 2), np.bool_), kind(0).item(), np.zeros((2, 2, 2), kind)
    jobs.append(Packer(worlds).job(overwrite, arguments))
"""
WORKERS_ALONE = """
assert all(job.is_missing() for job in jobs)
with workers._working(jobs):
    end = time.monotonic() + 120
    while any(job.is_missing() for job in jobs) and time.monotonic() < end:
        time.sleep(0.01)
try:
    os.waitpid(-1, os.WNOHANG)
except ChildProcessError:
    print("no child is left")
workers.compile_together(jobs)
print(compilation().compiled, "compiled here,", sum(job.is_missing() for job in jobs), "missing")
"""
# A letter of a layout only distinguishes files here: these take a worker a minute and more.
MANY = """
jobs = [jobs[0]._replace(layout=f"{jobs[0].layout[:-11]}{k:011b}") for k in range(2048)]
"""
HELD = """
with workers._working(jobs):
    print("begun", flush=True)
    time.sleep(600)
"""


def environment(folder: Path) -> dict[str, str]:
    return {**os.environ, "NUMBA_CACHE_DIR": str(folder), workers.SWITCH: "2"}


@pytest.fixture
def script(tmp_path: Path) -> Path:
    return tmp_path / "script.py"


def test_workers_compile_what_a_script_without_a_guard_lists(script: Path, tmp_path: Path) -> None:
    script.write_text(JOBS + WORKERS_ALONE)
    command = [sys.executable, "-W", "error", str(script)]
    done = subprocess.run(command, env=environment(tmp_path / "kept"), capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.stdout.splitlines() == ["no child is left", "0 compiled here, 0 missing"]


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="processes are looked up in /proc")
def test_a_worker_ends_with_the_process_that_needs_it(script: Path, tmp_path: Path) -> None:
    script.write_text(JOBS + MANY + HELD)
    with subprocess.Popen([sys.executable, str(script)], env=environment(tmp_path / "kept"), stdout=-1) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"begun\n"
        worker = int(Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text())
        process.send_signal(signal.SIGKILL)
    end = time.monotonic() + 30
    while Path(f"/proc/{worker}/cmdline").exists() and b"workers" in Path(f"/proc/{worker}/cmdline").read_bytes():
        assert time.monotonic() < end
        time.sleep(0.05)


def test_without_workers_the_body_runs_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*arguments: object, **options: object) -> None:
        raise OSError("no more processes")

    monkeypatch.setattr(subprocess, "Popen", refuse)
    ran = []
    with workers._worker(b"", tmp_path):
        ran.append(True)
    assert ran


def test_the_number_of_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: range(64), raising=False)
    monkeypatch.delenv(workers.SWITCH, raising=False)
    assert workers.n_processes() == workers.MOST
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {3}, raising=False)
    assert workers.n_processes() == 1
    monkeypatch.setenv(workers.SWITCH, "3")
    assert workers.n_processes() == 3
    monkeypatch.setenv(workers.SWITCH, "0")
    assert workers.n_processes() == 1


@pytest.mark.skipif(not is_possible(), reason="steps are not recorded")
def test_what_is_listed_beforehand_is_what_is_recorded() -> None:
    scenario = load_scenario("cluttered_room")
    episodes = Episodes(compile(scenario, 2, agents=load_task(scenario).agents), load_task(scenario))
    functions = episodes.simulation._recordings.all
    listed = {job for function in functions for job in function.jobs()}
    worlds = np.arange(2)
    episodes.begin(worlds, worlds)
    episodes.step(np.zeros(episodes.state.given.shape))
    assert any(program for function in functions for program in function.programs.values())
    for program in (program for function in functions for program in function.programs.values() if program):
        for called, arguments in program.calls:
            # The list of worlds is the only argument of one axis and whole numbers that all calls share.
            assert Packer(program.calls[0][1][0]).job(called, arguments) in listed


@dataclass(frozen=True)
class Task:
    """A job that this process compiles if it is its own; another process holds those of others until it has to wait."""

    size: int
    is_own: bool

    def is_missing(self) -> bool:
        return True

    def compile(self, *, waits: bool) -> None:
        workers.compilation().compiled += self.is_own and not waits


def test_what_others_have_compiled_is_counted_and_nothing_else(monkeypatch: pytest.MonkeyPatch) -> None:
    watch = Watch()
    monkeypatch.setattr(workers, "compilation", lambda: watch)
    monkeypatch.setattr(workers, "_n_kernels", len)
    monkeypatch.setattr(workers, "_working", nullcontext)
    jobs: list[Any] = [
        Task(size, is_own) for size, is_own in ((3, True), (5, False), (1, True), (4, False), (2, False))
    ]
    workers.compile_together(jobs)
    assert (watch.compiled, watch.received) == (2, 3)
    workers.compile_together(jobs[:3])  # too few to be shared
    assert (watch.compiled, watch.received) == (2, 3)


def test_progress_is_a_share_of_all_kernels() -> None:
    watch, kept = Watch(), [7]
    assert watch._progress() == ""
    with watch.expecting(200, lambda: kept[0]):
        kept[0] += 56
        assert watch._progress() == "kernel 57 of about 200"
    assert watch._progress() == ""
