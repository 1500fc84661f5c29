"""The smallest steps of the integer lattice: points beside a plane or a line, by the Euclidean algorithm.

An integer vector c and an integer point x have c.x a multiple of g = gcd(c). So the planes c.x = -g, 0 and
g hold the lattice points closest to, or on, the plane through the origin. Everything here is exact: 64-bit
integers hold the results, float64 only chooses among equivalent ones, and `exact` proves each result.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from triaxis.verif.core.stimulus.stimulus import Ints, Mask

Reals = npt.NDArray[np.float64]

# Edges up to here have cross products of at most 2 (2^31 - 1)^2 < 2^63 - 2^32. At widths up to 31 all do.
LARGEST_EDGE = (1 << 31) - 1

_CHUNK = 21


def cross(u: Ints, v: Ints) -> Ints:
    """Return u x v: (N, 3); exact for components up to LARGEST_EDGE."""
    c = np.empty(np.broadcast_shapes(u.shape, v.shape), np.int64)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        c[..., k] = u[..., i] * v[..., j] - u[..., j] * v[..., i]
    return c


def side(c: Ints, x: Ints) -> Ints:
    """Return the sign of c.x, and 0 where it is 0 or where float64 cannot tell; c, x: (.., 3).

    Each term carries at most three roundings and the sum two more, each of at most 2^-53 of the sum of the
    terms' sizes: less than 2^-50 of it in all.
    """
    terms = c.astype(np.float64) * x
    total = terms[..., 0] + terms[..., 1] + terms[..., 2]
    np.abs(terms, out=terms)
    bound = (terms[..., 0] + terms[..., 1] + terms[..., 2]) * 2.0**-50
    return (total > bound).astype(np.int64) - (total < -bound)


def bezout(a: Ints, b: Ints) -> tuple[Ints, Ints, Ints]:
    """Return g = gcd(a, b) >= 0 and s, t with s a + t b = g, for |a|, |b| <= 2^63 - 2^32: (N,) each.

    |s| <= |b|, |t| <= |a| unless one of a and b divides the other.
    """
    old, new = a.copy(), b.copy()
    zero, one = np.zeros_like(a), np.ones_like(a)
    s_old, s_new, t_old, t_new = one, zero, zero, one
    quotient = np.zeros(len(a))
    while True:
        going = new != 0
        if not (going & (old != 0)).any():
            break
        # The nearest quotient; a finished row, of remainder 0, only swaps its two. A quotient that float64
        # rounds is still an integer, and leaves a remainder all the same.
        quotient[:] = 0
        np.divide(old, new, out=quotient, where=going)
        q = np.rint(quotient, out=quotient).astype(np.int64)
        old, new = new, old - q * new
        s_old, s_new = s_new, s_old - q * s_new
        t_old, t_new = t_new, t_old - q * t_new
    last = new != 0
    g, s, t = (np.where(last, n, o) for n, o in ((new, old), (s_new, s_old), (t_new, t_old)))
    sign = np.where(g < 0, -1, 1)
    return g * sign, s * sign, t * sign


def exact(c: Ints, x: Ints, value: Ints) -> Mask:
    """Return whether c.x = value, proven: (N,). For |value| < 2^62; false where |x| is 2^34 or more.

    The 64-bit sum is right modulo 2^64, and float64 is off by less than 2^-50 of 3 * 2^63 * 2^34, and less
    than 2^50 in all. So the two together leave one integer.
    """
    products, about = c * x, c.astype(np.float64) * x
    wrapped = products[..., 0] + products[..., 1] + products[..., 2]
    real = about[..., 0] + about[..., 1] + about[..., 2]
    large = np.abs(x) >= 1 << 34
    return (
        (wrapped == value)
        & (np.abs(real - value) < 2.0**62)
        & ~(large[..., 0] | large[..., 1] | large[..., 2])
    )


def _by_coordinate(points: Ints) -> Ints:
    """Return points (N, K) as (K, N): arithmetic on whole rows is several times as fast."""
    return np.ascontiguousarray(points.T)


class _Cell:
    """The parallelogram of u and v in their plane, c = u x v, and coordinates in it: all (3, N)."""

    def __init__(self, u: Ints, v: Ints, c: Ints) -> None:
        self._u, self._v = u, v
        p, q, n = (vector.astype(np.float64) for vector in (u, v, c))
        area = np.maximum(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1.0)
        self._dual_u, self._dual_v = self._cross(q, n) / area, self._cross(n, p) / area

    @staticmethod
    def _cross(u: Reals, v: Reals) -> Reals:
        return np.stack([u[k - 2] * v[k - 1] - u[k - 1] * v[k - 2] for k in range(3)])

    def coordinates(self, x: Ints) -> tuple[Reals, Reals]:
        """Return alpha and beta, about: x = alpha u + beta v + something along c."""
        real = x.astype(np.float64)
        return (
            real[0] * self._dual_u[0] + real[1] * self._dual_u[1] + real[2] * self._dual_u[2],
            real[0] * self._dual_v[0] + real[1] * self._dual_v[1] + real[2] * self._dual_v[2],
        )

    def to_middle(self, x: Ints) -> Ints:
        """Return x less multiples of u and v: alpha and beta come to -1/2..1/2."""
        alpha, beta = self.coordinates(x)
        return x - np.rint(alpha).astype(np.int64) * self._u - np.rint(beta).astype(np.int64) * self._v

    def to_corner(self, x: Ints) -> Ints:
        """Return x less multiples of u and v: alpha and beta come to 0..1."""
        alpha, beta = self.coordinates(x)
        return x - np.floor(alpha).astype(np.int64) * self._u - np.floor(beta).astype(np.int64) * self._v


@dataclass(frozen=True)
class Step:
    """The lattice point x next above the plane of u and v and over their parallelogram.

    c = u x v, g = gcd(c), c.x = g, x = alpha u + beta v + something along c. ``found``: proven, and alpha
    and beta are safely inside 0..1.
    """

    c: Ints
    g: Ints
    x: Ints
    alpha: Reals
    beta: Reals
    found: Mask


# Closer to the rim of the parallelogram than this, a point is not used: far more than alpha may be off.
INSIDE = 2.0**-16


def plane_step(u: Ints, v: Ints) -> Step:
    """Return the step above the plane of u and v: (N, 3), components up to LARGEST_EDGE."""
    c = cross(u, v)
    rows = _by_coordinate(c)
    cell = _Cell(_by_coordinate(u), _by_coordinate(v), rows)
    # d = s cx + t cy, g = h d + e cz: so x = h (s, t, 0) + (0, 0, e), to be brought over the parallelogram.
    d, s, t = bezout(rows[0], rows[1])
    g, h, e = bezout(d, rows[2])
    w = cell.to_middle(cell.to_middle(np.stack([s, t, np.zeros_like(s)])))
    # The part along c stays below d / g, which is small unless cx and cy share a factor that cz does not.
    x = _times(cell, w, h)
    x[2] += e
    return _step(c, g, cell, x, g)


def _times(cell: _Cell, w: Ints, multiple: Ints) -> Ints:
    """Return multiple * w, less multiples of the cell's sides: for w in its middle, multiples of 63 bits.

    By Horner's scheme in chunks, back into the parallelogram after each.
    """
    x = np.zeros_like(w)
    digits = np.abs(multiple)
    for shift in (2 * _CHUNK, _CHUNK, 0):
        chunk = digits >> shift & (1 << _CHUNK) - 1
        if not shift or chunk.any():
            x = cell.to_middle((x << _CHUNK) + chunk * w)
    x *= np.sign(multiple)
    return x


def _step(c: Ints, g: Ints, cell: _Cell, x: Ints, value: Ints) -> Step:
    """Return the step to x, brought over the parallelogram, where c.x is ``value``."""
    x = cell.to_corner(cell.to_middle(x))
    alpha, beta = cell.coordinates(x)
    inside = (np.minimum(alpha, beta) > INSIDE) & (np.maximum(alpha, beta) < 1 - INSIDE)
    over = np.ascontiguousarray(x.T)
    return Step(c, g, over, alpha, beta, (g > 0) & inside & exact(c, over, value))


def raised(u: Ints, v: Ints, step: Step, multiple: Ints) -> Step:
    """Return the step that is ``multiple`` (N,) times as far from the plane of u and v as theirs.

    c.x = multiple * g, of at most 2^62 in size; where it is more, or x is 2^20 times as far from the plane as
    u and v are long, nothing is found.
    """
    cell = _Cell(_by_coordinate(u), _by_coordinate(v), _by_coordinate(step.c))
    small = np.abs(multiple.astype(np.float64) * step.g) < 2.0**61
    multiple = np.where(small & step.found, multiple, 0)
    x = _times(cell, cell.to_middle(_by_coordinate(step.x)), multiple)
    there = _step(step.c, step.g, cell, x, multiple * step.g)
    return replace(there, found=there.found & step.found & small)


def line_step(u: Ints) -> tuple[Ints, Ints, Reals]:
    """Return g = gcd(u), the point x beside the line along u, and alpha: for u (N, 2), below 2^33.

    c.x = g for c = (u_y, -u_x); x lies above alpha u, with alpha in 0..1.
    """
    along = _by_coordinate(u)
    g, s, t = bezout(along[1], -along[0])
    x = np.stack([s, t])
    dual = along / np.maximum(along[0].astype(np.float64) ** 2 + along[1].astype(np.float64) ** 2, 1.0)
    # Moving by u / g keeps c.x: any of g places along u is as good, and this is one of them.
    for _ in range(2):
        x -= np.floor(x[0] * dual[0] + x[1] * dual[1]).astype(np.int64) * along
    return g, np.ascontiguousarray(x.T), x[0] * dual[0] + x[1] * dual[1]
