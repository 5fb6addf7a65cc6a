"""Feet of sensed results: what slides is lifted, what stands is planted, at the height of the recordings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodies import person, walk
from kinetograph import rotations as rot
from kinetograph.evaluation import contact_speed, fastest_low_toe, sole_level
from kinetograph.kinematics import role_positions
from kinetograph.methods.sensor.feet import finished_feet, still_contacts
from kinetograph.methods.sensor.root import RootIntegrator, fit_root_model, root_features
from kinetograph.motion import Motion
from kinetograph.post import contact_mask
from kinetograph.segmentation import detect_contacts


def sliding(fps: float = 60.0) -> Motion:
    """A person who stands for a second, slides by 80 cm in half a second, and stands again."""
    along = 0.8 * np.clip((np.arange(150) / fps - 1.0) / 0.5, 0.0, 1.0)
    place = np.column_stack([along, np.full(150, 0.96), np.zeros(150)])
    return Motion(person(), place, rot.identity(150, len(person())), fps)


def test_feet_that_slide_are_lifted_and_not_planted() -> None:
    motion = sliding()
    made, contacts = finished_feet(motion, fit_root_model([motion]))
    assert fastest_low_toe(motion) > 1.5
    assert fastest_low_toe(made) < 0.3
    heights = role_positions(made, ("left_toe", "right_toe"))[..., 1]
    assert heights[65:85].min() > heights[:50].max() + 0.015
    for role in ("left_foot", "right_toe"):
        planted = contact_mask(contacts, role, len(made), made.fps)
        assert planted[5:50].all()
        assert not planted[65:85].any()
    assert contact_speed(made, contacts) < 0.05


def test_feet_that_stand_are_left_alone() -> None:
    still = sliding()
    still = replace(still, translation=np.tile(still.translation[0], (len(still), 1)))
    made, contacts = finished_feet(still, fit_root_model([still]))
    np.testing.assert_allclose(role_positions(made, ("left_toe",)), role_positions(still, ("left_toe",)), atol=1e-6)
    assert {note.label for note in contacts} == {"left_foot", "left_toe", "right_foot", "right_toe"}


def test_legs_are_not_bent_for_what_the_body_can_do() -> None:
    """A person who stands a little over the ground comes down to it with straight legs."""
    still = sliding()
    model = fit_root_model([replace(still, translation=np.tile(still.translation[0], (len(still), 1)))])
    for over, left in ((0.03, 0.0), (0.005, 0.0)):
        up = np.tile(still.translation[0] + np.array([0.0, over, 0.0]), (len(still), 1))
        made, _ = finished_feet(replace(still, translation=up), model)
        np.testing.assert_allclose(made.rotations, still.rotations, atol=1e-6)
        np.testing.assert_allclose(made.translation[:, 1] - still.translation[0, 1], left, atol=0.011)


def test_a_foot_that_spins_on_its_heel_is_not_planted() -> None:
    motion = sliding()
    motion = replace(motion, translation=np.tile(motion.translation[0], (len(motion), 1)))
    turns = motion.rotations.copy()
    spin = 1.2 * np.clip((np.arange(150) - 60) / 10, 0.0, 1.0)
    turns[:, motion.skeleton.index("LeftFoot")] = rot.about("y", spin)
    motion = replace(motion, rotations=turns)
    model = fit_root_model([motion])
    contacts = detect_contacts(motion)
    heel = contact_mask(contacts, "left_foot", len(motion), motion.fps)
    assert heel[62:68].all()
    kept = still_contacts(motion, contacts, model)
    assert not contact_mask(kept, "left_foot", len(motion), motion.fps)[62:68].any()
    assert contact_mask(kept, "right_foot", len(motion), motion.fps).all()


@pytest.mark.parametrize("level", [0.0, 0.05, 0.1])
def test_the_root_is_as_high_as_in_the_recordings(level: float) -> None:
    motion = walk(person(), level)
    model = fit_root_model([motion])
    assert model.level == pytest.approx(level + 0.03, abs=0.005)
    root = RootIntegrator(model, motion.fps)
    features = root_features(motion, model)
    made = np.array([root.step(motion.rotations[i], features[i])[0] for i in range(len(motion))])
    np.testing.assert_allclose(made[:, 1], motion.translation[:, 1], atol=0.01)


def test_the_level_of_soles_is_that_of_the_lowest_planted_joint() -> None:
    motion = walk(person(), 0.02)
    assert sole_level(motion, detect_contacts(motion)) == pytest.approx(0.05, abs=0.003)
    assert sole_level(motion, ()) == 0.0
