"""Kernels that are called by address: arguments lie in memory, packed beforehand as machine words.

Numba's functions take an array as seven words or more, most of them on the stack, where most are never looked at. Here
a kernel becomes a part of its *doorway*, a function that finds all arguments at one address and loads what it needs;
this is compiled in place of the kernel, and all that is kept of it on disk is the machine code, which is loaded twenty
times as fast as Numba's own files.
"""

from __future__ import annotations

import functools
import hashlib
import itertools
from collections.abc import Mapping
from typing import Any

import numba
from llvmlite import binding
from numba.core import codegen, compiler, registry, types
from numba.core.compiler_lock import global_compiler_lock

from irsim_gym.jit_cache import files_of
from irsim_gym.jit_passes import pipelines

Library: Any = codegen.JITCodeLibrary
Compiler: Any = compiler.Compiler
target: Any = registry.cpu_target
WHERE, COUNT = "w", "n"
"""Marks in the order of a doorway's words: not these, but address and number of the worlds that it is called with."""
ENVIRONMENT = "_ZN08NumbaEnv"
_numbers = itertools.count()


class Doors:
    """The doorways of one kernel: one for each signature and order of words.

    The arguments of a doorway are the address of the words, that of the worlds, and their number; it returns Numba's
    status.

    Args:
        function: The kernel.
        options: How it is compiled.
    """

    def __init__(self, function: Any, options: Mapping[str, Any]) -> None:
        self._function = function
        self._options = options
        self._addresses: dict[tuple[Any, str], int] = {}

    def __len__(self) -> int:
        return len(self._addresses)

    def find(self, signature: tuple[Any, ...], order: str) -> int:
        """Return the address of a doorway, loaded or compiled if need be; 0 where the kernel gives something back.

        Args:
            signature: Numba's types of the arguments.
            order: A letter for each word, of which ``WHERE`` and ``COUNT`` are marks.
        """
        address = self._addresses.get((signature, order))
        if address is None:
            with global_compiler_lock:
                address = self._addresses[signature, order] = self._find(signature, order)
        return address

    def _find(self, signature: tuple[Any, ...], order: str) -> int:
        machine = target.target_context.codegen()
        files = files_of(self._function, self._options, f"door {order}")
        if files is None:
            return self._compile(signature, order, f"door_{next(_numbers)}")[0]
        file = files.file(signature, machine)
        # The whole name, as kernels with the same types have the same digest; not the folder, which may be moved.
        name = f"door_{hashlib.blake2b(file.name.encode(), digest_size=10).hexdigest()}"
        found = _load(machine, name, files.read(file))
        if found is not None:
            return found
        with files.lock(file):
            found = _load(machine, name, files.read(file))
            if found is not None:
                return found
            address, made = self._compile(signature, order, name)
            if made is not None:
                files.write(file, made)
        return address

    def _compile(self, signature: tuple[Any, ...], order: str, name: str) -> tuple[int, bytes | None]:
        """Return the address of a new doorway, and its machine code; None if that cannot be kept."""
        pipeline: Any = functools.partial(DoorCompiler, order, name)
        dispatcher: Any = numba.njit(**self._options, pipeline_class=pipeline)(self._function)
        dispatcher.compile(signature)
        compiled = dispatcher.overloads[signature]
        if compiled.signature.return_type != types.none:
            return 0, b""
        library = compiled.library
        return library.get_pointer_to_function(name), None if library.is_bound else library._get_compiled_object()


def _load(machine: Any, name: str, code: bytes | None) -> int | None:
    """Return the address of a doorway in machine code, 0 if it is known that there is none; None without such code."""
    if not code:
        return None if code is None else 0
    engine: Any = machine._engine._ee
    engine.add_object_file(binding.object_file.ObjectFileRef.from_data(code))
    return int(engine.get_function_address(name)) or None


class DoorCompiler(Compiler):  # type: ignore[misc]
    """Numba's compiler, whose results go into such a library."""

    def __init__(self, order: str, name: str, typing: Any, context: Any, library: Any, *rest: Any) -> None:
        super().__init__(typing, context, library or DoorLibrary(context.codegen(), name, order), *rest)

    def define_pipelines(self) -> list[Any]:
        """Return the passes, by Numba's name for them."""
        return pipelines(self.state)


class DoorLibrary(Library):  # type: ignore[misc]
    """Code with a doorway as its only entry.

    Attributes:
        is_bound: Whether the code needs Python objects of this process, as one that prints does.
    """

    def __init__(self, machine: Any, name: str, order: str) -> None:
        super().__init__(machine, name)
        self.enable_object_caching()
        self.is_bound = False
        self._order = order

    def add_ir_module(self, ir_module: Any) -> None:
        """Add the kernel, and its doorway."""
        super().add_ir_module(ir_module)
        kernel = next(one for one in ir_module.functions if not one.is_declaration)
        given = ["ptr" if one.type.is_pointer else str(one.type) for one in kernel.args]
        self._final_module.link_in(binding.parse_assembly(doorway(self.name, kernel.name, given, self._order)))
        inside = self._final_module.get_function(kernel.name)
        inside.linkage = "internal"
        inside.add_function_attribute("alwaysinline")

    def _finalize_final_module(self) -> None:
        """Load the code, as Numba does, and see whether it reads an environment, where Python objects are kept."""
        environments = [one.name for one in self._final_module.global_variables if one.name.startswith(ENVIRONMENT)]
        reads = environments and str(self._final_module).count(ENVIRONMENT) > len(environments)
        super()._finalize_final_module()
        self.is_bound = bool(reads or self._dynamic_globals)


def doorway(name: str, kernel: str, given: list[str], order: str) -> str:
    """Return a doorway in LLVM's language, as text: LLVM's objects in Python take four times as long.

    Args:
        name: Its name.
        kernel: That of the function behind it.
        given: The types of the function's arguments; the first two are the places for its value and an exception.
        order: A letter for each other argument.
    """
    lines = ["%value = alloca i64", "%error = alloca i64"]
    handed = [f"{given[0]} %value", f"{given[1]} %error"]
    for k, (kind, mark) in enumerate(zip(given[2:], order, strict=True)):
        if mark == WHERE:
            lines.append(f"%word{k} = inttoptr i64 %where to {kind}")
        elif mark != COUNT:
            lines.append(f"%at{k} = getelementptr i64, ptr %words, i64 {k}")
            if kind == "i8":
                lines += [f"%wide{k} = load i64, ptr %at{k}", f"%word{k} = trunc i64 %wide{k} to i8"]
            else:
                lines.append(f"%word{k} = load {kind}, ptr %at{k}")
        handed.append(f"{kind} %count" if mark == COUNT else f"{kind} %word{k}")
    lines.append(f'%status = call i32 @"{kernel}"({", ".join(handed)})')
    head = f'declare i32 @"{kernel}"({", ".join(given)})\ndefine i32 @{name}(ptr %words, i64 %where, i64 %count) {{'
    return "\n".join([head, *lines, "ret i32 %status", "}"])
