"""
Look at motion
==============

Numbers pass while knees bend backwards: look at what you make. There are three pictures of a motion, and films.
"""

from clips import clip, picture
from kinetograph.drawing import character_film, character_sheet, contact_sheet, strobe
from kinetograph.motion import repeat
from kinetograph.segmentation import detect_contacts

# %%
# A contact sheet
# ---------------
#
# Poses in time, the path from above, the heights of the feet and when they are planted. On the command line:
# ``kinetograph view run.bvh -o run.png --contacts``.

run = repeat(clip("humanoid3d_run"), 3)
contact_sheet(run, picture("look_at_motion.png"), contacts=detect_contacts(run, track="motion"), frames=12)

# %%
# A strobe picture
# ----------------
#
# One view of the whole (``--strobe``). What stays in place is spread out over time.

strobe(clip("humanoid3d_backflip"), picture("look_at_motion_strobe.png"))

# %%
# A person
# --------
#
# With a body: capsules on any skeleton, or a character with a skin (``--character human``, after ``kinetograph data
# fetch character``).

character_sheet(clip("humanoid3d_spinkick"), picture("look_at_motion_person.png"), frames=6)

# %%
# A film
# ------
#
# One cycle of the run, in real time.

character_film(clip("humanoid3d_run"), picture("look_at_motion_film.gif"), seconds=0.8)
