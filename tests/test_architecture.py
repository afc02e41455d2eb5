"""The rules of the house (DESIGN.md), read from the syntax trees."""

from __future__ import annotations

import ast
import io
import subprocess
import sys
import tokenize
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from statistics import median

import pytest
from kernel_access import kernels

from irsim_gym.base.compiled.folder import GENERATORS

PACKAGE = Path(__file__).parents[1] / "irsim_gym"
OWN = "irsim_gym"
MOST_CODE_LINES = 53_000
"""Budget of the package, see DESIGN.md."""

FLOORS = {
    "base": 1,
    "scenario": 2,
    "simulator": 3,
    **dict.fromkeys(("bodies", "rendering"), 4),
    **dict.fromkeys(("tasks", "live"), 5),
    **dict.fromkeys(("envs", "plugins", "sb3", "rllib"), 6),
    "evaluation": 7,
    **dict.fromkeys(("training", "robot"), 8),
    "cli": 9,
}
"""A room imports from its own floor or below. Faces, which stand above, import what they show."""
HIGH_AND_APART = ("rendering", "tasks", "envs", "evaluation", "training", "robot")
APART = {
    **{room: {"bodies", "live", "plugins"} for room in HIGH_AND_APART},
    "bodies": {"rendering"},
    "live": {"bodies", "tasks"},
    "plugins": {"rendering", "live", "envs", "sb3", "rllib"},
    "cli": {"bodies", "plugins"},
}
"""Rooms that share no arrow, though their floors would allow it."""
NARROW = {
    ("bodies", "scenario"): ("scenario.specs.recordings", "scenario.specs.wander_goals", "scenario.reading.ros_map"),
    ("tasks", "rendering"): ("rendering.raster",),
    ("rendering", "simulator"): ("simulator.world", "simulator.readings"),
}
"""All that one room may import of another."""
FOREIGN = {
    "base": {"pydantic", "numba", "llvmlite", "rich"},
    "scenario": {"pydantic", "pydantic_core", "yaml", "PIL"},
    "simulator": {"numba", "llvmlite", "shapely"},
    "bodies": {"shapely", "PIL"},
    "rendering": {"matplotlib", "imageio_ffmpeg", "moviepy", "PIL", "rich", "IPython"},
    "tasks": {"pydantic", "pydantic_core", "onnx"},
    "live": {"shapely", "ompl"},
    "envs": {"gymnasium"},
    "evaluation": {"gymnasium", "rich", "scipy", "shapely", "pydantic", "yaml", "stable_baselines3", "torch"},
}
"""Libraries that a room may import beyond numpy; faces and the rooms above import what they are for."""
# Adapters to one library each: files whose place begins so.
ONLY_FILES = {
    "pettingzoo": "envs/teams/parallel",
    "stable_baselines3": "envs/sb3",
    "ray": "rllib.py",
    "torch": ("envs/sb3_learning/gru", "envs/sb3_learning/memory", "envs/teams/torch_rows"),
    "wrapt": "envs/gymnasium/registration",
    "rich": "envs/described/description_text",
}
MOST_FILES = 12
"""Of a folder, beside its ``__init__``."""
# These are slow to load: outside the places named here they are imported inside functions.
HEAVY = {
    "numba",
    "matplotlib",
    "pettingzoo",
    "torch",
    "stable_baselines3",
    "shapely",
    "moviepy",
    "imageio_ffmpeg",
    "rich",
    "PIL",
    "scipy",
    "onnx",
    "ompl",
}
FACES = {"__init__", "__main__", "irsim", "errors", "levels", "suite"}
LOADED_LATE = ("numba", "matplotlib", "pettingzoo", "torch", "stable_baselines3")
RENDER_FROM = {"envs", "evaluation", "live", "training", "cli"}
RASTER = "rendering.raster"

# Copied to where the package is not: they import only each other.
SCRIPTS = {
    "robot/drive.py",
    "robot/parts/perceive.py",
    "robot/parts/shield.py",
    "robot/scans.py",
    "robot/nodes/driving.py",
    *(f"robot/nodes/{ros}/policy_driver/node.py" for ros in ("ros1", "ros2")),
}

