"""Imports of modules by file or name, such as those that register kinds."""

import importlib
import importlib.util
import sys
from collections.abc import Sequence
from pathlib import Path

from irsim_gym.base.errors import IrsimGymError


def import_modules(names: Sequence[str] | None) -> Sequence[str]:
    """Import modules, such as those that register behaviours, and return their names.

    Args:
        names: Paths of ``.py`` files, or dotted names of modules in the current folder or installed.

    Raises:
        IrsimGymError: If a file or module does not exist or is not valid Python, or one of this name is already loaded.
    """
    for name in names or ():
        try:
            _import_file(Path(name).resolve()) if name.endswith(".py") else _import_module(name)
        except SyntaxError as error:
            raise IrsimGymError(f"--import: {error.filename}:{error.lineno}: {error.msg}") from None
    return names or ()


def _import_module(name: str) -> None:
    _search(Path.cwd())
    try:
        importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{name}.".startswith(f"{error.name}."):
            raise  # the module exists, but one that it imports does not
        raise IrsimGymError(
            f"--import: no module named '{name}' in this folder or installed; name a file with its suffix, .py"
        ) from None


def _import_file(file: Path) -> None:
    if not file.is_file():
        raise IrsimGymError(f"--import: no file {file}")
    known = sys.modules.get(file.stem)
    if known is not None:
        if getattr(known, "__file__", None) == str(file):
            return
        raise IrsimGymError(f"--import: another module named '{file.stem}' is already loaded; rename {file.name}")
    _search(file.parent)
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[file.stem] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[file.stem]
        raise


def _search(folder: Path) -> None:
    """Add a folder to the module path, so that a file can import its neighbours."""
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
