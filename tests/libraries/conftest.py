"""Tests with other libraries, each in a loop of its own: run by `make test-libraries`.

`make test` imports these files too, without the libraries: import those inside functions, by `needed.library`.
"""

from __future__ import annotations

from pathlib import Path

import pytest

HERE = Path(__file__).parent
WARNINGS = ("ignore", "error:::irsim_gym")
"""What these libraries warn of is theirs, what our modules cause is ours."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.libraries)
            item.add_marker(pytest.mark.filterwarnings(*WARNINGS))
