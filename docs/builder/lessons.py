"""Notebooks: run in a folder of their own, and kept with small outputs."""

from __future__ import annotations

import base64
import io
import os
import re
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import nbformat.v4
from nbclient import NotebookClient
from PIL import Image

FOLDER = Path(__file__).parents[1] / "lessons"
CELL_S = 900
"""A cell that takes longer than that [s] hangs: a whole lesson takes less than 300 s on two cores."""
STRICT = """
def _strictly(shell=get_ipython(), run=get_ipython().system):
    def system(command):
        run(command)
        if shell.user_ns["_exit_code"]:
            raise RuntimeError(f"{command}: exit status {shell.user_ns['_exit_code']}")
    shell.system = system
_strictly()
"""
"""Run before a notebook: a command that fails is an error, which Jupyter passes over."""
COLORS = 64
SIDE = 480
"""Longer side of a picture, at most [pixels]."""
MOST_LINES = 60
LANGUAGE = {"name": "python", "pygments_lexer": "ipython3"}
TEXT = "text/plain"
CONTROL = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")


def run(file: Path, folder: Path) -> Any:
    """Return a notebook after it has been run.

    Args:
        file: The notebook.
        folder: Its working folder.

    Raises:
        nbclient.exceptions.CellExecutionError: A cell, or a command in it, fails.
    """
    book: Any = nbformat.read(file, as_version=4)  # type: ignore[no-untyped-call]
    beside = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    kernel = {**os.environ, "PATH": beside, "COLUMNS": "100", "TERM": "dumb", "NO_COLOR": "1"}
    book.cells.insert(0, nbformat.v4.new_code_cell(STRICT))  # type: ignore[no-untyped-call]
    client = NotebookClient(book, timeout=CELL_S, resources={"metadata": {"path": str(folder)}})
    client.execute(env=kernel)
    del book.cells[0]
    for cell in book.cells:
        if cell.cell_type == "code":
            cell.outputs = [output for output in map(small, joined(cell.outputs)) if output is not None]
            cell.metadata = {}
    book.metadata = {"kernelspec": book.metadata["kernelspec"], "language_info": LANGUAGE}
    return book


def joined(outputs: Iterable[Any]) -> list[Any]:
    """Return outputs with neighbouring parts of what a cell prints as one; a progress bar comes in many parts."""
    kept: list[Any] = []
    for output in outputs:
        if output.output_type == "stream" and output.name == "stderr":
            continue
        if kept and kept[-1].output_type == output.output_type == "stream":
            kept[-1].text += output.text
        else:
            kept.append(output)
    return kept


def small(output: Any) -> Any:
    """Return an output with small pictures and few lines, or None where nothing is left."""
    if output.output_type == "stream":
        output.text = shortened(output.text)
        return output if output.text else None
    data = output.get("data", {})
    if "image/png" in data:
        picture = Image.open(io.BytesIO(base64.b64decode(data["image/png"]))).convert("RGB")
        picture.thumbnail((SIDE, SIDE))
        packed = io.BytesIO()
        picture.quantize(COLORS).save(packed, "png", optimize=True)
        output.data = {"image/png": base64.b64encode(packed.getvalue()).decode(), TEXT: "a picture"}
    elif TEXT in data:
        output.data = {TEXT: shortened(data[TEXT])}
    return output


def shortened(text: str) -> str:
    """Return a text as a terminal would show it in the end, without its middle where it is long."""
    lines = [line.rsplit("\r", 1)[-1].rstrip() for line in CONTROL.sub("", text).replace("\r\n", "\n").split("\n")]
    if len(lines) > MOST_LINES:
        left_out = len(lines) - MOST_LINES
        lines = [*lines[: MOST_LINES // 2], f"... ({left_out} more lines)", *lines[-MOST_LINES // 2 :]]
    return "\n".join(lines)


def write(book: Any, file: Path) -> None:
    """Write a notebook to a temporary file, and rename it."""
    for number, cell in enumerate(book.cells):
        cell.id = f"cell-{number}"
        if cell.cell_type == "code":
            cell.execution_count = None
            for output in cell.outputs:
                if "execution_count" in output:
                    output.execution_count = None
    unfinished = file.with_suffix(".unfinished")
    nbformat.write(book, unfinished)  # type: ignore[no-untyped-call]
    unfinished.replace(file)
