"""The compiler's cache is never stale, and kernels run without a compiler."""

from __future__ import annotations

import os
import shutil
import stat
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pytest
from numba.core.errors import NumbaError

import irsim_gym
from irsim_gym.base import kernels as jit
from irsim_gym.base import rng
from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.compiled import folder as folders
from irsim_gym.base.compiled.cache import Files
from irsim_gym.base.compiled.key import type_key
from irsim_gym.errors import UntrustedCodeWarning

PACKAGE = Path(irsim_gym.__file__).parent


def driven() -> dict[str, Floats]:
    """Return what a robot sees and does in six steps."""
    sim = irsim_gym.compile(irsim_gym.load_scenario("cluttered_room"), 2, agents=(0,))
    sim.reset(seed=4)
    for _ in range(6):
        sim.step([0.8, 0.3])
    group, _ = sim.scan(0)
    distance = np.zeros((2, 1))
    sim.clearance(sim.shards.all[0], sim.agents, distance)
    return {"pose": sim.state.pose, "ranges": group.arrays["ranges"], "goal": sim.state.goal, "distance": distance}


def run(arguments: list[str], **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *arguments], env={**os.environ, **environment}, capture_output=True, text=True, check=False
    )


def test_kernels_run_as_plain_python_with_the_same_results(tmp_path: Path) -> None:
    file = tmp_path / "plain.npz"
    use = "import sys, numpy; from tests.base import test_jit; numpy.savez(sys.argv[1], **test_jit.driven())"
    done = run(["-W", "error", "-c", use, str(file)], NUMBA_DISABLE_JIT="1", PYTHONPATH=str(PACKAGE.parent))
    assert done.returncode == 0, done.stderr
    compiled, plain = driven(), np.load(file)
    for name, tolerance in (("pose", 1e-12), ("goal", 1e-12), ("distance", 1e-12), ("ranges", 1e-5)):
        np.testing.assert_allclose(compiled[name], plain[name], rtol=0, atol=tolerance, err_msg=name)


def test_a_kernel_of_the_package_is_compiled_when_its_code_changes(tmp_path: Path) -> None:
    """Not when a comment, a docstring, an annotation or a line number does, nor for changes elsewhere in the file."""
    shutil.copytree(PACKAGE, tmp_path / "irsim_gym", ignore=shutil.ignore_patterns("__pycache__"))
    source = tmp_path / "irsim_gym" / "base/rng.py"
    use = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); from irsim_gym.base import rng; import numpy as np;"
    found = [compilations(tmp_path / "cache", f"{use} rng.level_stream(np.uint64(7), 3)")]
    for changes in (
        {
            '"""Scramble 64 bits': '"""Mix\n\n    64 bits',
            "def mix(x: np.uint64)": "# Here.\n\n\ndef unused() -> None:\n    pass\n\n\n@kernel\ndef mix(x: object)",
        },
        {"MIX_1 = np.uint64(0xB": "MIX_1 = np.uint64(0xC"},
    ):
        text = source.read_text()
        for old, new in changes.items():
            assert text.count(old) == 1
            text = text.replace(old, new)
        source.write_text(text)
        found.append(compilations(tmp_path / "cache", f"{use} rng.level_stream(np.uint64(7), 3)"))
    assert found == [2, 0, 2]


class Point(NamedTuple):
    x: float
    y: float


class Turned(NamedTuple):
    y: float
    x: float


def test_the_names_of_fields_belong_to_a_type() -> None:
    """Numba's name of the type leaves them out, and where they lie follows from them."""
    Turned.__name__ = "Point"
    for values in ([Point(1.0, 2.0), Turned(1.0, 2.0)], [(0, Point(1.0, 2.0)), (0, Turned(1.0, 2.0))]):
        kinds = [numba.typeof(value) for value in values]
        assert str(kinds[0]) == str(kinds[1])
        assert type_key(kinds[0]) != type_key(kinds[1])


