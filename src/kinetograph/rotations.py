"""Rotations as unit quaternions.

Conventions: quaternions are ``(..., 4)`` in the order w, x, y, z, with the Hamilton product, and act on column
vectors, so that ``multiply(a, b)`` rotates by ``b`` first. Angles are radians, counter-clockwise seen against the axis.
Every function is batch-first and broadcasts over leading dimensions.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError

IDENTITY: FloatArray = np.array([1.0, 0.0, 0.0, 0.0])
AXES: dict[str, FloatArray] = {"x": np.array([1.0, 0, 0]), "y": np.array([0, 1.0, 0]), "z": np.array([0, 0, 1.0])}


def identity(*shape: int) -> FloatArray:
    """Identity quaternions, shape ``(*shape, 4)``."""
    return np.broadcast_to(IDENTITY, (*shape, 4)).copy()


def normalize(q: FloatArray) -> FloatArray:
    """Quaternions, shape ``(..., 4)``, scaled to unit length."""
    return np.asarray(q / np.linalg.norm(q, axis=-1, keepdims=True))


def multiply(a: FloatArray, b: FloatArray) -> FloatArray:
    """Hamilton product: the rotation ``b`` followed by the rotation ``a``.

    Parameters
    ----------
    a, b : ndarray, shape (..., 4)

    Returns
    -------
    ndarray, shape (..., 4)
    """
    aw, ax, ay, az = a[..., 0], a[..., 1], a[..., 2], a[..., 3]
    bw, bx, by, bz = b[..., 0], b[..., 1], b[..., 2], b[..., 3]
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[..., 0] = aw * bw - ax * bx - ay * by - az * bz
    out[..., 1] = aw * bx + ax * bw + ay * bz - az * by
    out[..., 2] = aw * by - ax * bz + ay * bw + az * bx
    out[..., 3] = aw * bz + ax * by - ay * bx + az * bw
    return out


def conjugate(q: FloatArray) -> FloatArray:
    """The inverse rotations of unit quaternions, shape ``(..., 4)``."""
    return np.asarray(q * np.array([1.0, -1.0, -1.0, -1.0]))


def rotate(q: FloatArray, v: FloatArray) -> FloatArray:
    """Vectors rotated by quaternions.

    Parameters
    ----------
    q : ndarray, shape (..., 4)
        Unit quaternions.
    v : ndarray, shape (..., 3)

    Returns
    -------
    ndarray, shape (..., 3)

    Examples
    --------
    >>> rotate(about("z", np.pi / 2), np.array([1.0, 0.0, 0.0])).round(6).tolist()
    [0.0, 1.0, 0.0]
    """
    w, u = q[..., :1], q[..., 1:]
    t = 2.0 * _cross(u, v)
    return np.asarray(v + w * t + _cross(u, t))


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross product; np.cross spends most of its time on moving axes."""
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[..., 0] = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    out[..., 1] = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    out[..., 2] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return out


def about(axis: str, angle: npt.ArrayLike) -> FloatArray:
    """Rotations about a coordinate axis.

    Parameters
    ----------
    axis : {"x", "y", "z"}
    angle : array_like, shape (...)
        Radians.

    Returns
    -------
    ndarray, shape (..., 4)

    Examples
    --------
    >>> about("y", np.pi).round(6).tolist()
    [0.0, 0.0, 1.0, 0.0]
    """
    half = 0.5 * np.asarray(angle, dtype=np.float64)
    out = np.zeros((*half.shape, 4))
    out[..., 0] = np.cos(half)
    out[..., 1 + "xyz".index(axis)] = np.sin(half)
    return out


def exp(v: FloatArray) -> FloatArray:
    """Quaternions of rotation vectors.

    Parameters
    ----------
    v : ndarray, shape (..., 3)
        Axes times angles in radians.

    Returns
    -------
    ndarray, shape (..., 4)
    """
    angle = np.linalg.norm(v, axis=-1, keepdims=True)
    return np.concatenate([np.cos(angle / 2), v * (0.5 * np.sinc(angle / (2 * np.pi)))], axis=-1)


def log(q: FloatArray) -> FloatArray:
    """Rotation vectors of unit quaternions.

    Parameters
    ----------
    q : ndarray, shape (..., 4)

    Returns
    -------
    ndarray, shape (..., 3)
        Axes times angles in radians, at most pi long.

    Examples
    --------
    >>> log(exp(np.array([0.1, -0.2, 0.3]))).round(9).tolist()
    [0.1, -0.2, 0.3]
    """
    q = np.where(q[..., :1] < 0, -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, q[..., :1])
    small = sine < 1e-8
    return np.asarray(q[..., 1:] * np.where(small, 2.0, angle / np.where(small, 1.0, sine)))


