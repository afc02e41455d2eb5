"""What README.md, CONTRIBUTING.md and the pages of the site show is run."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from command_line import run

import irsim_gym
from irsim_gym.base import families

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
CONTRIBUTING = ROOT / "CONTRIBUTING.md"
DOCS = ROOT / "docs"
PICTURE = DOCS / "cluttered_room.png"
READ = (
    *("start", "own_scenario", "policies", "irsim_files", "scripts", "rendering", "driving", "training"),
    *("shield", "images", "teams", "guides", "plugins", "performance", "reproducibility", "submitting", "questions"),
    *("from_irsim", "from_vmas", "from_navground_learning"),
)
"""Pages of docs/ in the order of reading; other tests run the blocks of the rest."""
PAGES = (README, *(DOCS / f"{name}.md" for name in READ), CONTRIBUTING)
TRANSLATIONS = ((README, ROOT / "README.zh.md"), (DOCS / "start.md", DOCS / "start.zh.md"))
"""Pages, and the same in another language."""
NOT_FOLLOWED = (CONTRIBUTING, DOCS / "submitting.md")
"""Pages about runs of one's own."""
GROUPS = {"suite"}
"""Commands that have commands of their own."""
LONG = {"make", "train", "evaluate", "arena", "record", "demo", "play", "bench", "suite"}
LARGEST_DIFFERENCE = 8.0
PROGRAM = [sys.executable, "-c", "from irsim_gym.cli import main; main()"]


FOLDERS = ("agents", "benchmarks", "configs")
NO_PLACES = {"reward/progress", "agents/hyperparameters/ALGORITHM.yaml", "pi/2"}
"""What looks like a place on pages about the design: a key, a pattern."""
ELSEWHERE = {"make", "source", "pip", "play"}
"""What sets up or opens a window: not run when a page is followed from top to bottom."""


@dataclass(frozen=True)
class Block:
    """A fenced block of a page."""

    page: str
    line: int
    language: str
    text: str

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"


