"""Dataclasses that kernels take as one argument: ``state.pose[w, b]``.

A kernel gets the address of a block of memory in which the fields stand as machine words, an array as its place, shape
and strides. Numba's own form for this, a named tuple, hands every field of it to every kernel as arguments of their
own: eleven kernels with all fields of ``Model`` and ``State`` took 9.0 s to compile, 2.1 s with this form and
2.1 s with arrays as arguments. In plain Python (``NUMBA_DISABLE_JIT=1``) kernels get the dataclass itself.
"""

from __future__ import annotations

import dataclasses
import hashlib
import struct
from array import array
from typing import Any

import numpy as np
from llvmlite import ir
from numba import extending, types
from numba.core.typing import templates, typeof

WORD = ir.IntType(64)
PACKED = "_numba_type_", "address"
"""What Numba asks of a struct: its type, and where its block is."""

Words = list[tuple[str, int]]
numba_type: Any = typeof.typeof
extend: Any = extending
Template: Any = templates.AttributeTemplate


class Struct:
    """Base of dataclasses that kernels read: the fields are arrays, numbers, flags, None, tuples and other structs.

    A field that is replaced is known to the next call from Python. Recorded calls have to be recorded again
    (``Simulation.rewire``), as for any array that is replaced.
    """

    def __setattr__(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)
        for packed in PACKED:
            self.__dict__.pop(packed, None)

    def __getattr__(self, name: str) -> Any:
        if name not in PACKED:
            raise AttributeError(f"'{type(self).__name__}' object has no attribute '{name}'")
        self.__dict__.update(zip(PACKED, self._pack(), strict=True))
        return self.__dict__[name]

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name not in (*PACKED, "_blocks")}

    def _pack(self) -> tuple[StructType, int]:
        declared: Any = dataclasses.fields(self)  # type: ignore[arg-type]
        values = {entry.name: getattr(self, entry.name) for entry in declared}
        kinds = tuple((name, numba_type(value, typeof.Purpose.argument)) for name, value in values.items())
        kind = StructType(type(self).__name__, kinds)
        words = array("q", [word for name, kind in kinds for _, word in words_of(kind, values[name])])
        # Earlier blocks stay: a recorded call may still hold their addresses.
        self.__dict__.setdefault("_blocks", []).append(words)
        return kind, words.buffer_info()[0]


class StructType(types.Type):
    """Numba's type of a struct.

    Args:
        fields: Names and types of the fields.

    Attributes:
        fields: Types of the fields by name.
        places: The first word of each field.
    """

    def __init__(self, name: str, fields: tuple[tuple[str, Any], ...]) -> None:
        self.fields = dict(fields)
        self.places: dict[str, int] = {}
        for field in self.fields:
            self.places[field] = sum(n_words(self.fields[earlier]) for earlier in self.places)
        # Numba puts the name into the symbols of all kernels, so it is short.
        digest = hashlib.blake2b(repr(fields).encode(), digest_size=8).hexdigest()
        super().__init__(name=f"{name}_{digest}")

    def word(self, build: Any, block: Any, name: str, k: int, kind: Any) -> Any:
        """Load a word of a field. Nobody writes into a block while a kernel runs: loads may move out of loops."""
        if k < 2 and isinstance(self.fields[name], types.Array):
            return ir.Constant(kind, None)  # owner and parent: there are none
        is_narrow = isinstance(kind, ir.IntType)
        place = build.gep(build.bitcast(block, WORD.as_pointer()), [ir.Constant(WORD, self.places[name] + k)])
        word = build.load(place if is_narrow else build.bitcast(place, kind.as_pointer()))
        word.set_metadata("invariant.load", build.module.add_metadata(()))
        return build.trunc(word, kind) if is_narrow and kind != WORD else word

    def part(self, context: Any, build: Any, block: Any, name: str, k: int, axis: int = 0) -> Any:
        """Load a part of an array: the one at place ``k`` of Numba's form, of an axis for shape and strides."""
        kind: Any = self.fields[name]
        field_type = context.get_value_type(kind).elements[k]
        place = k + axis if k < 6 else k - 1 + kind.ndim + axis
        return self.word(build, block, name, place, field_type if k < 5 else WORD)


extend.register_model(StructType)(extend.models.OpaqueModel)


@extend.typeof_impl.register(Struct)  # type: ignore[untyped-decorator]
def _type_of(value: Struct, context: Any) -> Any:
    return value._numba_type_


@extend.unbox(StructType)  # type: ignore[untyped-decorator]
def _unbox(kind: StructType, value: Any, context: Any) -> Any:
    """Return the address of the block."""
    number = context.pyapi.object_getattr_string(value, "address")
    address = context.pyapi.long_as_voidptr(number)
    context.pyapi.decref(number)
    return extend.NativeValue(address)


@extend.infer_getattr
class _FieldTypes(Template):  # type: ignore[misc]
    key = StructType

    def generic_resolve(self, kind: StructType, name: str) -> Any:
        """Return the type of a field."""
        return kind.fields.get(name)


@extend.lower_getattr_generic(StructType)  # type: ignore[untyped-decorator]
def _load(context: Any, build: Any, kind: StructType, block: Any, name: str) -> Any:
    """Load a field."""
    packer = context.get_arg_packer([kind.fields[name]])
    argument_types = packer.argument_types
    words = [kind.word(build, block, name, k, argument) for k, argument in enumerate(argument_types)]
    return packer.from_arguments(build, tuple(words))[0]


class NotPackableError(Exception):
    """A value cannot be taken apart into machine words."""


def n_words(kind: Any) -> int:
    """Return how many words a value of a type takes."""
    if isinstance(kind, types.Array):
        return 5 + 2 * int(kind.ndim)
    inside: Any = kind
    return sum([n_words(member) for member in inside.types]) if isinstance(kind, types.BaseTuple) else 1


def words_of(kind: Any, value: Any) -> Words:
    """Return a value as Numba passes it on: an array as owner, parent, size, item size, address, shape, strides.

    Nobody owns an array here: whoever packs it holds on to it.

    Raises:
        NotPackableError: Values of this type are not known.
    """
    if isinstance(kind, types.Array):
        return [("q", n) for n in (0, 0, value.size, value.itemsize, value.ctypes.data, *value.shape, *value.strides)]
    if isinstance(kind, types.BaseTuple):
        inside: Any = kind
        return [word for inner, item in zip(inside.types, value, strict=True) for word in words_of(inner, item)]
    if isinstance(kind, StructType):
        return [("q", value.address)]
    if isinstance(kind, types.Boolean):
        return [("b", int(value))]
    if kind == types.float64:
        return [("d", struct.unpack("q", struct.pack("d", value))[0])]
    if kind in (types.int64, types.uint64):
        return [("q", struct.unpack("q", struct.pack("Q", int(value) % 2**64))[0])]
    if kind == types.none:
        return [("q", 0)]
    raise NotPackableError(f"a value of type {kind}")


def record_type(numbers: str, lanes: int | None = None, **others: Any) -> np.dtype[np.record]:
    """Return the type of records, which kernels read and write by name: ``discs[k].x``.

    A record with rows of numbers in place of arrays of its own for each: the compiler sees that rows do not overlap,
    and need not test it before it makes a loop over them run in vector instructions.

    Args:
        numbers: Names of its numbers, separated by spaces.
        lanes: Each of them is a row of so many numbers.
        **others: Types of further fields by name.
    """
    number = np.dtype(np.float64) if lanes is None else np.dtype((np.float64, lanes))
    record: Any = np.dtype((np.record, [*((name, number) for name in numbers.split()), *others.items()]))
    return record  # type: ignore[no-any-return]
