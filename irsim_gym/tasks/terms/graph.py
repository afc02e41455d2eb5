"""Computations as ONNX graphs: what an observation's kernel computes, for a robot that has neither Python nor Numba.

Each value has the batch as its first axis. Double precision is kept until places have been subtracted from each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Floats
from irsim_gym.simulator.world.names import Model
from irsim_gym.tasks.terms.term import Term

OPSET, IR_VERSION = 17, 8
BATCH = "batch"
Number = float | np.floating[Any] | NDArray[Any]


@dataclass(frozen=True, eq=False)
class Value:
    """A tensor of a graph; operators on values add nodes. Numbers become constants of the value's type."""

    graph: Graph
    name: str
    dtype: np.dtype[Any]

    def __add__(self, other: Value | Number) -> Value:
        return self._with("Add", other)

    def __sub__(self, other: Value | Number) -> Value:
        return self._with("Sub", other)

    def __rsub__(self, other: Number) -> Value:
        return self._alike(other)._with("Sub", self)

    def __mul__(self, other: Value | Number) -> Value:
        return self._with("Mul", other)

    def __truediv__(self, other: Value | Number) -> Value:
        return self._with("Div", other)

    def __rtruediv__(self, other: Number) -> Value:
        return self._alike(other)._with("Div", self)

    def __neg__(self) -> Value:
        return self.op("Neg")

    def __lt__(self, other: Value | Number) -> Value:  # type: ignore[misc]
        return self._with("Less", other, np.bool_)

    def __gt__(self, other: Value | Number) -> Value:  # type: ignore[misc]  # both sides are values here
        return self._with("Greater", other, np.bool_)

    def __ge__(self, other: Value | Number) -> Value:
        return self._with("GreaterOrEqual", other, np.bool_)

    def __and__(self, other: Value) -> Value:
        return self._with("And", other)

    def __or__(self, other: Value) -> Value:
        return self._with("Or", other)

    def __invert__(self) -> Value:
        return self.op("Not")

    def equals(self, other: Value | Number) -> Value:
        """Return where it equals another value."""
        return self._with("Equal", other, np.bool_)

    def least(self, other: Value | Number) -> Value:
        """Return the smaller of two values."""
        return self._with("Min", other)

    def most(self, other: Value | Number) -> Value:
        """Return the larger of two values."""
        return self._with("Max", other)

    def op(self, kind: str, dtype: Any = None, **attributes: Any) -> Value:
        """Return an operator of this value alone, of the same type or of ``dtype``."""
        if kind == "Cos":  # before 1.21, onnxruntime has none of float64
            return (self + 0.5 * np.pi).op("Sin")
        return self.graph.op(kind, [self], dtype or self.dtype, **attributes)

    def cast(self, dtype: Any) -> Value:
        """Return the value in another type."""
        return self if self.dtype == dtype else self.op("Cast", dtype, to=code_of(dtype))

    def columns(self, start: int, stop: int, axis: int = 1) -> Value:
        """Return some columns: a slice of the second axis, or of another."""
        ends = [self.graph.constant(np.array([k])) for k in (start, stop, axis)]
        return self.graph.op("Slice", [self, *ends], self.dtype)

    def take(self, indices: NDArray[Any]) -> Value:
        """Return columns by their numbers; a table of numbers gives one axis more."""
        return self.graph.op("Gather", [self, self.graph.constant(np.asarray(indices))], self.dtype, axis=1)

    def part(self, place: int) -> Value:
        """Return one number of each row of the last axis, which goes."""
        return self.graph.op("Gather", [self, self.graph.constant(np.array(place))], self.dtype, axis=-1)

    def first(self, count: int) -> Value:
        """Return where the smallest numbers of each row stand, ascending, ``(batch, count)``; equal ones in order."""
        return self.graph.op("TopK", [self, self.graph.constant(np.array([count]))], np.int64, largest=0)

    def at(self, places: Value) -> Value:
        """Return the second axis at places of each row's own, ``(batch, count)``."""
        return self.graph.op("GatherND", [self, places.spread(2)], self.dtype, batch_dims=1)

    def spread(self, axis: int) -> Value:
        """Return the value with another axis, of length 1."""
        return self.graph.op("Unsqueeze", [self, self.graph.constant(np.array([axis]))], self.dtype)

    def smallest(self, axis: int) -> Value:
        """Return the minimum along an axis, which goes."""
        return self.op("ReduceMin", axes=[axis], keepdims=0)

    def largest(self, axis: int) -> Value:
        """Return the maximum along an axis, which goes."""
        return self.op("ReduceMax", axes=[axis], keepdims=0)

    def between(self, low: Number, high: Number) -> Value:
        """Return the value within limits."""
        if np.unique(low).size > 1 or np.unique(high).size > 1:
            return self.most(low).least(high)
        return self.graph.op("Clip", [self, *(self._alike(np.max(limit)) for limit in (low, high))], self.dtype)

    def length(self, axis: int, *, keeps: bool = False) -> Value:
        """Return the lengths of vectors, whose components an axis has; it goes, or keeps one number."""
        # onnxruntime 1.17 has no ReduceL2 of float64.
        return self.op("ReduceSumSquare", axes=[axis], keepdims=int(keeps)).op("Sqrt")

    def unit(self) -> Value:
        """Return cosines and sines of angles [rad], ``(batch, 2)`` of ``(batch, 1)``."""
        return (self + np.array([0.5 * np.pi, 0.0])).op("Sin")

    def shaped(self, *shape: int) -> Value:
        """Return the value in another shape behind the axis of the batch."""
        return self.graph.op("Reshape", [self, self.graph.constant(np.array([0, *shape]))], self.dtype)

    def where(self, yes: Value, no: Value | Number) -> Value:
        """Return ``yes`` where it is true, else ``no``."""
        return self.graph.op("Where", [self, yes, yes._alike(no)], yes.dtype)

    def is_nan(self) -> Value:
        """Return where it is not a number."""
        return self.op("IsNaN", np.bool_)

    def times(self, matrix: Value | Number) -> Value:
        """Return the matrix product."""
        return self._with("MatMul", matrix)

    def _alike(self, other: Value | Number) -> Value:
        return other if isinstance(other, Value) else self.graph.constant(np.asarray(other, self.dtype))

    def _with(self, kind: str, other: Value | Number, dtype: Any = None) -> Value:
        return self.graph.op(kind, [self, self._alike(other)], dtype or self.dtype)


