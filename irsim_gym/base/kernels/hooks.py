"""Whether Numba's internals are used.

Kernels compile and load several times faster through some names that Numba does not document. They may change with any
release. Once something about them fails, none is used any more: ``numba.njit(cache=True)`` compiles the kernels with
the options that results depend on, and steps call one kernel after the other; the bits are the same.
"""

import functools
import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import numba

KNOWN = "0.62 to 0.68"
"""The releases of Numba that are tested; ``pyproject.toml`` allows these alone."""
SWITCH = "IRSIM_GYM_PLAIN_NUMBA"
"""The environment variable that turns all hooks off."""


def are_usable() -> bool:
    """Return whether Numba's internals may be used: none failed, and the user allows it."""
    return not _failures() and not is_plain()


def is_plain() -> bool:
    """Return whether the user asks for Numba's plain way."""
    return os.environ.get(SWITCH, "0") not in ("", "0")


def give_up(why: str) -> None:
    """Use none of Numba's internals from now on, and warn once.

    Args:
        why: How it failed.
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
