"""A public name has one path, in a module with ``__all__``; pages, agents, benchmarks and lessons import no others."""

from __future__ import annotations

import ast
import importlib
import json
import pickle
import re
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path

import gymnasium
import pytest

import irsim_gym

ROOT = Path(__file__).parents[1]
OWN = "irsim_gym"
FACES = (
    *("", "sb3", "plugins", "irsim", "errors", "evaluation", "levels", "suite", "scenario", "tasks"),
    *("envs", "live", "training"),
)
"""Modules that users import, and ``rllib``, which needs Ray."""
COMMANDS = {"irsim_gym.cli": {"main"}}
"""What starts the command line."""
MEASURED = {
    "benchmarks/drawing.py": "frames, drawn without an environment",
    "benchmarks/phases.py": "the phases of a step, each timed on its own",
}
"""Benchmarks of inner parts, and what they measure."""


def faces() -> dict[str, set[str]]:
    """The public names of each face."""
    names = {}
    for face in FACES:
        module = importlib.import_module(f"{OWN}.{face}".rstrip("."))
        names[module.__name__] = set(module.__all__)
    return names | {f"{OWN}.rllib": set(_listed(ROOT / OWN / "rllib.py"))}


def _listed(file: Path) -> Iterator[str]:
    """Yield the names in ``__all__`` of a file that is not imported."""
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign | ast.AugAssign) and "__all__" in ast.unparse(node).split("=")[0]:
            yield from ast.literal_eval(node.value)


def sources() -> Iterator[tuple[str, str]]:
    """Yield code that users read, with its place."""
    for folder in ("agents", "benchmarks"):
        for file in sorted((ROOT / folder).rglob("*.py")):
            yield file.relative_to(ROOT).as_posix(), file.read_text(encoding="utf-8")
    for page in sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "agents").glob("*.md")]):
        text = page.read_text(encoding="utf-8")
        for block in re.finditer(r"^ *```python[^\n]*\n(.*?)^ *```", text, re.MULTILINE | re.DOTALL):
            yield f"{page.relative_to(ROOT).as_posix()}:{text.count(chr(10), 0, block.start()) + 1}", block[1]
    for lesson in sorted((ROOT / "docs" / "lessons").glob("*.ipynb")):
        for cell in json.loads(lesson.read_text(encoding="utf-8"))["cells"]:
            if cell["cell_type"] == "code":
                code = "".join(cell["source"])
                yield lesson.relative_to(ROOT).as_posix(), re.sub(r"^\s*[%!].*$", "", code, flags=re.MULTILINE)


def imported(code: str) -> Iterator[tuple[str, str]]:
    """Yield module and name of each import of the package; no name where the module itself is imported."""
    for node in ast.walk(ast.parse(textwrap.dedent(code))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == OWN:
            yield from ((str(node.module), alias.name) for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names if alias.name.split(".")[0] == OWN)


def test_what_users_read_imports_faces() -> None:
    public = faces() | COMMANDS
    codes = list(sources())
    assert len(codes) > 100
    wrong = [
        f"{place}: from {module} import {name}" if name else f"{place}: import {module}"
        for place, code in codes
        if place not in MEASURED
        for module, name in imported(code)
        if module not in public or (name and name not in public[module] and f"{module}.{name}" not in public)
    ]
    assert wrong == []


def test_what_is_measured_is_no_face() -> None:
    public = faces()
    for place in MEASURED:
        used = imported((ROOT / place).read_text(encoding="utf-8"))
        assert any(module not in public or name not in public[module] for module, name in used), place


def test_a_public_thing_has_one_path() -> None:
    """Each class; ``irsim_gym`` shows the decorators of kinds and ``load_scenario`` as well."""
    paths: dict[int, list[str]] = {}
    for face in FACES:
        module = importlib.import_module(f"{OWN}.{face}".rstrip("."))
        for name in module.__all__:
            value = getattr(module, name)
            if isinstance(value, type) and value.__module__.startswith(OWN):
                paths.setdefault(id(value), []).append(f"{module.__name__}.{name}")
    twice = {path for found in paths.values() if len(set(found)) > 1 for path in found}
    assert twice == TWICE


TWICE = {
    *("irsim_gym.World", "irsim_gym.load"),
    *(
        "irsim_gym.irsim.EnvBase",
        "irsim_gym.irsim.EnvBase3D",
        "irsim_gym.irsim.ObjectBase",
        "irsim_gym.plugins.BodyView",
    ),
    *("irsim_gym.irsim.EnvGridMap", "irsim_gym.irsim.Map", "irsim_gym.live.GridMap"),
    *("irsim_gym.plugins.HitKind", "irsim_gym.plugins.Outcome", "irsim_gym.tasks.HitKind", "irsim_gym.tasks.Outcome"),
}
"""A world is loaded by its class; IR-SIM's names; and what plugins need."""


def test_entry_points_name_the_face() -> None:
    spec = gymnasium.spec("irsim_gym/corridor-v0")
    assert (spec.entry_point, spec.vector_entry_point) == ("irsim_gym:WorldEnv", "irsim_gym:WorldVectorEnv")
    scripts = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert re.search(r'^irsim-gym = "irsim_gym\.cli:main"$', scripts, re.MULTILINE)


def test_pickles_of_learners_name_the_face() -> None:
    """Whoever reads a policy.zip of today tomorrow finds its classes where the face is."""
    for name in irsim_gym.sb3.__all__:
        value = getattr(irsim_gym.sb3, name)
        if isinstance(value, type):
            assert value.__module__ == "irsim_gym.sb3", name
            assert pickle.loads(pickle.dumps(value)) is value
    assert b"irsim_gym.training\x94" in pickle.dumps(irsim_gym.training.Linear(1.0))


def test_faces_are_loaded_when_they_are_used() -> None:
    script = (
        "import sys, irsim_gym.evaluation, irsim_gym.envs, irsim_gym.training\n"
        "assert 'numba' not in sys.modules\n"
        "assert not hasattr(irsim_gym.envs, '__wrapped__')\n"
        "print(irsim_gym.evaluation.EpisodeRow.__name__, 'numba' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["EpisodeRow", "True"]
    with pytest.raises(AttributeError, match="EpisodeRov"):
        irsim_gym.evaluation.EpisodeRov  # noqa: B018
