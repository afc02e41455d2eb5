"""Folders of packages."""


class FindPackageShare:
    """Where a package is installed."""

    def __init__(self, package: str) -> None:
        self.package = package
