"""Links from highlighted sources back to the reference."""

from __future__ import annotations

import re
from pathlib import Path

from builder.check import anchors

BACK = re.compile(r'href="([^"#]+)#([^"]+)"(?=>\[docs\])')


def mend(site: Path) -> None:
    """Let each link of ``_modules`` lead to an anchor that is there.

    Sphinx builds these anchors from the first module that a name was met in, which is another one for names that are
    re-exported. The page is right; the anchor is the one of the page that ends alike.
    """
    known: dict[Path, set[str]] = {}
    for file in sorted((site / "_modules").rglob("*.html")):

        def mended(found: re.Match[str], file: Path = file) -> str:
            page = (file.parent / found[1]).resolve()
            there = known.setdefault(page, anchors(page))
            return f'href="{found[1]}{_anchor(found[2], there)}"'

        before = file.read_text(encoding="utf-8")
        if (after := BACK.sub(mended, before)) != before:
            file.write_text(after, encoding="utf-8")


def _anchor(wanted: str, there: set[str]) -> str:
    """Return the anchor that has most of the last names in common with the wanted one; nothing without one."""
    if wanted in there:
        return f"#{wanted}"
    names = wanted.split(".")
    for start in range(len(names)):
        alike = sorted(one for one in there if one.endswith("." + ".".join(names[start:])))
        if alike:
            return f"#{alike[0]}"
    return ""
