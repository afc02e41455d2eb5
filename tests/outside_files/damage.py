"""Ways to damage a file: its bytes, the members of its archive, its JSON data, the lines of its text."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

Random = np.random.Generator
ODD: tuple[Any, ...] = (
    None,
    [],
    {},
    "x",
    "",
    -1,
    0,
    10**30,
    1e308,
    float("nan"),
    True,
    [[1]],
    {"a": [None]},
    "../x",
    "-1",
)
"""Values put in the place of others."""


def broken_bytes(content: bytes, random: Random) -> bytes:
    """Return content that is cut, changed, empty, doubled, or another file's."""
    place = int(random.integers(0, max(len(content), 1)))
    changed = bytearray(content)
    for spot in random.integers(0, max(len(content), 1), int(random.integers(1, 9))):
        changed[spot : spot + 1] = bytes([int(random.integers(0, 256))])
    ways: tuple[Callable[[], bytes], ...] = (
        lambda: content[:place],
        lambda: bytes(changed),
        lambda: bytes(changed),
        lambda: content[:place] + bytes(64) + content[place + 64 :],
        lambda: content[:place] + random.bytes(40) + content[place:],
        lambda: content[place:] + content[:place],
        lambda: (b"", b"hello", b"PK\x03\x04", b"\x80\x04.", b"\x00" * 500, b"[]", b"- 1\n")[place % 7],
    )
    return ways[int(random.integers(len(ways)))]()


def broken_archive(content: bytes, random: Random) -> bytes:
    """Return an archive with a member that is missing, renamed, of another content, or an array that is another."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    name = list(parts)[int(random.integers(len(parts)))]
    part = parts.pop(name)
    way = int(random.integers(6))
    if way == 0 and len(parts) == 0:
        way = 2
    if way == 1:
        parts[f"{name[:-4]}s{name[-4:]}"] = part
    elif way == 2:
        parts[name] = broken_bytes(part, random)
    elif way == 3 and not name.endswith(".npy"):
        parts[name] = _json_bytes(part, random)
    elif way >= 3 and name.endswith(".npy"):
        parts[name] = _other_array(part, random)
    room = io.BytesIO()
    with zipfile.ZipFile(room, "w", zipfile.ZIP_DEFLATED) as archive:
        for one, held in parts.items():
            archive.writestr(one, held)
    return room.getvalue()


def _json_bytes(part: bytes, random: Random) -> bytes:
    try:
        return broken_json(part, random)
    except ValueError:
        return broken_bytes(part, random)


def _other_array(part: bytes, random: Random) -> bytes:
    """Return the bytes of an array of another type, shape, or values, or with a header that lies."""
    array: Any = np.load(io.BytesIO(part), allow_pickle=False)
    if array.dtype.kind in "US" and random.random() < 0.6:
        text = bytes(array.item()) if array.dtype.kind == "S" and not array.ndim else str(array.ravel()[:1]).encode()
        return _npy(np.array(_json_bytes(text, random)))
    flat = np.zeros(array.shape) if array.dtype.kind in "US" else array.astype(np.float64)
    odd = flat.copy()
    if odd.size:
        odd.ravel()[random.integers(0, odd.size, 3)] = random.choice([np.nan, np.inf, -1.0, 1e300, -(2.0**62), 99.0])
    ways: tuple[Callable[[], bytes], ...] = (
        lambda: _npy(odd),
        lambda: _npy(odd.astype(array.dtype) if array.dtype.kind in "biuf" else odd),
        lambda: _npy(array[..., None]),
        lambda: _npy(array.ravel()),
        lambda: _npy(array[:0] if array.ndim else array.reshape(1)),
        lambda: _npy(np.array(array.T)),
        lambda: _npy(flat.astype(np.complex64)),
        lambda: _npy(flat.astype("U3")),
        lambda: _npy(np.array(3)),
        lambda: _npy(array[:-1] if array.ndim else array),
        lambda: _lying_header((12, 10**12, 3)),
        lambda: _lying_header((-3, 2)),
        lambda: part.replace(b"'descr': '<f8'", b"'descr': '<f8(").replace(b"'descr': '|b1'", b"'descr': '|O8'"),
        lambda: _npy(np.zeros(array.shape, [("a", "f8"), ("b", "i4")])),
    )
    with np.errstate(all="ignore"):
        return ways[int(random.integers(len(ways)))]()


def _npy(array: Any) -> bytes:
    room = io.BytesIO()
    np.save(room, array)
    return room.getvalue()


def _lying_header(shape: tuple[int, ...]) -> bytes:
    room = io.BytesIO()
    np.lib.format.write_array_header_1_0(room, {"descr": "<f8", "fortran_order": False, "shape": shape})
    return room.getvalue() + bytes(64)


def broken_json(content: bytes, random: Random) -> bytes:
    """Return JSON in which a value is another, or a key is missing, renamed or new."""
    data = json.loads(content)
    places = list(_places(data))
    if not places:
        return json.dumps(ODD[int(random.integers(len(ODD)))]).encode()
    for _ in range(int(random.integers(1, 3))):
        holder, key = places[int(random.integers(len(places)))]
        if isinstance(holder, list) and key >= len(holder):
            continue
        if random.random() < 0.25:
            holder.pop(key) if isinstance(holder, list) else holder.pop(key, None)
        else:
            holder[key] = ODD[int(random.integers(len(ODD)))]
    return json.dumps(data).encode()


def _places(data: Any) -> Iterator[tuple[Any, Any]]:
    """Yield the places of all values in nested data; those near the root more often."""
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in list(items):
        yield data, key
        yield from list(_places(value))[:40]


def broken_text(content: bytes, random: Random) -> bytes:
    """Return text in which a line is missing, doubled, moved, cut, or holds another word."""
    lines = content.decode().split("\n")
    filled = [k for k, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("#")]
    k = filled[int(random.integers(len(filled)))] if filled else 0
    words = lines[k].replace(",", " , ").split(" ")
    word = int(random.integers(len(words)))
    odd = (
        "",
        "[]",
        "{}",
        "-1",
        "x",
        "nan",
        ".inf",
        "1e400",
        "[1, [2]]",
        "{a: b}",
        "'",
        "&a",
        "*a",
        "!!python/x y",
        "\t",
        "null",
    )
    ways: tuple[Callable[[], list[str]], ...] = (
        lambda: lines[:k] + lines[k + 1 :],
        lambda: [*lines[:k], lines[k], *lines[k:]],
        lambda: [
            *lines[:k],
            " ".join([*words[:word], odd[int(random.integers(len(odd)))], *words[word + 1 :]]),
            *lines[k + 1 :],
        ],
        lambda: [
            *lines[:k],
            " ".join([*words[:word], odd[int(random.integers(len(odd)))], *words[word + 1 :]]),
            *lines[k + 1 :],
        ],
        lambda: [*lines[:k], lines[k][: int(random.integers(0, len(lines[k]) + 1))], *lines[k + 1 :]],
        lambda: [*lines[:k], f"  {lines[k]}", *lines[k + 1 :]],
        lambda: [*lines[:k], *lines[:k:-1]],
        lambda: [*lines[:k], lines[k].replace(",", ",,", 1), *lines[k + 1 :]],
    )
    return "\n".join(ways[int(random.integers(len(ways)))]()).encode()