MAX_FILE_LINES = 400
MAX_FUNCTION_LINES = 60
MAX_KERNEL_LINES = 80
MAX_ARGUMENTS, MEDIAN_ARGUMENTS = 8, 4
"""Of kernels: values that belong together are one argument, such as a ``Point`` or a struct."""
# tasks/definition/checks.py compares a task with a scenario file, in the file's own words.
YAML_READERS = ("simulator/engine/compile", "tasks/definition/checks")
YAML_ONLY_NAMES = {"acce", "vel_min", "vel_max"}
MUTATORS = {"append", "extend", "insert", "add", "update", "setdefault", "pop", "popitem", "clear", "remove", "discard"}
RANDOM_OBJECTS = {"Generator", "SeedSequence", "BitGenerator", "PCG64", "default_rng"}


@dataclass(frozen=True, eq=False)
class Module:
    """One file of the package."""

    place: str
    text: str
    tree: ast.Module

    @cached_property
    def nodes(self) -> list[ast.AST]:
        """All nodes of its tree."""
        return list(ast.walk(self.tree))

    @property
    def part(self) -> str:
        """The room, or the name of a face."""
        return self.place.split("/")[0].removesuffix(".py")

    @property
    def name(self) -> str:
        """The dotted name below the package, '' for the package itself."""
        return self.place.removesuffix(".py").replace("/", ".").removesuffix("__init__").rstrip(".")

    @property
    def package(self) -> list[str]:
        """The dotted parts of the package that holds it."""
        return [OWN, *self.place.split("/")[:-1]]


@dataclass(frozen=True)
class Import:
    """One imported module."""

    module: str
    line: int
    deferred: bool
    for_types: bool


@cache
def modules() -> tuple[Module, ...]:
    files = sorted(file for file in PACKAGE.rglob("*.py") if "__pycache__" not in file.parts)
    places = [file.relative_to(PACKAGE).as_posix() for file in files]
    texts = [file.read_text(encoding="utf-8") for file in files]
    return tuple(Module(place, text, ast.parse(text, place)) for place, text in zip(places, texts, strict=True))


@cache
def names_of_modules() -> frozenset[str]:
    return frozenset(f"{OWN}.{module.name}" for module in modules())


@cache
def imports(module: Module) -> tuple[Import, ...]:
    return tuple(_imports(module, module.tree, deferred=False, for_types=False))


def _imports(module: Module, node: ast.AST, *, deferred: bool, for_types: bool) -> Iterator[Import]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import):
            for alias in child.names:
                yield Import(alias.name, child.lineno, deferred, for_types)
        elif isinstance(child, ast.ImportFrom):
            for name in _from_names(module, child):
                yield Import(name, child.lineno, deferred, for_types)
        else:
            in_function = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
            types_only = isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test)
            yield from _imports(module, child, deferred=deferred or in_function, for_types=for_types or types_only)


def _from_names(module: Module, node: ast.ImportFrom) -> list[str]:
    base = node.module or ""
    if node.level:
        above = module.package[: len(module.package) - node.level + 1]
        base = ".".join([*above, base] if base else above)
    found = [f"{base}.{alias.name}" for alias in node.names if f"{base}.{alias.name}" in names_of_modules()]
    return found if len(found) == len(node.names) else [*found, base]


def own(imported: Import) -> str | None:
    """Return the name below the package, or None for a module of others."""
    if imported.module == OWN:
        return ""
    return imported.module.removeprefix(OWN + ".") if imported.module.startswith(OWN + ".") else None


def is_allowed(module: Module, imported: Import) -> bool:
    inside, room = own(imported), module.part
    if inside is None:
        top = imported.module.split(".")[0]
        is_general = top in sys.stdlib_module_names or top == "numpy" or top in FOREIGN.get(room, {top})
        return is_general or (top in ONLY_FILES and module.place.startswith(ONLY_FILES[top]))
    part = inside.split(".")[0]
    if part == room or room not in FLOORS:
        return True
    is_below = FLOORS.get(part, len(FLOORS)) <= FLOORS[room] and part not in APART.get(room, set())
    return is_below and inside.startswith(NARROW.get((room, part), ("",)))


def functions(module: Module) -> Iterator[ast.FunctionDef]:
    for node in module.nodes:
        if isinstance(node, ast.FunctionDef):
            yield node


def is_kernel(function: ast.FunctionDef) -> bool:
    return any(ast.unparse(decorator).split("(")[0] == "kernel" for decorator in function.decorator_list)


