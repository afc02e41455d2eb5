"""The pages of docs/libraries: what they show is what is tested and measured."""

from __future__ import annotations

import re
import shlex
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

FOLDER = Path(__file__).parents[1] / "docs" / "libraries"
HEAD = re.compile(r"^# (.+?)(?: ([\d.]+))?\n")
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
INSTALLATION = re.compile(r"^pip install (.+)$", re.MULTILINE)


def names() -> list[str]:
    """Return the names of the pages, which are those of the modules."""
    return sorted(page.stem for page in FOLDER.glob("*.md"))


def text_of(name: str) -> str:
    """Return what a page says."""
    return (FOLDER / f"{name}.md").read_text(encoding="utf-8")


def blocks(name: str) -> list[str]:
    """Return the code of a page."""
    return BLOCK.findall(text_of(name))


def installations(name: str) -> list[list[str]]:
    """Return the words after ``pip install`` in each of these commands of a page."""
    return [shlex.split(line) for line in INSTALLATION.findall(text_of(name))]


def shown(name: str) -> dict[str, Any]:
    """Run what the first block of a page defines, up to where it is used, and return it.

    What it defines belongs to a module, since libraries pickle it.
    """
    definitions = re.split(r"^(?:if __name__|envs = |experiment = )", blocks(name)[0], flags=re.MULTILINE)[0]
    page = sys.modules[f"page_{name}"] = ModuleType(f"page_{name}")
    exec(compile(definitions, f"{name}.md", "exec", dont_inherit=True), page.__dict__)
    return page.__dict__
