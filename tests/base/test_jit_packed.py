"""Kernels that are called by address: their machine code is read from disk if it is theirs and whole."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from irsim_gym.base.kernels import replay

pytestmark = pytest.mark.skipif(not replay.is_possible(), reason="nothing is called by address")

KERNELS = """
from irsim_gym.base.kernels import kernel

@kernel
def add(worlds, values, flag, out):
    for i in range(worlds.shape[0]):
        out[worlds[i]] += values[worlds[i]] + flag

@kernel
def tick(worlds, out):
    for i in range(worlds.shape[0]):
        out[worlds[i]] += 1.0

@kernel
def tock(worlds, out):
    for i in range(worlds.shape[0]):
        out[worlds[i]] += 10.0

@kernel
def tell(worlds, out):
    for i in range(worlds.shape[0]):
        out[worlds[i]] = 4.0
        print(worlds[i])

@kernel
def count(worlds):
    return worlds.shape[0]
"""
USE = """
import ctypes, sys
sys.path.insert(0, FOLDER)
import numpy as np
import mine
from numba.core import event
from irsim_gym.base.kernels.replay import NotRecordableError, Packer

class Count(event.Listener):
    n = 0
    def on_start(self, event): self.n += 1
    def on_end(self, event): pass

def play(worlds, function, *arguments):
    "Call a kernel by address, as a recorded step does; returns Numba's status."
    some, given = np.zeros(1, np.int64), np.array(worlds)
    packer = Packer(some)
    entry, _ = packer.add(function, (some, *arguments))
    packed = np.array(packer.words, np.int64)
    call = ctypes.CFUNCTYPE(ctypes.c_int32, *[ctypes.c_int64] * 3)(entry)
    return call(packed.ctypes.data, given.ctypes.data, len(given))

out = np.zeros(4)
made = Count()
event.register("numba:compile", made)
"""
ADD = """
play([1, 3], mine.add, np.arange(4.0), True, out)
print(out.tolist(), made.n)
"""
SUM = "[0.0, 2.0, 0.0, 4.0]"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "mine.py").write_text(KERNELS)
    return tmp_path


def begin(folder: Path, use: str, cache: str = "cache") -> subprocess.Popen[str]:
    command = [sys.executable, "-B", "-W", "error", "-c", USE.replace("FOLDER", repr(str(folder))) + use]
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder / cache)}
    return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def run(folder: Path, use: str, cache: str = "cache") -> str:
    process = begin(folder, use, cache)
    answer, complaints = process.communicate(timeout=120)
    assert (process.returncode, complaints) == (0, ""), complaints
    return answer.strip()


def files(folder: Path, name: str) -> list[Path]:
    return list((folder / "cache").rglob(f"mine.{name}-*"))


def test_machine_code_is_kept(folder: Path) -> None:
    assert run(folder, ADD) == f"{SUM} 1"
    assert run(folder, ADD) == f"{SUM} 0"
    assert len(files(folder, "add")) == 1


def test_a_folder_may_be_moved(folder: Path) -> None:
    run(folder, ADD)
    (folder / "cache").rename(folder / "elsewhere")
    assert run(folder, ADD, "elsewhere") == f"{SUM} 0"


def test_kernels_of_the_same_types_have_files_of_their_own(folder: Path) -> None:
    both = """
for which in (mine.tick, mine.tock):
    play([1, 3], which, out)
print(out.tolist(), made.n)
"""
    assert [run(folder, both) for _ in range(2)] == [f"[0.0, 11.0, 0.0, 11.0] {n}" for n in (2, 0)]


@pytest.mark.parametrize("kept", [-1, *(pytest.param(n, marks=pytest.mark.slow) for n in (0, 10, 500))])
def test_a_damaged_file_is_made_anew(kept: int, folder: Path) -> None:
    """Its last bit is another one, or only some bytes at its beginning are left."""
    run(folder, ADD)
    (file,) = files(folder, "add")
    content = file.read_bytes()
    file.write_bytes(content[:kept] + (bytes([content[-1] ^ 1]) if kept < 0 else b""))
    assert run(folder, ADD) == f"{SUM} 1"
    assert len(file.read_bytes()) == len(content)
    assert run(folder, ADD) == f"{SUM} 0"


def test_processes_that_begin_together_make_one_file(folder: Path) -> None:
    processes = [begin(folder, ADD) for _ in range(2)]
    answers = [process.communicate(timeout=120) for process in processes]
    assert [answer.split("]")[0] for answer, _ in answers] == [SUM[:-1]] * 2, answers
    assert len(files(folder, "add")) == 1
    assert run(folder, ADD) == f"{SUM} 0"


def test_a_change_of_the_source_is_seen(folder: Path) -> None:
    run(folder, ADD)
    (folder / "mine.py").write_text(KERNELS.replace("] + flag", "] - flag"))
    assert run(folder, ADD) == "[0.0, 0.0, 0.0, 2.0] 1"


def test_without_a_writable_folder_nothing_is_kept(folder: Path) -> None:
    nowhere = (
        "from irsim_gym.base.compiled import folder\nfolder._cache_roots = lambda: [folder.Path('/proc/irsim_gym')]\n"
    )
    assert [run(folder, nowhere + ADD) for _ in range(2)] == [f"{SUM} 1"] * 2
    assert not (folder / "cache").exists()


def test_a_kernel_that_prints_is_compiled_each_time(folder: Path) -> None:
    """It needs Python objects, which are not on the disk."""
    use = "play([2], mine.tell, out)\nprint(out.tolist(), made.n)"
    for _ in range(2):
        assert run(folder, use).split("\n") == ["2", "[0.0, 0.0, 4.0, 0.0] 1"]
    assert files(folder, "tell") == []


def test_a_kernel_that_returns_a_value_is_refused_each_time(folder: Path) -> None:
    use = """
try:
    play([2], mine.count)
except NotRecordableError as error:
    print(error, made.n)
"""
    assert [run(folder, use) for _ in range(2)] == [f"count returns a value {n}" for n in (1, 0)]
