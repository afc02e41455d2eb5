"""How a kernel of the package becomes LLVM's code: in half the instructions that Numba writes.

Numba writes an array with all its parts to the stack and reads it back for each element, and each variable that
another block reads, too. LLVM removes that again, which takes a third of a cold start. Here an element takes the parts
that it needs, an array in a struct is not loaded as a whole, and a variable with one value is that value. What is left
after LLVM's passes is the same.
"""

import operator
from collections import Counter
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import analysis, cgutils, lowering, typed_passes, types
from numba.core import ir as numba_ir
from numba.core.compiler_machinery import register_pass
from numba.np import arrayobj

Lower: Any = lowering.Lower
Lowering: Any = typed_passes.BaseNativeLowering
items: Any = arrayobj
pointers: Any = cgutils
NITEMS, DATA, SHAPE, STRIDES = 2, 4, 5, 6
"""Places of an array's parts in Numba's form of it; those before are its owner and parent, then the size of an item."""


class KernelValue:
    """An array of Numba, whose parts are made where they are needed.

    Args:
        kind: Numba's type of it.
        part: Makes the part at a place.
    """

    def __init__(self, kind: Any, part: Callable[..., Any]) -> None:
        self.kind = kind
        self.part = part

    def whole(self, context: Any, build: Any) -> Any:
        """Return the value in Numba's form."""
        form = context.get_value_type(self.kind)
        whole = ir.Constant(form, ir.Undefined)
        for k, element in enumerate(form.elements):
            for place in [(k, axis) for axis in range(element.count)] if isinstance(element, ir.ArrayType) else [(k,)]:
                whole = build.insert_value(whole, self.part(*place), place)
        return whole


POWERS = operator.pow, operator.ipow


