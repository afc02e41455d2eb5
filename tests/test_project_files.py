"""The files around the code: citation, forms, hooks and workflows say what is so."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

import irsim_gym

ROOT = Path(__file__).parents[1]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
FORMS = sorted(file for file in (ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml") if file.stem != "config")
SCHEMAS = {
    "citation-file-format": [ROOT / "CITATION.cff"],
    "dependabot": [ROOT / ".github" / "dependabot.yml"],
    "github-issue-config": [ROOT / ".github" / "ISSUE_TEMPLATE" / "config.yml"],
    "github-issue-forms": FORMS,
    "github-workflows": WORKFLOWS,
}


def read(file: Path) -> Any:
    return yaml.safe_load(file.read_text(encoding="utf-8"))


def project() -> dict[str, Any]:
    found: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return found


def steps(workflow: Path) -> Iterator[dict[str, Any]]:
    for job in read(workflow)["jobs"].values():
        yield from job["steps"]


def commands(workflow: Path) -> Iterator[str]:
    return (step["run"] for step in steps(workflow) if "run" in step)


@pytest.mark.parametrize("schema", SCHEMAS)
def test_a_file_has_the_form_that_its_readers_ask_for(schema: str) -> None:
    assert SCHEMAS[schema]
    command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", f"vendor.{schema}"]
    done = subprocess.run([*command, *map(str, SCHEMAS[schema])], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_citation_is_of_this_version() -> None:
    citation = read(ROOT / "CITATION.cff")
    assert citation["version"] == irsim_gym.__version__
    assert citation["license"] == project()["license"]
    assert [author["name"] for author in citation["authors"]] == [one["name"] for one in project()["authors"]]


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda file: file.stem)
def test_a_workflow_may_do_only_what_it_says(workflow: Path) -> None:
    found = read(workflow)
    assert found["permissions"] == {"contents": "read"}
    assert "secrets." not in workflow.read_text(encoding="utf-8")
    for job in found["jobs"].values():
        assert job["timeout-minutes"] <= 90
        if "permissions" in job:  # it publishes, so it runs for a tag or main alone, and builds nothing
            assert job["if"]
            assert not [step for step in job["steps"] if "run" in step]


def test_workflows_call_what_there_is() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z-]+):", makefile, re.MULTILINE))  # of the site
    extras = set(project()["optional-dependencies"])
    called = [command for workflow in WORKFLOWS for command in commands(workflow)]
    words = {word for command in called if command.startswith("make ") for word in command.split()[1:]}
    assert {word for word in words if re.fullmatch(r"[a-z-]+", word)} <= targets
    asked = [
        extra for command in called for found in re.findall(r"\.\[([\w,-]+)\]", command) for extra in found.split(",")
    ]
    assert asked
    assert set(asked) <= extras


def test_the_tests_of_the_workflow_are_those_of_make_test() -> None:
    marks = re.search(r'pytest (-n auto .* -m ".*?")', (ROOT / "Makefile").read_text(encoding="utf-8"))
    assert marks
    matrix = read(ROOT / ".github" / "workflows" / "tests.yml")["jobs"]["tests"]
    assert marks[1] in matrix["steps"][-1]["run"]
    versions = matrix["strategy"]["matrix"]["python"]
    assert f">={versions[0]}" == project()["requires-python"]
    assert {"ubuntu-latest", "macos-latest", "windows-latest"} == set(matrix["strategy"]["matrix"]["system"])


def test_the_linters_before_a_commit_are_those_of_make_lint() -> None:
    """They come from the environment, so that no second list of versions exists."""
    hooks = [hook for repo in read(ROOT / ".pre-commit-config.yaml")["repos"] for hook in repo["hooks"]]
    linted = re.findall(r"python -m (ruff check|ruff format|mypy)", (ROOT / "Makefile").read_text(encoding="utf-8"))
    entries = {hook["entry"]: hook["language"] for hook in hooks}
    for name in linted:
        (entry,) = (entry for entry in entries if entry.startswith(f"python -m {name}"))
        assert entries[entry] == "system"


def test_platforms_that_were_never_tried_are_named() -> None:
    """Classifiers promise only what has run; CONTRIBUTING.md names the rest of what the workflow tests."""
    tried = {one.rsplit(" ", 1)[-1] for one in project()["classifiers"] if re.search(r"Python :: 3\.\d", one)}
    matrix = read(ROOT / ".github" / "workflows" / "tests.yml")["jobs"]["tests"]["strategy"]["matrix"]
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    section = page.split("## Platforms")[1].split("\n## ")[0]
    for version in set(matrix["python"]) - tried:
        assert f"Python {version}" in section
    for system in ("macOS", "Windows"):
        assert system in section
