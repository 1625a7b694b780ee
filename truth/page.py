"""The page of a case: its equations in plain form, for authors of solvers."""

from machine import Signal

SUITE = "../" * 2  # from the page of a case
LAWS = {
    "no-pull": "f = max(0, k x + c x') for x >= 0, else 0",
    "elastogap": "f = k x + min(k x, max(-k x, c x')) for x >= 0, else 0",
}


def shown(x):
    """A number in the shortest form that is its double."""
    x = float(x)
    return str(int(x)) if x == int(x) and abs(x) < 1e9 else repr(x)


def formula(signal):
    parts = [shown(signal.constant)] if signal.constant or signal.steady() else []
    for amplitude, frequency, phase in signal.harmonics:
        turned = f" + {shown(phase)}" if phase else ""
        parts.append(f"{shown(amplitude)} sin(2π {shown(frequency)} t{turned})")
    text = " + ".join(parts)
    for rows, before in zip(signal.pieces, signal.before):
        cells = [f"{shown(before)} before"] if rows and rows[0][0] > 0 else []
        for begin, value, end, later in (row for row in rows if signal.period is None or row[0] < signal.period):
            cells.append(f"{shown(value)} from {shown(begin)} s" + (f" straight to {shown(later)} at {shown(end)} s" if end is not None else ""))
        if signal.period is not None:
            cells.append(f"again after each {shown(signal.period)} s")
        text += (" + " if text else "") + "{" + ", ".join(cells) + "}"
    return text


def matrix(name, rows):
    return f"{name} = [" + "; ".join(" ".join(shown(x) for x in row) for row in rows) + "]"


def elongation(machine, arms):
    text = ""
    for i, a in arms:
        factor = "" if abs(a) == 1 else f"{shown(abs(a))} "
        sign = "-" if a < 0 else "+"
        text += f" {sign} {factor}s_{machine.bodies[i].name}" if text else f"{'-' if a < 0 else ''}{factor}s_{machine.bodies[i].name}"
    return text


def law(element):
    """The law of an element that is not a straight spring, in words and numbers."""
    n = {key: value if isinstance(value, (str, list, Signal)) else shown(value) for key, value in element.numbers.items()}
    if element.kind == "freewheel":
        return "e' <= 0, f >= 0, e' f = 0; where e' would become positive, an impulse sets it to 0"
    if element.kind == "stop" and "restitution" in n:
        return f"e <= {n['gap']}, f >= 0, (e - {n['gap']}) f = 0; impact: e' after = -{n['restitution']} e' before (Moreau's form for several stops)"
    if element.kind == "stop":
        stiff = formula(n["stiffness"])
        if "exponent" in n:
            damp = f" (1 + 1.5 * {n['dissipation']} x')" if "dissipation" in n else ""
            return f"x = e - {n['gap']}; f = max(0, {stiff} x^{n['exponent']}{damp}) for x >= 0, else 0"
        return f"x = e - {n['gap']}, k = {stiff}, c = {n.get('damping', 0)}; {LAWS[n.get('law', 'no-pull')]}"
    if element.kind == "friction":
        level, held = formula(n["force"]), formula(n.get("static", n["force"]))
        if "stribeck" in n:
            return f"slips: f = F sign(e'), F = {level} + ({held} - {level}) exp(-(e'/{n['stribeck']})^2); sticks while abs(f) <= {held}"
        return f"slips: f = F sign(e'), F = {level} (no friction where F <= 0); sticks while abs(f) <= {held}"
    if "slip" in n:
        return f"f = k (e - x), k = {formula(n['stiffness'])}; x' = 0 while abs(f) < {n['slip']}, x' = e' at abs(f) = {n['slip']}; x = 0 at the start"
    if "points" in n:
        points = ", ".join(f"({shown(e)}, {shown(f)})" for e, f in n["points"])
        return f"straight lines through the points (e, f) = {points}, the first and the last one extended; plus {n.get('damping', 0)} e'"
    if "cubic" in n:
        return f"f = {n['cubic']} e^3 in addition to K and C"
    if isinstance(n.get("stiffness"), Signal) and not n["stiffness"].steady():
        return f"f = k e, k = {formula(n['stiffness'])}"
    return None