def all_blocks(page: Path) -> list[Block]:
    text = page.read_text(encoding="utf-8")
    return [
        Block(page.name, text.count("\n", 0, found.start()) + 1, found[1], found[2])
        for found in re.finditer(r"^```(\w+)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    ]


def blocks(page: Path, language: str) -> list[Block]:
    return [block for block in all_blocks(page) if block.language == language]


def on_pages(language: str) -> list[Block]:
    return [block for page in PAGES for block in blocks(page, language)]


def lines_of(block: Block) -> list[str]:
    lines = [line.split("#")[0].strip() for line in block.text.splitlines()]
    return [line for line in lines if line]


def commands(page: Path) -> list[str]:
    return [line for block in blocks(page, "bash") for line in lines_of(block)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the files that the pages show, named as their code blocks name them."""
    place = tmp_path_factory.mktemp("readme")
    for block in on_pages("yaml"):
        (place / _file_name(block)).write_text(block.text, encoding="utf-8")
    for block in on_pages("python"):
        if block.text.startswith("# "):
            (place / block.text.split()[1]).write_text(block.text, encoding="utf-8")
    return place


@pytest.fixture
def at_home(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Be in the reader's folder; modules and kinds that are loaded from it are forgotten again."""
    modules = set(sys.modules)
    families.load()
    for family in families.every():
        monkeypatch.setattr(family, "_entries", dict(family._entries))
    monkeypatch.chdir(folder)
    monkeypatch.syspath_prepend(str(folder))
    yield
    for name in set(sys.modules) - modules:
        if str(getattr(sys.modules[name], "__file__", None) or "").startswith(str(folder)):
            del sys.modules[name]


@pytest.mark.parametrize("block", on_pages("python"), ids=str)
@pytest.mark.usefixtures("at_home")
def test_python_blocks_run(block: Block) -> None:
    """In this process; that they run in processes of their own is a slow test."""
    exec(compile(block.text, str(block), "exec", dont_inherit=True), {"__name__": "__main__"})


@pytest.mark.parametrize("block", on_pages("yaml"), ids=str)
def test_scenarios_load_and_run(block: Block, folder: Path) -> None:
    env = irsim_gym.make(folder / _file_name(block))
    env.reset(seed=0)
    env.step(env.action_space.sample())
    env.close()


@pytest.mark.parametrize("command", list(dict.fromkeys(line for page in PAGES for line in commands(page))))
@pytest.mark.usefixtures("at_home")
def test_commands_exist(command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Short commands are run; of the long ones it is checked that they exist and take these options."""
    words = shlex.split(command)
    words = [word for word in words if not re.fullmatch(r"[A-Z_]+=.*", word)]
    if words[0] == "make":
        rules = (ROOT / "Makefile").read_text(encoding="utf-8")
        assert all(re.search(rf"^{target}:", rules, re.MULTILINE) for target in words[1:])
    elif words[0] == "irsim-gym":
        if words[1] in LONG:
            monkeypatch.setenv("COLUMNS", "200")
            assert run(monkeypatch, *words[1 : 3 if words[1] in GROUPS else 2], "--help") == 0
            shown = capsys.readouterr().out
            assert all(word.split("=")[0] in shown for word in words if word.startswith("--"))
        else:
            assert run(monkeypatch, *words[1:]) == 0
    else:
        assert words[0] in {"pip", "source"}, f"cannot check: {command}"


@pytest.mark.slow
def test_a_reader_who_follows_the_pages_gets_everywhere(tmp_path: Path) -> None:
    """Whatever stands there runs as it stands, in the order in which it stands, trainings included."""
    (tmp_path / "agents").symlink_to(ROOT / "agents")
    for block in (block for page in PAGES if page not in NOT_FOLLOWED for block in all_blocks(page)):
        named = re.match(r"# (\S+\.(?:yaml|py))\n", block.text)
        if named is not None:
            (tmp_path / named[1]).write_text(block.text, encoding="utf-8")
        if block.language == "python":
            _run([sys.executable, "-W", "error", "-c", block.text], tmp_path, 600)
        for words in map(shlex.split, lines_of(block) if block.language == "bash" else ()):
            if not ELSEWHERE.intersection(words[:2]):
                _run([*PROGRAM, *words[1:]], tmp_path, 1800)


@pytest.mark.slow
def test_blocks_for_contributors_run_in_processes_of_their_own(folder: Path) -> None:
    for block in blocks(CONTRIBUTING, "python"):
        _run([sys.executable, "-W", "error", "-c", block.text], folder)


def test_the_picture_is_the_first_blocks(folder: Path) -> None:
    """The committed picture is what the first code block makes, but for fonts and anti-aliasing."""
    import imageio.v3 as iio

    first = blocks(DOCS / "start.md", "python")[0]
    _run([sys.executable, "-W", "error", "-c", first.text], folder)
    made = iio.imread(folder / PICTURE.name)[..., :3].astype(np.float64)
    shown = iio.imread(PICTURE)[..., :3].astype(np.float64)
    assert made.shape == shown.shape
    assert np.abs(made - shown).mean() < LARGEST_DIFFERENCE


def pages_of_folders() -> Iterator[Path]:
    """Yield the pages that stand outside of docs/, in folders."""
    for name in FOLDERS:
        yield from (ROOT / name).glob("*.md")


def test_links_lead_somewhere() -> None:
    for page in (*ROOT.glob("*.md"), *DOCS.rglob("*.md"), *pages_of_folders()):
        text = page.read_text(encoding="utf-8")
        for target in re.findall(r"(?:\]\(|^\[\w+\]: )([^)#\s]+)", text, re.MULTILINE):
            assert target.startswith("https://") or (page.parent / target).exists(), f"{page.name}: {target}"


def test_lines_of_pages_have_at_most_120_characters() -> None:
    """Rows of tables and commands may be longer."""
    pages = [*ROOT.glob("[!R]*.md"), *DOCS.rglob("*.md"), *pages_of_folders()]
    lines = [(page, n, line) for page in pages for n, line in enumerate(page.read_text("utf-8").splitlines(), 1)]
    long = [one for one in lines if len(one[2]) > 120 and not one[2].startswith(("|", "irsim-gym ", "python "))]
    assert not [f"{page.relative_to(ROOT)}:{n}" for page, n, _ in long]


def test_the_first_page_is_short_and_its_figures_stand_where_it_says() -> None:
    text = README.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 120
    speed, agents = (page.read_text(encoding="utf-8") for page in (DOCS / "speed.md", ROOT / "agents" / "README.md"))
    shown = (("0.52", speed), ("1,345", speed), ("98.2", agents), ("99.1", agents), ("95.5", agents), ("99.9", agents))
    for figure, page in shown:
        assert figure in text
        assert figure in page


@pytest.mark.parametrize(("english", "other"), TRANSLATIONS, ids=lambda page: page.name)
def test_translations_show_the_same_code_links_and_figures(english: Path, other: Path) -> None:
    """Only comments are translated; a page that is translated too may take the place of another in a link."""
    same = {"start.md": "start.zh.md", "docs/start.md": "docs/start.zh.md", "README.md": "README.zh.md"}
    for page in (english, other):
        assert len(all_blocks(page)) >= 3
    assert [lines_of(block) for block in all_blocks(english)] == [lines_of(block) for block in all_blocks(other)]
    linked = [re.findall(r"\]\(([^)]+)\)", page.read_text(encoding="utf-8")) for page in (english, other)]
    mine, theirs = ({same.get(target, target) for target in targets} for targets in linked)
    assert theirs - mine <= {"start.zh.md", "README.zh.md"}
    assert mine - theirs <= {"README.zh.md", "start.zh.md", "docs/start.zh.md"}
    figures = [re.findall(r"\d[\d,.]*\d", _without_blocks(page)) for page in (english, other)]
    assert sorted(set(figures[0])) == sorted(set(figures[1]))


def _without_blocks(page: Path) -> str:
    """Return the text of a page without code blocks, inline code and targets of links."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    return re.sub(r"`[^`]*`|\]\([^)]*\)", "", text)


def test_design_leads_to_the_page_of_each_room() -> None:
    linked = re.findall(r"\]\(docs/design/(\w+)\.md\)", (ROOT / "DESIGN.md").read_text(encoding="utf-8"))
    assert sorted(linked) == sorted(page.stem for page in (DOCS / "design").glob("*.md"))
    assert len(linked) == 12


def test_pages_about_the_design_are_short() -> None:
    """What a page gains, it loses elsewhere."""
    most = {ROOT / "DESIGN.md": 200, **dict.fromkeys((DOCS / "design").glob("*.md"), 150)}
    lengths = {page.name: page.read_text(encoding="utf-8").count("\n") for page in most}
    assert [page.name for page, lines in most.items() if lengths[page.name] > lines] == []
    newest = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").split("\n## ")[1]
    assert newest.count("\n") <= 250


def test_pages_about_the_design_name_what_there_is() -> None:
    """Places in backticks lie in the room of the page, in the package, or in the repository."""
    gone = []
    for page in (ROOT / "DESIGN.md", *(DOCS / "design").glob("*.md")):
        homes = ROOT / "irsim_gym" / page.stem, ROOT / "irsim_gym", ROOT
        for place in re.findall(r"`([\w./]+/[\w./]*|[\w./]+\.py)`", page.read_text(encoding="utf-8")):
            files = [home / f"{place.rstrip('/')}{suffix}" for home in homes for suffix in ("", ".py")]
            files += [] if "/" in place else homes[0].rglob(place)
            if not any(file.exists() for file in files) and place not in NO_PLACES:
                gone.append(f"{page.name}: {place}")
    assert gone == []


def _file_name(block: Block) -> str:
    named = re.match(r"#\s*(\S+\.yaml)", block.text)
    return named[1] if named else f"block_{block.line}.yaml"


def _run(command: list[str], folder: Path, most_s: float = 300) -> str:
    outside = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    result = subprocess.run(
        command, cwd=folder, env=outside, capture_output=True, text=True, check=False, timeout=most_s
    )
    assert result.returncode == 0, f"{result.stdout}\n{result.stderr}"
    return result.stdout
