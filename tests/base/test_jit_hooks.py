"""Where Numba's internals are not as expected, its plain way gives the same bits, after one warning."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from irsim_gym.base.kernels import config, hooks

pytestmark = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")
ROOT = Path(__file__).parents[2]
MINE = """
import numpy as np
from irsim_gym.base.kernels import kernel

@kernel(allocates=True)
def third(number):
    return np.full(1, number)[0] / 3.0

@kernel
def draw(worlds, numbers, out):
    for i in range(worlds.shape[0]):
        out[worlds[i]] = third(numbers[worlds[i]])
"""
RENAME = """
import importlib, types

def rename(old):
    "Give something inside of Numba another name, everywhere: another release of it."
    new = old + "_2"
    for name in MODULES:
        module = importlib.import_module(name)
        for holder in [module, *(value for value in vars(module).values() if isinstance(value, type))]:
            if not getattr(holder, "__module__", name).startswith("numba"):
                continue
            if old in vars(holder):
                setattr(holder, new, vars(holder)[old])
                delattr(holder, old)
            for value in list(vars(holder).values()):
                function = getattr(value, "__func__", getattr(value, "__wrapped__", value))
                if isinstance(function, types.FunctionType) and old in function.__code__.co_names:
                    words = tuple(new if word == old else word for word in function.__code__.co_names)
                    function.__code__ = function.__code__.replace(co_names=words)
MODULES = ["numba.core.codegen", "numba.core.compiler", "numba.core.caching", "numba.core.dispatcher"]
"""
USE = """
import sys, warnings
sys.path.insert(0, FOLDER)
BREAK
with warnings.catch_warnings(record=True) as seen:
    warnings.simplefilter("always")
    import numpy as np
    import mine
    from irsim_gym.simulator.running.fused import Fused
    from irsim_gym.simulator.world.group import Shard

    out, numbers = np.zeros((2, 3)), np.arange(3.0)
    mine.draw(np.arange(3), numbers, out[0])
    fused = Fused(lambda shard: mine.draw(shard.worlds, numbers, out[1]))
    fused(Shard(np.arange(3)))
print(out.tobytes().hex(), fused.programs.get(0) is not None)
for one in seen:
    print(one.message)
"""


def use(folder: Path, change: str = "", **environment: str) -> list[str]:
    """Use kernels in a process of its own after a change of Numba; return bits, whether it recorded, and warnings."""
    (folder / "mine.py").write_text(MINE)
    code = USE.replace("FOLDER", repr(str(folder))).replace("BREAK", change)
    known = {**os.environ, "NUMBA_CACHE_DIR": str(folder / "cache"), hooks.SWITCH: "0", **environment}
    done = subprocess.run([sys.executable, "-c", code], env=known, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    answer, *warnings = done.stdout.splitlines()
    return [*answer.split(), *warnings]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where all share what is compiled."""
    return tmp_path_factory.mktemp("hooks")


@pytest.fixture(scope="module")
def bits(folder: Path) -> str:
    """What the kernels give with all hooks."""
    found, is_recorded = use(folder)
    assert is_recorded == "True"
    return found


@pytest.mark.parametrize("name", ["_reduce", "_finalize_dynamic_globals", "JITCodeLibrary"])
def test_another_name_inside_numba_changes_no_bit(name: str, bits: str, tmp_path: Path) -> None:
    found, is_recorded, *warnings = use(tmp_path, f"{RENAME}\nrename({name!r})")
    assert (found, is_recorded) == (bits, "False")
    (warning,) = warnings
    assert f"irsim_gym is tested with numba {hooks.KNOWN}" in warning


@pytest.mark.parametrize(
    ("hook", "is_read"),
    [
        pytest.param("cache.keep_on_disk", True, marks=pytest.mark.slow),
        ("inner.InnerLibrary.restore", True),
        ("inner.InnerLibrary._finalize_final_module", False),
        ("packed.PackedLibrary.add_ir_module", False),
    ],
)
def test_a_hook_that_fails_changes_no_bit(hook: str, is_read: bool, bits: str, folder: Path) -> None:
    """Before anything, when a file is read, when a kernel is compiled for others, and for calls by address.

    A kernel that is compiled while a hook fails counts references, though its caller does not: otherwise one that
    allocates does not compile, and one that returns an array is called by others that free it too early.
    """
    removed = "draw" if is_read else ""
    for file in folder.rglob(f"mine.{removed}*.nbc"):
        file.unlink()
    change = f"from irsim_gym.base.kernels import inner, packed; from irsim_gym.base.compiled import cache; {hook} = "
    found, is_recorded, *warnings = use(folder, f"{change}lambda: None")
    assert (found, is_recorded) == (bits, "False")
    (warning,) = warnings
    assert "failed with TypeError" in warning


def test_the_switch_turns_all_hooks_off_without_a_word(bits: str, folder: Path, tmp_path: Path) -> None:
    plain = {hooks.SWITCH: "1", "NUMBA_CACHE_DIR": str(tmp_path)}
    assert use(folder, **plain) == [bits, "False"]
    (kept,) = tmp_path.glob("irsim_gym-*/plain-*")
    assert list(kept.rglob("mine.draw-*.nbi"))
    assert not list(tmp_path.glob("irsim_gym-*/*.nbc"))


@pytest.mark.slow
def test_contracts_hold_in_numbas_plain_way(tmp_path: Path) -> None:
    files = ("test_batch", "test_processes", "test_vector_contract")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "not slow"]
    environment = {**os.environ, hooks.SWITCH: "1", "NUMBA_CACHE_DIR": str(tmp_path)}
    done = subprocess.run(
        [*command, *(f"tests/envs/contracts/{name}.py" for name in files)],
        cwd=ROOT, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
