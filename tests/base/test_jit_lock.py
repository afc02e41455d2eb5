"""Processes that need the same kernel at once: one compiles it, and no lock is ever a reason to fail."""

from __future__ import annotations

import errno
import os
import pty
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numba.core.errors import NumbaError

from irsim_gym.base import kernels as jit
from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.compiled import lock as locks
from irsim_gym.base.compiled.folder import cache_folder
from irsim_gym.base.compiled.lock import lock
from irsim_gym.base.kernels import hooks
from irsim_gym.errors import UntrustedCodeWarning

NOTHING = jit.config.DISABLE_JIT or hooks.is_plain() or sys.platform == "win32"
pytestmark = pytest.mark.skipif(NOTHING, reason="nothing to lock")

TOGETHER = """
import os, sys, time
import numpy as np
from numba.core import event
class Count(event.Listener):
    n = 0
    def on_start(self, event): self.n += 1
    def on_end(self, event): pass
made = Count()
event.register("numba:compile", made)
from irsim_gym.base import rng
from irsim_gym.base.kernels.replay import Packer
sys.path.insert(0, FOLDER)
print("ready", flush=True)
sys.stdin.readline()
"""
# What is compiled, by all processes together: kernels of the package, as Python calls them (one of them as a part of
# the other too); one from elsewhere, by address; one that is never kept, because it prints.
USES = {
    "rng.mix(np.uint64(1)); rng.later_level(1, 2)": 3,
    "import mine; Packer(np.zeros(1, np.int64)).add(mine.fill, (np.ones(3),))": 1,
    "import mine; Packer(np.zeros(1, np.int64)).add(mine.tell, (3.0,))": 3,
}
MINE = """
from irsim_gym.base.kernels import kernel
@kernel
def fill(out):
    for k in range(len(out)):
        out[k] = k
@kernel
def tell(value):
    print(value)
"""
HOLD = """
import sys, time
from pathlib import Path
from irsim_gym.base.compiled.lock import lock
with lock(Path(sys.argv[1]), is_ordered=False):
    print("held", flush=True)
    time.sleep(600)
"""


@pytest.mark.parametrize("use", USES)
def test_processes_that_begin_together_compile_once(use: str, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(MINE)
    code = f"{TOGETHER.replace('FOLDER', repr(str(tmp_path)))}\n{use}\nprint('compiled', made.n)"
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    several = [
        subprocess.Popen(
            [sys.executable, "-B", "-W", "error", "-c", code],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        for _ in range(3)
    ]
    assert [one.stdout.readline() for one in several if one.stdout] == ["ready\n"] * 3
    for one in several:
        assert one.stdin is not None
        one.stdin.write("go\n")
        one.stdin.flush()
    answers = [one.communicate(timeout=300)[0] for one in several]
    assert sum(int(answer.split()[-1]) for answer in answers) == USES[use]
    assert list((tmp_path / "cache").rglob("*.lock")) == []


@pytest.fixture
def owner(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """A process that holds the lock of one file."""
    command = [sys.executable, "-c", HOLD, str(tmp_path / "one.nbc")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


def is_held(file: Path) -> bool:
    """Whether this process holds the lock of a file."""
    return file.with_suffix(".lock") in locks._held.get()


def test_a_killed_owner_leaves_the_lock_to_others(
    owner: subprocess.Popen[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "one.nbc"
    monkeypatch.setattr(locks, "PATIENCE_S", 0.05)
    with lock(file, is_ordered=True):
        assert not is_held(file)  # it went on without
    owner.kill()
    owner.wait()
    assert file.with_suffix(".lock").exists()
    with lock(file, is_ordered=True):
        assert is_held(file)
        with lock(file, is_ordered=True):  # by itself nobody waits for himself
            assert is_held(file)
        assert is_held(file)
    assert not is_held(file)
    assert list(tmp_path.iterdir()) == []


def test_who_holds_a_lock_waits_only_in_order(
    owner: subprocess.Popen[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two processes whose kernels call each other would wait for each other."""
    looks: list[float] = []
    monkeypatch.setattr(time, "sleep", looks.append)
    monkeypatch.setattr(locks, "PATIENCE_S", 0.01)
    with lock(tmp_path / "other.nbc", is_ordered=False):
        with lock(tmp_path / "one.nbc", is_ordered=False):
            assert not is_held(tmp_path / "one.nbc")
        assert looks == []
        with lock(tmp_path / "one.nbc", is_ordered=True):
            assert not is_held(tmp_path / "one.nbc")
        assert looks


def test_where_there_are_no_locks_it_goes_on_without(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOLCK, "no locks available")

    (tmp_path / "linked.lock").symlink_to(tmp_path / "elsewhere")
    (tmp_path / "open.lock").touch()
    (tmp_path / "open.lock").chmod(0o666)
    for file in (Path("/proc/irsim_gym/some.nbc"), tmp_path / "linked.nbc"):
        with lock(file, is_ordered=True):
            assert not is_held(file)
    assert not (tmp_path / "elsewhere").exists()
    with pytest.warns(UntrustedCodeWarning, match=r"open.lock may be written by others"):  # noqa: SIM117
        with lock(tmp_path / "open.nbc", is_ordered=True):
            assert not is_held(tmp_path / "open.nbc")
    monkeypatch.setattr("fcntl.flock", refuse)
    with lock(tmp_path / "some.nbc", is_ordered=True):
        assert not is_held(tmp_path / "some.nbc")


@jit.kernel
def sum_of_a_copy(values: Floats) -> float:
    return float(values.copy().sum())


def test_a_kernel_that_does_not_compile_keeps_no_lock() -> None:
    with pytest.raises(NumbaError, match="NRT required"):
        sum_of_a_copy(np.ones(3))
    assert locks._held.get() == ()
    folder = cache_folder()
    assert folder is not None
    assert list(folder.glob("*sum_of_a_copy*.lock")) == []


def test_a_terminal_shows_what_is_compiled_in_one_line_that_goes(tmp_path: Path) -> None:
    use = (
        "from irsim_gym.base import rng; "
        "from irsim_gym.base.compiled import watch; watch.PATIENCE_S = 0.0; rng.later_level(1, 2)"
    )
    here, there = pty.openpty()
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "TERM": "xterm", "COLUMNS": "200"}
    with subprocess.Popen([sys.executable, "-c", use], env=environment, stderr=there) as process:
        os.close(there)
        shown = b""
        while True:
            try:
                part = os.read(here, 4096)
            except OSError:  # the other end is closed
                break
            shown += part
            if not part:
                break
    os.close(here)
    assert process.returncode == 0
    text = shown.decode()
    assert "compiling kernels for this machine, once: 0 done in 0 s, now later_level" in text
    assert "\n" not in text
    assert text.endswith("\r\x1b[2K")
