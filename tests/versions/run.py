"""Do the bounds of pyproject.toml hold? Chosen tests with the lowest, and with the newest, of every dependency."""

from __future__ import annotations

import argparse
import importlib.metadata
import os
import platform
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

ROOT = Path(__file__).parents[2]
RESOLUTIONS = {"lowest": "lowest-direct", "newest": "highest"}
EXTRAS = ("train", "contrib", "tune", "play", "test")
TESTS = (
    "tests/base/test_jit.py",
    "tests/base/test_jit_hooks.py",
    "tests/base/test_jit_packed.py",
    "tests/base/test_compilation.py",
    "tests/envs/contracts/test_checkers.py",
    "tests/envs/contracts/test_parallel_checkers.py",
    "tests/envs/contracts/test_sb3.py",
    "tests/envs/contracts/test_vector_contract.py",
    "tests/envs/contracts/test_wrappers.py",
    "tests/cli/test_cli.py",
    "tests/evaluation/test_committed_policies.py",
    "tests/evaluation/test_record.py",
    "tests/training/test_train.py",
    "tests/parity/test_golden_vectors.py",
    "tests/parity/test_steps.py",
    "tests/rendering/test_frame.py",
    "tests/rendering/test_video.py",
    "tests/robot/test_network_graph.py",
    "tests/robot/test_robot_export.py",
    "tests/robot/test_twins.py",
    "tests/scenario",
    "tests/test_readme.py",
)
"""Numba's insides, the faces for Gymnasium, PettingZoo and SB3, IR-SIM's steps, commands, pictures, graphs."""
FOREIGN = ("DeprecationWarning", "PendingDeprecationWarning")
"""An old release that warns of what it does itself, next to newer ones, is no mistake of ours."""


def main() -> None:
    """Install and test one environment after the other; the exit status is 1 if something fails in one of them."""
    options = _options()
    failed = []
    for python in options.python:
        for name in options.only:
            folder = options.folder.resolve() / f"{name}-{python}"
            problems = try_out(folder, name, python, options.tests or TESTS)
            print(f"{folder.name}: {'; '.join(problems) or 'fine'}", flush=True)
            failed += problems
    sys.exit(1 if failed else 0)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", choices=list(RESOLUTIONS), default=list(RESOLUTIONS))
    parser.add_argument("--python", nargs="+", default=[platform.python_version()], help="versions, e.g. 3.12 3.13")
    parser.add_argument("--tests", nargs="+", help="in place of the chosen ones")
    parser.add_argument("--folder", type=Path, default=ROOT / "build" / "versions")
    return parser.parse_args()


def try_out(folder: Path, name: str, python: str, tests: tuple[str, ...]) -> list[str]:
    """Make an environment and run tests in it; return what is wrong.

    Args:
        folder: Where to make it.
        name: ``lowest`` or ``newest``.
        python: Version of the interpreter, which uv looks for, or fetches.
        tests: Files or folders.
    """
    uv = [sys.executable, "-m", "uv"]
    if not _runs([*uv, "venv", "--quiet", "--clear", "--python", python, str(folder)]):
        return [f"there is no Python {python}"]
    # As pip does: the best version of all indexes, not of the first that knows a name.
    given = ["--index-strategy", "unsafe-best-match", *shlex.split(os.environ.get("PIP_ARGS", ""))]
    wanted = f"{ROOT}[{','.join(EXTRAS)}]"
    install = [*uv, "pip", "install", "--quiet", "--python", str(folder), "--resolution", RESOLUTIONS[name], *given]
    if not _runs([*install, "--editable", wanted]):
        return ["it cannot be installed"]
    problems = []
    if name == "lowest":
        _leave_old_releases_alone(folder)
    if name == "lowest" and (missed := _missed(folder)):
        problems.append(f"bounds too low for the other ones: {', '.join(missed)}")
    ignored = [word for warning in FOREIGN if name == "lowest" for word in ("-W", f"ignore::{warning}")]
    command = [_python(folder), "-m", "pytest", "-q", "-m", "not slow and not gui", *ignored, *tests]
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder / "kernels"), "MPLBACKEND": "Agg"}
    if not _runs(command, environment):
        problems.append("tests failed")
    return problems


def bounds(text: str) -> dict[str, Version]:
    """Return the lowest version of each package that a project file asks for, as far as the chosen extras go."""
    project = tomllib.loads(text)["project"]
    extras = project["optional-dependencies"]
    lines = [*project["dependencies"], *(line for extra in EXTRAS for line in extras[extra])]
    found = {}
    for requirement in map(Requirement, lines):
        if requirement.name == project["name"]:  # one extra that brings another
            continue
        (lowest,) = [Version(one.version) for one in requirement.specifier if one.operator in (">=", "==")]
        found[requirement.name] = lowest
    return found


def _leave_old_releases_alone(folder: Path) -> None:
    """Ignore foreign warnings in processes that tests start with ``-W error``, too: Python runs this file first."""
    lines = ["import warnings", *(f'warnings.simplefilter("ignore", {warning})' for warning in FOREIGN)]
    (_packages(folder) / "sitecustomize.py").write_text("\n".join(lines), encoding="utf-8")


def _packages(folder: Path) -> Path:
    (found,) = folder.glob("[Ll]ib/**/site-packages")
    return found


def _missed(folder: Path) -> list[str]:
    """Return bounds that another dependency does not allow: nobody can have such a version."""
    packages = [str(_packages(folder))]
    found = {canonicalize_name(one.name): one.version for one in importlib.metadata.distributions(path=packages)}
    return [
        f"{name} {lowest} (got {found[canonicalize_name(name)]})"
        for name, lowest in bounds((ROOT / "pyproject.toml").read_text(encoding="utf-8")).items()
        if Version(found[canonicalize_name(name)]).release[:2] != (*lowest.release, 0)[:2]
    ]


def _python(folder: Path) -> str:
    place = "Scripts/python.exe" if sys.platform == "win32" else "bin/python"
    return str(folder / place)


def _runs(command: list[str], environment: dict[str, str] | None = None) -> bool:
    print(shlex.join(command), flush=True)
    return subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode == 0


if __name__ == "__main__":
    main()