def dotted(node: ast.AST) -> str:
    return ast.unparse(node) if isinstance(node, ast.Attribute | ast.Name) else ""


def report(problems: list[str]) -> None:
    assert not problems, "\n" + "\n".join(problems)


def test_every_folder_has_a_rule() -> None:
    parts = {module.part for module in modules()}
    assert parts == {*FLOORS, *FACES}, "say in DESIGN.md and here on which floor the new room stands"


def test_imports_go_to_the_own_floor_or_below() -> None:
    report(
        [
            f"{module.place}:{found.line} imports {found.module}"
            for module in modules()
            for found in imports(module)
            if not is_allowed(module, found)
        ]
    )


def test_narrow_ways_are_needed() -> None:
    """What stands in the tables and no file uses goes."""
    used = {(module.part, own(found) or "") for module in modules() for found in imports(module)}
    report(
        [
            f"{room} imports nothing of {place}"
            for (room, _), places in NARROW.items()
            for place in places
            if not any(part == room and inside.startswith(place) for part, inside in used)
        ]
    )


def test_no_rings() -> None:
    """Nothing imports in a circle: no files, no folders at any depth, neither in functions nor for types."""
    arrows = {
        (module.name, inside)
        for module in modules()
        if module.part in FLOORS and Path(module.place).stem != "face"
        for found in imports(module)
        if (inside := own(found)) and inside.split(".")[0] in FLOORS and not inside.endswith(".face")
    }
    for depth in range(1, 6):
        graph: dict[str, set[str]] = {}
        for one, other in arrows:
            near, far = cut(one, depth), cut(other, depth)
            # A folder may be imported by what is in it: its ``__init__`` lists its kinds.
            if near != far and not near.startswith(f"{far}.") and not far.startswith(f"{near}."):
                graph.setdefault(near, set()).add(far)
        try:
            TopologicalSorter(graph).prepare()
        except CycleError as ring:
            pytest.fail(" -> ".join(ring.args[1]))


def cut(name: str, depth: int) -> str:
    return ".".join(name.split(".")[:depth])


def test_folders_hold_few_files() -> None:
    sizes = Counter(Path(module.place).parent.as_posix() for module in modules() if "__init__" not in module.place)
    report([f"{folder}: {size} files, at most {MOST_FILES}" for folder, size in sizes.items() if size > MOST_FILES])


def test_the_renderer_is_loaded_late() -> None:
    """Only adapters, `live`, training and the command line know the renderer, and only inside functions."""
    report(
        [
            f"{module.place}:{found.line} imports {found.module}"
            for module in modules()
            if module.part != "rendering"
            for found in imports(module)
            if (own(found) or "").split(".")[0] == "rendering"
            and not (module.part == "tasks" and (own(found) or "").startswith(RASTER))
            and not (own(found) or "").startswith("rendering.controls")
            and (module.part not in RENDER_FROM or not (found.deferred or found.for_types))
        ]
    )


def test_heavy_packages_are_loaded_late() -> None:
    """What `import irsim_gym` and the command line reach at once must stay light."""
    light = ("__init__", "scenario/", "errors", "simulator/world/")
    light += tuple(f"base/{name}" for name in ("errors", "registry", "families", "arraytypes"))
    report(
        [
            f"{module.place}:{found.line} imports {found.module}"
            for module in modules()
            if module.place.startswith(light)
            for found in imports(module)
            if found.module.split(".")[0] in HEAVY and not (found.deferred or found.for_types)
        ]
    )


def test_importing_loads_nothing_heavy() -> None:
    """Nor do the ids, and what is loaded when it is named."""
    code = "import gymnasium, irsim_gym; assert 'irsim_gym/cluttered_room-v0' in gymnasium.registry"
    script = (
        f"{code}; irsim_gym.load_scenario\nimport sys\nprint([name for name in {LOADED_LATE!r} if name in sys.modules])"
    )
    result = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert (result.returncode, result.stdout.strip()) == (0, "[]"), result.stderr


def test_numba_is_used_through_kernel_alone() -> None:
    problems = []
    for module in modules():
        for node in module.nodes:
            if isinstance(node, ast.Attribute | ast.Name) and not module.place.startswith("base/kernels"):
                name = dotted(node).split(".")[-1]
                if name in {"njit", "prange", "vectorize", "guvectorize", "cfunc"} or dotted(node) == "numba.jit":
                    problems.append(f"{module.place}:{node.lineno} uses {dotted(node)}")
            if isinstance(node, ast.keyword) and node.arg == "parallel":
                problems.append(f"{module.place}:{node.value.lineno} passes parallel=")
    report(problems)


