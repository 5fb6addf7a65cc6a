"""What an animator sees, one module per kind of fault. Elbows are in `kinetograph evaluate performance` of dances."""

from benchmarks.quality import paths, repetition, soles


def main() -> None:
    for part in (paths, repetition, soles):
        part.main()
