"""What a call resolves to, remembered: Numba looks through all meanings of an operator anew for each ``a + b``."""

import functools
from typing import Any

from numba.core import targetconfig, types

Flags: Any = targetconfig.ConfigStack


@functools.cache
def _signatures(flags: Any) -> dict[Any, Any]:
    """Return the signatures known under some flags; each call returns the same dictionary."""
    return {}


class Typing:
    """Numba's typing context, for one compilation: calls of Numba's own functions are resolved once in a process.

    Args:
        context: Numba's.
    """

    def __init__(self, context: Any) -> None:
        self._context = context
        # Under other flags, a function may have another implementation.
        self._known = _signatures(Flags.top_or_none())

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_function_type(self, func: Any, args: Any, kws: Any) -> Any:
        """Return the signature of a call; None if there is none."""
        if kws or not isinstance(func, types.Function):
            return self._context.resolve_function_type(func, args, kws)
        # Numba notes the implementation in the very object, so it is held here.
        key = id(func), tuple(args)
        if key not in self._known:
            signature = self._context.resolve_function_type(func, args, kws)
            if signature is None:
                return None
            self._known[key] = func, signature
        return self._known[key][1]