def test_what_generates_code_names_the_folder_of_compiled_code() -> None:
    """The key of a kernel on disk covers kernels; a change in what extends the compiler has to compile all anew."""
    generators = {file for pattern in GENERATORS for file in PACKAGE.glob(pattern)}
    report(
        [
            f"{module.place} imports {found.module}: add it to base/compiled/folder.py"
            for module in modules()
            for found in imports(module)
            if found.module.split(".")[0] in {"numba", "llvmlite"} and PACKAGE / module.place not in generators
        ]
    )


def test_kernels_need_no_more_of_numbas_passes() -> None:
    """What ``base.kernels.passes`` leaves out is for these; where it is wanted, the pass has to come back."""
    needs = (ast.Lambda, ast.FunctionDef, ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp, ast.With)
    problems = []
    for module in modules():
        for function in filter(is_kernel, functions(module)):
            for node in (inner for statement in function.body for inner in ast.walk(statement)):
                is_told = isinstance(node, ast.Raise) and any(isinstance(one, ast.JoinedStr) for one in ast.walk(node))
                is_asked = isinstance(node, ast.Attribute) and node.attr in {"ndim", "literally", "literal_unroll"}
                if isinstance(node, needs) or is_told or is_asked:
                    problems.append(f"{module.place}:{node.lineno} {type(node).__name__} in a kernel")
    report(problems)


def test_threads_are_made_in_one_place() -> None:
    """Asking which thread this is (`threading.current_thread`) is no parallelism.

    The threads of `base/kernels/workers.py` wait for a pipe; the processes of a tuning train, each by itself.
    """
    makers = {"Thread", "Timer", "Process", "Pool", "ThreadPoolExecutor", "ProcessPoolExecutor", "ThreadPool", "fork"}
    problems = []
    for module in modules():
        if module.place in {"simulator/running/shards.py", "base/kernels/workers.py", "training/searches/tuning.py"}:
            continue
        for node in module.nodes:
            if isinstance(node, ast.Call) and dotted(node.func).split(".")[-1] in makers:
                problems.append(f"{module.place}:{node.lineno} makes {dotted(node.func)}")
        for found in imports(module):
            if found.module.split(".")[0] in {"multiprocessing", "concurrent", "_thread", "asyncio"}:
                problems.append(f"{module.place}:{found.line} imports {found.module}")
    report(problems)


def test_no_global_random_generator() -> None:
    """Training alone may save and restore the foreign global generators, for `--resume`."""
    problems = []
    for module in modules():
        states = {"get_state", "set_state", "seed"} if module.part == "training" else set()
        for node in module.nodes:
            parts = dotted(node).split(".")
            is_random = len(parts) == 3 and parts[:2] in (["np", "random"], ["numpy", "random"])
            if is_random and parts[2] not in RANDOM_OBJECTS | states:
                problems.append(f"{module.place}:{node.lineno} uses {dotted(node)}")  # type: ignore[attr-defined]
        for found in imports(module):
            if found.module == "random" and module.part != "training":
                problems.append(f"{module.place}:{found.line} imports random")
    report(problems)


def test_no_module_level_state() -> None:
    """Tables at module level are never changed, none begins empty, and no function rebinds a global."""
    problems = []
    for module in modules():
        if module.place == "base/families.py":
            continue
        tables = set()
        for name, value in _module_values(module):
            if isinstance(value, ast.Dict | ast.List | ast.Set) and not (getattr(value, "elts", None) or _keys(value)):
                problems.append(f"{module.place}:{value.lineno} {name} begins empty")
            if isinstance(value, ast.Call) and dotted(value.func) in _CONTAINERS and "((0" not in ast.unparse(value):
                problems.append(f"{module.place}:{value.lineno} {name} is mutable")
            if isinstance(value, ast.Dict | ast.List | ast.Set | ast.DictComp | ast.ListComp | ast.SetComp):
                tables.add(name)
        problems += [f"{module.place}:{line} changes {name}" for name, line in _changes(module, tables)]
        problems += [
            f"{module.place}:{node.lineno} rebinds {', '.join(node.names)}"
            for node in module.nodes
            if isinstance(node, ast.Global)
        ]
    report(problems)


