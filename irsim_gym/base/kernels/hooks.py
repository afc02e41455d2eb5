"""Whether Numba's internals are as this package knows them.

Kernels compile and load several times faster through some names that Numba does not document. They may change with any
release. This module decides whether they are used. Where they are not, ``numba.njit(cache=True)`` compiles the kernels
with the options that results depend on, and steps call one kernel after the other; the bits are the same.
"""

import functools
import importlib
import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numba

KNOWN = "0.62 to 0.68"
"""The releases of Numba that are tested; ``pyproject.toml`` allows these alone."""
SWITCH = "IRSIM_GYM_PLAIN_NUMBA"
"""The environment variable that turns all hooks off."""
LOWERED = (
    "_alloca_var _find_singly_assigned_variable _lower_call_normal delvar fold_call_args getvar loadvar lower_assign "
    "lower_binop lower_expr lower_getitem lower_setitem storevar"
)
NAMES = {
    "llvmlite.binding": ("parse_assembly", "parse_bitcode", "object_file.ObjectFileRef.from_data"),
    "numba.core.analysis": ("compute_cfg_from_blocks", "compute_use_defs"),
    "numba.core.cgutils": ("alloca_once", "pointer_add"),
    "numba.core.codegen": (
        "JITCodeLibrary._ensure_finalized",
        "JITCodeLibrary._finalize_dynamic_globals",
        "JITCodeLibrary._finalize_final_module",
        "JITCodeLibrary._get_compiled_object",
        "JITCodeLibrary._optimize_final_module",
        "JITCodeLibrary._optimize_functions",
        "JITCodeLibrary.add_ir_module",
        "JITCodeLibrary.enable_object_caching",
        "JITCodeLibrary.serialize_using_bitcode",
        "JITCodeLibrary.serialize_using_object_code",
    ),
    "numba.core.compiler": (
        "Compiler.define_pipelines",
        "CompileResult._reduce",
        "CompileResult._rebuild",
        "DefaultPassBuilder.define_nopython_pipeline",
    ),
    "numba.core.compiler_lock": ("global_compiler_lock",),
    "numba.core.compiler_machinery": ("PassManager._ENFORCING", "register_pass"),
    "numba.core.lowering": tuple(f"Lower.{name}" for name in LOWERED.split()),
    "numba.core.options": ("DefaultOptions._nrt", "DefaultOptions.forceinline"),
    "numba.core.registry": ("cpu_target",),
    "numba.core.runtime.nrt": ("rtsys.initialize",),
    "numba.core.serialize": ("dumps",),
    "numba.core.targetconfig": ("ConfigStack.top_or_none",),
    "numba.core.typed_passes": ("BaseNativeLowering.run_pass",),
    "numba.core.typing.context": ("BaseContext.resolve_function_type",),
    "numba.np.arrayobj": ("fix_integer_index", "load_item", "store_item"),
}
"""The internals that the other modules use, by module."""


def are_usable() -> bool:
    """Return whether Numba's internals may be used: they are as expected, none failed, and the user allows it."""
    return not _failures() and not is_plain() and _are_known()


def is_plain() -> bool:
    """Return whether the user asks for Numba's plain way."""
    return os.environ.get(SWITCH, "0") not in ("", "0")


def give_up(why: str) -> None:
    """Use none of Numba's internals from now on, and warn once.

    Args:
        why: What Numba lacks, or how it failed.
    """
    if not _failures():
        _failures().append(why)
        _warn(why)


@contextmanager
def without(error: Exception) -> Iterator[None]:
    """Run the body without hooks, after one has failed; give them up if the body succeeds.

    If the body fails too, the error is the kernel's.
    """
    why = f"failed with {type(error).__name__}: {error}"
    is_first = not _failures()
    # Written before the body runs, so that ``are_usable`` is False within it.
    _failures().append(why)
    try:
        yield
    except BaseException:
        _failures().remove(why)
        raise
    if is_first:
        _warn(why)


def _warn(why: str) -> None:
    warnings.warn(
        f"numba {numba.__version__} {why}; irsim_gym is tested with numba {KNOWN}. Kernels are compiled in Numba's "
        "plain way: results stay the same, but the first start takes twice as long, and steps of few worlds several "
        f"times as long ({SWITCH}=1 hides this warning)",
        RuntimeWarning,
        stacklevel=3,
    )


@functools.cache
def _failures() -> list[str]:
    """Return why hooks are not used in this process; each call returns the same list."""
    return []


@functools.cache
def _are_known() -> bool:
    gone = missing()
    if gone:
        give_up(f"lacks {', '.join(gone)}")
    return not gone


def missing() -> list[str]:
    """Return which of ``NAMES`` this Numba lacks."""
    found = [_first_missing(module, name) for module, names in NAMES.items() for name in names]
    return list(dict.fromkeys(filter(None, found)))


def _first_missing(module: str, name: str) -> str:
    """Return the part of a dotted name that is not there, '' if all of it is."""
    place = module
    try:
        found: Any = importlib.import_module(module)
        for part in name.split("."):
            place += f".{part}"
            found = getattr(found, part)
    except (ImportError, AttributeError):
        return place
    return ""