def test_files_that_nobody_has_read_for_long_are_removed(tmp_path: Path) -> None:
    for name, age in (("old", folders.UNUSED_S + 60.0), ("new", 0.0)):
        (tmp_path / f"{name}.nbc").touch()
        os.utime(tmp_path / f"{name}.nbc", (time.time() - age,) * 2)
    Files.write(tmp_path / "written.nbc", b"code")
    assert {file.stem for file in tmp_path.iterdir()} == {"new", "written"}


def test_without_a_writable_folder_nothing_is_cached(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(folders, "_cache_roots", lambda: [Path("/proc/irsim_gym")])
    folders.cache_folder.cache_clear()
    try:
        assert folders.cache_folder() is None
        assert jit.kernel(lambda x: x + 1)(1) == 2
    finally:
        monkeypatch.undo()
        folders.cache_folder.cache_clear()


def test_old_cache_folders_are_pruned(tmp_path: Path) -> None:
    for age in range(8):
        folder = tmp_path / f"irsim_gym-{age}"
        folder.mkdir()
        os.utime(folder, (1000 - age, 1000 - age))
    folders._prune(tmp_path)
    assert sorted(folder.name for folder in tmp_path.iterdir()) == [f"irsim_gym-{age}" for age in range(4)]


@jit.kernel
def sum_of_a_copy(values: Floats) -> float:
    return float(values.copy().sum())


@pytest.mark.skipif(jit.config.DISABLE_JIT, reason="nothing is compiled")
def test_a_kernel_that_allocates_does_not_compile() -> None:
    with pytest.raises(NumbaError, match="NRT required"):
        sum_of_a_copy(np.ones(3))


def test_folders_used_lately_are_not_pruned(tmp_path: Path) -> None:
    for name in "abcdef":
        (tmp_path / f"irsim_gym-{name}").mkdir()
    folders._prune(tmp_path)
    assert len(list(tmp_path.iterdir())) == 6


USE = "from irsim_gym.base import rng; import numpy as np; rng.mix(np.uint64(1)); rng.later_level(1, 2)"
COUNT = """
from numba.core import event
class Count(event.Listener):
    n = 0
    def on_start(self, event): self.n += 1
    def on_end(self, event): pass
count = Count()
event.register("numba:compile", count)
"""


def compilations(folder: Path, use: str = USE, **environment: str) -> int:
    """Use two kernels in a process of its own, of which one calls a third; return how many were compiled.

    Python compares sources with what it has compiled by their size and second, in which tests may change them again.
    """
    environment |= {"NUMBA_CACHE_DIR": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    done = run(["-W", "error", "-c", f"{COUNT}\n{use}\nprint(count.n)"], **environment)
    assert done.returncode == 0, done.stderr
    return int(done.stdout)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the three kernels of ``USE``."""
    folder = tmp_path_factory.mktemp("compiled")
    assert compilations(folder) == 3
    return folder


@pytest.fixture
def full(compiled: Path, tmp_path: Path) -> Path:
    """A copy of that folder."""
    return Path(shutil.copytree(compiled, tmp_path / "full"))


def test_what_is_on_disk_is_not_compiled_again(full: Path) -> None:
    assert compilations(full) == 0


READY = "print('numba.np.arraymath' in sys.modules)"


def test_kernels_on_disk_run_before_the_compiler_is_ready(full: Path) -> None:
    """Numba's preparations take longer than all kernels, and import SciPy where it is installed."""
    use = f"import sys; from irsim_gym.base import rng; rng.later_level(1, 2); {READY}"
    assert run(["-c", use], NUMBA_CACHE_DIR=str(full)).stdout.strip() == "False"


@pytest.mark.slow
def test_kernels_elsewhere_wait_for_the_compiler(tmp_path: Path) -> None:
    use = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); from mine import half; half(3.0); {READY}"
    (tmp_path / "mine.py").write_text(
        "from irsim_gym.base.kernels import kernel\n@kernel\ndef half(x):\n    return 0.5 * x\n"
    )
    seen = [run(["-c", use], NUMBA_CACHE_DIR=str(tmp_path / "cache")).stdout.strip() for _ in range(2)]
    assert seen == ["True", "True"]


def test_a_kernel_on_disk_may_allocate(tmp_path: Path) -> None:
    """The least circle around a square with sides of 2 m: sqrt(2) = 1.414."""
    use = """
import numpy as np
from irsim_gym.simulator.levels.body_measures import measure
from irsim_gym.simulator.world.model import Model
sizes = dict.fromkeys(("disc", "map_column", "map_row", "map_box", "waypoint", "watching"), 0)
model = Model.allocate({**sizes, "world": 1, "body": 1, "segment": 4})
corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]]
model.local_segments[0] = [[*corners[k - 1], *corners[k]] for k in range(4)]
model.segment_count[:], model.solid[:], one = 4, True, np.zeros(1, np.int64)
measure(one, one, model)
assert abs(model.radius[0, 0] - 2**0.5) < 1e-9, model.radius
"""
    assert compilations(tmp_path, use) > 0
    assert compilations(tmp_path, use) == 0


def test_a_part_that_is_on_disk_serves_other_kernels(tmp_path: Path) -> None:
    assert compilations(tmp_path, "from irsim_gym.base import rng; a = rng.later_level(1, 2)") == 2
    other = "from irsim_gym.base import rng; import numpy as np; print(rng.level_stream(np.uint64(7), 3))"
    done = run(["-c", f"{COUNT}\n{other}\nprint(count.n)"], NUMBA_CACHE_DIR=str(tmp_path)).stdout.split()
    assert done == [str(rng.level_stream(np.uint64(7), 3)), "1"]


def test_processors_and_settings_have_files_of_their_own(full: Path) -> None:
    assert compilations(full, NUMBA_CPU_NAME="generic", NUMBA_CPU_FEATURES="") == 3
    assert compilations(full, NUMBA_BOUNDSCHECK="1") == 3
    assert compilations(full) == 0


def test_a_damaged_file_is_compiled_anew(full: Path) -> None:
    files = sorted(full.rglob("*.nbc"))
    files[0].write_bytes(files[0].read_bytes()[:-10])
    files[1].write_bytes(b"")
    files[2].write_bytes(files[2].read_bytes()[:99] + b"x" + files[2].read_bytes()[100:])
    assert compilations(full) == 3
    assert compilations(full) == 0


def test_a_full_disk_is_done_without(tmp_path: Path) -> None:
    full = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (64, 64));"  # as if no more would fit
    assert compilations(tmp_path, full + USE) == 3
    assert not [file for file in tmp_path.rglob("*") if file.is_file()]


