"""What the pages of docs/libraries show is run, as scripts, with the packages that their commands install."""

from __future__ import annotations

import importlib.metadata
import os
import subprocess
import sys
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import library_pages as pages
import pytest
from needed import skip_without

GIVEN = {"rl_zoo3": ["--help"], "sample_factory": ["--env=empty_goal", "--help"]}
"""Arguments of scripts that train, which their own tests do."""
HIDING = """
import sys
from importlib.machinery import PathFinder


class Present(PathFinder):
    @classmethod
    def find_spec(cls, name, path=None, target=None):
        return None if name.partition(".")[0] in {absent} else super().find_spec(name, path, target)


sys.meta_path[sys.meta_path.index(PathFinder)] = Present
"""
"""Python runs it first, in child processes too."""


def installed_by(name: str) -> set[str]:
    """Return the packages that a page's commands bring, with what these ask for, as far as they are here."""
    from packaging.requirements import Requirement
    from packaging.utils import canonicalize_name

    found: set[str] = set()
    open_ones = []
    for words in pages.installations(name):
        alone = "--no-deps" in words
        for requirement in (Requirement(word) for word in words if not word.startswith("-")):
            if alone:
                found.add(canonicalize_name(requirement.name))
            else:
                open_ones.append((canonicalize_name(requirement.name), frozenset(requirement.extras)))
    seen = set()
    while open_ones:
        package, extras = one = open_ones.pop()
        if one in seen:
            continue
        seen.add(one)
        try:
            asked = importlib.metadata.requires(package) or []
        except PackageNotFoundError:  # for another system, or another version of Python
            continue
        found.add(package)
        for requirement in map(Requirement, asked):
            if not requirement.marker or any(requirement.marker.evaluate({"extra": extra}) for extra in {"", *extras}):
                open_ones.append((canonicalize_name(requirement.name), frozenset(requirement.extras)))
    return found


def only_with(packages: set[str], folder: Path) -> dict[str, str]:
    """Return the environment of a process that finds no other packages than these."""
    from packaging.utils import canonicalize_name

    owners = importlib.metadata.packages_distributions()
    absent = {module for module, names in owners.items() if not packages & set(map(canonicalize_name, names))}
    folder.mkdir()
    (folder / "sitecustomize.py").write_text(HIDING.format(absent=sorted(absent)), encoding="utf-8")
    return {**os.environ, "PYTHONPATH": str(folder)}


@pytest.mark.parametrize("name", pages.names())
def test_blocks_run(name, tmp_path):
    skip_without(name)
    blocks = pages.blocks(name)
    assert blocks
    environment = only_with(installed_by(name), tmp_path / "first")
    for k, block in enumerate(blocks):
        script = tmp_path / f"block_{k}.py"
        script.write_text(block, encoding="utf-8")
        command = [sys.executable, str(script), *GIVEN.get(name, [])]
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
