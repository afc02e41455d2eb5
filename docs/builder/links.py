"""Links of the repository's Markdown, as links of the site."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path, PurePosixPath

LINK = re.compile(r"(!?\[(?:[^\[\]]|\[[^\]]*\])*\])\(([^)\s]+)\)")
DEFINITION = re.compile(r"^(\[[^\]]+\]): (\S+)$")
FENCE = re.compile(r"^\s*(```|~~~)")


class BrokenLinkError(Exception):
    """A link leads to nothing; the message names page, line and target."""


def rewrite(text: str, source: str, place: str, pages: Mapping[str, str], root: Path) -> str:
    """Return Markdown with its relative links changed to those of the site.

    A link to a page of the site leads to that page, one to another file to the file itself, and of one to a folder the
    words stay. Code blocks are left alone.

    Args:
        text: The Markdown.
        source: Where it stands in the repository.
        place: Where it stands on the site, relative to the folder that Sphinx reads.
        pages: Pages of the site, perhaps with ``#anchor``, by the files of the repository that they are made from.
        root: The repository.

    Raises:
        BrokenLinkError: A target is not there.
    """
    lines, in_code = [], False
    for number, line in enumerate(text.split("\n"), 1):
        if FENCE.match(line):
            in_code = not in_code
        if not in_code:
            where = f"{source}:{number}"

            def inline(found: re.Match[str], where: str = where) -> str:
                target = _target(found[2], source, place, pages, root, where)
                return found[1][1:-1] if target is None else f"{found[1]}({target})"

            def defined(found: re.Match[str], where: str = where) -> str:
                return f"{found[1]}: {_target(found[2], source, place, pages, root, where)}"

            line = DEFINITION.sub(defined, LINK.sub(inline, line))
        lines.append(line)
    return "\n".join(lines)


def _target(given: str, source: str, place: str, pages: Mapping[str, str], root: Path, where: str) -> str | None:
    """Return the target of a link on the site, None for a folder."""
    if re.match(r"[a-z]+:|#|\{", given):
        return given
    name, _, anchor = given.partition("#")
    file = os.path.normpath((PurePosixPath(source).parent / name).as_posix())
    if (page := pages.get(file)) is not None:
        found, _, own = page.partition("#")
        anchor = anchor or own
        return _relative(found, place) + (f"#{anchor}" if anchor else "")
    if (root / file).is_dir():
        return None
    if not (root / file).is_file():
        raise BrokenLinkError(f"{where}: there is no {given}")
    return _relative(file.removeprefix("docs/") if file.startswith("docs/") else f"files/{file}", place)


def _relative(target: str, place: str) -> str:
    return Path(os.path.relpath(target, PurePosixPath(place).parent)).as_posix()
