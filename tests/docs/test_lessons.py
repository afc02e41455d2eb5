"""The notebooks of the site run from top to bottom, commands in them included."""

from __future__ import annotations

from pathlib import Path

import pytest

LESSONS = sorted((Path(__file__).parents[2] / "docs" / "lessons").glob("*.ipynb"))


@pytest.mark.slow
@pytest.mark.parametrize("file", LESSONS, ids=lambda file: file.stem)
@pytest.mark.filterwarnings("default")  # of Jupyter's own packages
def test_a_lesson_runs(file: Path, tmp_path: Path) -> None:
    pytest.importorskip("nbclient", reason="needs the extra docs, which `make test-slow` installs")
    from builder import lessons

    book = lessons.run(file, tmp_path)
    assert not [cell for cell in book.cells if any(output.output_type == "error" for output in cell.get("outputs", ()))]


@pytest.mark.slow
@pytest.mark.filterwarnings("default")
def test_a_command_that_fails_fails_its_lesson(tmp_path: Path) -> None:
    """Jupyter goes on after a command that fails."""
    pytest.importorskip("nbclient", reason="needs the extra docs, which `make test-slow` installs")
    import nbformat
    from builder import lessons
    from nbclient.exceptions import CellExecutionError

    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell("!irsim-gym check nowhere.yaml")])
    book.metadata["kernelspec"] = {"display_name": "Python 3", "language": "python", "name": "python3"}
    nbformat.write(book, tmp_path / "wrong.ipynb")
    with pytest.raises(CellExecutionError, match="exit status"):
        lessons.run(tmp_path / "wrong.ipynb", tmp_path)
