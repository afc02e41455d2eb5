#!/usr/bin/env bash
# Installs ROS 1 of Debian or Ubuntu for tests/ros, where it is missing.
set -euo pipefail

packages=(catkin cmake make python3-rospy python3-tf2-ros ros-core
    python3-geometry-msgs python3-nav-msgs python3-rosgraph-msgs python3-sensor-msgs)
missing=()
for package in "${packages[@]}"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q "install ok installed" || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

install="apt-get install -y --no-install-recommends ${missing[*]}"
if [ "$(id -u)" -eq 0 ]; then
    as_root=""
elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
    as_root="sudo"
else
    echo "make test-ros needs ROS 1; install it with: sudo $install" >&2
    exit 1
fi
$as_root apt-get update -q
DEBIAN_FRONTEND=noninteractive $as_root $install