def angle_between(a: FloatArray, b: FloatArray) -> FloatArray:
    """Geodesic angle between rotations.

    Parameters
    ----------
    a, b : ndarray, shape (..., 4)

    Returns
    -------
    ndarray, shape (...)
        Radians, from 0 to pi.
    """
    return np.asarray(np.linalg.norm(log(multiply(conjugate(a), b)), axis=-1))


def slerp(a: FloatArray, b: FloatArray, u: npt.ArrayLike) -> FloatArray:
    """Spherical linear interpolation along the shorter arc.

    Parameters
    ----------
    a, b : ndarray, shape (..., 4)
        Rotations at ``u`` of 0 and of 1.
    u : array_like, shape (...)

    Returns
    -------
    ndarray, shape (..., 4)

    Examples
    --------
    >>> slerp(about("y", 0.0), about("y", 1.0), 0.25).round(9).tolist() == about("y", 0.25).round(9).tolist()
    True
    """
    u = np.asarray(u, dtype=np.float64)[..., None]
    cosine = np.sum(a * b, axis=-1, keepdims=True)
    b = np.where(cosine < 0, -b, b)
    theta = np.arccos(np.clip(np.abs(cosine), 0.0, 1.0))
    near = theta < 1e-6  # sin(theta) loses its digits; the chord is as good as the arc there
    sine = np.where(near, 1.0, np.sin(theta))
    from_a = np.where(near, 1.0 - u, np.sin((1.0 - u) * theta) / sine)
    from_b = np.where(near, u, np.sin(u * theta) / sine)
    return normalize(from_a * a + from_b * b)


def unroll(q: FloatArray, axis: int = 0) -> FloatArray:
    """Quaternions with signs chosen such that neighbours lie on the same side of the sphere.

    Parameters
    ----------
    q : ndarray, shape (..., 4)
    axis : int
        The axis along which neighbours follow one another.

    Returns
    -------
    ndarray, shape (..., 4)
        The same rotations; the first keep their sign, and the dot product of neighbours is never negative.
    """
    q = np.moveaxis(q, axis, 0)
    dots = np.sum(q[1:] * q[:-1], axis=-1)
    signs = np.concatenate([np.ones((1, *dots.shape[1:])), np.cumprod(np.where(dots < 0, -1.0, 1.0), axis=0)])
    return np.moveaxis(q * signs[..., None], 0, axis)


def _check_order(order: str) -> str:
    if len(order) not in (1, 2, 3) or set(order.lower()) - set("xyz"):
        raise RequestError(
            f"Euler order must be one to three letters of x, y, z, found {order!r}; name it, as in 'zxy'"
        )
    return order.lower()


def from_euler(angles: FloatArray, order: str) -> FloatArray:
    """Quaternions of intrinsic Euler angles.

    Parameters
    ----------
    angles : ndarray, shape (..., N)
        Radians, one per letter of ``order``.
    order : str
        One to three letters of x, y, z. ``"zxy"`` is the product Z X Y, the meaning of BVH channels ``Zrotation
        Xrotation Yrotation``: the last rotation acts on the vector first. There is no default.

    Returns
    -------
    ndarray, shape (..., 4)

    Raises
    ------
    RequestError
        If the order is none.
    """
    order = _check_order(order)
    out = about(order[0], angles[..., 0])
    for i, axis in enumerate(order[1:], start=1):
        out = multiply(out, about(axis, angles[..., i]))
    return out


def to_euler(q: FloatArray, order: str) -> FloatArray:
    """Intrinsic Euler angles of quaternions.

    Parameters
    ----------
    q : ndarray, shape (..., 4)
    order : str
        Three different letters of x, y, z (Tait-Bryan angles), as `from_euler` takes them.

    Returns
    -------
    ndarray, shape (..., 3)
        Radians. The middle angle lies in [-pi/2, pi/2]. At the poles, where the outer angles are not unique, the last
        one is 0.

    Raises
    ------
    RequestError
        If the order does not name three different axes.
    """
    order = _check_order(order)
    if len(set(order)) != 3:
        raise RequestError(f"Euler order must name three different axes, found {order!r}; try 'zxy' or 'zyx'")
    i, j, k = ("xyz".index(c) for c in order)
    sign = 1.0 if (i, j, k) in ((0, 1, 2), (1, 2, 0), (2, 0, 1)) else -1.0
    m = to_matrix(q)
    sine = np.clip(sign * m[..., i, k], -1.0, 1.0)
    pole = np.abs(sine) > 1.0 - 1e-12
    first = np.where(
        pole, np.arctan2(sign * m[..., k, j], m[..., j, j]), np.arctan2(-sign * m[..., j, k], m[..., k, k])
    )
    last = np.where(pole, 0.0, np.arctan2(-sign * m[..., i, j], m[..., i, i]))
    middle = np.arctan2(sine, np.hypot(m[..., i, i], m[..., i, j]))
    return np.stack([first, middle, last], axis=-1)


