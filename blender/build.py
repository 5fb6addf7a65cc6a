# SPDX-License-Identifier: GPL-3.0-or-later
"""Zip the extension, always to the same bytes: python blender/build.py [FOLDER]. Prints the file."""

import sys
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
_TIME = (2000, 1, 1, 0, 0, 0)


def build(folder):
    """Write the zip into a folder; its path."""
    names = sorted(
        ["LICENSE", "blender_manifest.toml", *(p.name for p in HERE.glob("*.py") if p.name != Path(__file__).name)]
    )
    manifest = (HERE / "blender_manifest.toml").read_text()
    version = next(line.split('"')[1] for line in manifest.splitlines() if line.startswith("version"))
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"kinetograph-blender-{version}.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name in names:
            entry = zipfile.ZipInfo(name, _TIME)
            entry.external_attr, entry.compress_type, entry.create_system = 0o644 << 16, zipfile.ZIP_DEFLATED, 3
            archive.writestr(entry, (HERE / name).read_bytes())
    return path


if __name__ == "__main__":
    print(build(sys.argv[1] if len(sys.argv) > 1 else HERE.parent / "dist"))
