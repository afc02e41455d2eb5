"""What the site is made from: links, lists of pages, options, names, scenarios, stored outputs of notebooks."""

from __future__ import annotations

import ast
import inspect
import json
import re
import sys
import textwrap
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from builder import check, films, gallery, language, links, reference, source_pages, stage, stand_ins, tables
from reference_rules import documented

import irsim_gym
from irsim_gym.base import arraytypes, families
from irsim_gym.errors import MissingExtraError
from irsim_gym.evaluation.saved_policies.shelf import card_of
from irsim_gym.evaluation.saved_policies.shelf_tables import curves_text
from irsim_gym.scenario.reference.option_tables import option_tables
from irsim_gym.scenario.specs.library import every_scenario

ROOT = Path(__file__).parents[2]
PAGES = {"docs/a.md": "a.md", "agents/README.md": "agents.md", "docs/design/b.md": "design/b.md"}
RLLIB = "irsim_gym.rllib"
MODULES = {section.module for section in reference.SECTIONS.values() if section.module}
NOT_READ = {"Fused", "Overlay", "ScenarioSpec", "Struct", "Track", "WorldContext"}
"""Classes that public functions return for other parts of the package, not for readers."""
MOST_BYTES = 150_000
"""Of a notebook with its outputs."""


@pytest.mark.parametrize(
    ("written", "on_the_site"),
    [
        ("[here](a.md#part)", "[here](../a.md#part)"),
        ("[all\nof it](../agents/README.md)", "[all\nof it](../agents.md)"),
        ("[why](design/b.md)", "[why](../design/b.md)"),
        ("[code](../irsim_gym/cli/app.py)", "[code](../files/irsim_gym/cli/app.py)"),
        ("see [the folder](../configs/tasks).", "see the folder."),
        ("![A robot](cluttered_room.png)", "![A robot](../cluttered_room.png)"),
        ("[web](https://a.b/c), [below](#part)", "[web](https://a.b/c), [below](#part)"),
        ("```\n[here](nowhere.md)\n```", "```\n[here](nowhere.md)\n```"),
        ("[7]: design/b.md", "[7]: ../design/b.md"),
    ],
)
def test_links_lead_to_pages_of_the_site(written: str, on_the_site: str) -> None:
    assert links.rewrite(written, "docs/c.md", "deep/c.md", PAGES, ROOT) == on_the_site


def test_a_broken_link_is_an_error_with_page_and_line() -> None:
    with pytest.raises(links.BrokenLinkError, match=r"docs/c.md:5: there is no nowhere.md"):
        links.rewrite("```\ncode\n```\n\n[gone](nowhere.md)", "docs/c.md", "c.md", PAGES, ROOT)


def test_patterns_in_lists_of_pages_are_expanded() -> None:
    text = "a *\n```{toctree}\n:hidden:\n\nfirst\nlib*\nnone*\n```\n"
    places = ["library.md", "lib/b.md", "other.md", "libs.ipynb"]
    assert stage.expanded(text, places) == "a *\n```{toctree}\n:hidden:\n\nfirst\nlib/b\nlibrary\n```\n"


def test_every_page_of_the_repository_is_staged_and_every_link_leads_somewhere(tmp_path: Path) -> None:
    (tmp_path / "old.md").write_text("of last year", encoding="utf-8")
    stage.stage(ROOT, tmp_path, {"options/made.md": "# Made\n"})
    placed = {file.relative_to(tmp_path).as_posix() for file in tmp_path.rglob("*") if file.is_file()}
    assert {"index.md", "start.md", "design.md", "agents.md", "project/changelog.md", "design/tasks.md"} <= placed
    assert {"options/made.md", "lessons/teams.ipynb", "cluttered_room.png", "files/benchmarks/twin/s1.c"} <= placed
    assert not {"old.md", "README.md", "builder/stage.py"} & placed
    for page in ("design.md", "design/tasks.md", "project/changelog.md"):
        assert (tmp_path / page).read_text(encoding="utf-8").startswith("---\nnosearch: true\n---\n")
    assert (tmp_path / "start.md").read_text(encoding="utf-8").startswith("# Start")


def test_captions_of_scenarios_are_their_first_sentence(tmp_path: Path) -> None:
    file = tmp_path / "hall.yaml"
    file.write_text("# A hall, after Somebody (et al. 2020;\n# page 2): people walk. They\n# stop.\nworld: {}\n")
    assert gallery.caption(file) == "A hall, after Somebody: people walk"
    captions = [gallery.caption(file) for file in every_scenario().values()]
    assert all(10 < len(caption) < 200 for caption in captions)


def test_every_option_is_on_a_page() -> None:
    pages = "\n".join(language.pages().values())
    for title, rows in option_tables():
        assert f"## {title}\n" in pages
        assert all(f"| `{row.key}` | " in pages for row in rows)
    assert [place for place, text in language.pages().items() if "\n## " not in text] == ["options/index.md"]


