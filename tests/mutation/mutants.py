"""Which mutants there are, and which of them are drawn: places and operators of cosmic-ray, by a seed."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import parso
from cosmic_ray import plugins
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.operators.operator import Example, Operator
from cosmic_ray.work_item import MutationSpec, WorkItem

PARTS: dict[str, tuple[str, ...]] = {
    "core": tuple(
        f"{folder}/**/*.py"
        for folder in ("simulator", "bodies/drives", "bodies/sensors", "bodies/behaviors", "tasks", "envs")
    ),
    "recent": (
        *(f"bodies/behaviors/{name}/*.py" for name in ("local_planners", "hybrid_astar", "pursuit")),
        *(f"bodies/maps/{name}.py" for name in ("cells", "cellular", "level", "maze", "rooms", "shelves")),
        *(
            f"simulator/cell_paths/{name}.py"
            for name in ("cell_lines", "occupancy", "outline_room", "scan_marks", "wavefront")
        ),
        *(f"simulator/levels/{name}.py" for name in ("level_table", "traits", "path_checks")),
        *("simulator/step/respawn.py", "tasks/observations/bodies/time_to_collision.py"),
        "tasks/observations/seen_map/*.py",
        *(f"envs/sb3_learning/{name}.py" for name in ("gru", "memory")),
        "envs/parts/mirror.py",
        "bodies/placements/cells.py",
        "evaluation/measures/certificate_measures.py",
        "evaluation/suite/scores.py",
    ),
}
"""Files of the package from which the mutants of a campaign are drawn, as patterns."""

OPERATORS = (
    r"irsim_gym/DeleteStatement",
    r"core/ReplaceBinaryOperator_(Add_Sub|Add_Mul|Sub_Add|Sub_Mul|Mul_Div|Mul_Add|Div_Mul|Div_Sub|FloorDiv_Mul|Mod_Add)",
    r"core/ReplaceBinaryOperator_(Pow_Mul|BitOr_BitAnd|BitAnd_BitOr|BitXor_BitAnd|LShift_RShift|RShift_LShift)",
    r"core/ReplaceComparisonOperator_(Lt_LtE|Lt_GtE|LtE_Lt|LtE_Gt|Gt_GtE|Gt_LtE|GtE_Gt|GtE_Lt|Eq_NotEq|NotEq_Eq)",
    r"core/ReplaceComparisonOperator_(Is_IsNot|IsNot_Is)",
    r"core/ReplaceUnaryOperator_(USub_UAdd|Delete_Not|Delete_Invert)",
    r"core/(AddNot|ReplaceTrueWithFalse|ReplaceFalseWithTrue|ReplaceAndWithOr|ReplaceOrWithAnd)",
    r"core/(ReplaceBreakWithContinue|ReplaceContinueWithBreak|ExceptionReplacer|NumberReplacer|ZeroIterationForLoop)",
)
"""Those that leave a program which may run: a ``+`` that becomes ``<<`` fails for all floats, whatever a test says."""

EXCLUDED = (
    "annotations and type aliases",
    "decorators",
    "imports",
    "raise statements and f-strings: what a message says",
)
"""What is not mutated: it is no code that runs, or says something to people only."""

Place = tuple[tuple[int, int], tuple[int, int]]


class DeleteStatement(Operator):  # type: ignore[misc]
    """Leave out an assignment to an element or an attribute, or a call whose result nobody takes."""

    def mutation_positions(self, node: Any) -> Iterator[Place]:
        """Yield the place of such a statement."""
        if _is_effect(node):
            yield node.start_pos, node.end_pos

    def mutate(self, node: Any, index: int) -> Any:
        """Return ``pass`` in its place."""
        first = node.get_first_leaf()
        return parso.python.tree.Name("pass", node.start_pos, prefix=first.prefix)

    @classmethod
    def examples(cls) -> tuple[Example, ...]:
        """Return what it does to some statements."""
        return (
            Example("a[0] = 1\n", "pass\n"),
            Example("b = 2\na[0], c.d = 1, 2\n", "b = 2\npass\n"),
            Example("f(1)\n", "pass\n"),
        )


def _is_effect(node: Any) -> bool:
    if node.parent is None or node.parent.type != "simple_stmt":
        return False
    if node.type == "expr_stmt":
        target = node.children[0]
        parts = target.children if target.type == "testlist_star_expr" else [target]
        return any(part.type in ("atom_expr", "power") for part in parts)
    if node.type not in ("atom_expr", "power"):
        return False
    last = node.children[-1]
    return bool(last.type == "trailer" and last.children[0].value == "(")


plugins.OPERATOR_PROVIDERS["irsim_gym"] = {"DeleteStatement": DeleteStatement}


def operators() -> dict[str, Operator]:
    """Return the operators by their names."""
    chosen = [name for name in plugins.operator_names() if any(re.fullmatch(one, name) for one in OPERATORS)]
    return {name: plugins.get_operator(name)() for name in sorted(chosen)}


def modules(root: Path, part: str) -> list[str]:
    """Return the files of a part, as paths from the root of the repository."""
    files = [file for pattern in PARTS[part] for file in sorted((root / "irsim_gym").glob(pattern))]
    return [file.relative_to(root).as_posix() for file in dict.fromkeys(files)]


def mutants_of(source: str, module: str) -> list[MutationSpec]:
    """Return all mutations of a module but those of ``EXCLUDED``."""
    tree = get_ast(source)
    nodes = list(ast_nodes(tree))
    leaves = {node.start_pos: node for node in nodes if isinstance(node, parso.tree.Leaf)}
    found = []
    for name, operator in operators().items():
        places = [place for node in nodes for place in operator.mutation_positions(node)]
        for occurrence, (start, end) in enumerate(places):
            if not _is_excluded(leaves[start], name):
                found.append(MutationSpec(module, name, occurrence, start, end))
    return found


def _is_excluded(leaf: Any, operator: str) -> bool:
    if leaf.value in ("*", "**") and leaf.parent.type in ("argument", "dictorsetmaker", "testlist_star_expr"):
        return True  # unpacks, which cosmic-ray takes for an operator
    node, inside_function = leaf, False
    while node.parent is not None:
        above = node.parent
        if above.type in ("decorator", "import_name", "import_from", "raise_stmt", "fstring"):
            return True
        if above.type == "annassign" and node is above.children[1]:
            return True
        if above.type == "tfpdef" or (above.type == "funcdef" and node is above.annotation):
            return True
        inside_function |= above.type == "funcdef"
        node = above
    return "Bit" in operator and not inside_function


def sample(root: Path, part: str, count: int, seed: int) -> tuple[list[WorkItem], dict[str, int]]:
    """Draw mutants of a part, from each module as many as its share of all places where something can be mutated.

    A place is drawn first, then one of its mutations, so that numbers, each of which has two, do not prevail.

    Returns:
        The mutants, and the number of mutations that each module has.
    """
    places: dict[str, dict[Place, list[MutationSpec]]] = {}
    for module in modules(root, part):
        for spec in mutants_of((root / module).read_text(encoding="utf-8"), module):
            places.setdefault(module, {}).setdefault((spec.start_pos, spec.end_pos), []).append(spec)
    total = sum(len(one) for one in places.values())
    shares = {module: count * len(one) / total for module, one in places.items()}
    quota = {module: int(share) for module, share in shares.items()}
    by_rest = sorted(shares, key=lambda module: (quota[module] - shares[module], module))
    for module in by_rest[: count - sum(quota.values())]:
        quota[module] += 1
    chosen = []
    for module, n in quota.items():
        rng = random.Random(f"{seed} {module}")
        for place in rng.sample(sorted(places[module]), n):
            spec = rng.choice(places[module][place])
            chosen.append(WorkItem.single(name_of(spec), spec))
    return chosen, {module: sum(map(len, one.values())) for module, one in places.items()}


def name_of(spec: MutationSpec) -> str:
    """Return what a mutant is called: file, line, column, operator, and which of several at the same place."""
    line, column = spec.start_pos
    kind = spec.operator_name.split("/")[1].removeprefix("Replace")
    return f"{spec.module_path.as_posix()}:{line}:{column} {kind} {spec.occurrence}"
