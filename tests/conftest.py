"""Fixtures that every test may use: where recordings are (``KINETOGRAPH_DATA``), and how hypothesis runs."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

collect_ignore_glob = ["clients/*.py"]  # scripts for other programs' interpreters: make check-clients

# keys and certificates of tests are none of the user's
_DATA = tempfile.mkdtemp(prefix="kinetograph-tests-")
atexit.register(shutil.rmtree, _DATA, ignore_errors=True)
os.environ["XDG_DATA_HOME"] = _DATA

settings.register_profile("default", deadline=None, suppress_health_check=[HealthCheck.too_slow])
# a failure in continuous integration must be the same failure on the next run
settings.register_profile("ci", settings.get_profile("default"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "default")


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """A folder of real recordings (``walks/``, ``salsa/``, ``actions/``, ...); the test is skipped without one."""
    from kinetograph.samples import data_folders

    for folder in data_folders():
        if (folder / "walks").is_dir():
            return folder
    pytest.skip("no recordings: set KINETOGRAPH_DATA to a folder that holds walks/, salsa/, ...")


@pytest.fixture(scope="session")
def clips_folder() -> Path:
    """The ``deepmimic-clips`` sample, found or fetched; the test is skipped where it cannot be had."""
    from kinetograph.errors import FetchError
    from kinetograph.samples import fetch

    try:
        return fetch("deepmimic-clips")
    except FetchError as error:
        pytest.skip(f"no deepmimic-clips sample: {error}")