def test_processes_that_compile_at_once_do_not_disturb_each_other(tmp_path: Path) -> None:
    command = [sys.executable, "-W", "error", "-c", USE]
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    processes = [subprocess.Popen(command, env=environment) for _ in range(2)]
    assert [process.wait(timeout=120) for process in processes] == [0, 0]
    assert compilations(tmp_path) == 0
    assert {file.suffix for file in tmp_path.rglob("*") if file.is_file()} == {".nbc"}


def test_a_kernel_elsewhere_follows_what_it_calls_and_reads(tmp_path: Path) -> None:
    files = {
        "mine": "from irsim_gym.base.kernels import kernel\nfrom lib import twice, STEP\n"
        "@kernel\ndef answer(x):\n    return twice(x) + STEP\n",
        "lib": "from irsim_gym.base.kernels import kernel\nSTEP = 1.0\n@kernel\ndef twice(x):\n    return 2.0 * x\n",
    }
    for name, text in files.items():
        (tmp_path / f"{name}.py").write_text(text)
    ask = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); from mine import answer; print(answer(10.0))"

    def answer() -> float:
        done = run(["-B", "-c", ask], NUMBA_CACHE_DIR=str(tmp_path / "cache"))
        return float(done.stdout)

    assert answer() == 21.0
    (tmp_path / "lib.py").write_text(files["lib"].replace("2.0 *", "3.0 *"))
    assert answer() == 31.0
    (tmp_path / "lib.py").write_text(files["lib"].replace("STEP = 1.0", "STEP = 5.0"))
    assert answer() == 25.0