def test_every_kind_is_in_one_table_and_leads_to_its_options() -> None:
    pages = language.pages()
    for family in families.every():
        place = f"{family.family.replace(' ', '_')}.md"
        for entry in family:
            row = f"| [`{entry.name}`]({place}#{family.family.replace(' ', '-')}-{entry.name}) | "
            assert pages["options/index.md"].count(row) == 1
            assert f"\n## {family.family} {entry.name}\n" in pages[f"options/{place}"]


def test_columns_that_say_nothing_are_left_out() -> None:
    text = "Options.\n\n| key | unit | effect |\n|---|---|---|\n| `a\\|b` |  |  |\n| `c` |  | bad |\n"
    kept = "Options.\n\n| key | effect |\n|---|---|\n| `a\\|b` |  |\n| `c` | bad |\n"
    assert language.without_empty_columns(text) == kept
    assert language.without_empty_columns("No options.\n") == "No options.\n"


def test_every_public_name_is_in_the_reference() -> None:
    pages = "\n".join(reference.pages().values())
    modules = irsim_gym, irsim_gym.plugins, irsim_gym.sb3, irsim_gym.irsim, irsim_gym.errors, stand_ins.module(RLLIB)
    wanted = [f"{module.__name__}.{name}" for module in modules for name in reference.public(module)]
    assert len(wanted) > 100
    assert [name for name in wanted if f":: {name}\n" not in pages and f"``{name}``" not in pages] == []


def test_every_name_that_pages_use_is_in_the_reference() -> None:
    shown = {name for section in reference.SECTIONS.values() for name, _ in reference.names(section)}
    shown |= MODULES | {"irsim_gym.tasks"}
    used = dict(item for file in pages_with_code() for item in names_used(file))
    assert {"irsim_gym.make_vec", "irsim_gym.rllib", "irsim_gym.sb3.make_vec_env"} <= set(used)
    assert {name: page for name, page in used.items() if name not in shown} == {}


def test_every_class_that_a_public_function_returns_is_in_the_reference() -> None:
    listed = list(documented())
    shown = {one.value.__name__ for one in listed if inspect.isclass(one.value)} | NOT_READ
    shown |= {alias for alias in vars(arraytypes) if not alias.startswith("_")}
    own = {node.name for file in (ROOT / "irsim_gym").rglob("*.py") for node in classes(file)}
    returned = {(word, one.name) for one in listed for word in re.findall(r"\b[A-Z]\w+", one.returned) if word in own}
    assert len(returned) > 20
    assert sorted(pair for pair in returned if pair[0] not in shown) == []


def test_modules_with_stand_ins_leave_nothing_behind() -> None:
    before = dict(sys.modules)
    module = stand_ins.module(RLLIB)
    assert module.register_environments.__module__ == RLLIB
    if find_spec("ray") is None:
        assert RLLIB not in sys.modules
        assert "ray" not in sys.modules
        with pytest.raises(MissingExtraError, match=r"irsim_gym\.rllib needs the extra 'rllib'"):
            irsim_gym.rllib  # noqa: B018
    kept = {name for name, one in before.items() if sys.modules.get(name) is not one}
    assert kept == set()


def pages_with_code() -> list[Path]:
    """Return the pages that show readers code."""
    pages = [*(ROOT / "docs").rglob("*.md"), *(ROOT / "docs" / "lessons").glob("*.ipynb"), *ROOT.glob("*/README.md")]
    return [ROOT / "README.md", *pages]


def names_used(file: Path) -> Iterator[tuple[str, str]]:
    """Yield the names of the package that the code on a page imports, with the page."""
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".ipynb":
        cells = [cell for cell in json.loads(text)["cells"] if cell["cell_type"] == "code"]
        blocks = ["".join(line for line in cell["source"] if not line.startswith(("%", "!"))) for cell in cells]
    else:
        blocks = [textwrap.dedent(block) for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL)]
    for block in blocks:
        for node in ast.walk(ast.parse(block)):
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith("irsim_gym"):
                yield from ((f"{node.module}.{one.name}", file.name) for one in node.names)
            elif isinstance(node, ast.Attribute) and ast.unparse(node.value) in MODULES:
                yield ast.unparse(node), file.name


def classes(file: Path) -> Iterator[ast.ClassDef]:
    """Yield the classes of a module."""
    yield from (node for node in ast.parse(file.read_text(encoding="utf-8")).body if isinstance(node, ast.ClassDef))


def test_every_public_name_is_documented() -> None:
    missing = []
    for section in reference.SECTIONS.values():
        missing += [name for name, value in reference.names(section) if not (getattr(value, "__doc__", None) or "")]
    assert missing == []


