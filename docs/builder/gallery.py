"""The gallery: a page for each shipped scenario, from its file, its environment, the suite's rows and the shelf."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import irsim_gym
from builder import pictures as drawn
from builder import tables
from builder.records import cards_in, references
from irsim_gym.envs.described.description import Description
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.saved_policies.cards import PolicyCard
from irsim_gym.evaluation.saved_policies.shelf_tables import curves_text, percent
from irsim_gym.evaluation.suite import suite_tables
from irsim_gym.evaluation.suite.members import shipped_suite
from irsim_gym.scenario.reading.load import load_scenario
from irsim_gym.scenario.reading.parameters import ParameterSpec
from irsim_gym.scenario.specs.library import benchmark_names, every_scenario
from irsim_gym.scenario.text.source import read_file

FOLDER = "scenarios"


def pages(source: Path, *, pictures: bool = True, names: Sequence[str] | None = None) -> dict[str, str]:
    """Return the pages of the gallery by their places, and draw their pictures.

    Args:
        source: The folder that Sphinx reads.
        pictures: Draw levels and films that are older than what they show; else only use those that are there.
        names: The scenarios; None for all.
    """
    files = {name: file for name, file in every_scenario().items() if names is None or name in names}
    if pictures:
        for name, file in files.items():
            drawn.draw(name, file, source / FOLDER)
    have = {name: drawn.existing(name, source / FOLDER) for name in files}
    made = {f"{FOLDER}/{name}.md": _page(name, file, have[name]) for name, file in files.items()}
    return {f"{FOLDER}/index.md": _index(files, have), **made}


def intro(file: Path) -> str:
    """Return the comment at the head of a scenario file, without its commands."""
    lines = []
    for line in file.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.removeprefix("#").strip())
    told = "\n".join(lines).split("\n\n")
    return "\n\n".join(part for part in told if not part.startswith(("gymnasium.make", "irsim-gym ")))


def caption(file: Path) -> str:
    """Return the first sentence of a scenario file's head, without what is in brackets."""
    text = re.sub(r"\s*\([^)]*\)|\s*\n\s*", lambda gap: "" if "(" in gap[0] else " ", intro(file))
    return text.split(". ")[0].rstrip(".")


def _index(files: dict[str, Path], have: dict[str, drawn.Pictures]) -> str:
    parts = ["# Scenarios\n\nEvery shipped world, with what a robot observes, does and is paid for in it.\n"]
    suite = set(benchmark_names())
    for title, chosen in (
        ("Worlds", [name for name in files if name not in suite]),
        ("Benchmarks", [name for name in files if name in suite]),
    ):
        shown = "\n".join(["````{container} gallery", *_tiles(chosen, files, have), "````"])
        parts.append(f"## {title}\n\n{shown}\n")
    listed = "\n".join(files)
    return "\n".join(parts) + f"\n```{{toctree}}\n:hidden:\n\n{listed}\n```\n"


def _tiles(names: list[str], files: dict[str, Path], have: dict[str, drawn.Pictures]) -> Iterator[str]:
    for name in names:
        told = f"[{name}]({name}.md): {caption(files[name])}"
        if have[name].level:
            yield f"```{{figure}} {name}.png\n:alt: A level of {name}\n:target: {name}.html\n\n{told}\n```"
        else:
            yield f"{told}\n"


def _page(name: str, file: Path, have: drawn.Pictures) -> str:
    parts = [f"# {name}", intro(file) or "A shipped scenario."]
    if have.level:
        parts.append(f"![A level of {name}]({name}.png)")
    if have.film:
        parts.append(
            f"{have.film}\n\n```{{raw}} html\n"
            f"<video src='../films/{name}.mp4' controls loop muted preload='metadata' "
            f"aria-label='Film of {name}'></video>\n```"
        )
    parts.append(f'```python\nimport irsim_gym\n\nenv = irsim_gym.make("{name}")\n```')
    parts += [*_parameters(file), *_learned(name), *_rows(name), *map(_card, cards_in(name))]
    parts.append(f"## File\n\n```yaml\n{file.read_text(encoding='utf-8').strip()}\n```")
    return "\n\n".join(parts) + "\n"


def _parameters(file: Path) -> Iterator[str]:
    given = read_file(file).data.get("parameters") or {}
    rows = []
    for name, entry in given.items():
        one = ParameterSpec(**entry)
        ends = [tables.number(end) for end in (one.min, one.max) if end is not None]
        span = ", ".join(map(str, one.choices)) if one.choices else " to ".join(ends)
        rows.append((f"`{name}`", one.default, one.unit, span, one.meaning))
    if rows:
        yield "## Parameters\n\n" + tables.table(("name", "default", "unit", "range", "meaning"), rows)


def _learned(name: str) -> Iterator[str]:
    """Yield what a learner meets; nothing can be learned where no robot is."""
    if not load_scenario(name).robots:
        yield "No robot learns here: the file has none."
        return
    try:
        env = irsim_gym.make(name)
    except IrsimGymError as error:
        yield f"No robot can learn here as it stands: {str(error).splitlines()[-1].strip()}"
        return
    told: Description = env.get_wrapper_attr("describe")()
    env.close()
    yield f"## Observation\n\nOf `{told.agent}`, with the task `{told.task}`.\n\n{tables.observation(told)}"
    yield f"## Action\n\n{tables.action(told.action)}"
    yield f"## Reward\n\n{tables.rewards(told)}"
    yield f"## Endings\n\n{tables.endings(told)}"


def _rows(name: str) -> Iterator[str]:
    """Yield the reference rows of the benchmarks that play a scenario."""
    record = references()
    played = [one for one in shipped_suite().members.values() if one.scenario == name and one.name in record.figures]
    if played:
        yield "## Reference rows\n\nFrom the [benchmark suite](../benchmarks.md), success and others in percent."
    for member in played:
        told = suite_tables.member_markdown(record, member.name).split("\n", 2)[2].strip()
        yield f"### {member.name}\n\n{member.asks}\n\n{told}"


def _card(card: PolicyCard) -> str:
    observed = ", ".join(f"`{term.name}` {' x '.join(map(str, term.shape))}" for term in card.observation)
    training = card.training
    rows = [
        ("algorithm", training.algorithm.upper()),
        ("task", card.scenario.task or "of the scenario"),
        ("parameters", ", ".join(f"{key} = {value}" for key, value in card.scenario.parameters.items()) or "none"),
        ("observation", observed),
        ("needed on a robot", ", ".join(card.needs or ()) or "nothing"),
        ("action", f"{card.action.name} ({'; '.join(card.action.components)})"),
        ("network", "; ".join(card.network.layers)),
        ("weights", f"{card.network.weights:,}, {card.size / 1000:.0f} kB"),
        ("training", f"{training.steps:,} steps, {training.cpu_seconds:.0f} s of CPU time, seed {training.seed}"),
        *(("success [%]", f"{percent(one.success)} on {one.levels:,} {one.split} levels") for one in card.results),
        *([("5 points of success lost at", curves_text(card.robustness))] if card.robustness else []),
        *(("weakness", sentence) for sentence in card.weaknesses),
    ]
    use = f'`irsim_gym.load_policy("{card.name}")`, `irsim-gym policies show {card.name}`'
    return f"## Policy {card.name}\n\n{use}\n\n" + tables.table(("", ""), rows)
