"""A host that integrates one mass on a spring between a stop and an outer force, rightly or with one fault."""

SUBSTEPS = 64  # Runge-Kutta steps of each output step: an error of 1e-8


def force_at(inputs, time, after):
    """The straight line between the rows; at a jump the value before or after it."""
    rows = [row for row in inputs if row[0] <= time] if after else [row for row in inputs if row[0] < time] or inputs[:1]
    begin = rows[-1]
    later = next((row for row in inputs if row[0] > begin[0]), begin)
    if later[0] == begin[0]:
        return begin[1]
    return begin[1] + (later[1] - begin[1]) * (time - begin[0]) / (later[0] - begin[0])


def rows(inputs, steps, step, events=True, held=False, jumps=True):
    """(time, s, v) at the output times for the machine of the cases `input_ramps` and `input_jumps`.

    Faults: `events=False` passes the stop, `held=True` holds the input over each output step, `jumps=False` goes straight
    from the row before a jump to the next output time.
    """
    s, v, out = 0.0, 0.0, [(0.0, 0.0, 0.0)]
    h = step / SUBSTEPS
    for k in range(steps):
        for j in range(SUBSTEPS):
            time = k * step + j * h
            first = force_at(inputs, k * step, True)
            if held:
                force = lambda t: first
            elif not jumps:
                last = force_at(inputs, (k + 1) * step, True)
                force = lambda t: first + (last - first) * (t - k * step) / step
            else:
                force = lambda t: force_at(inputs, t, t < time + h / 2)
            s, v = advance(s, v, time, h, force, events)
        out.append(((k + 1) * step, s, v))
    return out


def rate(time, s, v, force):
    return v, force(time) - 16.0 * s - 0.5 * v


def runge_kutta(s, v, t, h, force):
    a = rate(t, s, v, force)
    b = rate(t + h / 2, s + h / 2 * a[0], v + h / 2 * a[1], force)
    c = rate(t + h / 2, s + h / 2 * b[0], v + h / 2 * b[1], force)
    d = rate(t + h, s + h * c[0], v + h * c[1], force)
    return tuple(x + h / 6 * (p + 2 * q + 2 * r + w) for x, p, q, r, w in zip((s, v), a, b, c, d))


def advance(s, v, t, h, force, events):
    """A step, through an impact at s = 0.25 with restitution 0.5."""
    to = runge_kutta(s, v, t, h, force)
    if not events or to[0] <= 0.25 or to[1] <= 0:
        return to
    low, high = 0.0, h
    for _ in range(50):
        mid = (low + high) / 2
        low, high = (mid, high) if runge_kutta(s, v, t, mid, force)[0] <= 0.25 else (low, mid)
    _, speed = runge_kutta(s, v, t, low, force)
    return advance(0.25, -0.5 * speed, t + low, h - low, force, True)
