"""Put together what Sphinx reads: the pages of the repository with their links changed, and generated pages."""

from __future__ import annotations

import fnmatch
import json
import re
import shutil
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from builder.links import LINK, rewrite

ELSEWHERE = {
    "README.md": "index.md",
    "DESIGN.md": "design.md",
    "configs/README.md": "language.md",
    "agents/README.md": "agents.md",
    "benchmarks/README.md": "measurements.md",
    "benchmarks/choices.md": "choices.md",
}
"""Pages outside of docs/; other Markdown files at the top go to ``project/``."""
ONLY_LINKED = ("README.md", "configs/README.md")
"""The site has pages of its own in their place."""
DRAWN = ("scenarios", "extra")
"""Folders of the site's sources where pictures and films are drawn, and stay."""
NOT_SEARCHED = "---\nnosearch: true\n---\n\n"
"""Head of a page that the search leaves out."""
UNSEARCHED = ("project/changelog.md", "training_trials.md", "design.md")
"""Pages about how the package came to be, as the decisions: who searches for how to use it does not get them."""
SKIPPED = ("builder", "decisions", "__pycache__")
"""Folders of docs/ that are not copied as they are."""


def pages_of(root: Path) -> dict[str, str]:
    """Return the page of the site, perhaps with an anchor, that each file of the repository becomes."""
    pages = {file.name: f"project/{file.name.lower()}" for file in sorted(root.glob("*.md"))}
    pages |= ELSEWHERE
    for file in _files_of(root / "docs"):
        if file.suffix in (".md", ".ipynb"):
            pages[f"docs/{file.relative_to(root / 'docs').as_posix()}"] = file.relative_to(root / "docs").as_posix()
    for file in decisions(root):
        pages[f"docs/decisions/{file.name}"] = f"decisions.md#decision-{file.name[:3]}"
    return pages


def decisions(root: Path) -> list[Path]:
    """Return the files of the decisions, in order."""
    return sorted((root / "docs" / "decisions").glob("*.md"))


def stage(root: Path, out: Path, generated: Mapping[str, str]) -> None:
    """Write everything that Sphinx reads; files that are as they were keep their time, and stale ones are removed.

    Args:
        root: The repository.
        out: The folder that Sphinx reads.
        generated: Text of generated pages by their place.

    Raises:
        BrokenLinkError: A link of a page leads to nothing.
    """
    pages, written = pages_of(root), {out / place for place in generated}
    for place, text in generated.items():
        _write(out / place, text)
    for source, place in pages.items():
        if source not in ONLY_LINKED and "#" not in place:
            head = NOT_SEARCHED if place in UNSEARCHED else ""
            _write(out / place, head + expanded(_page(root, source, place, pages), pages.values()))
            written.add(out / place)
    _write(out / "decisions.md", _decisions(root, pages))
    written.add(out / "decisions.md")
    for file in _files_of(root / "docs"):
        if file.suffix not in (".md", ".ipynb", ".py"):
            written.add(_copy(file, out / file.relative_to(root / "docs")))
    for page in sorted(written):
        if page.suffix == ".md":
            written |= set(_linked_files(root, out, page))
    _remove_all_but(out, written)


def expanded(text: str, places: Iterable[str]) -> str:
    """Return a page whose lists of pages have names in place of patterns; one that matches nothing is left out.

    Sphinx expands patterns too, but warns of those that match nothing, and pages of other libraries come and go.
    """
    names = sorted(place.removesuffix(".md") for place in places if place.endswith(".md"))

    def listed(found: re.Match[str]) -> str:
        lines = found[0].split("\n")
        return "\n".join(name for line in lines for name in (fnmatch.filter(names, line) if "*" in line else [line]))

    return re.sub(r"^```\{toctree\}$.*?^```$", listed, text, flags=re.MULTILINE | re.DOTALL)


def _page(root: Path, source: str, place: str, pages: Mapping[str, str]) -> str:
    text = (root / source).read_text(encoding="utf-8")
    if not source.endswith(".ipynb"):
        return rewrite(text, source, place, pages, root)
    book = json.loads(text)
    for cell in book["cells"]:
        if cell["cell_type"] == "markdown":
            cell["source"] = rewrite("".join(cell["source"]), source, place, pages, root)
    return json.dumps(book, indent=1)


def _decisions(root: Path, pages: Mapping[str, str]) -> str:
    """Return one page with all decisions."""
    told = "What was decided, why, and at what cost. [The design](design.md) lists them by subject."
    parts = [f"{NOT_SEARCHED}# Decisions\n\n{told}\n"]
    for file in decisions(root):
        text = rewrite(
            file.read_text(encoding="utf-8"), f"docs/decisions/{file.name}", "decisions.md", dict(pages), root
        )
        text = re.sub(r"^## (.*)$", r"**\1**", text, flags=re.MULTILINE)
        text = re.sub(r"^# (.*)$", rf"(decision-{file.name[:3]})=\n## {file.name[:3]}. \1", text, flags=re.MULTILINE)
        parts.append(text)
    return "\n".join(parts)


def _linked_files(root: Path, out: Path, page: Path) -> Iterator[Path]:
    """Copy the files of the repository that a page links to, and yield where they are then."""
    for _, target in LINK.findall(page.read_text(encoding="utf-8")):
        if "files/" in target and not re.match(r"[a-z]+:", target):
            place = (page.parent / target.partition("#")[0]).resolve().relative_to(out.resolve())
            yield _copy(root / place.relative_to("files"), out / place)


def _files_of(folder: Path) -> Iterable[Path]:
    for file in sorted(folder.rglob("*")):
        parts = file.relative_to(folder).parts
        if file.is_file() and parts[0] not in SKIPPED and "__pycache__" not in parts:
            yield file


def _write(file: Path, text: str) -> None:
    if not file.is_file() or file.read_text(encoding="utf-8") != text:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")


def _copy(file: Path, place: Path) -> Path:
    if not place.is_file() or place.stat().st_mtime < file.stat().st_mtime:
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(file, place)
    return place


def _remove_all_but(folder: Path, kept: Iterable[Path]) -> None:
    keep = {file.resolve() for file in kept}
    for file in sorted(folder.rglob("*")):
        if file.is_file() and file.resolve() not in keep and file.relative_to(folder).parts[0] not in DRAWN:
            file.unlink()