def kept_in(monkeypatch: pytest.MonkeyPatch, *roots: Path) -> Path | None:
    """Choose the folder for compiled code anew, among some roots."""
    monkeypatch.setattr(folders, "_cache_roots", lambda: roots)
    return folders.cache_folder.__wrapped__()


def test_the_folder_is_for_its_owner_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = os.umask(0o002)  # as where each user has a group
    try:
        folder = kept_in(monkeypatch, tmp_path)
        assert folder is not None
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
        Files.write(folder / "some.nbc", b"code")
    finally:
        os.umask(before)
    assert stat.S_IMODE((folder / "some.nbc").stat().st_mode) == 0o600
    assert Files.read(folder / "some.nbc") == b"code"


def test_a_folder_that_others_may_write_is_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    open_to_all = tmp_path / "a" / f"irsim_gym-{folders.compiler_digest()}"
    open_to_all.mkdir(parents=True)
    open_to_all.chmod(0o777)
    with pytest.warns(UntrustedCodeWarning, match=r"a/irsim_gym-\w+ may be written by others \(mode 0777\)"):
        folder = kept_in(monkeypatch, tmp_path / "a", tmp_path / "b")
    assert folder == tmp_path / "b" / open_to_all.name


def test_a_folder_of_somebody_else_is_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    name = f"irsim_gym-{folders.compiler_digest()}"
    (tmp_path / "theirs" / name).mkdir(mode=0o700, parents=True)
    (tmp_path / "linked").mkdir()
    (tmp_path / "linked" / name).symlink_to(tmp_path / "theirs" / name)
    with pytest.warns(UntrustedCodeWarning, match="is a link"):
        assert kept_in(monkeypatch, tmp_path / "linked") is None
    monkeypatch.setattr(os, "getuid", lambda: tmp_path.stat().st_uid + 1)
    with pytest.warns(UntrustedCodeWarning, match="belongs to another user"):
        assert kept_in(monkeypatch, tmp_path / "theirs") is None


def test_a_file_of_somebody_else_is_not_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "some.nbc"
    Files.write(file, b"code")
    file.chmod(0o620)
    with pytest.warns(UntrustedCodeWarning, match=r"some.nbc may be written by others"):
        assert Files.read(file) is None
    file.chmod(0o600)
    monkeypatch.setattr(os, "getuid", lambda: tmp_path.stat().st_uid + 1)
    with pytest.warns(UntrustedCodeWarning, match="NUMBA_CACHE_DIR"):
        assert Files.read(file) is None


def test_what_others_may_have_written_is_compiled_anew(full: Path) -> None:
    files = list(full.rglob("*.nbc"))
    for file in files:
        file.chmod(0o666)
    trusting = "import warnings; warnings.simplefilter('ignore');"
    assert compilations(full, trusting + USE) == 3
    assert all(stat.S_IMODE(file.stat().st_mode) == 0o600 for file in files)
    assert compilations(full) == 0


def test_a_long_compilation_is_announced_once(tmp_path: Path, full: Path) -> None:
    hasty = "from irsim_gym.base.compiled import watch; watch.PATIENCE_S = 0.0;"
    first = run(["-c", hasty + USE], NUMBA_CACHE_DIR=str(tmp_path / "empty"))
    assert first.stderr.count("compiling kernels") == 1
    assert "`irsim-gym warmup`" in first.stderr
    assert run(["-c", hasty + USE], NUMBA_CACHE_DIR=str(full)).stderr == ""


def test_a_short_compilation_is_not_worth_a_word(tmp_path: Path) -> None:
    patient = "from irsim_gym.base.compiled import watch; watch.PATIENCE_S = 60.0;"
    assert run(["-c", patient + USE], NUMBA_CACHE_DIR=str(tmp_path)).stderr == ""
