"""A driven snap-through spring in 40 digits: python make_points.py > points.txt

Independent of the crate: Taylor's method of order 40 for the whole machine as a system of equations. The elongation at each step selects
the active line, and bisection of the step's polynomial finds corners. A row for each corner: time, rate e'; then rows
`state` with time, s and v of both bodies.
"""

from mpmath import cos, mp, mpf, pi, sin

mp.dps = 40
ORDER, STEP = 40, mpf(1) / 64
POINTS = [("-0.06", "-8"), ("-0.01", "3"), ("0.02", "-2"), ("0.04", "-1"), ("0.05", "4")]
POINTS = [(mpf(e), mpf(f)) for e, f in POINTS]
MASS = [mpf("0.7"), mpf("1.3")]
TIE, DAMPING = mpf("25"), mpf("0.2")
LOAD, FREQUENCY, PHASE = mpf("6"), mpf("1.3"), mpf("0.4")
TIMES = [mpf(k) / 2 for k in range(1, 9)]


def line(e):
    """Returns slope and value at e = 0 of the line that acts at e."""
    j = 0
    while j < len(POINTS) - 2 and e >= POINTS[j + 1][0]:
        j += 1
    (a, f), (b, g) = POINTS[j], POINTS[j + 1]
    k = (g - f) / (b - a)
    return k, f - k * a


def series(q, v, t, j):
    """Coefficients of both coordinates while the line j acts."""
    k, c = j
    w = 2 * pi * FREQUENCY
    qs = [[q[i], v[i]] for i in range(2)]
    for n in range(ORDER - 2):
        drive = LOAD * w**n / mp.factorial(n) * sin(w * t + PHASE + n * pi / 2)
        rate = (n + 1) * qs[0][n + 1]
        spring = k * qs[0][n] + (c if n == 0 else 0) + DAMPING * rate
        tie = TIE * (qs[1][n] - qs[0][n])
        forces = [drive - spring + tie, -tie]
        for i in range(2):
            qs[i].append(forces[i] / MASS[i] / ((n + 1) * (n + 2)))
    return qs


def value(p, t):
    return mp.polyval(list(reversed(p)), t)


def rate(p, t):
    return mp.polyval([k * c for k, c in enumerate(p)][:0:-1], t)


def corner(p, h):
    """Returns the first time in (0, h] at which e reaches a corner, and whether upwards."""
    n, found = 64, None
    for e, _ in POINTS[1:-1]:
        grid = [value(p, h * i / n) - e for i in range(n + 1)]
        for i in range(n):
            if grid[i] * grid[i + 1] < 0 or (grid[i + 1] == 0 and i < n):
                if i == 0 and abs(grid[0]) < mpf(10) ** -30:
                    continue
                a, b = h * i / n, h * (i + 1) / n
                for _ in range(140):
                    m = (a + b) / 2
                    a, b = (m, b) if (value(p, m) - e) * grid[i] > 0 else (a, m)
                if found is None or b < found:
                    found = b
                break
    return found


def main():
    q, v, t = [mpf("0.01"), mpf("-0.02")], [mpf("0.3"), mpf(0)], mpf(0)
    print("# By make_points.py.")
    for end in TIMES:
        while t < end:
            h = min(STEP, end - t)
        # The line just after the current instant.
            k = line(q[0] + v[0] * mpf(10) ** -25)
            qs = series(q, v, t, k)
            at = corner(qs[0], h)
            h = h if at is None else at
            q, v = [value(p, h) for p in qs], [rate(p, h) for p in qs]
            t = end if at is None and end - t == h else t + h
            if at is not None:
                print("corner", mp.nstr(t, 22), mp.nstr(v[0], 22))
        print("state", mp.nstr(t, 22), *[mp.nstr(x, 22) for x in (q[0], v[0], q[1], v[1])])


main()