def test_a_scenario_has_a_page_with_all_that_a_learner_meets(tmp_path: Path) -> None:
    pages = gallery.pages(tmp_path, pictures=False, names=["circle_swap"])
    text = pages["scenarios/circle_swap.md"]
    for part in ("Parameters", "Observation", "Action", "Reward", "Endings", "Reference rows", "Policy circle_swap"):
        assert f"## {part}" in text
    told = irsim_gym.make("circle_swap").unwrapped.describe()
    assert all(f"`{block.name}`" in text for block in told.blocks)
    assert all(f"`{one.name}`" in text for one in (*told.rewards, *told.endings))
    assert "| `n_robots` | 4 |  | 2 to 64 |" in text
    assert "the classic test of giving way" in text
    card = card_of("cluttered_room")
    assert card is not None
    row = f"| 5 points of success lost at | {curves_text(card.robustness)} |"
    assert row in gallery.pages(tmp_path, pictures=False, names=["cluttered_room"])["scenarios/cluttered_room.md"]
    assert text.count((every_scenario()["circle_swap"]).read_text(encoding="utf-8").strip()) == 1


@pytest.mark.parametrize(
    ("name", "source", "team"),
    [
        ("circle_swap", "circle_swap", True),  # a shipped policy
        ("l_bend", "hybrid_astar", False),  # the best row of the suite
        ("jaxnav_corner_2", "pursuit", True),  # nobody succeeds
        ("corridor", "pursuit", False),  # not in the suite, no behaviour
        ("four_drives", None, False),  # behaviours of the file
    ],
)
def test_films_show_who_succeeds_most_often(name: str, source: str | None, team: bool) -> None:
    driver = films.driver_of(name)
    assert (driver.source, driver.team) == (source, team)


def test_a_film_ends_with_its_episode() -> None:
    shown = films.film("empty_goal")
    assert shown.caption == "The behaviour `pursuit` drives in this film of `test` level 0: success."
    assert 10 < len(shown.frames) < films.MOST_FRAMES
    assert {frame.shape for frame in shown.frames} == {(480, 480, 3)}
    assert not np.array_equal(shown.frames[0], shown.frames[-1])


def test_tables_escape_what_would_end_a_cell() -> None:
    assert tables.table(("a", "b"), [("x|y", 1.5)]) == "| a | b |\n| --- | --- |\n| x\\|y | 1.5 |"
    assert [tables.number(value) for value in (float("inf"), float("-inf"), 0.25)] == ["infinity", "-infinity", "0.25"]


def test_broken_links_of_a_site_are_found(tmp_path: Path) -> None:
    (tmp_path / "a.html").write_text(
        '<p id="top"><a href="b.html#there">b</a> <a href="b.html#gone">b</a> <a href="c.html">c</a>'
        '<img src="https://a.b/c.png" alt="far"><a href="https://a.b">web</a><img src="b.html"></p>',
        encoding="utf-8",
    )
    (tmp_path / "b.html").write_text('<h1 id="there">B</h1>', encoding="utf-8")
    assert check.broken_links(tmp_path) == [
        "a.html: b.html#gone: no such place",
        "a.html: c.html: no such file",
        "a.html: https://a.b/c.png: loaded from elsewhere",
        "a.html: b.html: no alternative text",
    ]


def test_links_of_sources_lead_back_to_the_names_of_the_reference(tmp_path: Path) -> None:
    (tmp_path / "_modules").mkdir()
    (tmp_path / "page.html").write_text('<dt id="public.Arena"></dt><dt id="public.Arena.rows"></dt>', encoding="utf-8")
    back = '<a class="viewcode-back" href="../page.html#{}">[docs]</a>'
    source = tmp_path / "_modules" / "arena.html"
    names = "public.Arena", "inner.Arena.rows", "inner.gone"
    source.write_text("".join(map(back.format, names)), encoding="utf-8")
    source_pages.mend(tmp_path)
    wanted = "public.Arena", "public.Arena.rows"
    assert source.read_text(encoding="utf-8") == "".join(map(back.format, wanted)) + back.replace("#{}", "")
    assert check.broken_links(tmp_path) == []


@pytest.mark.parametrize("file", sorted((ROOT / "docs" / "lessons").glob("*.ipynb")), ids=lambda file: file.stem)
def test_lessons_are_kept_with_small_outputs(file: Path) -> None:
    assert file.stat().st_size < MOST_BYTES
    book = json.loads(file.read_text(encoding="utf-8"))
    assert (book["nbformat"], book["metadata"]["kernelspec"]["name"]) == (4, "python3")
    outputs = [output for cell in book["cells"] for output in cell.get("outputs", ())]
    assert outputs, "run: make lessons"
    assert not [output for output in outputs if output["output_type"] == "error"]


def test_the_list_of_lessons_is_complete() -> None:
    text = (ROOT / "docs" / "lessons.md").read_text(encoding="utf-8")
    names = [file.stem for file in (ROOT / "docs" / "lessons").glob("*.ipynb")]
    assert len(names) == 8
    assert all(text.count(f"lessons/{name}\n") == text.count(f"lessons/{name}.ipynb") == 1 for name in names)