def straight(machine):
    """C and K of the straight springs and dampers, and their preloads: a row for each free body, a column for each body."""
    size = len(machine.bodies)
    K, C = ([[0] * size for _ in range(size)] for _ in range(2))
    constant = [0] * size
    for e in machine.elements:
        plain = e.kind == "damper" or e.kind == "spring" and not {"slip", "points"} & set(e.numbers)
        damped = e.kind in ("spring", "damper") and "points" not in e.numbers
        stiff = e.numbers.get("stiffness")
        for i, a in e.arms:
            constant[i] -= a * e.numbers.get("preload", 0)
            for j, b in e.arms:
                if plain and stiff is not None and stiff.steady():
                    K[i][j] += a * b * stiff.constant
                if damped:
                    C[i][j] += a * b * e.numbers.get("damping", 0)
    return C, K, constant


def page(case, machine):
    about = case.about
    free = machine.free()
    C, K, constant = straight(machine)
    names = [b.name for b in machine.bodies]
    lines = [f"# {about['title']}", "", f"Covers: {', '.join(about['covers'])}. A host or solver fails if {about['fails_if']}.", ""]
    if "note" in about:
        lines += [about["note"].strip(), ""]
    lines += [f"Time from 0 to {shown(case.stop)} s, output every {shown(case.step)} s. All numbers are doubles in SI.", ""]
    lines += ["## Equations", "", f"s = ({', '.join(names)}); M s'' + C s' + K s + Σ w f = F, a row for each body that is not prescribed;", "w has the factors of s in the elongation e of each element.", ""]
    rows = lambda m: [m[i] for i in free]
    lines += ["```text", matrix("M", [[machine.bodies[i].mass if i == j else 0 for j in range(len(names))] for i in free])]
    lines += [matrix("C", rows(C)), matrix("K", rows(K))]
    for i in free:
        body = machine.bodies[i]
        forces = [shown(x) for x in (body.weight * body.mass + constant[i],) if x]
        for load in machine.loads:
            if load["on"] == i:
                forces.append(f"{shown(load['factor'])} {load['from']}" if load["from"] else formula(load["signal"]))
        lines.append(f"F_{body.name} = {' + '.join(forces) or '0'}; start s = {shown(body.s)}, s' = {shown(body.v)}")
    for body in machine.bodies:
        for key, signal, begin in (("s", body.position, ""), ("s'", body.rate, f", s(0) = {shown(body.s)}"),
                                   ("s''", body.acceleration, f", s(0) = {shown(body.s)}, s'(0) = {shown(body.v)}")):
            if signal:
                rate = f" + {shown(body.v)} t" if key == "s" and body.v else ""
                lines.append(f"{key}_{body.name} = {formula(signal)}{rate}{begin} (prescribed)")
    lines += ["```", ""]
    laws = [(e, law(e)) for e in machine.elements]
    if any(text for _, text in laws):
        lines += ["| element | e | law |", "|---|---|---|"]
        lines += [f"| `{e.kind}.{e.name}` | {elongation(machine, e.arms)} | {text} |" for e, text in laws if text]
        lines.append("")
    for block in machine.blocks:
        inputs = ", ".join(f"{names[i]}.{way}" for i, way in block["inputs"])
        lines += [f"Block `{block['name']}`: at each t = k {shown(block['sample'])} s, u = ({inputs}); y = c x + d u is held until the next sample, then x = a x + b u; x = 0 at the start;",
                  "; ".join(matrix(k, block[k]) for k in "abcd" if block[k]) + ".", ""]
    lines += ["## Files", "", "`truth.csv`: states at the output times; where a time occurs twice, an event is at the output time: the state before it and after it.",
              f"`events.csv`: all events. Both have the magnification of each value ([format]({SUITE}README.md#the-tables)).", ""]
    return "\n".join(lines)
