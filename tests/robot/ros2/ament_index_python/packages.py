"""Where packages are installed."""

import os


def get_package_share_directory(package_name: str) -> str:
    """Return the folder that a test names."""
    return os.environ[f"SHARE_OF_{package_name}"]
