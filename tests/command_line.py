"""The command line, called in this process."""

from __future__ import annotations

import sys

import pytest

from irsim_gym.cli import app as cli


def run(monkeypatch: pytest.MonkeyPatch, *arguments: object) -> int:
    """Run ``irsim-gym`` with these arguments, and return its exit status."""
    monkeypatch.setattr(sys, "argv", ["irsim-gym", *map(str, arguments)])
    with pytest.raises(SystemExit) as end:
        cli.main()
    return int(end.value.code or 0)
