"""Collections of patches and how they are coloured."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.collections import PathCollection

Colour = tuple[float, float, float, float]


def empty_collection(axes: Axes) -> Any:
    """Add an empty collection of paths in world coordinates, which no full draw of the figure shows."""
    collection: Any = PathCollection([], transform=axes.transData, animated=True)
    collection.set(capstyle="round", joinstyle="round")
    # With two entries a lone path is not drawn as if it were a marker, which is slower.
    collection.set_antialiased([True, True])
    axes.add_collection(collection, autolim=False)
    return collection


def paint(collection: Any, fills: Sequence[Colour], edges: Sequence[Colour]) -> None:
    """Give each path its colours; without any, none is seen."""
    collection.set_facecolors(fills or [(0.0,) * 4])
    collection.set_edgecolors(edges or [(0.0,) * 4])
