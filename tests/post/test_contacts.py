from __future__ import annotations

import pytest

from kinetograph.post.contacts import TOUCH, carry, merge
from kinetograph.synthesis import Piece
from kinetograph.take import Annotation


def _contact(label: str, start: float, stop: float, track: str = "motion") -> Annotation:
    return Annotation(track, "contact", label, start, stop)


def _piece(start: float, stop: float, source_start: float, source_stop: float) -> Piece:
    return Piece("take", "body", source_start, source_stop, start, stop)


def _spans(contacts: tuple[Annotation, ...]) -> list[tuple[str, float, float]]:
    return [(n.label, pytest.approx(n.start), pytest.approx(n.stop)) for n in contacts]  # type: ignore[misc]


def test_contacts_move_and_stretch_with_their_piece() -> None:
    carried = carry([(_piece(1.0, 3.0, 10.0, 11.0), (_contact("left_toe", 10.25, 10.75, "body"),))])
    assert _spans(carried) == [("left_toe", 1.5, 2.5)]
    assert {(n.track, n.kind) for n in carried} == {("motion", "contact")}


def test_contacts_are_clipped_to_their_piece() -> None:
    notes = (_contact("left_toe", 9.0, 10.5), _contact("right_toe", 10.8, 12.0), _contact("left_foot", 12.0, 13.0))
    assert _spans(carry([(_piece(1.0, 2.0, 10.0, 11.0), notes)])) == [("left_toe", 1.0, 1.5), ("right_toe", 1.8, 2.0)]


def test_the_part_of_a_piece_before_the_result_begins_is_left_out() -> None:
    notes = (_contact("left_toe", 10.0, 10.2), _contact("right_toe", 10.1, 10.9))
    assert _spans(carry([(_piece(-0.5, 0.5, 10.0, 11.0), notes)])) == [("right_toe", 0.0, 0.4)]


def test_a_contact_across_a_seam_is_one() -> None:
    pieces = [
        (_piece(0.0, 1.0, 5.0, 6.0), (_contact("left_toe", 5.6, 7.0),)),
        (_piece(1.0, 2.0, 20.0, 21.0), (_contact("left_toe", 19.0, 20.3),)),
    ]
    assert _spans(carry(pieces)) == [("left_toe", 0.6, 1.3)]


def test_contacts_that_nearly_touch_become_one_and_others_do_not() -> None:
    near, far = 1.0 + 0.9 * TOUCH, 1.0 + 1.1 * TOUCH
    assert _spans(merge([_contact("a", near, 2), _contact("a", 0, 1)])) == [("a", 0, 2)]
    assert _spans(merge([_contact("a", far, 2), _contact("a", 0, 1)])) == [("a", 0, 1), ("a", far, 2)]


def test_a_contact_within_another_does_not_shorten_it() -> None:
    assert _spans(merge([_contact("a", 0, 5), _contact("a", 1, 2), _contact("a", 4.9, 6)])) == [("a", 0, 6)]


def test_roles_are_kept_apart_and_come_by_start() -> None:
    merged = merge([_contact("b", 0, 1), _contact("a", 0.5, 2), _contact("b", 0.9, 3), _contact("a", 4, 5)])
    assert _spans(merged) == [("b", 0, 3), ("a", 0.5, 2), ("a", 4, 5)]


def test_nothing_is_carried_from_nothing() -> None:
    assert carry([]) == ()
    assert carry([(_piece(0, 1, 0, 1), ())]) == ()
