#!/usr/bin/env bash
# Installs the programs that the tests with windows and a browser start, where they are missing.
set -euo pipefail

missing=()
needs() { # needs PACKAGE COMMAND...: one of the commands is enough
    local package="$1" command
    shift
    for command in "$@"; do
        if command -v "$command" >/dev/null 2>&1; then return; fi
    done
    missing+=("$package")
}
needs xvfb Xvfb
needs xdotool xdotool
needs chromium chromium chromium-browser google-chrome
needs chromium-driver chromedriver
[ ${#missing[@]} -eq 0 ] && exit 0

install="apt-get install -y --no-install-recommends ${missing[*]}"
if ! command -v apt-get >/dev/null 2>&1; then
    echo "make test-gui needs, from your system's packages: ${missing[*]} (the names are Debian's)" >&2
    exit 1
fi
if [ "$(id -u)" -eq 0 ]; then
    as_root=""
elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
    as_root="sudo"
else
    echo "make test-gui needs more programs; install them with: sudo $install" >&2
    exit 1
fi
$as_root apt-get update -q
DEBIAN_FRONTEND=noninteractive $as_root $install
