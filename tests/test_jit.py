"""The compiler's cache is never stale, and kernels run without a compiler."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numba.core.errors import NumbaError

import irsim_gym
from irsim_gym import jit
from irsim_gym.arraytypes import Floats

PACKAGE = Path(irsim_gym.__file__).parent
SCRIPT = """
import sys, numpy as np
import irsim_gym as ig
sim = ig.compile(ig.load_scenario("cluttered_room"), 2, agents=(0,))
sim.reset(seed=4)
for _ in range(6):
    sim.step([0.8, 0.3])
group, member = sim.scan(0)
distance = np.zeros((2, 1))
sim.clearance(sim.shards.all[0], sim.agents, distance)
np.savez(sys.argv[1], pose=sim.state.pose, ranges=group.arrays["ranges"], goal=sim.state.goal, distance=distance)
"""


def run(arguments: list[str], **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *arguments], env={**os.environ, **environment}, capture_output=True, text=True, check=False
    )


def test_kernels_run_as_plain_python_with_the_same_results(tmp_path: Path) -> None:
    files = {flag: tmp_path / f"{flag}.npz" for flag in ("0", "1")}
    for flag, file in files.items():
        done = run(["-W", "error", "-c", SCRIPT, str(file)], NUMBA_DISABLE_JIT=flag)
        assert done.returncode == 0, done.stderr
    compiled, plain = (np.load(file) for file in files.values())
    for name, tolerance in (("pose", 1e-12), ("goal", 1e-12), ("distance", 1e-12), ("ranges", 1e-5)):
        np.testing.assert_allclose(compiled[name], plain[name], rtol=0, atol=tolerance, err_msg=name)


def test_the_cache_folder_follows_the_sources(tmp_path: Path) -> None:
    copy = tmp_path / "irsim_gym"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    ask = [
        "-c",
        f"import sys; sys.path.insert(0, {str(tmp_path)!r}); from irsim_gym import jit; print(jit.cache_folder())",
    ]
    before = run(ask).stdout
    assert str(tmp_path) in before
    assert run(ask).stdout == before
    angles = copy / "geometry" / "angles.py"
    angles.write_text(angles.read_text() + "\n")
    assert run(ask).stdout != before


def test_without_a_writable_folder_nothing_is_cached(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jit, "_cache_roots", lambda: [Path("/proc/irsim_gym")])
    jit.cache_folder.cache_clear()
    try:
        assert jit.cache_folder() is None
        assert jit.kernel(lambda x: x + 1)(1) == 2
    finally:
        monkeypatch.undo()
        jit.cache_folder.cache_clear()


def test_old_cache_folders_are_pruned(tmp_path: Path) -> None:
    for age in range(8):
        folder = tmp_path / f"irsim_gym-{age}"
        folder.mkdir()
        os.utime(folder, (1000 - age, 1000 - age))
    jit._prune(tmp_path)
    assert sorted(folder.name for folder in tmp_path.iterdir()) == [f"irsim_gym-{age}" for age in range(4)]


def test_the_first_compilation_is_announced_once(tmp_path: Path) -> None:
    script = "from irsim_gym import rng; import numpy as np; rng.mix(np.uint64(1)); rng.later_level(1, 2)"
    done = run(["-c", script], NUMBA_CACHE_DIR=str(tmp_path))
    assert done.stderr.count("compiling kernels") == 1
    assert "(half a minute or so, first use only)" in done.stderr
    assert "compiling" not in run(["-c", script], NUMBA_CACHE_DIR=str(tmp_path)).stderr


@jit.kernel
def sum_of_a_copy(values: Floats) -> float:
    return float(values.copy().sum())


@pytest.mark.skipif(jit.config.DISABLE_JIT, reason="nothing is compiled")
def test_a_kernel_that_allocates_does_not_compile() -> None:
    with pytest.raises(NumbaError, match="NRT required"):
        sum_of_a_copy(np.ones(3))
