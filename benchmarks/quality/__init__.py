"""What an animator sees, one module per kind of fault. Elbows are in `kinetograph evaluate performance` of dances."""

from benchmarks.quality import filler, floor, partners, paths, repetition, soles


def main() -> None:
    for part in (paths, repetition, soles, filler, floor, partners):
        part.main()