@dataclass
class Graph:
    """A graph under construction.

    Attributes:
        starts: What each state is before the first step, without the axis of the batch.
    """

    starts: dict[str, NDArray[Any]] = field(default_factory=dict)
    _nodes: list[tuple[str, list[str], list[str], dict[str, Any]]] = field(default_factory=list)
    _constants: dict[tuple[Any, ...], str] = field(default_factory=dict)
    _arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    _inputs: dict[str, tuple[np.dtype[Any], tuple[int | str, ...]]] = field(default_factory=dict)
    _outputs: dict[str, tuple[Value, tuple[int, ...]]] = field(default_factory=dict)

    def op(self, kind: str, inputs: Sequence[Value], dtype: Any, **attributes: Any) -> Value:
        """Add a node, and return its output of type ``dtype``; of TopK the places."""
        name = f"{kind.lower()}_{len(self._nodes)}"
        outputs = [f"{name}_values", name] if kind == "TopK" else [name]
        self._nodes.append((kind, [value.name for value in inputs], outputs, attributes))
        return Value(self, name, np.dtype(dtype))

    def constant(self, array: NDArray[Any]) -> Value:
        """Return a constant; equal ones are stored once."""
        key = (array.dtype.str, array.shape, array.tobytes())
        name = self._constants.setdefault(key, f"constant_{len(self._constants)}")
        self._arrays[name] = array
        return Value(self, name, array.dtype)

    def input(self, name: str, dtype: Any, *shape: int | str) -> Value:
        """Return an input of shape ``(batch, *shape)``; an axis with a name has any length."""
        self._inputs[name] = (np.dtype(dtype), shape)
        return Value(self, name, np.dtype(dtype))

    def state(self, name: str, start: NDArray[Any]) -> Value:
        """Return what was kept under a name in the last step; ``start`` before the first one."""
        self.starts[name] = start
        return self.input(name, start.dtype, *start.shape)

    def keep(self, name: str, value: Value) -> None:
        """Keep a state for the next step: the output ``NAME_next``."""
        self.output(f"{name}_next", value, *self.starts[name].shape)

    def output(self, name: str, value: Value, *shape: int) -> None:
        """Name an output, of shape ``(batch, *shape)``."""
        self._outputs[name] = (value, shape)

    def join(self, values: Sequence[Value], axis: int = 1) -> Value:
        """Return values side by side."""
        return values[0] if len(values) == 1 else self.op("Concat", values, values[0].dtype, axis=axis)

    def model(self, name: str) -> Any:
        """Return the ``onnx.ModelProto``, without nodes and inputs that no output depends on."""
        from onnx import helper, numpy_helper

        fed = {*self._inputs, *self._arrays}
        names = {value.name: name for name, (value, _) in self._outputs.items() if value.name not in fed}
        needed, nodes, every = set(self._outputs), [], self._nodes.copy()
        for key, (value, _) in self._outputs.items():
            if names.get(value.name) != key:
                every.append(("Identity", [value.name], [key], {}))
        for kind, *ends, attributes in reversed(every):
            taken, found = ([names.get(end, end) for end in some] for some in ends)
            if needed.intersection(found):
                # Nodes have names: onnxruntime 1.19 merges nodes under names of theirs, and refuses two of the same.
                nodes.append(helper.make_node(kind, taken, found, name=found[-1], **attributes))
                needed.update(taken)
        inputs, outputs = (
            [helper.make_tensor_value_info(key, code_of(dtype), [BATCH, *shape]) for key, dtype, shape in some]
            for some in (
                [(key, *form) for key, form in self._inputs.items() if key in needed],
                [(key, value.dtype, shape) for key, (value, shape) in self._outputs.items()],
            )
        )
        arrays = [numpy_helper.from_array(array, key) for key, array in self._arrays.items() if key in needed]
        graph = helper.make_graph(nodes[::-1], name, inputs, outputs, arrays)
        return helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=IR_VERSION)


