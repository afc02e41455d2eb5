"""Tests with other libraries, each in a loop of its own: run by `make test-libraries`.

`make test` imports these files too, without the libraries: import those inside functions, by `pytest.importorskip`.
"""

from __future__ import annotations

from pathlib import Path

import pytest

HERE = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.libraries)
            item.add_marker(pytest.mark.filterwarnings("ignore"))  # what these libraries warn of is theirs
