"""What compiled code is made of: a digest of a function, of what it calls, and of the values it reads.

Comments, docstrings, annotations and line numbers do not enter compiled code, so they do not enter the digest.
"""

import functools
import hashlib
import sys
from collections.abc import Iterator
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

VERSIONED = {"llvmlite", "numba", "numpy"} | sys.stdlib_module_names
"""Modules whose version says enough."""


def function_key(function: FunctionType) -> str:
    """Return the digest of a Python function that is to be compiled.

    A value that has no other description than its address gives another key in each process: the function is compiled
    anew then, and never stale.
    """
    return hashlib.blake2b("\n".join(functions_of(function).values()).encode(), digest_size=16).hexdigest()


def functions_of(function: FunctionType) -> dict[FunctionType, str]:
    """Return a function and all that it calls, at any depth, with descriptions of what each is made of."""
    described: dict[FunctionType, str] = {}
    left = [function]
    while left:
        callee = left.pop()
        if callee not in described:
            described[callee], called = _description(callee)
            left += called
    return described


def type_key(kind: Any) -> str:
    """Return a text that identifies one of Numba's types: the type's own name lacks the names of a tuple's fields."""
    fields = getattr(kind, "fields", None)
    inside = [type_key(member) for member in kind.types] if hasattr(kind, "types") else []
    return f"{kind} {fields if isinstance(fields, tuple) else ''} {inside}" if fields or inside else str(kind)


@functools.cache
def _description(function: FunctionType) -> tuple[str, list[FunctionType]]:
    """Return what a function is made of, and the functions that it calls."""
    called: list[FunctionType] = []
    parts = [f"{function.__module__}.{function.__qualname__}", repr(function.__defaults__)]
    for cell in function.__closure__ or ():
        parts += _value(cell.cell_contents, set(), called)
    parts += _code(function.__code__, function, called)
    return "\n".join(parts), called


def _code(code: CodeType, function: FunctionType, called: list[FunctionType]) -> Iterator[str]:
    names = set(code.co_names)
    yield code.co_code.hex()
    yield repr((code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars, code.co_exceptiontable))
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _code(constant, function, called)
        else:
            yield repr(None if constant == function.__doc__ else constant)
    for name in sorted(names & function.__globals__.keys()):
        yield name
        yield from _value(function.__globals__[name], names, called)


def _value(value: Any, names: set[str], called: list[FunctionType]) -> Iterator[str]:
    """Yield descriptions of a value that a function reads; of a module, those of its attributes with such names."""
    # A kernel, or a dispatcher of Numba's, wraps the Python function.
    target = getattr(value, "__wrapped__", value)
    if isinstance(target, FunctionType):
        called.append(target)
        options = getattr(value, "_options", None) or getattr(value, "targetoptions", {})
        yield f"{target.__module__}.{target.__qualname__} {sorted(options.items(), key=str)}"
    elif isinstance(value, np.ndarray):
        yield f"{value.dtype} {value.shape} {hashlib.blake2b(value.tobytes()).hexdigest()}"
    elif isinstance(value, tuple | list):
        for item in value:
            yield from _value(item, names, called)
    elif isinstance(value, ModuleType):
        yield value.__name__
        if value.__name__.split(".")[0] not in VERSIONED:
            for name in sorted(names & vars(value).keys()):
                attribute = vars(value)[name]
                if not isinstance(attribute, ModuleType) or attribute.__name__.startswith(f"{value.__name__}."):
                    yield from _value(attribute, names, called)
    elif isinstance(value, type):
        yield f"{value.__module__}.{value.__qualname__} {getattr(value, '_fields', '')}"
        yield repr(getattr(value, "__members__", ""))
    else:
        yield repr(value)