def code_of(dtype: Any) -> int:
    """Return ONNX's number of a type."""
    from onnx import helper

    return int(helper.np_dtype_to_tensor_dtype(np.dtype(dtype)))


@dataclass(frozen=True)
class RobotValues:
    """What a robot knows in a step, as values of a graph.

    Attributes:
        graph: The graph.
        ranges: Its scan [m], within [0, range_max], ``(batch, n_beams)``, float32.
        pose: Its pose [m, m, rad], ``(batch, 3)``, float64.
        velocity: The components of its velocity, in its own frame, ``(batch, n_components)``, float64.
        goal: Its goal [m, m, rad], the heading NaN where any will do, ``(batch, 3)``, float64.
        elapsed: Time since the last step [s], ``(batch, 1)``, float64.
        action: Its latest action in [-1, 1], ``(batch, n_components)``, float32.
        bodies: Other bodies as its tracker has them: x, y [m], their velocity [m/s] and their radius [m], in the frame
            of the pose, ``(batch, n, 5)``, float64; rows of NaN are absent.
    """

    graph: Graph
    ranges: Value
    pose: Value
    velocity: Value
    goal: Value
    elapsed: Value
    action: Value
    bodies: Value

    def ways(self, places: Value) -> Value:
        """Return the ways from its own place to others [m], in the axes of the world, ``(batch, n, 2)``."""
        return places - self.pose.columns(0, 2).spread(1)

    def turned(self, ways: Value) -> Value:
        """Return vectors in the axes of its own frame, ahead and to the left, ``(batch, n, 2)``."""
        return ways.times(rotation(self.pose.columns(2, 3)))

    def direction(self, way: Value) -> Value:
        """Return cosine and sine of the direction of one way, ``(batch, 1, 2)``: straight ahead without a way."""
        d = way.length(2)
        return (d > 0.0).where(self.turned(way).op("Flatten") / d, np.array([1.0, 0.0]))

    def others(self, count: int) -> Value:
        """Return other bodies as in ``bodies``, but places from its own on; the last ``count`` rows are absent."""
        absent = self.elapsed.spread(2) * 0.0 + np.full((count, 5), np.nan)
        place = self.pose.times(np.diag([1.0, 1.0, 0.0]) @ np.eye(3, 5))
        return self.graph.join([self.bodies, absent]) - place.spread(1)

    def turned_rows(self, rows: Value) -> Value:
        """Return rows of ``others`` in the axes of its own frame."""
        heading, aside = self.pose.columns(2, 3).spread(2), np.zeros((5, 5))
        aside[[0, 1, 2, 3], [1, 0, 3, 2]] = [-1.0, 1.0, -1.0, 1.0]
        turn = heading.op("Cos") * np.diag([1.0, 1.0, 1.0, 1.0, 0.0]) + heading.op("Sin") * aside
        return rows.times(turn + np.diag([0.0, 0.0, 0.0, 0.0, 1.0]))

    def constant(self, numbers: Sequence[float] | NDArray[Any]) -> Value:
        """Return the same float32 numbers for each row of the batch, ``(batch, n)``."""
        nothing = self.elapsed.is_nan().cast(np.float32) * 0.0
        return nothing + np.asarray(numbers, np.float32)


