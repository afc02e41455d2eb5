"""What kernels read and write of the structs that they are given, read from their syntax trees.

``python tests/kernel_access.py`` writes it into their docstrings, where ``test_architecture`` looks for it.
"""

from __future__ import annotations

import ast
import re
import textwrap
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "irsim_gym"
LINE = 120


Root = tuple[str, str]
"""A parameter, and the field of it, which is empty for a parameter that is an array."""


@dataclass
class Kernel:
    """A compiled function.

    Attributes:
        file: Where it is.
        tree: Its definition.
        names: What the names of kernels in its file stand for.
        structs: Its parameters that are structs.
        reads: What it reads, itself or through other kernels.
        writes: What it writes.
    """

    file: Path
    tree: ast.FunctionDef
    names: dict[str, tuple[str, str]]
    structs: set[str]
    reads: set[Root] = field(default_factory=set)
    writes: set[Root] = field(default_factory=set)

    @property
    def parameters(self) -> list[str]:
        return [one.arg for one in self.tree.args.args]

    def expected(self) -> str:
        """Return the lines that its docstring has to hold."""
        lines = ("Reads", {root for root in self.reads if root[1]}), ("Writes", self.writes)
        return "\n".join(_line(word, roots, self) for word, roots in lines if roots)

    def found(self) -> str:
        """Return the lines that its docstring holds."""
        _, lines = _separated(ast.get_docstring(self.tree, clean=False) or "")
        return "\n".join(lines)


def _separated(docstring: str) -> tuple[str, list[str]]:
    """Return a docstring without the lines on what is read and written, and these lines."""
    kept, taken, is_inside = [], [], False
    for line in docstring.split("\n"):
        is_inside = line.startswith(("    Reads: ", "    Writes: ")) or (is_inside and line.startswith(" " * 8))
        (taken if is_inside else kept).append(line)
    return re.sub(r"\n\n\n+", "\n\n", "\n".join(kept)), taken


def _line(word: str, roots: set[Root], kernel: Kernel) -> str:
    given = [(name, sorted(one for at, one in roots if at == name)) for name in kernel.parameters]
    parts = [f"{name} ({', '.join(fields)})" if all(fields) else name for name, fields in given if fields]
    return textwrap.fill(f"{word}: {', '.join(parts)}.", LINE, initial_indent="    ", subsequent_indent="        ")


@cache
def kernels() -> dict[tuple[str, str], Kernel]:
    """Return all kernels by module and name, with what they read and write."""
    texts = {file: file.read_text(encoding="utf-8") for file in sorted(PACKAGE.rglob("*.py"))}
    trees = {file: ast.parse(text) for file, text in texts.items() if "@kernel" in text}
    structs = _struct_classes(texts.values())
    vocabulary = _imported(ast.parse(texts[PACKAGE / "simulator/world/names.py"]))
    modules = "irsim_gym.simulator.world.names", "irsim_gym.tasks.terms"
    passed_on = {(module, name): origin for module in modules for name, origin in vocabulary.items()}
    found = {}
    for file, tree in trees.items():
        module = ".".join(file.relative_to(PACKAGE.parent).with_suffix("").parts)
        names = {name: passed_on.get(origin, origin) for name, origin in _imported(tree).items()}
        here = [node for node in tree.body if isinstance(node, ast.FunctionDef) and _is_kernel(node)]
        names |= {node.name: (module, node.name) for node in here}
        for node in here:
            given = {
                one.arg
                for one in node.args.args
                if one.annotation and ast.unparse(one.annotation).split(".")[-1] in structs
            }
            found[module, node.name] = Kernel(file, node, names, given)
    _propagate(found)
    return found


def _imported(tree: ast.Module) -> dict[str, tuple[str, str]]:
    """Return module and name of what a file imports, by its name there."""
    imports = [node for node in tree.body if isinstance(node, ast.ImportFrom)]
    return {name.asname or name.name: (node.module or "", name.name) for node in imports for name in node.names}


def _is_kernel(function: ast.FunctionDef) -> bool:
    return any(ast.unparse(one).split("(")[0] == "kernel" for one in function.decorator_list)


def _struct_classes(texts: Iterable[str]) -> set[str]:
    """Return the names of the classes that derive from ``Struct``."""
    classes = [found.groups() for text in texts for found in re.finditer(r"^class (\w+)\((\w+)\):", text, re.MULTILINE)]
    names, before = {"Struct"}, 0
    while len(names) > before:
        before = len(names)
        names |= {name for name, base in classes if base in names}
    return names


def _propagate(found: dict[tuple[str, str], Kernel]) -> None:
    """Look at all kernels until what they call adds nothing more."""
    changed = True
    while changed:
        changed = False
        for kernel in found.values():
            before = len(kernel.reads) + len(kernel.writes)
            _Look(kernel, found).visit_body()
            changed = changed or len(kernel.reads) + len(kernel.writes) > before


