"""Reads files from outside: whatever is wrong with one ends as an error that names the file and the reason.

Errors of writing name their file too, and nothing is removed behind a link.

All files that other programs or other people may have written are read within ``reading``: damaged bytes make NumPy,
``zipfile``, ``zlib``, ``pickle`` and JSON raise errors of nearly any class. No file stays open.
"""

import io
import json
import math
import shutil
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.errors import IrsimGymError, MissingExtraError, ScenarioError, UnreadableFileError

T = TypeVar("T")
MOST_BYTES = 2**32
"""Largest size of the arrays in a file [bytes]."""
HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
"""Readers of the headers of arrays by version; the third is only for records with names that are not ASCII."""
KINDS = "biufUS"
"""Kinds of types that are read: numbers and text."""


@contextmanager
def reading(file: str | Path, kind: str) -> Iterator[None]:
    """Raise every error of the body as one that names the file; those that name a file already, and warnings, pass.

    Args:
        file: The file, or the folder.
        kind: What it should be, e.g. ``"certificate of levels"``.

    Raises:
        UnreadableFileError: The file cannot be read, or it is something else.
    """
    try:
        yield
    except (UnreadableFileError, ScenarioError, MissingExtraError, Warning):
        raise
    except Exception as problem:
        raise UnreadableFileError(str(file), kind, _reason(problem)) from problem


def _reason(problem: Exception) -> str:
    """Return what an error says of a file."""
    if isinstance(problem, FileNotFoundError):
        return "no such file"
    if isinstance(problem, OSError) and problem.strerror:
        return f"it cannot be read: {problem.strerror}"
    if isinstance(problem, KeyError) and not isinstance(problem, IrsimGymError):
        return f"{problem} is missing"
    if hasattr(problem, "errors"):  # pydantic's: each with its place
        return "; ".join(f"{'.'.join(map(str, item['loc']))}: {item['msg']}" for item in problem.errors())
    if isinstance(problem, MemoryError):
        return "it needs more memory than there is"
    if isinstance(problem, UnicodeDecodeError):
        return f"it is not UTF-8 text (byte 0x{problem.object[problem.start]:02x} at {problem.start:,})"
    if isinstance(problem, AttributeError | TypeError | AssertionError):
        return f"a value is of another kind or length than it must be ({problem or type(problem).__name__})"
    return str(problem) or type(problem).__name__


def json_object(file: Path) -> dict[str, Any]:
    """Return the JSON object in a text file; call it within ``reading``.

    Raises:
        ValueError: The file holds something else.
    """
    return json_text(file.read_text(encoding="utf-8"))


@cache
def word_tables(file: Path) -> dict[str, dict[str, str]]:
    """Return the tables of a file of this package, each from names to what is said of them.

    Args:
        file: A JSON file of tables, each from what is said to the names that it is said of, with spaces between.
    """
    tables = json_object(file)
    return {key: {name: text for text, names in rows.items() for name in names.split()} for key, rows in tables.items()}


def checked(value: T) -> T:
    """Return a dataclass made from a file, after checking the type of every field; call it within ``reading``.

    Raises:
        ValidationError: A value is of another type.
    """
    from pydantic import TypeAdapter

    TypeAdapter(type(value)).validate_python(vars(value))
    return value


def json_text(text: str | bytes) -> dict[str, Any]:
    """Return the JSON object in a text.

    Raises:
        ValueError: The text is something else.
    """
    data = json.loads(text)
    if not isinstance(data, dict):
        raise ValueError(f"it must be a JSON object, got {type(data).__name__}")
    return data


def npz_arrays(file: Path) -> dict[str, NDArray[Any]]:
    """Return the arrays of an ``.npz`` by name, of numbers or text; call it within ``reading``.

    Types, shapes and sizes are checked before an array is made, and nothing is unpickled.

    Raises:
        ValueError: A member is no array of numbers or text, or the arrays are too large.
        Exception: The file is no archive; of nearly any class.
    """
    arrays = {}
    with file.open("rb") as opened:
        if not zipfile.is_zipfile(opened):
            raise ValueError("it is no .npz file, an archive of arrays as np.savez writes it")
        with zipfile.ZipFile(opened) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
            if size > MOST_BYTES:
                raise ValueError(f"it holds {size / 1e9:.1f} GB, at most {MOST_BYTES / 1e9:.1f} GB")
            for entry in archive.infolist():
                arrays[entry.filename.removesuffix(".npy")] = _array(entry.filename, archive.read(entry))
    return arrays


def _array(name: str, content: bytes) -> NDArray[Any]:
    """Return the array in a member of an archive, which can be written to."""
    stream = io.BytesIO(content)
    try:
        shape, is_fortran, dtype = HEADERS[np.lib.format.read_magic(stream)](stream)
    except Exception as error:
        raise ValueError(f"{name} is no array as np.savez writes it ({error})") from None
    if dtype.kind not in KINDS:
        raise ValueError(f"{name} must hold numbers or text, got {dtype}")
    n_bytes, there = math.prod(shape) * dtype.itemsize, len(content) - stream.tell()
    if min(shape, default=0) < 0 or n_bytes != there:
        raise ValueError(f"{name} of {dtype} with shape {shape} needs {n_bytes:,} bytes, got {there:,}")
    flat = np.frombuffer(content, dtype, offset=stream.tell()) if n_bytes else np.zeros(0, dtype)
    return np.array(flat.reshape(shape, order="F" if is_fortran else "C"))


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Let each error of the file system name the file: that of a full disk does not."""
    try:
        yield
    except OSError as error:
        error.filename = str(path) if error.filename is None else error.filename
        raise


def remove(path: Path) -> None:
    """Remove a file, or a folder with all that it holds; of a link the link alone, so that nothing elsewhere goes."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
