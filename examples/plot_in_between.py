"""
In-between two poses
====================

Two poses are the control: lying on the floor, and half a step into a run. Recordings lead from one to the other, and
both poses are met exactly.
"""

import kinetograph as kg
from clips import picture, rises
from kinetograph.drawing import contact_sheet
from kinetograph.keys import key_at

# %%
# Keys
# ----
#
# A key is a pose out of a clip. What else is asked of it (a time, a place, a heading) is up to you; here the second
# key is to be met 5 seconds after the first.

library = rises()
lying, running = (library.take(f"humanoid3d_{name}").motion() for name in ("getup_facedown", "run"))
keys = (key_at(lying, 0.0), key_at(running, 0.4, time=(5.0, 5.0)))

# %%
# The motion
# ----------

model = kg.KeyframeControl().fit(library)
result = model.synthesize(keys)
contact_sheet(
    result.motion,
    picture("in_between.png"),
    contacts=result.annotations,
    seams=[piece.start for piece in result.pieces[1:]],
    frames=16,
)

# %%
# Where it is from, and how much of it had to be edited so that keys, times and the ground are met.

for piece in result.pieces:
    print(f"{piece.start:5.2f} s: {piece.take} from {piece.source_start:.2f} s, stretched by {piece.stretch:.2f}")
print(f"{100 * result.statistics['untouched']:.0f} % of the frames were moved by less than a centimetre")

# %%
# A time that no motion of the library can keep is refused before anything is solved.

try:
    model.synthesize((keys[0], key_at(running, 0.4, time=(0.5, 0.5))))
except kg.errors.RequestError as error:
    print(error)
