"""Motions with springs in series, by power series in 50 digits: the numbers of tests/series.rs.

A ball of 0.5 kg falls 0.2 m onto a plate of 0.05 kg and hits a compliant stop between both
(20 kN/m, never pulls); the plate rests on a Zener buffer of 800 N/m parallel to 3 kN/m in series with
12 N s/m. Each mode is z' = A z; events are roots of rows times z, found by Newton's method.
"""

import mpmath as mp

mp.mp.dps = 50
G, BALL, PLATE, DROP = mp.mpf("9.81"), mp.mpf("0.5"), mp.mpf("0.05"), mp.mpf("0.2")
CONTACT, SOFT, K, C = mp.mpf(20000), mp.mpf(800), mp.mpf(3000), mp.mpf(12)


def matrix(pressed):
    """Returns the matrix for z = (ball, plate, v_ball, v_plate, x, 1), with coordinates downwards."""
    a = mp.zeros(6)
    a[0, 2] = a[1, 3] = 1
    a[2, 5], a[3, 5] = G, G
    a[3, 1] -= (SOFT + K) / PLATE
    a[3, 4] += K / PLATE
    a[4, 1], a[4, 4] = K / C, -K / C
    if pressed:  # contact force f = CONTACT (ball - plate - DROP)
        for body, mass, sign in [(2, BALL, -1), (3, PLATE, 1)]:
            a[body, 0] += sign * CONTACT / mass
            a[body, 1] -= sign * CONTACT / mass
            a[body, 5] -= sign * CONTACT * DROP / mass
    return a


def excess(z):
    return z[0] - z[1] - DROP


def flow(a, z, t):
    term, total, k = z.copy(), z.copy(), 0
    while mp.norm(term) > mp.mpf(10) ** -45 or k < 5:
        k += 1
        term = a * term * (t / k)
        total += term
    return total


def rate(z):
    return z[2] - z[3]


def main():
    # The plate rests on its buffer, which has relaxed.
    plate = PLATE * G / SOFT
    z, time, pressed = mp.matrix([0, plate, 0, 0, plate, 1]), mp.mpf(0), False
    end, step = mp.mpf("0.9"), mp.mpf("1e-4")
    events = []
    while time < end:
        a = matrix(pressed)
        h = min(step, end - time)
        later = flow(a, z, h)
        inside = excess(later) > 0
        if inside != pressed:
            h = h / 2
            for _ in range(60):
                at = flow(a, z, h)
                change = excess(at) / rate(at)
                h -= change
                if abs(change) < mp.mpf(10) ** -44:
                    break
            z, time, pressed = flow(a, z, h), time + h, not pressed
            events.append((pressed, time))
            z = flow(matrix(pressed), z, mp.mpf("1e-9"))
            time += mp.mpf("1e-9")
            continue
        z, time = later, time + h
    print(len(events), [mp.nstr(t, 17) for _, t in events[:4]], mp.nstr(events[-1][1], 17))
    print([mp.nstr(x, 17) for x in z[:5]])


if __name__ == "__main__":
    main()
