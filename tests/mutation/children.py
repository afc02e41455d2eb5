"""A mutant in a forked child: the parent has imported everything, the child changes one function and runs tests."""

from __future__ import annotations

import importlib
import importlib.abc
import importlib.util
import inspect
import os
import resource
import sys
import traceback
import warnings
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

from selection import MARKS, PLAIN

MEMORY = 12 << 30
OPTIONS = (
    "-q", "--tb=short", "--color=no", "-p", "no:cacheprovider", *MARKS,
    "-W", "ignore::pytest.PytestAssertRewriteWarning",  # of what was imported before the fork
)  # fmt: skip


class Failures:
    """Writes down which tests have failed, as a plugin of pytest."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Note a failure."""
        if report.outcome == "failed":
            with self.file.open("a", encoding="utf-8") as out:
                out.write(report.nodeid + "\n")


class OneModule(importlib.abc.MetaPathFinder, importlib.abc.SourceLoader):
    """Imports one module from a text in place of its file."""

    def __init__(self, name: str, file: Path, text: str) -> None:
        self.name, self.file, self.text = name, file, text

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> Any:
        """Return how to import the module; None for all others."""
        if fullname != self.name:
            return None
        folder = [str(self.file.parent)] if self.file.name == "__init__.py" else None
        return importlib.util.spec_from_file_location(
            fullname, self.file, loader=self, submodule_search_locations=folder
        )

    def get_filename(self, fullname: str) -> str:
        """Return the file that the text stands for."""
        return str(self.file)

    def get_data(self, path: str | bytes) -> bytes:
        """Return the text; nothing compiled is found or kept."""
        return self.text.encode()


def preload(root: Path, files: Sequence[str], is_compiled: bool) -> None:
    """Import what children need: the package and the tests, as pytest does when it collects them."""
    import pytest

    os.environ.update(PLAIN, PYTHONPATH=str(root))
    if is_compiled:
        del os.environ["NUMBA_DISABLE_JIT"]
    os.chdir(root)
    sys.path.insert(0, str(root))
    code = pytest.main(["--collect-only", "-qq", "-p", "no:cacheprovider", *MARKS, *files])
    if code:
        raise SystemExit("the tests cannot be collected")


def run(root: Path, module: str, source: str, mutated: str, tests: Sequence[str], failures: Path, limit: int) -> None:
    """Run the tests over a mutant in this process, which is a child, and end it with pytest's answer.

    Args:
        root: The repository.
        module: The mutated file.
        source: Its text.
        mutated: The mutant's text; the same text for no mutant: then all tests run, else they end with a failure.
        tests: What to run, in this order.
        failures: File for the names of tests that fail.
        limit: Time of the processor after which the process is ended [s].
    """
    code = 3
    try:
        from numba.core import config

        from irsim_gym.base.compiled.folder import cache_folder

        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        if not config.DISABLE_JIT:  # what was compiled of the file as it is must not be found
            config.CACHE_DIR = os.environ["NUMBA_CACHE_DIR"]
            cache_folder.cache_clear()
        name = module.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what the compiler says of the mutant
            if mutated != source and not change(sys.modules.get(name), source, mutated):
                _import_again(root, name, root / module, mutated)
        import pytest

        options = OPTIONS if mutated == source else ("-x", *OPTIONS)
        code = int(pytest.main([*options, *tests], plugins=[Failures(failures)]))
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _import_again(root: Path, name: str, file: Path, text: str) -> None:
    """Forget the package and the tests, so that they are imported again, with the mutant."""
    sys.meta_path.insert(0, OneModule(name, file, text))
    tests, tools = (root / "tests").resolve(), Path(__file__).resolve().parent
    for known, module in list(sys.modules.items()):
        place = Path(getattr(module, "__file__", None) or "/").resolve()
        if known.split(".")[0] == "irsim_gym" or (tests in place.parents and tools not in place.parents):
            del sys.modules[known]


def change(module: ModuleType | None, source: str, mutated: str) -> bool:
    """Give one function of a module that has been imported the body that it has in the mutant.

    Whoever has imported the function sees the change: it stays the same object.

    Returns:
        False, and nothing has changed, if more than the body of one function differs.
    """
    if module is None:
        return False
    file = str(module.__file__)
    found = difference(compile(source, file, "exec"), compile(mutated, file, "exec"))
    function = None if found is None else function_at(module, found.co_qualname)
    if found is None or function is None or len(found.co_freevars) != len(function.__code__.co_freevars):
        return False
    function.__code__ = found
    return True


def difference(old: CodeType, new: CodeType) -> CodeType | None:
    """Return the new body of the outermost function that differs, if nothing else does."""
    inner_old, inner_new = _inner(old), _inner(new)
    if len(inner_old) != len(inner_new) or _own(old) != _own(new):
        return None
    changed = [(a, b) for a, b in zip(inner_old, inner_new, strict=True) if a != b]
    if len(changed) != 1:
        return None
    is_function = changed[0][1].co_flags & inspect.CO_NEWLOCALS
    return changed[0][1] if is_function else difference(*changed[0])


def _inner(code: CodeType) -> list[CodeType]:
    return [one for one in code.co_consts if isinstance(one, CodeType)]


def _own(code: CodeType) -> tuple[Any, ...]:
    """Return what a body does by itself, without what it defines."""
    plain = [(type(one), one) for one in code.co_consts if not isinstance(one, CodeType)]
    return code.co_code, code.co_names, code.co_varnames, plain


def function_at(module: ModuleType, qualname: str) -> FunctionType | None:
    """Return the plain function of a name, below its decorators; None if there is none."""
    found: Any = module
    for part in qualname.split("."):
        found = vars(found).get(part)
        if found is None:
            return None
    if isinstance(found, property):
        found = found.fget
    if isinstance(found, cached_property):
        found = found.func
    found = inspect.unwrap(getattr(found, "__func__", found))
    return found if isinstance(found, FunctionType) and found.__code__.co_qualname == qualname else None
