"""Links of the repository's Markdown, as links of the site."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path, PurePosixPath

LINK = re.compile(r"(!?\[(?:[^\[\]]|\[[^\]]*\])*\])\(([^)\s]+)\)")
DEFINITION = re.compile(r"^(\[[^\]]+\]): (\S+)$", re.MULTILINE)
FENCED = re.compile(r"^( *)(```+|~~~+).*?^\1\2 *$", re.MULTILINE | re.DOTALL)


class BrokenLinkError(Exception):
    """A link leads to nothing; the message names page, line and target."""


def rewrite(text: str, source: str, place: str, pages: Mapping[str, str], root: Path) -> str:
    """Return Markdown with its relative links changed to those of the site.

    A link to a page of the site leads to that page, one to another file to the file itself, and of one to a folder,
    or to Markdown that is no page of the site, the words stay. Code blocks are left alone.

    Args:
        text: The Markdown.
        source: Where it stands in the repository.
        place: Where it stands on the site, relative to the folder that Sphinx reads.
        pages: Pages of the site by the files of the repository that they are made from.
        root: The repository.

    Raises:
        BrokenLinkError: A target is not there.
    """

    def changed(prose: str, first: int) -> str:
        def inline(found: re.Match[str]) -> str:
            target = _target(found[2], source, place, pages, root, at(found))
            return found[1].lstrip("!")[1:-1] if target is None else f"{found[1]}({target})"

        def defined(found: re.Match[str]) -> str:
            return f"{found[1]}: {_target(found[2], source, place, pages, root, at(found))}"

        def at(found: re.Match[str]) -> str:
            return f"{source}:{first + found.string.count(chr(10), 0, found.end())}"

        return DEFINITION.sub(defined, LINK.sub(inline, prose))

    parts, end = [], 0
    for code in FENCED.finditer(text):
        parts += [changed(text[end : code.start()], 1 + text.count("\n", 0, end)), code[0]]
        end = code.end()
    return "".join([*parts, changed(text[end:], 1 + text.count("\n", 0, end))])


def _target(given: str, source: str, place: str, pages: Mapping[str, str], root: Path, where: str) -> str | None:
    """Return the target of a link on the site, None where the site has no page for it."""
    if re.match(r"[a-z]+:|#|\{", given):
        return given
    name, _, anchor = given.partition("#")
    file = os.path.normpath((PurePosixPath(source).parent / name).as_posix())
    if (page := pages.get(file)) is not None:
        return _relative(page, place) + (f"#{anchor}" if anchor else "")
    if (root / file).is_dir() or ((root / file).is_file() and file.endswith(".md")):
        return None
    if not (root / file).is_file():
        raise BrokenLinkError(f"{where}: there is no {given}")
    return _relative(file.removeprefix("docs/") if file.startswith("docs/") else f"files/{file}", place)


def _relative(target: str, place: str) -> str:
    return Path(os.path.relpath(target, PurePosixPath(place).parent)).as_posix()