@runtime_checkable
class HasGraph(Protocol):
    """An observation with a twin in ONNX operators."""

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return its columns for one agent, as ``write`` writes them, ``(batch, width)``, float32.

        Limits and sizes are those of the first world.
        """


def rotation(angle: Value, *shape: int) -> Value:
    """Return matrices that turn rows of vectors to the right, and columns to the left, ``(batch, *shape, 2, 2)``.

    Args:
        angle: By how much [rad], ``(batch, *shape, 1)``.
        shape: Its shape without the first and the last axis.
    """
    return (angle + np.array([0.5, 1.0, 0.0, 0.5]) * np.pi).op("Sin").shaped(*shape, 2, 2)


def sector_flags(places: Value, count: int) -> Value:
    """Return in which sector around the robot each place lies, ``(..., count, n)``; the first begins straight behind.

    Args:
        places: How far ahead and to the left each place is [m], ``(..., 2, n)``; of NaN it lies nowhere.
        count: Number of sectors.
    """
    return _sector_depths(places, count) >= 0.0


def sector_minima(values: Value, places: Value, count: int) -> Value:
    """Return the smallest value of the places in each sector, ``(..., count)``; huge, or at least 0, where none lies.

    Args:
        values: One of each place, ``(..., 1, n)``.
        places: As for ``sector_flags``.
        count: Number of sectors.
    """
    # ``Max`` takes a third of the time of ``Where``; a power of two rounds nothing.
    return values.most(_sector_depths(places, count) * -(2.0**100)).smallest(-1)


def _sector_depths(places: Value, count: int) -> Value:
    """Return how deep each place lies in each sector, ``(..., count, n)``; negative outside."""
    # A place lies in a sector if it is as far along the middle of it as on its edges, or farther. A place on an edge
    # belongs to the sector that begins there, whatever is rounded.
    middle = 2.0 * np.pi * (np.arange(count) + 0.5) / count - np.pi - 1e-12
    edge = np.full(count, -np.cos(np.pi / count) if count > 1 else 2.0)
    sectors = places.graph.constant(np.stack([np.cos(middle), np.sin(middle), edge], axis=1))
    return sectors.times(places.graph.join([places, places.length(-2, keeps=True)], axis=-2))


def between_edges(x: Value, y: Value, edges: Floats) -> Value:
    """Return between which edges each place lies, ``(batch, n_edges - 1, n)``.

    Args:
        x: How far ahead each place is [m], ``(batch, n)``.
        y: How far to the left it is [m].
        edges: Ascending angles [rad]; neighbours are at most half a turn apart.
    """
    # A place on an edge belongs to the sector that begins there, whatever is rounded.
    turned = x.graph.constant(np.stack([-np.sin(edges - 1e-12), np.cos(edges - 1e-12)], axis=1).astype(x.dtype))
    begun = turned.times(x.graph.join([x.spread(1), y.spread(1)])) >= 0.0
    return begun.columns(0, len(edges) - 1) & ~begun.columns(1, len(edges))
