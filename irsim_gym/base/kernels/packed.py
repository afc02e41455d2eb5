"""Entries to kernels that find their arguments in memory, packed beforehand as machine words.

Numba's functions take an array as seven words or more, most of them on the stack, where most are never read. A packed
entry takes one address instead, and loads what the kernel needs; the kernel is inlined into it before anything is
optimised. All that is on disk is the entry's machine code, which loads twenty times as fast as Numba's own files.
"""

import functools
import hashlib
import itertools
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numba
from llvmlite import binding
from numba.core import codegen, registry, types
from numba.core.compiler_lock import global_compiler_lock

from irsim_gym.base.compiled.cache import Files, files_of
from irsim_gym.base.kernels.layout import entry_code
from irsim_gym.base.kernels.passes import EntryCompiler

Library: Any = codegen.JITCodeLibrary
target: Any = registry.cpu_target
ENVIRONMENT = "_ZN08NumbaEnv"
_numbers = itertools.count()


class PackedEntries:
    """The packed entries of one kernel: one for each signature and layout of words.

    An entry takes the address of the words, the address of the worlds, and their number; it returns Numba's status.

    Args:
        function: The kernel.
        options: How it is compiled.
    """

    def __init__(self, function: Any, options: Mapping[str, Any]) -> None:
        self._function = function
        self._options = options
        self._addresses: dict[tuple[Any, str], int] = {}
        self._places: dict[tuple[Any, str], tuple[Files, Path] | None] = {}

    def __len__(self) -> int:
        return len(self._addresses)

    def address(self, signature: tuple[Any, ...], layout: str, compile_ahead: Callable[[], None] | None = None) -> int:
        """Return the address of an entry, loaded or compiled if need be; 0 where the kernel returns a value.

        Args:
            signature: Numba's types of the arguments.
            layout: A letter for each word, of which ``layout.WORLDS`` and ``layout.COUNT`` are marks.
            compile_ahead: Called if the entry is not on disk; may compile it together with others.
        """
        if compile_ahead is not None and self.is_missing(signature, layout):
            compile_ahead()
        return self.find(signature, layout, waits=True) or 0

    def is_missing(self, signature: tuple[Any, ...], layout: str) -> bool:
        """Return whether an entry could be on disk and is not."""
        place = None if (signature, layout) in self._addresses else self._place(signature, layout)
        return place is not None and not place[1].exists()

    def find(self, signature: tuple[Any, ...], layout: str, *, waits: bool) -> int | None:
        """Return the address of an entry, see ``address``.

        Args:
            signature: See ``address``.
            layout: See ``address``.
            waits: Whether to wait for another process that compiles it; if not, the result is None then.
        """
        address = self._addresses.get((signature, layout))
        if address is None:
            with global_compiler_lock:
                address = self._find(signature, layout, waits)
            if address is not None:
                self._addresses[signature, layout] = address
        return address

    def _place(self, signature: tuple[Any, ...], layout: str) -> tuple[Files, Path] | None:
        """Return where an entry is on disk; None where nothing can be kept."""
        if (signature, layout) not in self._places:
            files = files_of(self._function, self._options, f"packed {layout}")
            generator = target.target_context.codegen()
            self._places[signature, layout] = None if files is None else (files, files.file(signature, generator))
        return self._places[signature, layout]

    def _find(self, signature: tuple[Any, ...], layout: str, waits: bool) -> int | None:
        generator = target.target_context.codegen()
        place = self._place(signature, layout)
        if place is None:
            return self._compile(signature, layout, f"packed_{next(_numbers)}")[0]
        files, file = place
        # The file's name tells the entry from all others; its folder is left out, because it may be moved.
        name = f"packed_{hashlib.blake2b(file.name.encode(), digest_size=10).hexdigest()}"
        entry = _load(generator, name, files.read(file))
        # Found without the lock; the second look below finds what another process wrote while this one waited.
        if entry is not None:
            return entry
        with files.lock(file, waits=waits) as is_held:
            entry = _load(generator, name, files.read(file))
            if entry is not None or not (waits or is_held):
                return entry
            address, code = self._compile(signature, layout, name)
            if code is not None:
                files.write(file, code)
        return address

    def _compile(self, signature: tuple[Any, ...], layout: str, name: str) -> tuple[int, bytes | None]:
        """Return the address of a new entry, and its machine code; None if that cannot be kept."""
        pipeline: Any = functools.partial(PackedCompiler, layout, name)
        dispatcher: Any = numba.njit(**self._options, pipeline_class=pipeline)(self._function)
        dispatcher.compile(signature)
        compiled = dispatcher.overloads[signature]
        # An empty file says that the kernel returns a value, so that it is not compiled again to find out.
        if compiled.signature.return_type != types.none:
            return 0, b""
        library = compiled.library
        return library.get_pointer_to_function(name), None if library.is_bound else library._get_compiled_object()


def _load(generator: Any, name: str, code: bytes | None) -> int | None:
    """Return the address of an entry in machine code, 0 if it is known that there is none; None without such code."""
    if not code:
        return None if code is None else 0
    engine: Any = generator._engine._ee
    engine.add_object_file(binding.object_file.ObjectFileRef.from_data(code))
    return int(engine.get_function_address(name)) or None


class PackedCompiler(EntryCompiler):
    """The compiler with fewer passes, and such a library for its results."""

    def __init__(self, layout: str, name: str, typing: Any, context: Any, library: Any, *rest: Any) -> None:
        super().__init__(typing, context, library or PackedLibrary(context.codegen(), name, layout), *rest)


class PackedLibrary(Library):  # type: ignore[misc]
    """Code with a packed entry as its only function.

    Attributes:
        is_bound: Whether the code needs Python objects of this process, as one that prints does.
    """

    def __init__(self, generator: Any, name: str, layout: str) -> None:
        super().__init__(generator, name)
        self.enable_object_caching()
        self.is_bound = False
        self._layout = layout

    def add_ir_module(self, ir_module: Any) -> None:
        """Add the kernel and its packed entry."""
        # The function with a body is the kernel. By Numba's calling convention, its first two arguments are the places
        # for the returned value and for an exception.
        kernel = next(item for item in ir_module.functions if not item.is_declaration)
        kernel.attributes.add("alwaysinline")
        super().add_ir_module(ir_module)
        types = ["ptr" if item.type.is_pointer else str(item.type) for item in kernel.args]
        self._final_module.link_in(binding.parse_assembly(entry_code(self.name, kernel.name, types, self._layout)))
        self._final_module.get_function(kernel.name).linkage = "internal"

    def _finalize_final_module(self) -> None:
        """Load the code as Numba does, and note whether it reads an environment, which holds Python objects."""
        # Every definition mentions its name once; a further mention is code that reads it.
        environments = [item.name for item in self._final_module.global_variables if item.name.startswith(ENVIRONMENT)]
        reads = environments and str(self._final_module).count(ENVIRONMENT) > len(environments)
        super()._finalize_final_module()
        self.is_bound = bool(reads or self._dynamic_globals)
