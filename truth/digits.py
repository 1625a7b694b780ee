"""Numbers of many digits, power series and their roots, for the program of motion.py."""

from fractions import Fraction

import gmpy2
from gmpy2 import mpfr, mpq



def digits(many):
    """Sets the precision: 96 digits for the tables, 57 for magnifications, and limits that lie above its rounding."""
    global ORDER, TAIL, TINY, NEAR, SLOW, ROOT, SINGULAR, PI
    gmpy2.get_context().precision = 320 if many else 192
    choose = lambda fine, coarse: mpfr(fine if many else coarse)
    ORDER = 60 if many else 36
    TAIL = choose("1e-66", "1e-36")  # last coefficients over a step, relative to the motion's size
    TINY = choose("1e-70", "1e-40")  # a value below it counts as zero
    NEAR = choose("1e-64", "1e-34")  # a touch within this distance is a touch; times within it are one instant
    SLOW = choose("1e-42", "1e-20")  # closing speed, relative to the largest speed, from which on a chatter is at rest
    ROOT = choose("1e-92", "1e-54")  # last step of Newton's method
    SINGULAR = choose("1e-60", "1e-30")
    PI = gmpy2.const_pi()


digits(True)


def real(fraction):
    return mpfr(mpq(fraction.numerator, fraction.denominator))


def times(p, q, k):
    """Coefficient k of a product."""
    return sum(p[j] * q[k - j] for j in range(k + 1))


def power_term(x, y, p, k):
    """Appends coefficient k of y = x^p, x_0 > 0: k x_0 y_k = sum of (p j - (k - j)) x_j y_(k-j)."""
    if k == 0:
        y.append(x[0] ** p)
    else:
        y.append(sum((p * j - (k - j)) * x[j] * y[k - j] for j in range(1, k + 1)) / (k * x[0]))


def sine(harmonics, time, k, derivative=0):
    """Coefficient k of the derivative of a sum of harmonics about `time`."""
    total = mpfr(0)
    for amplitude, frequency, phase in harmonics:
        w = 2 * PI * real(frequency)
        total += real(amplitude) * w ** (k + derivative) * gmpy2.sin(w * time + real(phase) + (k + derivative) * PI / 2)
    return total / gmpy2.fac(k)


def as_fraction(x):
    q = mpq(x)
    return Fraction(int(q.numerator), int(q.denominator))


def advanced(p, k, clock):
    """Coefficient k + 1 of the integral over time of a series in tau."""
    if clock == 1:
        return p[k] / (k + 1)
    return 2 * p[k - 1] / (k + 1) if k else mpfr(0)


def inverse_of(rows):
    """Inverse by Gauss and Jordan; None if singular."""
    n = len(rows)
    a = [list(row) + [mpfr(i == j) for j in range(n)] for i, row in enumerate(rows)]
    size = max(abs(x) for row in rows for x in row) if rows else 1
    for c in range(n):
        pivot = max(range(c, n), key=lambda r: abs(a[r][c]))
        if abs(a[pivot][c]) <= size * SINGULAR:
            return None
        a[c], a[pivot] = a[pivot], a[c]
        a[c] = [x / a[c][c] for x in a[c]]
        for r in range(n):
            if r != c:
                a[r] = [x - a[r][c] * y for x, y in zip(a[r], a[c])]
    return [row[n:] for row in a]


def value(p, t):
    total = mpfr(0)
    for c in reversed(p):
        total = total * t + c
    return total


def shifted(p, t):
    p, n = list(p), len(p)
    for i in range(n - 1):
        for j in range(n - 2, i - 1, -1):
            p[j] += t * p[j + 1]
    return p


def first_root(p, h):
    """First root in (0, h] of a series that begins negative; None if a bound shows that there is none."""
    lead, span = 0, max(h, mpfr("1e-6"))
    while lead < 8 and abs(p[lead]) * span**lead < TINY:
        lead += 1
    if lead == 8:
        return None
    p = p[lead:]
    if p[0] > 0:
        if lead:
            return mpfr(0)  # the root came at the end of the step before, within rounding
        raise RuntimeError("a watched quantity begins positive")
    if -p[0] > sum(abs(c) * h**k for k, c in enumerate(p) if k):
        return None
    stack = [(mpfr(0), mpfr(h))]
    while stack:
        a, b = stack.pop()
        mid, r = (a + b) / 2, (b - a) / 2
        c = shifted(p, mid)
        if abs(c[0]) > sum(abs(x) * r**k for k, x in enumerate(c) if k):
            assert c[0] < 0, "a root was passed"
            continue
        if abs(c[1]) > sum(k * abs(x) * r ** (k - 1) for k, x in enumerate(c) if k > 1):
            if c[1] < 0 or value(c, r) < 0:
                continue
            return mid + newton(c, r)
        if r < SINGULAR:
            raise RuntimeError("a touch without speed")
        stack += [(mid, b), (a, mid)]
    return None


def newton(c, r):
    """Root of a rising series in [-r, r]."""
    slope = [k * x for k, x in enumerate(c)][1:]
    low, high, x = -r, r, mpfr(0)
    for _ in range(400):
        f = value(c, x)
        step = f / value(slope, x)
        if abs(step) < ROOT * r:
            break
        low, high = (x, high) if f < 0 else (low, x)
        x = x - step if low < x - step < high else (low + high) / 2
    return x
