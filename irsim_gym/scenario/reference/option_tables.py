"""Tables of all options for the command line and the documentation, made from their declarations."""

import dataclasses
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, get_args

from irsim_gym.base import families
from irsim_gym.base.options import option_fields
from irsim_gym.base.registry import Registry
from irsim_gym.scenario.checking.whereabouts import SPECS
from irsim_gym.scenario.reading.parameters import ParameterSpec
from irsim_gym.scenario.text.messages import describe, show

SUMMARIES = {
    "robot, obstacle": "The keys of an entry.",
    "parameters": "The keys of a parameter.",
    "wander_goals": "The keys of wander_goals, in a behaviour or group behaviour that wanders.",
    "plot": "Drawing options: in an entry for its bodies, at the top of the file for all.",
}
_NAMED = "a mapping with a name, as below"
ALLOWED = {
    **dict.fromkeys(("distribution", "kinematics", "shape", "behavior", "group_behavior"), _NAMED),
    **dict.fromkeys(("sensors", "disturbances"), "a list of mappings with a name, as below"),
    "action": "a name, or a mapping with a name, as below",
    **dict.fromkeys(("observations", "rewards", "endings"), "a list of names or of mappings with a name, as below"),
    "goal": "a list of 2 or 3 numbers, or lists of them",
    "obstacle_map": "a file, a mapping with a name, or a list of columns",
    "seen_by": "all, or a list of roles, names and names of groups",
    "state": "a list of up to 4 numbers",
}
_SIGNS = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}


@dataclass(frozen=True)
class OptionRow:
    """One option.

    Attributes:
        key: Its name in YAML.
        default: Its default; ``required`` if it must be given.
        unit: SI unit, or empty.
        allowed: Type and bounds.
        meaning: What it does.
        consequence: Effect of a bad value that validation cannot detect.
    """

    key: str
    default: str
    unit: str
    allowed: str
    meaning: str
    consequence: str


def option_rows(cls: type[Any]) -> tuple[OptionRow, ...]:
    """Return the options of a kind or spec, in the order of their declaration."""
    rows = []
    for key, info in option_fields(cls).items():
        extra: Any = info.json_schema_extra if isinstance(info.json_schema_extra, dict) else {}
        bounds = [
            f"{sign} {getattr(item, name):g}"
            for item in info.metadata
            for name, sign in _SIGNS.items()
            if hasattr(item, name)
        ]
        default = "required" if info.is_required() else _default(info.default)
        allowed = ", ".join([ALLOWED.get(key, describe(info.annotation)), *bounds])
        texts = str(extra.get("unit", "")), allowed, str(info.description or ""), str(extra.get("consequence", ""))
        rows.append(OptionRow(key, default, *texts))
    return tuple(rows)


def _default(value: object) -> str:
    if value is None or value == ():
        return ""
    return "{}" if dataclasses.is_dataclass(value) else show(value)


def find_family(name: str) -> Registry | None:
    """Return the family of kinds that a name or its plural names, e.g. ``rewards`` or ``obstacle_map``."""
    family_name = name.lower().replace("_", " ").replace("behaviour", "behavior")
    families.load()
    by_name = {family.family: family for family in families.every()}
    return by_name.get(family_name) or by_name.get(family_name.removesuffix("s"))


def kind_summaries(family: Registry) -> dict[str, str]:
    """Return the first sentence about each kind of a family, by name."""
    texts = {entry.name: _summary(entry.kind) for entry in family}
    first = re.compile(r"(?<!e\.g)(?<!i\.e)[.;](?: |$)")
    return {name: first.split(text, maxsplit=1)[0] for name, text in texts.items()}


def option_tables() -> Iterator[tuple[str, tuple[OptionRow, ...]]]:
    """Yield a title and the options of each section, and of each registered kind."""
    for title, cls in _sections():
        yield title, option_rows(cls)


def _sections() -> Iterator[tuple[str, type[Any]]]:
    """Yield a title and the declaring class of each section, and of each registered kind."""
    families.load()
    yield from SPECS.items()
    yield "parameters", ParameterSpec
    for entry in families.SECTIONS:
        yield entry.name, entry.kind
    for registry in families.every():
        for entry in registry:
            yield f"{registry.family} {entry.name}", entry.kind
            plot = _plot_options(entry.kind)
            if plot is not None:
                yield f"{registry.family} {entry.name}: plot", plot


def _plot_options(cls: type[Any]) -> type[Any] | None:
    """Return the class that declares a kind's drawing options; None for a kind without them."""
    info = option_fields(cls).get("plot")
    if info is None:
        return None
    candidates = (info.annotation, *get_args(info.annotation))
    return next((item for item in candidates if dataclasses.is_dataclass(item) and isinstance(item, type)), None)


def markdown() -> str:
    """Return all tables as Markdown."""
    return "\n".join(_table(title, cls) for title, cls in _sections())


def _summary(cls: type[Any]) -> str:
    """Return the first paragraph of a class's docstring."""
    return " ".join((cls.__doc__ or "").strip().split("\n\n")[0].split())


def _table(title: str, cls: type[Any]) -> str:
    summary = _summary(cls)
    rows = option_rows(cls)
    lines = [f"### {title}", "", SUMMARIES.get(title, summary), ""]
    if not rows:
        return "\n".join([*lines, "No options.", ""])
    lines += ["| key | default | unit | allowed | meaning | effect of a bad value |", "|---|---|---|---|---|---|"]
    lines += [_cells(row) for row in rows]
    return "\n".join([*lines, ""])


def _cells(row: OptionRow) -> str:
    cells = (f"`{row.key}`", row.default, row.unit, row.allowed, row.meaning, row.consequence)
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
