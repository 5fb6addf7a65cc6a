"""What an animator sees, one module per kind of fault. Elbows are in `kinetograph evaluate performance` of dances."""

from benchmarks.quality import partners, paths


def main() -> None:
    for part in (paths, partners):
        part.main()
