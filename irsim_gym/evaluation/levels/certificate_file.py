"""How a certificate is written: numbers as multiples of a unit in as few bytes as they need, in planes of bytes."""

import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Floats, Ints
from irsim_gym.base.outside_files import json_text, npz_arrays
from irsim_gym.evaluation.byte_planes import from_planes, layout_of, to_planes

FORMAT = 2
"""Format 1 has each array under its own name, as ``Certificate`` has it."""
WHOLE = ("hash", "reachable", "outcome")
NUMBERS = {"straight": 2, "length": 2, "clearance": 2, "least_time": 3, "density": 3, "time": 3}
"""Digits after the point that are kept: the way that is found is itself up to 1 % longer than the shortest."""
BASES = {"length": "straight", "time": "least_time"}
"""Numbers that are stored as the difference from others, which is small."""
NO_NUMBER, NO_END = 0, 1
"""How NaN and infinity are stored; finite numbers follow."""
FINITE = 2

Numbers = NDArray[np.float32]
Arrays = Mapping[str, NDArray[Any]]


def certificate_bytes(said: Mapping[str, Any], arrays: Arrays) -> bytes:
    """Return the content of a certificate's file."""
    packed, units = {name: arrays[name] for name in WHOLE}, {}
    for name in NUMBERS:
        packed[name], *units[name] = _packed(_last_digits(name, arrays), _base(name, arrays))
    about = {**said, "format": FORMAT, "layout": layout_of(packed), "units": units}
    text, room = np.array(json.dumps(about, sort_keys=True).encode()), io.BytesIO()
    np.savez_compressed(room, allow_pickle=False, about=text, planes=to_planes(packed))
    return room.getvalue()


def read_certificate_file(file: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return what a certificate says of all levels, and its arrays by name; call it within ``reading``.

    Raises:
        Exception: The file is no certificate, or one of a newer version; of nearly any class.
    """
    stored = npz_arrays(file)
    said = json_text(stored["about"].item())
    if said.get("format", 1) not in (1, FORMAT):
        raise ValueError(f"its format is {said['format']}, and this version of irsim_gym reads 1 and {FORMAT}")
    if "format" not in said:
        return said, {name: stored[name] for name in (*WHOLE, *NUMBERS)}
    return said, _unpacked(said, stored["planes"])


def rounded(values: Any, name: str) -> Numbers:
    """Return the numbers of an array as a certificate keeps them, of the shape of ``values``."""
    return np.round(np.asarray(values, np.float64), NUMBERS[name]).astype(np.float32)


def _last_digits(name: str, arrays: Arrays) -> Floats:
    """Return the numbers of an array, counted in their last digit."""
    return np.asarray(np.rint(arrays[name].astype(np.float64) * 10 ** NUMBERS[name]), np.float64)


def _base(name: str, arrays: Arrays) -> Ints:
    """Return from what the differences of an array are taken, in the last digit; 0 where that is no finite number."""
    if name not in BASES:
        return np.zeros((), np.int64)
    base = _last_digits(BASES[name], arrays)
    return np.where(np.isfinite(base), base, 0.0).astype(np.int64)


def _packed(digits: Floats, base: Ints) -> tuple[NDArray[Any], int, int]:
    """Return whole numbers in the narrowest type, their unit, and what the first finite one of them stands for."""
    finite = np.isfinite(digits)
    above = np.where(finite, digits, 0.0).astype(np.int64) - base
    least = int(above[finite].min(initial=above.max(initial=0)))
    unit = int(np.gcd.reduce(above[finite] - least, initial=0)) or 1
    places = np.where(np.isnan(digits), NO_NUMBER, NO_END)
    places[finite] = (above[finite] - least) // unit + FINITE
    return places.astype(np.min_scalar_type(int(places.max(initial=0)))), unit, least


def _unpacked(said: dict[str, Any], planes: NDArray[Any]) -> dict[str, NDArray[Any]]:
    units = said.pop("units")
    arrays = from_planes(said.pop("layout"), planes)
    for name in NUMBERS:
        places, (unit, least) = arrays[name].astype(np.int64), units[name]
        numbers = ((places - FINITE) * unit + least + _base(name, arrays)) / 10 ** NUMBERS[name]
        numbers[places == NO_NUMBER], numbers[places == NO_END] = np.nan, np.inf
        arrays[name] = numbers.astype(np.float32)
    return arrays
