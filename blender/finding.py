# SPDX-License-Identifier: GPL-3.0-or-later
"""Where kinetograph is: in the preferences, on the PATH, or in an environment that the extension makes."""

import os
import shutil
import subprocess
import sys
import threading
from pathlib import Path

try:
    from .link import Trouble
except ImportError:  # a test without Blender
    from link import Trouble

ADVICE = "kinetograph is not installed: press Install in the extension's preferences, or name where it is"


def command(preferred, managed):
    """What starts kinetograph, as a list. Raises Trouble."""
    if preferred:
        path = Path(os.path.expanduser(preferred))
        if path.is_dir():
            path = in_environment(path)
        if path.is_file():
            return [str(path)]
        found = shutil.which(preferred)
        if found is None:
            raise Trouble(f"{preferred}: there is no kinetograph; correct it in the extension's preferences")
        return [found]
    found = shutil.which("kinetograph")
    if found is None and managed and in_environment(managed).is_file():
        found = str(in_environment(managed))
    if found is None:
        raise Trouble(ADVICE)
    return [found]


def in_environment(folder):
    """The program of a virtual environment."""
    windows = os.name == "nt"
    return Path(folder) / ("Scripts" if windows else "bin") / ("kinetograph.exe" if windows else "kinetograph")


class Installing:
    """A virtual environment that is being made, and kinetograph installed into it; ``said`` is its latest line."""

    def __init__(self, folder, package="kinetograph", python=None):
        self.folder = Path(folder)
        self.said = "making an environment"
        self.error = None
        self.done = False
        self._wanted = True
        self._process = None
        self._package, self._python = package, python or sys.executable
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def wait(self):
        """Wait until it is done."""
        self._thread.join()

    def cancel(self):
        """Give it up."""
        self._wanted = False
        if self._process is not None:
            self._process.kill()

    def _run(self):
        python = self.folder / ("Scripts" if os.name == "nt" else "bin") / "python"
        try:
            self._call([self._python, "-m", "venv", str(self.folder)])
            self._call([str(python), "-m", "pip", "install", "--disable-pip-version-check", "-U", self._package])
        except (OSError, Trouble) as error:
            self.error = str(error)
        self.done = True

    def _call(self, words):
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
        with subprocess.Popen(words, env=_clean(), **pipes) as self._process:
            for line in self._process.stdout:
                self.said = line.strip() or self.said
        if self._process.returncode != 0:
            raise Trouble(f"it could not be installed: {self.said}" if self._wanted else "cancelled")


def _clean():
    return {key: value for key, value in os.environ.items() if key not in ("PYTHONHOME", "PYTHONPATH")}
