"""Run the notebooks of docs/lessons from top to bottom, and keep their outputs.

python docs/run_lessons.py [NAME...]
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from builder.lessons import FOLDER, run, write


def main(names: list[str]) -> None:
    """Run notebooks, by default all."""
    for name in names or sorted(file.stem for file in FOLDER.glob("*.ipynb")):
        with tempfile.TemporaryDirectory() as folder:
            write(run(FOLDER / f"{name}.ipynb", Path(folder)), FOLDER / f"{name}.ipynb")
        print(name)


if __name__ == "__main__":
    main(sys.argv[1:])
