"""The sections of a project: what makes each, what they answer, and what of them runs live."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from kinetograph.studio import browsing, exporting
from kinetograph.studio.duet import making as duetting
from kinetograph.studio.duet import rehearsing
from kinetograph.studio.keys import making as keying
from kinetograph.studio.messages import Export, Message
from kinetograph.studio.project import Mode, Project
from kinetograph.studio.room import Room
from kinetograph.studio.sections import Answer, Run, Section
from kinetograph.studio.sensors import making as sensing
from kinetograph.studio.walk import making as walking

SECTIONS: Mapping[Mode, Section] = {
    "walk": walking.make,
    "keys": keying.make,
    "duet": duetting.make,
    "sensors": sensing.make,
}
"""What makes each section of a project."""

ANSWERS: Mapping[type[Message], Answer] = {
    **browsing.ANSWERS,
    **walking.ANSWERS,
    **keying.ANSWERS,
    **duetting.ANSWERS,
    **sensing.ANSWERS,
}
"""Questions of the page, and what answers them."""

RUNS: Mapping[type[Message], Run] = {
    Export: exporting.run,
    **walking.RUNS,
    **rehearsing.RUNS,
    **sensing.RUNS,
}
"""What runs live, by the message that starts it."""

HEARD: tuple[type[Message], ...] = (
    *walking.HEARD,
    *sensing.HEARD,
)
"""Messages for what runs live."""

PREPARE: tuple[Callable[[Project, Room], object], ...] = (walking.prepare,)
"""What may be done before it is asked for: models fitted, kernels compiled."""