_CONTAINERS = {
    "list",
    "dict",
    "set",
    "bytearray",
    "defaultdict",
    "deque",
    "Counter",
    "OrderedDict",
    "np.zeros",
    "np.empty",
}


def _keys(value: ast.AST) -> list[ast.expr | None]:
    return value.keys if isinstance(value, ast.Dict) else []


def _module_values(module: Module) -> Iterator[tuple[str, ast.expr]]:
    for node in module.tree.body:
        if isinstance(node, ast.Assign):
            for target in node.targets:
                if isinstance(target, ast.Name) and target.id != "__all__":
                    yield target.id, node.value
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.value is not None:
            yield node.target.id, node.value


def _changes(module: Module, tables: set[str]) -> Iterator[tuple[str, int]]:
    for node in module.nodes:
        if (
            isinstance(node, ast.Subscript)
            and isinstance(node.ctx, ast.Store | ast.Del)
            and dotted(node.value) in tables
        ):
            yield dotted(node.value), node.lineno
        called = node.func if isinstance(node, ast.Call) else None
        if isinstance(called, ast.Attribute) and called.attr in MUTATORS and dotted(called.value) in tables:
            yield dotted(called.value), called.lineno


def test_a_family_only_lists_its_kinds() -> None:
    families = {f"bodies/{name}" for name in ("drives", "behaviors", "shapes", "placements", "sensors", "maps")}
    families |= {f"tasks/{name}" for name in ("actions", "observations", "rewards", "endings")}
    problems = []
    for module in modules():
        if not module.place.endswith("__init__.py") or module.place.removesuffix("/__init__.py") not in families:
            continue
        for node in module.tree.body:
            listed = isinstance(node, ast.Import | ast.ImportFrom) or (
                isinstance(node, ast.Expr)
                and (
                    isinstance(node.value, ast.Constant)
                    or (isinstance(node.value, ast.Call) and dotted(node.value.func).endswith(".register"))
                )
            )
            exported = isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"
            if not listed and not exported:
                problems.append(f"{module.place}:{node.lineno} does more than list kinds")
    report(problems)


def test_yaml_words_end_at_compile() -> None:
    report(
        [
            f"{module.place}:{node.lineno} reads .{node.attr}"
            for module in modules()
            if module.part != "scenario" and not module.place.startswith(YAML_READERS)
            for node in module.nodes
            if isinstance(node, ast.Attribute) and node.attr in YAML_ONLY_NAMES
        ]
    )


def test_classes_are_abstract_or_final() -> None:
    """No class of ours has two bases of ours, and no concrete method of ours is overridden."""
    classes = {
        node.name: (module, node) for module in modules() for node in module.tree.body if isinstance(node, ast.ClassDef)
    }
    problems = []
    for module, node in classes.values():
        bases = [name for base in node.bases if (name := ast.unparse(base).split("[")[0].split(".")[-1]) in classes]
        if len(bases) > 1:
            problems.append(f"{module.place}:{node.lineno} {node.name} mixes {', '.join(bases)}")
        mine = {item.name for item in node.body if isinstance(item, ast.FunctionDef)}
        for base in bases:
            concrete = {
                item.name
                for item in classes[base][1].body
                if isinstance(item, ast.FunctionDef)
                and not item.name.startswith("__")
                and not any("abstract" in ast.unparse(decorator) for decorator in item.decorator_list)
            }
            problems += [f"{module.place} {node.name}.{name} overrides {base}'s" for name in sorted(mine & concrete)]
    report(problems)


def _twice(found: Iterable[tuple[str, str]]) -> dict[str, list[str]]:
    places: dict[str, list[str]] = {}
    for name, place in found:
        places.setdefault(name, []).append(place)
    return {name: where for name, where in places.items() if len(where) > 1}


def test_one_name_is_one_thing() -> None:
    """Public classes have one name each; modules have folders for that."""
    classes = _twice(
        (node.name, module.place)
        for module in modules()
        for node in module.tree.body
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_") and module.place not in SCRIPTS
    )
    report([f"class {name}: {', '.join(where)}" for name, where in classes.items()])


def test_the_package_keeps_to_its_budget() -> None:
    """Lines of code, without blank lines, comments and docstrings: whoever needs more removes something."""
    total = sum(code_lines(file.read_text(encoding="utf-8")) for file in PACKAGE.rglob("*.py"))
    print(f"{total:,} of {MOST_CODE_LINES:,} code lines")
    assert total <= MOST_CODE_LINES


