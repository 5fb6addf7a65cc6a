"""Fixtures that every test may use: where real recordings lie, and how hypothesis runs."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

collect_ignore_glob = ["clients/*.py"]  # scripts for other programs' interpreters: make check-clients

settings.register_profile("default", deadline=None, suppress_health_check=[HealthCheck.too_slow])
# a failure in continuous integration must be the same failure on the next run
settings.register_profile("ci", settings.get_profile("default"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "default")

_BESIDE_THE_PROJECT = Path(__file__).resolve().parents[2] / "shared" / "data"


def _data_entries() -> list[Path]:
    named = [Path(entry) for entry in os.environ.get("KINETOGRAPH_DATA", "").split(os.pathsep) if entry]
    return [*named, _BESIDE_THE_PROJECT]


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """A folder of real recordings (``walks/``, ``salsa/``, ``actions/``, ...); the test is skipped without one."""
    for entry in _data_entries():
        if (entry / "walks").is_dir():
            return entry
    pytest.skip("no recordings: set KINETOGRAPH_DATA to a folder that holds walks/, salsa/, ...")


@pytest.fixture(scope="session")
def clips_folder() -> Path:
    """The ``deepmimic-clips`` sample, found or fetched; the test is skipped where it cannot be had."""
    from kinetograph.errors import FetchError
    from kinetograph.samples import fetching as samples

    try:
        return samples.where("deepmimic-clips") or samples.fetch("deepmimic-clips")
    except FetchError as error:
        pytest.skip(f"no deepmimic-clips sample: {error}")
