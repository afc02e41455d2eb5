"""The pages of other libraries, the Makefile and the extras name the same versions."""

from __future__ import annotations

import ast
import re
import shlex
import tomllib
from pathlib import Path

import library_pages as pages
import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[1]
TABLE = (ROOT / "docs" / "libraries.md").read_text(encoding="utf-8")
PINNED = [name for name in pages.names() if pages.HEAD.match(pages.text_of(name))[2]]
GLUE = re.findall(r"(?:by|of) (\d+) lines.*\(libraries/(\w+)\.md\)", TABLE)


def sets() -> dict[str, dict[str, str]]:
    """Return what `make test-libraries` installs beside our package: for each set, packages and their versions."""
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8").replace("\\\n", "")
    found: dict[str, dict[str, str]] = {}
    for name, line in re.findall(r"^(?:REQUIRED|ALONE)_(\w+) := (.+)$", makefile, re.MULTILINE):
        for one in map(Requirement, shlex.split(line)):
            found.setdefault(name, {})[canonicalize_name(one.name)] = str(one.specifier)
    return found


def told(name: str) -> dict[str, str]:
    """Return the requirements of a page's commands, without what our package brings."""
    words = [word for words in pages.installations(name) for word in words if not word.startswith("-")]
    found = {canonicalize_name(one.name): str(one.specifier) for one in map(Requirement, words)}
    return {package: version for package, version in found.items() if package not in ("irsim-gym", "torch")}


@pytest.mark.parametrize("name", pages.names())
def test_a_page_installs_what_is_tested(name: str) -> None:
    assert pages.installations(name)
    assert any(told(name).items() <= one.items() for one in sets().values())


@pytest.mark.parametrize("name", PINNED)
def test_a_heading_names_the_version_that_the_page_installs(name: str) -> None:
    assert f"=={pages.HEAD.match(pages.text_of(name))[2]}" in told(name).values()


def test_extras_allow_what_is_tested() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    for extra, package in (("torchrl", "torchrl"), ("zoo", "rl-zoo3")):
        (bounds,) = (one for one in map(Requirement, extras[extra]) if canonicalize_name(one.name) == package)
        assert bounds.specifier.contains(sets()[extra][package].removeprefix("=="))


def test_every_page_is_in_the_table() -> None:
    assert sorted(re.findall(r"\(libraries/(\w+)\.md\) \|$", TABLE, re.MULTILINE)) == pages.names()


@pytest.mark.parametrize(("lines", "name"), GLUE, ids=[name for _, name in GLUE])
def test_the_table_counts_lines_of_glue(lines: str, name: str) -> None:
    """The first thing that a page defines; of rl_zoo3's also the two lines that use it."""
    first = next(
        one for one in ast.parse(pages.blocks(name)[0]).body if isinstance(one, ast.ClassDef | ast.FunctionDef)
    )
    assert first.end_lineno is not None
    assert int(lines) == first.end_lineno - first.lineno + 1 + 2 * (name == "rl_zoo3")
