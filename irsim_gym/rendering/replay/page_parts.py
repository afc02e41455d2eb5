"""Builds HTML pages from scripts, styles and data, each page as one file."""

import base64
import json
import re
import zlib
from collections.abc import Mapping
from importlib.resources import files

PLAYER = ("data", "primitives", "world", "chart", "player", "input")
"""Scripts of the player, in the order of their dependencies."""


def page_part(name: str, package: str = "irsim_gym.rendering.replay") -> str:
    """Return the text of a file in a package's folder ``page``."""
    return (files(package) / "page" / name).read_text(encoding="utf-8")


def player_parts() -> dict[str, str]:
    """Return the player's ``style``, ``player`` (its elements) and ``script``, which starts nothing by itself."""
    script = "\n".join(page_part(f"{name}.js") for name in PLAYER)
    return {"style": page_part("page.css"), "player": page_part("player.html"), "script": script}


def whole_page(parts: Mapping[str, str]) -> str:
    """Return a page from ``title``, ``style``, ``kind`` (attributes of the body), ``body``, ``data`` and ``script``."""
    return filled(page_part("page.html"), parts)


def filled(page: str, parts: Mapping[str, str]) -> str:
    """Return a page with its parts in place of ``{{name}}``."""
    return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], page)


def held(name: str, text: str) -> str:
    """Return the element that embeds data in a page."""
    return f'<script type="application/octet-stream" id="{name}">{text}</script>'


def deflated(data: object) -> str:
    """Return plain data as JSON, deflated and in base64, which needs no escaping in a page."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return base64.b64encode(zlib.compress(text.encode(), 9)).decode()
