"""array: a map given as a table of numbers."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from irsim_gym.base.errors import OptionError
from irsim_gym.bodies.maps.level import CellsKind
from irsim_gym.simulator.world.names import Flags, kind, option

OCCUPIED_ABOVE = 50.0
"""Occupancy (0 to 100) above which a cell is occupied, as in IR-SIM."""


@kind
class ArrayMap(CellsKind):
    """Occupancies of 0 to 100, or truth values, by column from the left and row from the bottom."""

    is_random: ClassVar[bool] = False

    cells: Any = option(meaning="One list per column, from the left; each lists the rows from the bottom.")

    def occupied(self, width: float, height: float, name: str, find: Callable[[str], Path]) -> Flags:
        """Return which cells are occupied, shape ``(columns, rows)``.

        Raises:
            OptionError: If the cells are not a table of numbers.
        """
        try:
            table = np.array(self.cells)
        except ValueError:
            raise OptionError("cells", "must be columns of equal length") from None
        if table.ndim != 2 or table.size == 0 or table.dtype.kind not in "buif":
            shown = "x".join(str(length) for length in table.shape)
            raise OptionError("cells", f"must be a table of numbers, columns by rows, got one of size {shown or '1'}")
        if table.dtype.kind == "b":
            return np.asarray(table, np.bool_)
        if not np.all((table >= 0) & (table <= 100)):
            raise OptionError("cells", "must be occupancies from 0 to 100")
        if table.max() == 1 and np.isin(table, (0, 1)).all():
            raise OptionError(
                "cells", "contains only 0 and 1, but cells above 50 are occupied: use true and false, or 0 and 100"
            )
        return np.asarray(table > OCCUPIED_ABOVE)
