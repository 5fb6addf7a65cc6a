"""Bodies in the floor, and falls faster than free, of keyframe control on the sample's clips."""

from __future__ import annotations

import itertools
import tempfile
from pathlib import Path

from benchmarks.quality.filler import KEYS, clips_library, key_of
from kinetograph.errors import RequestError
from kinetograph.evaluation import below_pieces, seam_falls
from kinetograph.methods.keyframe import KeyframeControl
from kinetograph.post import PostSettings


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        library = clips_library(Path(folder))
        print("keys 0.25 s on       lowest below recordings cm, pair        fastest fall at a seam, pair")
        for name, floor in (("blended only", False), ("kept above", True)):
            model = KeyframeControl(post=PostSettings(floor=floor)).fit(library)
            deep, fast = (0.0, ""), (0.0, "")
            for first, last in itertools.permutations(KEYS, 2):
                keys = [key_of(library, first, KEYS[first] + 0.25), key_of(library, last, KEYS[last] + 0.25)]
                try:
                    made = model.synthesize(keys)
                except RequestError:
                    continue
                pair = f"{first} to {last}"
                deep = max(deep, (100 * below_pieces(made, model.examples), pair))
                fast = max(fast, (float(seam_falls(made, model.examples).max(initial=0.0)), pair))
            print(f"   {name:16s} {deep[0]:6.1f} {deep[1]:32s} {fast[0]:6.2f} {fast[1]}")
