"""MP4 films, encoded by a program: ffmpeg on PATH, or that of the package imageio-ffmpeg where it is installed."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import tempfile
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import numpy.typing as npt

from kinetograph.errors import RequestError

ABSENT = "an .mp4 film needs ffmpeg: install it, or pip install imageio-ffmpeg; or write a .gif"


def find_ffmpeg() -> str | None:
    """The path of ffmpeg, or None where this machine has none."""
    found = shutil.which("ffmpeg")
    if found or importlib.util.find_spec("imageio_ffmpeg") is None:
        return found
    import imageio_ffmpeg

    try:
        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except RuntimeError:  # the package without its program
        return None


def write_video(frames: Iterable[npt.NDArray[np.uint8]], path: str | Path, size: tuple[int, int], rate: float) -> None:
    """Encode frames as H.264 in an MP4 file.

    Parameters
    ----------
    frames : iterable of ndarray of uint8, shape (height, width, 3)
    path : str or Path
    size : (int, int)
        Width and height in pixels, both even.
    rate : float
        Frames per second.

    Raises
    ------
    RequestError
        There is no ffmpeg, or it failed.
    """
    program = find_ffmpeg()
    if program is None:
        raise RequestError(ABSENT)
    source = ("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{size[0]}x{size[1]}", "-r", f"{rate:g}", "-i", "-")
    coding = ("-c:v", "libx264", "-crf", "18", "-pix_fmt", "yuv420p", "-movflags", "+faststart")
    exact = ("-threads", "1", "-fflags", "+bitexact", "-flags:v", "+bitexact", "-map_metadata", "-1")
    command = (program, "-y", "-loglevel", "error", *source, *coding, *exact, str(path))
    with tempfile.TemporaryFile() as said:
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=said) as encoder:
            try:
                _feed(encoder, frames)
            except BaseException:
                encoder.kill()
                raise
        if encoder.returncode:
            said.seek(0)
            reason = said.read().decode(errors="replace").strip().splitlines()
            raise RequestError(f"{path}: ffmpeg could not write it: {reason[-1] if reason else encoder.returncode}")


def _feed(encoder: subprocess.Popen[bytes], frames: Iterable[npt.NDArray[np.uint8]]) -> None:
    """Give the encoder its frames, until it takes no more."""
    assert encoder.stdin is not None
    try:
        for frame in frames:
            encoder.stdin.write(frame.tobytes())
        encoder.stdin.close()
    except BrokenPipeError:
        return  # it has said why
