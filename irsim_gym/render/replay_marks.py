"""What a replay remembers of the marks that somebody drew over a world."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.colors import to_hex

from irsim_gym.render.packing import METRE, packed
from irsim_gym.render.replay_tracks import Changes
from irsim_gym.render.styles import faded
from irsim_gym.world.marks import LineMark, Mark, Overlay, PointsMark, TextMark


def overlay_data(overlays: Sequence[Overlay]) -> dict[str, Any]:
    """Return what was drawn over a world as JSON.

    Args:
        overlays: What lay over it at each moment.

    Returns:
        ``titles``: changes; and ``marks``, in the order of drawing. A mark has ``spans`` (first moments, and those
        after the last ones, at which it is seen), ``layer``, ``colour``, ``alpha``, and beside ``points`` (packed) and
        their ``count`` either ``width``, ``style``, ``closed`` and ``fill`` of a line, or ``size``, ``form`` and
        ``width`` of points, or ``text``, ``size`` and ``align``. What is drawn anew just as it was is one mark.
    """
    titles, marks = Changes(), list[dict[str, Any]]()
    known: dict[int, int] = {}
    equal: dict[Any, list[int]] = {}
    for moment, overlay in enumerate(overlays):
        titles.note(moment, overlay.title)
        if moment and overlay is overlays[moment - 1]:
            for mark in overlay.marks:
                marks[known[id(mark)]]["spans"][-1][1] = moment + 1
            continue
        taken = set[int]()
        for mark in overlay.marks:
            number = known.get(id(mark), -1)
            if number < 0:
                look = _key(mark)
                alike = equal.setdefault(look, [])
                number = next((one for one in alike if one not in taken), len(marks))
                if number == len(marks):
                    marks.append({**_data(mark), "spans": []})
                    alike.append(number)
                known[id(mark)] = number
            taken.add(number)
            _extend(marks[number]["spans"], moment)
    return {"titles": titles.list, "marks": marks}


def _extend(spans: list[list[int]], moment: int) -> None:
    """Add a moment to the spans of moments at which a mark is seen."""
    if spans and spans[-1][1] >= moment:
        spans[-1][1] = moment + 1
    else:
        spans.append([moment, moment + 1])


def _key(mark: Mark) -> Any:
    """Return what makes a mark look as it does."""
    look: list[Any] = [type(mark)]
    for name, value in vars(mark).items():
        if name == "form":
            look.append(tuple(map(id, value)))
        else:
            look.append(value.tobytes() if isinstance(value, np.ndarray) else value)
    return tuple(look)


def _data(mark: Mark) -> dict[str, Any]:
    match mark:
        case LineMark():
            fill, opacity = faded(mark.fill or "none", mark.alpha)
            own = {
                "points": mark.points,
                "width": mark.width,
                "style": mark.style,
                "closed": mark.closed,
                "fill": to_hex(fill) if opacity > 0.0 else "",
                "fill_alpha": opacity,
            }
        case PointsMark():
            form = [np.round(part, 4).ravel().tolist() for part in mark.form]
            own = {"points": mark.points, "size": mark.size, "form": form, "width": mark.width}
        case TextMark():
            own = {"points": [[mark.x, mark.y]], "text": mark.text, "size": mark.size, "align": mark.align}
    colour, alpha = faded(mark.color, mark.alpha)
    points = np.asarray(own["points"])
    return {
        **own,
        "points": packed(points, METRE),
        "count": len(points),
        "colour": to_hex(colour),
        "alpha": alpha,
        "layer": mark.layer,
    }