class _Look(ast.NodeVisitor):
    """Reads one kernel."""

    def __init__(self, kernel: Kernel, found: dict[tuple[str, str], Kernel]) -> None:
        self._kernel, self._found = kernel, found
        self._roots: dict[str, Root] = {name: (name, "") for name in kernel.parameters if name not in kernel.structs}

    def visit_body(self) -> None:
        for node in self._kernel.tree.body:
            self.visit(node)

    def _root(self, node: ast.AST) -> Root | None:
        """Return what an expression is a part of."""
        while isinstance(node, ast.Subscript | ast.Attribute):
            inner = node.value
            if isinstance(node, ast.Attribute) and isinstance(inner, ast.Name) and inner.id in self._kernel.structs:
                return inner.id, node.attr
            node = inner
        return self._roots.get(node.id) if isinstance(node, ast.Name) else None

    def _note(self, root: Root | None, *, reads: bool = False, writes: bool = False) -> None:
        if root is not None and reads:
            self._kernel.reads.add(root)
        if root is not None and writes:
            self._kernel.writes.add(root)

    def visit_Assign(self, node: ast.Assign) -> None:
        for target in node.targets:
            pairs = [(target, node.value)]
            if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                pairs = list(zip(target.elts, node.value.elts, strict=True))
            for one, value in pairs:
                self._assign(one, value)

    def _assign(self, target: ast.AST, value: ast.AST) -> None:
        if isinstance(target, ast.Name):
            root = self._root(value) if isinstance(value, ast.Subscript | ast.Attribute | ast.Name) else None
            if root is not None:
                self._roots[target.id] = root
                self._indices(value)
                return
        elif isinstance(target, ast.Tuple):
            for one in target.elts:
                self._assign(one, ast.Constant(None))
        else:
            self._note(self._root(target), writes=True)
            self._indices(target)
        self.visit(value)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        if not isinstance(node.target, ast.Name):
            self._note(self._root(node.target), reads=True, writes=True)
            self._indices(node.target)
        self.visit(node.value)

    def _indices(self, node: ast.AST) -> None:
        while isinstance(node, ast.Subscript | ast.Attribute):
            if isinstance(node, ast.Subscript):
                self.visit(node.slice)
            node = node.value

    def visit_Subscript(self, node: ast.Subscript) -> None:
        if not self._is_shape(node.value):
            self._note(self._root(node), reads=True)
        self._indices(node)
        if self._root(node) is None:
            self.visit(node.value)

    def visit_Attribute(self, node: ast.Attribute) -> None:
        if node.attr != "shape" and self._root(node) is not None:
            self._note(self._root(node), reads=True)
        elif not self._is_shape(node):
            self.generic_visit(node)

    @staticmethod
    def _is_shape(node: ast.AST) -> bool:
        return isinstance(node, ast.Attribute) and node.attr == "shape"

    def visit_Name(self, node: ast.Name) -> None:
        self._note(self._roots.get(node.id), reads=True)

    def visit_Call(self, node: ast.Call) -> None:
        module, _, name = ast.unparse(node.func).rpartition(".")
        key = self._kernel.names.get(module or name)
        if module and key is not None:
            key = (".".join(key), name)
        called = self._found.get(key) if key else None
        if called is None:
            self.generic_visit(node)
            return
        given = dict(zip(called.parameters, node.args, strict=False))
        given |= {one.arg: one.value for one in node.keywords if one.arg}
        for name, value in given.items():
            self._hand_over(called, name, value)

    def _hand_over(self, called: Kernel, name: str, value: ast.expr) -> None:
        """Note what a called kernel does with one of its arguments."""
        is_struct = isinstance(value, ast.Name) and value.id in self._kernel.structs
        root = self._root(value)
        if not is_struct and root is None:
            self.visit(value)
            return
        self._indices(value)
        for at, one in called.reads | called.writes:
            if at == name:
                here = (value.id, one) if is_struct and isinstance(value, ast.Name) else root
                self._note(here, reads=(at, one) in called.reads, writes=(at, one) in called.writes)


def main() -> None:
    """Write into all docstrings what their kernels read and write."""
    everyone = list(kernels().values())
    for file in sorted({kernel.file for kernel in everyone}):
        text = file.read_text(encoding="utf-8")
        here = [kernel for kernel in everyone if kernel.file == file and kernel.structs]
        for kernel in sorted(here, key=lambda one: -one.tree.lineno):
            if kernel.expected() != kernel.found():
                text = _rewritten(text, kernel)
        file.write_text(text, encoding="utf-8")


def _rewritten(text: str, kernel: Kernel) -> str:
    lines = text.splitlines(keepends=True)
    node = kernel.tree.body[0]
    docstring = "".join(lines[node.lineno - 1 : node.end_lineno])
    inside = docstring.strip().removeprefix('"""').removesuffix('"""').rstrip()
    inside = _separated(inside)[0].rstrip()
    match = re.search(r"\n\n    (Args|Returns|Raises):\n", inside)
    at = match.start() if match else len(inside)
    new = f'    """{inside[:at]}\n\n{kernel.expected()}{inside[at:]}\n    """\n'
    return "".join([*lines[: node.lineno - 1], new, *lines[node.end_lineno :]])


if __name__ == "__main__":
    main()
