"""What other systems lack or do in another way, as far as it can be seen from here."""

from __future__ import annotations

import ast
import errno
import fcntl
import importlib.util
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from irsim_gym.base.compiled import folder, trust
from irsim_gym.base.compiled import lock as posix_lock
from irsim_gym.errors import IrsimGymError

ROOT = Path(__file__).parents[1]
TEXT = {"read_text", "write_text", "open"}


def test_text_files_are_utf_8_everywhere() -> None:
    """Without a word, Windows takes its code page."""
    found = []
    for source in (*ROOT.glob("irsim_gym/**/*.py"), *ROOT.glob("agents/*.py"), *ROOT.glob("benchmarks/*.py")):
        for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
                continue
            words = {word.arg for word in node.keywords}
            first = ast.unparse(node.args[0]) if node.args else ""
            is_text = node.func.attr != "open" or first in ("", "'r'", "'w'", "'x'", "'a'")
            own = ast.unparse(node.func.value)  # files alone have this method
            if node.func.attr in TEXT and is_text and "encoding" not in words and own not in ("Image", "webbrowser"):
                found.append(f"{source.relative_to(ROOT)}:{node.lineno}: {ast.unparse(node)}")
    assert found == []


def windows_lock(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Return `base/compiled/lock.py` as Windows loads it: with `msvcrt` in place of `fcntl`."""

    def locking(descriptor: int, mode: int, n_bytes: int) -> None:
        assert n_bytes == 1
        kind = fcntl.LOCK_UN if mode == windows.LK_UNLCK else fcntl.LOCK_EX | fcntl.LOCK_NB
        try:
            fcntl.flock(descriptor, kind)
        except BlockingIOError:
            raise PermissionError(errno.EACCES, "Permission denied") from None  # as Windows calls it

    windows: Any = SimpleNamespace(LK_NBLCK=2, LK_UNLCK=0, locking=locking)
    monkeypatch.setitem(sys.modules, "msvcrt", windows)
    monkeypatch.setitem(sys.modules, "fcntl", None)
    monkeypatch.setattr(sys, "platform", "win32")
    assert posix_lock.__spec__ is not None
    spec = importlib.util.spec_from_file_location("windows_lock", posix_lock.__spec__.origin)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_locks_of_windows_exclude_each_other(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    module: Any = windows_lock(monkeypatch)
    monkeypatch.setattr(trust, "HAS_OWNERS", False)
    monkeypatch.setattr(Path, "unlink", lambda path: (_ for _ in ()).throw(PermissionError(path)))  # it is open
    file = tmp_path / "kernel.nbc"
    with module.lock(file, is_ordered=True):
        other = os.open(file.with_suffix(".lock"), os.O_RDWR)
        assert not module._try(other)
    assert module._try(other)
    os.close(other)
    with module.lock(file, is_ordered=True):  # the file that stayed is no obstacle
        pass


def test_code_on_disk_is_kept_where_files_have_no_owners(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(trust, "HAS_OWNERS", False)
    monkeypatch.delattr(os, "getuid")
    monkeypatch.delattr(os, "O_NOFOLLOW")
    monkeypatch.setattr(folder.config, "CACHE_DIR", str(tmp_path / "cache"))
    place = folder.cache_folder.__wrapped__()
    assert place is not None
    assert place.parent == tmp_path / "cache"
    trust.write_private(place / "kernel.nbc", b"code")
    assert trust.read_trusted(place / "kernel.nbc") == b"code"
    os.close(trust.open_private(place / "kernel.lock"))
    assert folder._temporary_root().name == "irsim_gym-user"


@pytest.mark.parametrize("command", [["policies", "list"], ["options", "lidar2d"]])
def test_output_goes_to_files_of_any_code_page(command: list[str]) -> None:
    """ASCII stands for the code pages of Windows, which lack what tables are drawn with."""
    variables = {**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    done = subprocess.run(
        [sys.executable, "-m", "irsim_gym", *command], env=variables, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.isascii()


def test_names_of_files_may_have_any_letters(tmp_path: Path) -> None:
    from irsim_gym.scenario import load_scenario

    file = tmp_path / "Größe 世界.yaml"
    file.write_text("robot: {kinematics: {name: diff}, state: [1, 1, 0], gaol: [5, 5]}  # Straße\n", encoding="utf-8")
    with pytest.raises(IrsimGymError, match=r"Größe 世界\.yaml:1"):
        load_scenario(file)