def to_matrix(q: FloatArray) -> FloatArray:
    """Rotation matrices, shape ``(..., 3, 3)``, of unit quaternions, shape ``(..., 4)``."""
    w, x, y, z = (q[..., i] for i in range(4))
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def from_matrix(m: FloatArray) -> FloatArray:
    """Unit quaternions, shape ``(..., 4)`` with w >= 0, of rotation matrices, shape ``(..., 3, 3)``."""
    trace = np.trace(m, axis1=-2, axis2=-1)
    # four times the squares of w, x, y, z; the largest one is safe to divide by
    squares = np.stack(
        [1 + trace, *(1 - trace + 2 * m[..., i, i] for i in range(3))],
        axis=-1,
    )
    skew = [m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]]
    plus = {(i, j): m[..., i, j] + m[..., j, i] for i, j in ((0, 1), (0, 2), (1, 2))}
    rows = np.stack(
        [
            np.stack([squares[..., 0], *skew], axis=-1),
            np.stack([skew[0], squares[..., 1], plus[0, 1], plus[0, 2]], axis=-1),
            np.stack([skew[1], plus[0, 1], squares[..., 2], plus[1, 2]], axis=-1),
            np.stack([skew[2], plus[0, 2], plus[1, 2], squares[..., 3]], axis=-1),
        ],
        axis=-2,
    )
    best = np.argmax(squares, axis=-1)
    q = normalize(np.take_along_axis(rows, best[..., None, None], axis=-2)[..., 0, :])
    return np.where(q[..., :1] < 0, -q, q)


def between(a: FloatArray, b: FloatArray) -> FloatArray:
    """The smallest rotations that take one direction to another.

    Parameters
    ----------
    a, b : ndarray, shape (..., 3)
        Vectors of any length but 0.

    Returns
    -------
    ndarray, shape (..., 4)
        For opposite directions, which have no smallest one, a rotation by pi about some axis perpendicular to ``a``.
    """
    a = a / np.linalg.norm(a, axis=-1, keepdims=True)
    b = b / np.linalg.norm(b, axis=-1, keepdims=True)
    w = 1.0 + np.sum(a * b, axis=-1, keepdims=True)
    axis = _cross(a, b)
    other = np.where(np.abs(a[..., :1]) < 0.9, AXES["x"], AXES["y"])
    opposite = w < 1e-9
    axis = np.where(opposite, _cross(a, np.broadcast_to(other, a.shape)), axis)
    return normalize(np.concatenate([np.where(opposite, 0.0, w), axis], axis=-1))


def twist(q: FloatArray, axis: str) -> FloatArray:
    """Angle of the twist of rotations about a coordinate axis, by swing-twist decomposition.

    Parameters
    ----------
    q : ndarray, shape (..., 4)
    axis : {"x", "y", "z"}

    Returns
    -------
    ndarray, shape (...)
        Radians from -pi to pi. The rotation about the axis by it is, of all rotations about that axis, the nearest
        to ``q``.
    """
    return np.asarray(_wrap(2.0 * np.arctan2(q[..., 1 + "xyz".index(axis)], q[..., 0])))


def heading(q: FloatArray) -> FloatArray:
    """Heading of rotations: the angle of the rotation about the vertical that is nearest to each.

    Parameters
    ----------
    q : ndarray, shape (..., 4)

    Returns
    -------
    ndarray, shape (...)
        Radians from -pi to pi, not unwrapped; 0 for a root joint that faces where its rest pose faces.

    Examples
    --------
    >>> round(float(heading(multiply(about("y", 0.5), about("x", 0.2)))), 6)
    0.5
    """
    return twist(q, "y")


def without_heading(q: FloatArray) -> FloatArray:
    """Rotations followed by the one about the vertical that makes their heading 0.

    Parameters
    ----------
    q : ndarray, shape (..., 4)

    Returns
    -------
    ndarray, shape (..., 4)

    Examples
    --------
    >>> round(abs(float(heading(without_heading(multiply(about("y", 2.0), about("x", 0.3)))))), 6)
    0.0
    """
    return multiply(about("y", -heading(q)), q)


def _wrap(angle: FloatArray) -> FloatArray:
    return np.asarray((angle + np.pi) % (2 * np.pi) - np.pi)
