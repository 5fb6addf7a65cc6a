"""Feet that are carried off while they are planted: they step, and say so."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from kinetograph.kinematics import role_positions
from kinetograph.motion import Motion
from kinetograph.post.contacts import contacts_of
from kinetograph.post.footskate import clean_feet, contact_mask
from kinetograph.post.stepping import STANDING, STEP, where_feet_stand, with_steps
from kinetograph.take import Annotation
from walkers import walk

_FPS = 60.0


def _standing(shift: float) -> tuple[Motion, tuple[Annotation, ...]]:
    """Somebody who stands for four seconds on both feet, and is moved by ``shift`` m within the third half second."""
    pose, times = walk(0.1, fps=_FPS, speed=0.0), np.arange(241) / _FPS
    moved = np.outer(np.interp(times, [1.0, 1.5], [0.0, shift]), [1.0, 0.0, 0.0])
    still = np.repeat(pose.rotations[:1], len(times), axis=0)
    motion = replace(pose, translation=pose.translation[0] + moved, rotations=still)
    roles = ("left_foot", "left_toe", "right_foot", "right_toe")
    notes = [Annotation("motion", "contact", role, 0.0, 4.0) for role in roles]
    return motion, (*notes, Annotation("motion", "move", "stand", 0.0, 4.0))


def test_who_is_moved_a_little_stays_on_both_feet() -> None:
    motion, notes = _standing(0.1)
    assert set(with_steps(motion, notes)) == set(notes)


def test_who_is_moved_far_steps_and_then_stands_where_she_is() -> None:
    motion, notes = _standing(0.4)
    stepped = with_steps(motion, notes)
    assert [note for note in stepped if note.kind == "move"] == list(notes[-1:])
    for side in ("left", "right"):
        own = sorted((note for note in stepped if note.label == f"{side}_toe"), key=lambda note: note.start)
        assert len(own) >= 2
        gaps = [after.start - before.stop for before, after in itertools.pairwise(own)]
        assert all(STEP - 1.5 / _FPS <= gap <= 2 * STEP + 1.5 / _FPS for gap in gaps)
        assert own[0].stop < 1.5
    cleaned = clean_feet(motion, contacts_of(stepped))
    toes = role_positions(cleaned, ("left_toe", "right_toe"))
    assert np.abs(toes[-1] - toes[0])[:, 0] == pytest.approx([0.4, 0.4], abs=0.15)
    slid = np.linalg.norm(np.diff(toes, axis=0), axis=-1)
    for i, side in enumerate(("left", "right")):
        mask = contact_mask(contacts_of(stepped), f"{side}_toe", len(motion), _FPS)
        inside = mask[1:] & mask[:-1]
        assert slid[inside, i].sum() < 0.15  # of 40 cm


def test_contacts_end_where_feet_move() -> None:
    motion, notes = _standing(0.4)  # 0.8 m/s within the third half second
    kept = where_feet_stand(motion, notes)
    for role in ("left_foot", "left_toe", "right_foot", "right_toe"):
        spans = sorted((note.start, note.stop) for note in kept if note.label == role)
        assert spans == [(0.0, pytest.approx(1.0, abs=2 / _FPS)), (pytest.approx(1.5, abs=2 / _FPS), 4.0)]
    still, all_of_it = _standing(0.5 * STANDING * 0.5)
    assert set(where_feet_stand(still, all_of_it)) == set(all_of_it)