class KernelLower(Lower):  # type: ignore[misc]
    """Numba's lowering for a kernel without reference counts, bounds checks and debug information."""

    def _find_singly_assigned_variable(self) -> None:
        """Find the variables with one assignment that comes before all uses, wherever these are."""
        self._parts: dict[str, Any] = {}
        self._blk_local_varmap: dict[str, Any] = {}
        made = Counter(one.target.name for block in self.blocks.values() for one in block.find_insts(numba_ir.Assign))
        uses = analysis.compute_use_defs(self.blocks)  # type: ignore[no-untyped-call]
        dominators = analysis.compute_cfg_from_blocks(self.blocks).dominators()  # type: ignore[no-untyped-call]
        places = {name: place for place, names in uses.defmap.items() for name in names if made[name] == 1}
        for place, names in uses.usemap.items():
            for name in names & places.keys():
                if places[name] >= place or places[name] not in dominators[place]:
                    del places[name]
        self._singly_assigned_vars = set(places)

    def loadvar(self, name: str) -> Any:
        """Return the value of a variable."""
        if name in self._parts:
            return self._parts[name].whole(self.context, self.builder)
        return super().loadvar(name)

    def storevar(self, value: Any, name: str, argidx: Any = None) -> None:
        """Give a variable its value."""
        if name in self._singly_assigned_vars:
            (self._parts if isinstance(value, KernelValue) else self._blk_local_varmap)[name] = value
            return
        self._alloca_var(name, self.typeof(name))
        whole = value.whole(self.context, self.builder) if isinstance(value, KernelValue) else value
        self.builder.store(whole, self.getvar(name))

    def delvar(self, name: str) -> None:
        """Do nothing: nothing is counted."""

    def lower_assign(self, ty: Any, inst: Any) -> Any:
        """Return the value of an assignment."""
        source = inst.value
        if isinstance(source, numba_ir.Var) and source.name in self._parts and self.typeof(source.name) == ty:
            return self._parts[source.name]
        return super().lower_assign(ty, inst)

    def lower_expr(self, resty: Any, expr: Any) -> Any:
        """Return the value of an expression."""
        if expr.op == "getattr" and isinstance(resty, types.Array):
            kind = self.typeof(expr.value.name)
            if hasattr(kind, "part") and kind.fields[expr.attr] == resty:
                block = self.loadvar(expr.value.name)
                return KernelValue(resty, lambda *at: kind.part(self.context, self.builder, block, expr.attr, *at))
        if expr.op == "getattr" and expr.attr == "shape" and isinstance(self.typeof(expr.value.name), types.Array):
            array = self._array(expr.value)
            return KernelValue(resty, lambda axis: array.part(SHAPE, axis)).whole(self.context, self.builder)
        if expr.op == "static_getitem" and isinstance(self.typeof(expr.value.name), types.Array) and expr.index_var:
            return self.lower_getitem(resty, expr, expr.value, expr.index_var, self.fndesc.calltypes[expr])
        return super().lower_expr(resty, expr)

    def lower_binop(self, resty: Any, expr: Any, op: Any) -> Any:
        """Return the value of an operation; that of two numbers, other than a power, is what it was resolved to."""
        signature, build = self.fndesc.calltypes[expr], self.builder
        if op in POWERS or not all(isinstance(argument, types.Number | types.Boolean) for argument in signature.args):
            return super().lower_binop(resty, expr, op)
        try:
            compute = self.context.get_function(self.context.typing_context.resolve_value_type(op), signature)
        except KeyError:  # Numba notes the implementation only when it resolves the operator again
            return super().lower_binop(resty, expr, op)
        values = [
            self.context.cast(build, self.loadvar(argument.name), self.typeof(argument.name), wanted)
            for argument, wanted in zip((expr.lhs, expr.rhs), signature.args, strict=True)
        ]
        return self.context.cast(build, compute(build, values), signature.return_type, resty)

    def lower_getitem(self, resty: Any, expr: Any, value: Any, index: Any, signature: Any) -> Any:
        """Return an element of an array, or a row."""
        found = self._place(value, index)
        if found is None:
            return super().lower_getitem(resty, expr, value, index, signature)
        array, address, n_axes = found
        if n_axes == array.kind.ndim:
            item = items.load_item(self.context, self.builder, array.kind, address)
            return self.context.cast(self.builder, item, array.kind.dtype, resty)

        def part(k: int, *axis: int) -> Any:
            if k == NITEMS:
                size, *more = [array.part(SHAPE, j) for j in range(n_axes, array.kind.ndim)]
                for value in more:
                    size = self.builder.mul(size, value)
                return size
            return address if k == DATA else array.part(k, *(n_axes + j for j in axis))

        return KernelValue(resty, part)

    def lower_setitem(self, target_var: Any, index_var: Any, value_var: Any, signature: Any) -> Any:
        """Write an element of an array."""
        found = self._place(target_var, index_var)
        if found is None or found[2] < found[0].kind.ndim:
            return super().lower_setitem(target_var, index_var, value_var, signature)
        array, address, _ = found
        value = self.loadvar(value_var.name)
        value = self.context.cast(self.builder, value, self.typeof(value_var.name), signature.args[2])
        value = self.context.cast(self.builder, value, signature.args[2], array.kind.dtype)
        return items.store_item(self.context, self.builder, array.kind, value, address)

    def _array(self, array: Any) -> KernelValue:
        """Return the parts of an array."""
        if array.name in self._parts:
            return self._parts[array.name]  # type: ignore[no-any-return]
        whole = self.loadvar(array.name)
        return KernelValue(self.typeof(array.name), lambda *place: self.builder.extract_value(whole, place))

    def _place(self, array: Any, index: Any) -> tuple[KernelValue, Any, int] | None:
        """Return an array, the address of its element or row, and for how many axes it is given; None for slices."""
        kind, given, build = self.typeof(array.name), self.typeof(index.name), self.builder
        kinds: Any = getattr(given, "types", (given,))
        if not isinstance(kind, types.Array) or isinstance(kind.dtype, types.NestedArray) or kind.layout not in "CA":
            return None
        if not kinds or not all(isinstance(index_kind, types.Integer) for index_kind in kinds):
            return None
        parts = self._array(array)
        numbers = self.loadvar(index.name)
        numbers = [build.extract_value(numbers, k) for k in range(len(kinds))] if kinds[0] is not given else [numbers]
        shape = [parts.part(SHAPE, axis) for axis in range(kind.ndim)]
        indices = [
            items.fix_integer_index(self.context, build, index_kind, number, size)
            for index_kind, number, size in zip(kinds, numbers, shape, strict=False)
        ]
        data = parts.part(DATA)
        if kind.layout == "C":
            place = indices[0]
            for axis in range(1, kind.ndim):
                place = build.mul(place, shape[axis])
                if axis < len(indices):
                    place = build.add(place, indices[axis])
            return parts, build.gep(data, [place]), len(indices)
        offset = build.mul(parts.part(STRIDES, 0), indices[0])
        for axis in range(1, len(indices)):
            offset = build.add(offset, build.mul(parts.part(STRIDES, axis), indices[axis]))
        return parts, pointers.pointer_add(build, data, offset), len(indices)


@register_pass(mutates_CFG=True, analysis_only=False)  # type: ignore[no-untyped-call]
class KernelLowering(Lowering):  # type: ignore[misc]
    """The pass that does so."""

    _name = "kernel_lowering"

    @property
    def lowering_class(self) -> Any:
        """The class that writes the code."""
        return KernelLower
