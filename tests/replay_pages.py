"""What replay pages hold."""

import base64
import re
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.outside_files import json_text
from irsim_gym.rendering.replay.replay_page import SCHEMA, VERSION

HELD = re.compile(r'<script type="application/octet-stream" id="([\w-]+)">([^<]*)</script>')


def held_data(path: str | Path) -> dict[str, str]:
    """Return all data that a page embeds, by name."""
    return dict(HELD.findall(Path(path).read_text(encoding="utf-8")))


def inflated(text: str) -> dict[str, Any]:
    """Return the data that ``deflated`` packed."""
    return json_text(zlib.decompress(base64.b64decode(text, validate=True)))


def main_data(parts: Mapping[str, str], schema: str, version: int) -> dict[str, Any]:
    """Return the main data of a page, which must say its schema and version."""
    data = inflated(parts["data"])
    assert (data["schema"], data["version"]) == (schema, version)
    return data


def read_html(path: str | Path) -> dict[str, Any]:
    """Return the data of a page that ``save_html`` wrote."""
    return main_data(held_data(path), SCHEMA, VERSION)


def unpacked(data: Mapping[str, Any], count: int) -> Floats:
    """Return the numbers that were packed, shape ``(count, width)``."""
    values: Sequence[int | None] = data["values"]
    table = np.array([np.nan if value is None else value for value in values], np.float64).reshape(-1, data["width"])
    # Missing numbers add 0, so the next difference still counts from the latest number.
    sums = np.where(np.isnan(table), np.nan, np.cumsum(np.nan_to_num(table), axis=0)) * data["unit"]
    return np.array(np.broadcast_to(sums, (count, data["width"])) if len(sums) == 1 else sums)
