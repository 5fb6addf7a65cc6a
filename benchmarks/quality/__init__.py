"""What an animator sees, one module per kind of fault. Elbows are in `kinetograph evaluate performance` of dances."""

from benchmarks.quality import filler, floor, paths


def main() -> None:
    for part in (paths, filler, floor):
        part.main()
