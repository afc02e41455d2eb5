"""Writes recorded episodes as one self-contained HTML file that replays them."""

import html
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from irsim_gym.rendering.looks.files import whole_file
from irsim_gym.rendering.replay import page_parts
from irsim_gym.rendering.replay.replay_data import Recording
from irsim_gym.rendering.replay.replay_items import SharedItems
from irsim_gym.rendering.scene import vocabulary

SCHEMA, VERSION = "irsim_gym replay", 2


def save_html(path: str | Path, recordings: Sequence[Recording], title: str = "") -> Path:
    """Write episodes to a page with play controls, zoom and a plot of reward terms; return its path.

    The page embeds its data, deflated and in base64: ``schema``, ``version``, ``title``, ``theme`` (constants of the
    drawing vocabulary for the script), ``pens``, ``shapes`` and ``pictures`` (without duplicates), and ``episodes``,
    see `Recording`.

    Args:
        path: File to write, ``.html``; missing folders are created.
        recordings: The episodes, in the order of the page's list.
        title: Heading of the page; by default, that of the first episode.

    Raises:
        ValueError: If there are no episodes, an episode is empty, or the suffix is not supported.
    """
    target = Path(path)
    if target.suffix.lower() not in (".html", ".htm"):
        raise ValueError(f"a replay's name ends in .html, got '{target.name}'")
    if not recordings:
        raise ValueError("a replay needs an episode")
    data = _recorded(recordings, title)
    parts = page_parts.player_parts()
    parts["script"] += f"\n{page_parts.page_part('start.js')}"
    parts |= {"title": html.escape(data["title"]), "kind": ' class="player"', "body": parts["player"]}
    parts["data"] = page_parts.held("data", page_parts.deflated(data))
    with whole_file(target) as part:
        part.write_text(page_parts.whole_page(parts), encoding="utf-8")
    return target


def _recorded(recordings: Sequence[Recording], title: str) -> dict[str, Any]:
    """Return the data of a page."""
    shared = SharedItems()
    episodes = [recording.data(shared) for recording in recordings]
    about = {"schema": SCHEMA, "version": VERSION, "title": title or episodes[0]["title"]}
    return {**about, "theme": vocabulary.page_constants(), **shared.data(), "episodes": episodes}