def code_lines(source: str) -> int:
    """Return the number of lines with code; strings that stand alone are docstrings."""
    layout = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in layout:
            lines.update(range(token.start[0], token.end[0] + 1))
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            lines -= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return sum(bool(line.strip()) for number, line in enumerate(source.splitlines(), 1) if number in lines)


def test_files_and_functions_are_short() -> None:
    problems = [
        f"{module.place}: {lines} lines, at most {MAX_FILE_LINES}"
        for module in modules()
        if (lines := module.text.count("\n")) > MAX_FILE_LINES
    ]
    for module in modules():
        for function in functions(module):
            limit = MAX_KERNEL_LINES if is_kernel(function) else MAX_FUNCTION_LINES
            length = (function.end_lineno or function.lineno) - function.lineno + 1
            if length > limit:
                problems.append(f"{module.place}:{function.lineno} {function.name}: {length} lines, at most {limit}")
    report(problems)


def test_kernels_have_few_arguments() -> None:
    counts = {
        f"{module.place}:{kernel.lineno} {kernel.name}": len(kernel.args.args)
        for module in modules()
        for kernel in filter(is_kernel, functions(module))
    }
    report([f"{name}: {n} arguments, at most {MAX_ARGUMENTS}" for name, n in counts.items() if n > MAX_ARGUMENTS])
    assert median(counts.values()) <= MEDIAN_ARGUMENTS


def test_public_things_have_docstrings() -> None:
    problems = []
    for module in modules():
        if not ast.get_docstring(module.tree):
            problems.append(f"{module.place}: no docstring")
        classes = [
            node for node in module.tree.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
        ]
        bodies = [module.tree.body, *(node.body for node in classes)]
        for node in (node for body in bodies for node in body):
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
                overloaded = any(
                    ast.unparse(decorator).split(".")[-1] in {"overload", "setter"} for decorator in node.decorator_list
                )
                if not overloaded and not ast.get_docstring(node):
                    problems.append(f"{module.place}:{node.lineno} {node.name}: no docstring")
    report(problems)


def test_kernels_say_what_they_read_and_write() -> None:
    """``python tests/kernel_access.py`` writes it."""
    wrong = [
        f"{kernel.file.name}:{kernel.tree.lineno} {name} should say\n{kernel.expected()}"
        for (_, name), kernel in kernels().items()
        if kernel.structs and kernel.expected() != kernel.found()
    ]
    report(wrong)


def test_what_kernels_access_is_read_from_their_bodies() -> None:
    found = kernels()
    tick = found["irsim_gym.simulator.step.step", "tick"]
    assert tick.reads == {("worlds", ""), ("model", "step_time"), ("state", "step")}
    assert tick.writes == {("state", "step"), ("state", "time")}
    moved = found["irsim_gym.bodies.drives.differential", "move_differential"].writes
    assert moved == {("state", "pose"), ("state", "direction"), ("state", "twist")}


def test_files_from_outside_have_one_reader() -> None:
    """Others read what they have just written, what a child of theirs has, or objects after their own checks."""
    calls = {"np.load", "json.load", "json.loads", "pickle.load", "pickle.loads", "zipfile.ZipFile"}
    others = {
        *(
            "base/compiled/cache.py",
            "base/kernels/workers.py",
            "rendering/replay/replay_items.py",
            "training/runs/checkpoint.py",
        ),
        "training/runs/environment.py",
        *("training/export/exporting.py", "evaluation/saved_policies/saved_models.py", "training/searches/tuning.py"),
        "evaluation/saved_policies/trusted.py",
    }
    places = {
        module.place
        for module in modules()
        for node in module.nodes
        if isinstance(node, ast.Call) and ast.unparse(node.func) in calls
    }
    assert places - SCRIPTS == {"base/outside_files.py", *others}


def test_scripts_import_nothing_but_scripts() -> None:
    own_scripts = {place.removesuffix(".py").replace("/", ".") for place in SCRIPTS}
    report(
        [
            f"{module.place}:{found.line} imports {found.module}"
            for module in modules()
            if module.place in SCRIPTS
            for found in imports(module)
            if own(found) is not None and own(found) not in own_scripts
        ]
    )
