"""The readings of body-worn sensors become a motion."""

from __future__ import annotations

from pathlib import Path

from kinetograph.formats import read_layout
from kinetograph.methods.sensor import SensorControl, synthesis_named
from kinetograph.pipeline import fit_sensor, noted, read_rows
from kinetograph.sensing import kinds_of
from kinetograph.service.job import Job
from kinetograph.service.recordings import Recordings
from kinetograph.service.results import Made, Output, made_of, own_body, worn


class Sense(Output, forbid_unknown_fields=True, kw_only=True):
    """A motion from readings.

    Parameters
    ----------
    recordings : Recordings
    readings : str
        A file of readings.
    layout : str
        A .toml file, or the name of a layout: wii, phone, imu, ideal.
    synthesis : str
        See `kinetograph.methods.sensor.SYNTHESES`.
    """

    recordings: Recordings
    readings: str
    layout: str = "wii"
    synthesis: str = "guided"


def sense(asked: Sense, job: Job) -> Made:
    """A motion from a file of readings."""
    library = asked.recordings.opened(job)
    rows, notes = read_rows(Path(asked.readings).expanduser())
    for note in notes:
        job.note(note)
    synthesis = synthesis_named(asked.synthesis, "pca")
    method = SensorControl(layout=read_layout(asked.layout), kinds=kinds_of(rows), synthesis=synthesis)
    model = job.warm.fitted(library, method, lambda: fit_sensor(method, library, note=job.note, progress=job.progress))
    made = noted(model.synthesize(rows, job.progress), model.notes, model.left_out)
    body = own_body(asked.body, made.motion.skeleton)
    return made_of(made, worn(made.motion, body, asked.fps, made.annotations), asked)
