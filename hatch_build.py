"""What a package index shows: README.md with links that lead into the repository on the web, and where that is."""

from __future__ import annotations

import re
import subprocess
from email.parser import Parser
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

LINK = re.compile(r"(!?)\[([^\]]*)\]\((?!https?://|#)([^)\s]+)\)")


class CustomMetadataHook(MetadataHookInterface):
    """Write the description and the addresses while a wheel or an sdist is built."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Fill in ``readme`` and ``urls``."""
        metadata["readme"] = {"content-type": "text/markdown", "text": description(Path(self.root))}
        metadata["urls"] = addresses(Path(self.root))


def addresses(root: Path) -> dict[str, str]:
    """Return where the project is on the web, by label; those of an sdist were written when it was built."""
    built = root / "PKG-INFO"
    if built.is_file():
        written = Parser().parsestr(built.read_text(encoding="utf-8")).get_all("Project-URL", [])
        return dict(one.split(", ", 1) for one in written)
    name = repository(root)
    if name is None:
        return {}
    base = f"https://github.com/{name}"
    return {"Source": base, "Issues": f"{base}/issues", "Changelog": f"{base}/blob/HEAD/CHANGELOG.md"}


def description(root: Path) -> str:
    """Return the description; that of an sdist was written when it was built."""
    built = root / "PKG-INFO"
    if built.is_file():
        return str(Parser().parsestr(built.read_text(encoding="utf-8")).get_payload())
    text = (root / "README.md").read_text(encoding="utf-8")
    return linked(text, repository(root), _git(root, "rev-parse", "HEAD") or "HEAD")


def repository(root: Path) -> str | None:
    """Return ``owner/name`` on GitHub of the remote ``origin``; None without one."""
    origin = _git(root, "remote", "get-url", "origin")
    found = re.fullmatch(r"(?:https://|ssh://git@|git@)github\.com[/:]([\w.-]+/[\w.-]+?)(?:\.git)?/?", origin)
    return found[1] if found else None


def linked(text: str, name: str | None, commit: str) -> str:
    """Return Markdown whose relative links lead to a commit on GitHub.

    Args:
        text: The Markdown.
        name: ``owner/name``; None leaves pictures out, and of links the words.
        commit: The commit.
    """

    def replaced(found: re.Match[str]) -> str:
        mark, words, target = found.groups()
        if name is None:
            return "" if mark else words
        base = "https://raw.githubusercontent.com" if mark else "https://github.com"
        return f"{mark}[{words}]({base}/{name}/{'' if mark else 'blob/'}{commit}/{target})"

    return LINK.sub(replaced, text)


def _git(root: Path, *arguments: str) -> str:
    """Return what git prints, nothing where it cannot."""
    try:
        done = subprocess.run(["git", "-C", str(root), *arguments], capture_output=True, text=True, check=False)
    except OSError:
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""
