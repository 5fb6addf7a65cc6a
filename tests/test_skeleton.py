from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

from kinetograph.errors import DataError, RequestError
from kinetograph.skeleton import ROLES, Landmark, Skeleton, opposite, same_shape, with_roles
from walkers import stick_figure


def _chain(**changes: Any) -> Skeleton:
    parts: dict[str, Any] = {
        "names": ("root", "spine", "head"),
        "parents": [-1, 0, 1],
        "offsets": [[9, 9, 9], [0, 0.5, 0], [0, 0.25, 0]],
        "end_parents": [2],
        "end_offsets": [[0, 0.2, 0]],
        "roles": {"hips": Landmark(0), "head": Landmark(2, np.array([0, 0.1, 0]))},
    }
    return Skeleton(**{**parts, **changes})


def test_a_skeleton_holds_arrays() -> None:
    skeleton = _chain()
    assert len(skeleton) == 3
    assert skeleton.parents.dtype == np.int64
    assert skeleton.offsets.dtype == np.float64
    assert skeleton.children == ((1,), (2,), ())


def test_a_skeleton_cannot_be_changed() -> None:
    skeleton = _chain()
    with pytest.raises(AttributeError):
        skeleton.names = ()  # type: ignore[misc]
    with pytest.raises(TypeError):
        skeleton.roles["head"] = Landmark(0)  # type: ignore[index]


def test_height_is_the_longest_chains_up_and_down() -> None:
    assert _chain().height == pytest.approx(0.5 + 0.25 + 0.2)
    leg = np.hypot(0.05, 0.14)
    assert stick_figure().height == pytest.approx(0.1 + 0.88 + leg + 0.1 + 0.88 + leg)


def test_a_lone_joint_has_no_height() -> None:
    assert Skeleton(("root",), np.array([-1]), np.zeros((1, 3))).height == 0.0


def test_joints_are_found_by_name_and_by_role() -> None:
    assert _chain().index("spine") == 1
    assert _chain().landmark("head").joint == 2
    np.testing.assert_array_equal(_chain().landmark("hips").offset, np.zeros(3))


def test_an_unknown_joint_gets_suggestions() -> None:
    with pytest.raises(RequestError, match="no joint 'spin'; did you mean spine"):
        _chain().index("spin")
    with pytest.raises(RequestError, match=r"no joint '12345'; did you mean root, spine, head\?"):
        _chain().index("12345")


def test_an_unknown_role_gets_the_ones_there_are() -> None:
    with pytest.raises(RequestError, match="no joint plays the role 'left_toe'; this skeleton has: hips, head; name"):
        _chain().landmark("left_toe")
    with pytest.raises(RequestError, match="no joint plays the role 'tail'; expected one of hips, spine, chest"):
        _chain().landmark("tail")
    with pytest.raises(RequestError, match="this skeleton has: none"):
        _chain(roles={}).landmark("hips")


def test_roles_can_be_given_by_name_or_as_a_point() -> None:
    tip = Landmark(2, np.array([0.0, 0.2, 0.0]))
    changed = with_roles(_chain(), {"chest": "spine", "head": tip})
    assert changed.roles["chest"].joint == 1
    assert changed.roles["head"] is tip
    assert changed.roles["hips"].joint == 0
    assert "chest" not in _chain().roles
    with pytest.raises(RequestError, match="unknown role 'tail'; expected one of hips"):
        with_roles(_chain(), {"tail": "spine"})
    with pytest.raises(RequestError, match="no joint 'nowhere'"):
        with_roles(_chain(), {"head": "nowhere"})


def test_same_shape_looks_at_joints_and_bones_but_not_at_where_the_root_rests() -> None:
    chain = _chain()
    elsewhere = _chain(offsets=[[5, 0, 0], *chain.offsets[1:]])
    longer = _chain(offsets=[*chain.offsets[:2], chain.offsets[2] + np.array([0, 2e-3, 0])])
    assert same_shape(chain, elsewhere)
    assert not same_shape(chain, longer)
    assert same_shape(chain, longer, tolerance=3e-3)
    assert not same_shape(chain, _chain(names=("root", "spine", "skull")))
    assert not same_shape(chain, _chain(parents=[-1, 0, 0]))
    assert not same_shape(chain, Skeleton(("root",), np.array([-1]), np.zeros((1, 3))))


@pytest.mark.parametrize("role", ROLES)
def test_every_role_has_an_opposite(role: str) -> None:
    assert opposite(role) in ROLES
    assert opposite(opposite(role)) == role
    assert (opposite(role) == role) == (not role.startswith(("left_", "right_")))


def test_a_skeleton_pickles() -> None:
    skeleton = pickle.loads(pickle.dumps(_chain()))
    assert same_shape(skeleton, _chain())
    np.testing.assert_array_equal(skeleton.end_offsets, _chain().end_offsets)
    np.testing.assert_array_equal(skeleton.roles["head"].offset, [0, 0.1, 0])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"names": ()}, "a skeleton needs at least one joint, found none"),
        ({"names": ("root", "a", "a")}, "joint names must be unique, found 'a' twice; rename one"),
        ({"parents": [-1, 0]}, r"expected parents \(3,\) and offsets \(3, 3\) for 3 names, found \(2,\) and \(3, 3\)"),
        ({"offsets": np.zeros((3, 2))}, r"found \(3,\) and \(3, 2\)"),
        ({"parents": [0, 0, 1]}, "parents must come before their children and the one root first; sort the joints"),
        ({"parents": [-1, 2, 1]}, "parents must come before their children"),
        ({"parents": [-1, -1, 1]}, "parents must come before their children"),
        ({"end_parents": [1, 2]}, "2 end parents but 1 end offsets"),
        ({"end_parents": [3]}, r"end sites must hang on joints 0 to 2, found \[3\]"),
        ({"offsets": np.full((3, 3), np.nan)}, "offsets must be finite numbers of metres"),
        ({"end_offsets": [[0, np.inf, 0]]}, "offsets must be finite numbers of metres"),
        ({"roles": {"tail": Landmark(1)}}, "role 'tail' on joint 1: expected one of hips"),
        ({"roles": {"head": Landmark(3)}}, "role 'head' on joint 3"),
        ({"roles": {"head": Landmark(-1)}}, "role 'head' on joint -1"),
        ({"roles": {"head": Landmark(2, np.zeros(2))}}, "role 'head': an offset is three finite metres, found"),
        ({"roles": {"head": Landmark(2, np.full(3, np.nan))}}, "an offset is three finite metres"),
    ],
)
def test_invariants(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(DataError, match=message):
        _chain(**changes)
