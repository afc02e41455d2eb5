"""The forms of markers, which are those of matplotlib."""

from functools import cache

import numpy as np
from matplotlib.markers import MarkerStyle

from irsim_gym.base.arraytypes import Floats


@cache
def marker_form(marker: str) -> tuple[Floats, ...]:
    """Return the corners of a marker's parts in a square with the side 1 about the origin, ``(k, 2)`` each."""
    style = MarkerStyle(marker)
    path = style.get_path().transformed(style.get_transform())
    return tuple(np.asarray(part, np.float64) for part in path.to_polygons(closed_only=False))
