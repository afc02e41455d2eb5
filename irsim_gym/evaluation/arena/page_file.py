"""Writes the page of an arena: one self-contained HTML file."""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from irsim_gym.evaluation.arena.board import Board
from irsim_gym.evaluation.arena.shown_episodes import ShownEpisode, count_failures

if TYPE_CHECKING:
    from irsim_gym.rendering.replay.replay_data import Recording

SCRIPTS = ("tables", "matrix", "arena")
MOST_BYTES = 40_000_000
"""Maximum total size of the replays: a larger page is slow to open."""


def write_page(
    path: Path,
    data: Mapping[str, Any],
    board: Board,
    recorded: Iterable[tuple[ShownEpisode, Recording | None]],
    chosen: Sequence[ShownEpisode],
) -> None:
    """Write the page.

    Beside its data, the page holds each replay separately, deflated and in base64, so that only viewed replays are
    unpacked. ``replays`` in the data gives the policy and level of each.

    Args:
        data: See `page_data`.
        board: Results of the policies.
        recorded: Episodes with their recordings; None for an episode that ended differently this time.
        chosen: All episodes that were chosen for the page.
    """
    from irsim_gym.rendering.looks import theme
    from irsim_gym.rendering.looks.files import whole_file
    from irsim_gym.rendering.replay.page_parts import deflated, filled, held, page_part, player_parts, whole_page
    from irsim_gym.rendering.replay.replay_items import SharedItems
    from irsim_gym.rendering.scene import vocabulary

    shared, told, texts, size, unlike, failed = SharedItems(), [], [], 0, 0, 0
    for shown, recording in recorded:
        if recording is None:
            unlike += 1
            continue
        text = deflated(recording.data(shared))
        size += len(text)
        if size > MOST_BYTES:
            break
        failed += not board.success[shown.policy, shown.level]
        told.append({"policy": shown.policy, "level": shown.level, "name": recording.name})
        texts.append(text)
    left = {"failures": count_failures(board), "shown": failed, "unlike": unlike}
    colours = {**theme.OUTCOMES, "deadlock": theme.RUNNING}
    constants = {"theme": vocabulary.page_constants(), "colours": colours, **shared.data()}
    parts = player_parts()
    parts["style"] += page_part("arena.css", __package__)
    parts["script"] += "".join(f"\n{page_part(f'{name}.js', __package__)}" for name in SCRIPTS)
    parts |= {"title": html.escape(data["title"]), "kind": ""}
    parts["body"] = filled(page_part("arena.html", __package__), parts)
    everything = deflated({**data, **constants, "replays": told, "left": left})
    replays = (held(f"replay-{i}", text) for i, text in enumerate(texts))
    parts["data"] = "\n".join((held("data", everything), *replays))
    with whole_file(path) as part:
        part.write_text(whole_page(parts), encoding="utf-8")
