"""Every link of a built site leads to a file of it and to an anchor that is there; nothing is loaded from elsewhere."""

from __future__ import annotations

from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {("img", "src"), ("script", "src"), ("link", "href"), ("video", "src"), ("source", "src"), ("video", "poster")}


@dataclass
class Page(HTMLParser):
    """What a page links to.

    Attributes:
        anchors: Names that a link may lead to.
        links: Targets, with whether the browser loads them by itself.
        without_text: Pictures without alternative text.
    """

    anchors: set[str] = field(default_factory=set)
    links: list[tuple[str, bool]] = field(default_factory=list)
    without_text: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Keep what a tag says."""
        given = dict(attrs)
        self.anchors |= {value for key in ("id", "name") if (value := given.get(key))}
        for key in ("href", "src", "poster"):
            if value := given.get(key):
                self.links.append((value, (tag, key) in LOADED))
        if tag == "img" and not given.get("alt"):
            self.without_text.append(str(given.get("src")))


def broken_links(site: Path) -> list[str]:
    """Return what is wrong with the pages of a site: ``page: link``."""
    pages = {file: _read(file) for file in sorted(site.rglob("*.html")) if "_static" not in file.parts}
    wrong = []
    for file, page in pages.items():
        for link, is_loaded in page.links:
            said = _problem(file, link, is_loaded, pages)
            if said:
                wrong.append(f"{file.relative_to(site)}: {link}: {said}")
        wrong += [f"{file.relative_to(site)}: {name}: no alternative text" for name in page.without_text]
    return wrong


def anchors(file: Path) -> set[str]:
    """Return the names on a page that a link may lead to."""
    return _read(file).anchors


def _problem(file: Path, link: str, is_loaded: bool, pages: dict[Path, Page]) -> str:
    parts = urlsplit(link)
    if parts.scheme or parts.netloc:
        return "loaded from elsewhere" if is_loaded and parts.scheme != "data" else ""
    target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
    if not target.is_file():
        return "no such file"
    if parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].anchors:
        return "no such place"
    return ""


def _read(file: Path) -> Page:
    page = Page()
    page.feed(file.read_text(encoding="utf-8"))
    return page
