"""What docs/libraries.md shows is run."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "libraries.md"
SECTION = re.compile(r"^## (\w+) ([\d.]+)\n(.*?)(?=^## |\Z)", re.MULTILINE | re.DOTALL)
SECTIONS = SECTION.findall(PAGE.read_text(encoding="utf-8"))


@pytest.mark.parametrize(("library", "version", "text"), SECTIONS, ids=[section[0] for section in SECTIONS])
def test_blocks_run(library, version, text, tmp_path):
    module = pytest.importorskip(library.lower())
    if getattr(module, "__version__", version) != version:
        pytest.skip(f"{library} {module.__version__} is here, which comes with others")
    blocks = re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    assert blocks
    for k, block in enumerate(blocks):
        script = tmp_path / f"block_{k}.py"
        script.write_text(block, encoding="utf-8")
        done = subprocess.run([sys.executable, str(script)], cwd=tmp_path, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
