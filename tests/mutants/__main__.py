"""Mutation testing: small faults are put into the package, one at a time, and the tests must notice.

``python -m tests.mutants --count 200 --seed 1 --minutes 60`` prints the share that was noticed and every fault that was
not. Which tests call a function is found once, by running them under a profiler (``--map FILE`` keeps it); a fault is
given to those tests alone, the quickest first. It works on copies of the checkout in ``build/mutants``.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import shutil
import subprocess
import sys
import time
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import Queue

from tests.mutants.sites import Fault, drawn

ROOT = Path(__file__).parents[2]
ROOMS = ("methods", "post", "segmentation", "sensing", "formats", "library")
_ROOMS = ("attack", "cli", "clients", "drawing", "evaluation", "live", "studio")
_SLOW = ("formats/test_damage.py", "formats/test_claims.py", "library/test_crash.py", "library/test_backup.py")
LEFT_OUT = tuple(f"tests/{name}" for name in (*_ROOMS, *_SLOW, "test_layers.py", "test_docs.py", "test_lazy_doors.py"))
"""Tests that no fault is given to: of other rooms and of whole programs, and what damages thousands of files."""

Calls = dict[str, list[str]]
"""Function, as ``path:name:line`` -> the tests that call it, the quickest first."""


def main() -> int:
    """Run it; 1 where fewer faults were noticed than asked for."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--least", type=float, default=0.92, help="share that must be noticed")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--map", type=Path, default=ROOT / "build/mutants/calls.json")
    parser.add_argument("--folder", type=Path, default=ROOT / "build/mutants")
    options = parser.parse_args()
    end = time.monotonic() + 60 * options.minutes
    first = _copy(options.folder / "0")
    if not options.map.exists():
        _map(first, options.map)
    more = [options.folder / str(job) for job in range(1, options.jobs)]
    folders = [first, *(Path(shutil.copytree(first, folder, dirs_exist_ok=True)) for folder in more)]  # kernels as well
    package = folders[0] / "src/kinetograph"
    paths = [path for room in ROOMS for path in sorted((package / room).rglob("*.py"))]
    faults = drawn(paths, options.count, options.seed)
    finder = _Finder(package, json.loads(options.map.read_text()))
    free: Queue[Path] = Queue()
    for folder in folders:
        free.put(folder)
    survived, judged = [], 0
    with ThreadPoolExecutor(options.jobs) as pool:
        judge = lambda fault: _judge(fault, finder, free, folders[0], end)  # noqa: E731
        for fault, verdict in zip(faults, pool.map(judge, faults), strict=True):
            judged += verdict != "not tried"
            if verdict in ("survived", "no test"):
                survived.append(fault)
            place = str(fault).replace(f"{folders[0]}/src/kinetograph/", "")
            print(f"{verdict:<10} {place}", flush=True)
    share = 1 - len(survived) / max(judged, 1)
    print(f"{judged - len(survived)} of {judged} noticed ({share:.0%}), seed {options.seed}")
    return int(share < options.least)


def _copy(folder: Path) -> Path:
    """The files that git knows, in a folder; compiled kernels that are there already stay."""
    names = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")
    for name in filter(None, names):
        source, copy = ROOT / name, folder / name
        if source.is_file() and not (copy.exists() and copy.read_bytes() == source.read_bytes()):
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(source, copy)
    return folder


def _environment(folder: Path) -> dict[str, str]:
    paths = f"{folder / 'src'}{os.pathsep}{folder}"
    return {
        **os.environ,
        "PYTHONPATH": paths,
        "CI": "true",
        "KINETOGRAPH_NO_BROWSER": "not looked at",
    }


def _map(folder: Path, file: Path) -> None:
    """Run all tests under the profiler."""
    ignored = [f"--ignore={name}" for name in LEFT_OUT]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "tests.mutants.calls", "-p", "no:cacheprovider", *ignored]
    subprocess.run(command, cwd=folder, env=_environment(folder) | {"KINETOGRAPH_CALLS": str(file)}, check=False)


class _Finder:
    """The tests of each function; those of a compiled function, which no profiler sees, are its callers' tests."""

    def __init__(self, package: Path, rows: dict[str, dict[str, object]]) -> None:
        self.seconds = {test: float(str(row["seconds"])) for test, row in rows.items()}
        self.tests: dict[str, set[str]] = defaultdict(set)
        for test, row in rows.items():
            for function in row["calls"]:  # type: ignore[attr-defined]
                self.tests[function] |= {test}
        self.users: dict[str, set[str]] = defaultdict(set)
        for path in sorted(package.rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_bytes())):
                if isinstance(node, ast.FunctionDef):
                    here = f"{path.relative_to(package.parent)}:{node.name}:{_first(node)}"
                    for name in ast.walk(node):
                        if isinstance(name, ast.Name | ast.Attribute):
                            self.users[name.id if isinstance(name, ast.Name) else name.attr].add(here)

    def of(self, fault: Fault, root: Path) -> list[str]:
        """The tests that call the function of a fault, the quickest first."""
        name, _, _ = fault.function.partition(":")
        path = fault.path.relative_to(root / "src")
        keys = {key for key in self.tests if key.startswith(f"{path}:{name}:")}
        todo, seen = [name], {name}
        while not keys and todo:
            users = self.users[todo.pop()]
            keys |= {user for user in users if user in self.tests}
            more = {user.split(":")[1] for user in users} - seen
            seen |= more
            todo += sorted(more)
        tests = set().union(*(self.tests[key] for key in keys)) if keys else set()
        return sorted(tests, key=lambda test: self.seconds[test])


def _first(node: ast.FunctionDef) -> int:
    return min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])


def _judge(fault: Fault, finder: _Finder, free: Queue[Path], root: Path, end: float, most: float = 90.0) -> str:
    """``killed``, ``survived``, ``no test`` or ``not tried``."""
    tests = finder.of(fault, root)
    if not tests or time.monotonic() > end:
        return "not tried" if tests else "no test"
    chosen, seconds = [], 0.0
    for test in tests:
        seconds += finder.seconds[test]
        if seconds > most and chosen:
            break
        chosen.append(test)
    folder = free.get()
    try:
        return _run(folder, folder / fault.path.relative_to(root), fault, chosen, 60 + 4 * seconds)
    finally:
        free.put(folder)


def _run(folder: Path, path: Path, fault: Fault, tests: list[str], limit: float) -> str:
    """Whether tests fail with a fault in a file of a copy, which is put back afterwards, its time as well."""
    before, stamp = path.read_bytes(), path.stat()
    environment = _environment(folder)
    if "kernels" in path.name:  # kernels that call the changed one would be taken from the cache
        environment["NUMBA_CACHE_DIR"] = str(folder / "build/numba")
        shutil.rmtree(folder / "build/numba", ignore_errors=True)
        limit += 300
    path.write_bytes(fault.source())
    try:
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "--no-header", *tests]
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, timeout=limit, check=False)
        return "survived" if done.returncode == 0 else "killed"
    except subprocess.TimeoutExpired:
        return "killed"  # a loop that does not end is noticed by whoever waits
    finally:
        path.write_bytes(before)
        os.utime(path, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))


if __name__ == "__main__":
    sys.exit(main())
