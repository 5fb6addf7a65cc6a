"""What an animator sees, one module per kind of fault. Elbows are in `kinetograph evaluate performance` of dances."""

from benchmarks.quality import paths, repetition


def main() -> None:
    for part in (paths, repetition):
        part.main()
