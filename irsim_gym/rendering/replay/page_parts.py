"""Builds HTML pages from scripts, styles and data, each page as one file."""

import base64
import json
import re
import zlib
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from irsim_gym.base.outside_files import json_text

PLAYER = ("data", "primitives", "world", "chart", "player", "input")
"""Scripts of the player, in the order of their dependencies."""
HELD = re.compile(r'<script type="application/octet-stream" id="([\w-]+)">([^<]*)</script>')


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
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts[found[1]], page)


def held(name: str, text: str) -> str:
    """Return the element that embeds data in a page; ``held_data`` reads it."""
    return f'<script type="application/octet-stream" id="{name}">{text}</script>'


def held_data(path: Path) -> dict[str, str]:
    """Return all data that a page embeds, by name."""
    return dict(HELD.findall(path.read_text(encoding="utf-8")))


def deflated(data: object) -> str:
    """Return plain data as JSON, deflated and in base64, which needs no escaping in a page."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return base64.b64encode(zlib.compress(text.encode(), 9)).decode()


def inflated(text: str) -> dict[str, Any]:
    """Return the data that ``deflated`` packed; call it within ``reading``."""
    return json_text(zlib.decompress(base64.b64decode(text, validate=True)))


def main_data(parts: Mapping[str, str], schema: str, version: int) -> dict[str, Any]:
    """Return the main data of a page; call it within ``reading``.

    Args:
        parts: What ``held_data`` returned for the page.
        schema: What the data says of itself.
        version: Its version.

    Raises:
        ValueError: They are of another page.
    """
    data = inflated(parts["data"]) if "data" in parts else {}
    if (data.get("schema"), data.get("version")) != (schema, version):
        raise ValueError(f"it holds no data of schema '{schema}', version {version}")
    return data
