"""Section 12: energy accounts."""

from typing import Any, Dict

import mpmath
import pytest
import sympy
from equations import eq, sym, zero
from simulation import DIGITS, Parameters, State, at, basic, other, run, series
from test_motion import in_time, t
from approximation import NUMERIC

# Ten nodes over a step of the simulation are exact to its digits for the tests below.
NODES, WEIGHTS = (
    [mpmath.mpf(x) for x in ("0.0130467357414141", "0.0674683166555077", "0.1602952158504878", "0.2833023029353764", "0.4255628305091844")],
    [mpmath.mpf(x) for x in ("0.0333356721543441", "0.0747256745752903", "0.1095431812579910", "0.1346333596549982", "0.1477621123573764")],
)


def start(p: Parameters) -> State:
    return [mpmath.mpf(x) for x in ("0.1", "0.5", "-0.2", "0.3", "1.4", "0.1", "0.4")]


def known(p: Parameters, z: State) -> Dict[str, Any]:
    """A state by the page's names."""
    names: Dict[str, Any] = {**NUMERIC, **p, "theta": z[6], "x_1": z[0], "w": z[1] - z[0], "x_3": z[2]}
    names.update(dot_x_1=z[3], dot_w=z[4] - z[3], dot_x_3=z[5], f_1=mpmath.mpf(0), f_2=mpmath.mpf(0), f_3=mpmath.mpf(0))
    return names


def integral(p: Parameters, key: str, z: State, h: Any) -> Any:
    """The integral of a power of (89) along a flight, by Gauss-Legendre's rule with ten nodes."""
    x = series(p, z)
    total = mpmath.mpf(0)
    for node, weight in zip(NODES, WEIGHTS):
        for u in (node, 1 - node):
            total += weight * eq(89)(key, known(p, at(p, z, x, u * h)))
    return total * h


def test_eq_88_mechanical_energy() -> None:
    """(88) is T + V of (1) in the coordinates (5)."""
    x_2 = {"x_2": sym("x_1") + sym("w"), "dot_x_2": sym("dot_x_1") + sym("dot_w")}
    assert zero(eq(88)("E") - eq(1)("T", x_2) - eq(1)("V", x_2))


@pytest.mark.parametrize("mode", ["flight", "rest"])
def test_eq_89_power_balance(mode: str) -> None:
    """The derivative of (88) along (7), and along (13) with w' = 0, is P_F - P_d of (89)."""
    env = in_time(["x_1", "w", "x_3"])
    energy = eq(88)("E", env)
    a = eq(6).values(env)
    number = 7 if mode == "flight" else 13
    rates = {k: eq(number)(k, {**a, "m_r": eq(10)("m_r")}) for k in ("ddot_x_1", "ddot_w", "ddot_x_3")}
    change = energy.diff(t).subs({env[k]: v for k, v in rates.items()})
    powers = {k: eq(89)(k, env) for k in ("P_F", "P_d")}
    difference = change - eq(89)("dot_E", powers)
    if mode == "rest":
        difference = difference.subs(env["dot_w"], 0)
    assert zero(difference)


@pytest.mark.parametrize("p", [basic(), other()], ids=["basic", "other"])
def test_eq_90_94_95_balance_and_work_of_the_drive_over_impacts(p: Parameters) -> None:
    """Along a simulated motion with impacts the accounts (90) balance, with the work by quadrature and by (94), (95)."""
    with mpmath.workdps(DIGITS):
        end = mpmath.mpf(9)
        found = run(p, start(p), end)
        assert len(found.impacts) >= 2
        work, damped = (sum(integral(p, key, z, h) for z, h in found.pieces) for key in ("P_F", "P_d"))
        lost, jumps = mpmath.mpf(0), mpmath.mpf(0)
        constants = eq(93).values({**NUMERIC, **p})
        for _, before, after in found.impacts:
            rate = before[4] - before[3]
            impact = {**NUMERIC, **p, "s": mpmath.sign(rate), "dot_w_minus": rate}
            impact.update(m_r=eq(10)("m_r", impact), v=eq(10)("v", impact))
            lost += eq(12)("E_i", impact)
            jump = {**known(p, before), **constants, "dot_x_1_minus": before[3], "dot_x_1_plus": after[3]}
            change = eq(95).relations[0].right(jump)
            gamma = [eq(92)("Gamma", {**known(p, z), **constants}) for z in (before, after)]
            assert abs(gamma[1] - gamma[0] - change) < mpmath.mpf(10) ** -25
            jumps += change
        energy = [eq(88)("E", known(p, z)) for z in (start(p), found.end)]
        account = eq(90).relations[0].right({"E": lambda time: energy[0] if time == 0 else None, "number": mpmath.mpf, "W_F": work, "E_d": damped, "E_i": lost})
        assert abs(account - energy[1]) < mpmath.mpf(10) ** -12
        # (94), whose last term is the sum of the jumps.
        tokens = list(eq(94).relations[0].right_tokens)
        assert tokens[-4:] == ["-", r"\sum", r"\Delta", r"\Gamma"]
        from equations import Reader

        first = eq(92)("Gamma", {**known(p, start(p)), **constants})
        last = eq(92)("Gamma", {**known(p, found.end), **constants})
        t_1, t_2 = mpmath.mpf("0.7"), mpmath.mpf("0.7") + end
        env = {**NUMERIC, **constants, "Gamma": lambda time: last if time == t_2 else first, "t_1": t_1, "t_2": t_2, "j": jumps}
        form = Reader(tokens[:-3] + ["j"], env).all()
        assert abs(form - work) < mpmath.mpf(10) ** -12


def test_eq_91_damped_energy_as_a_quadratic_form() -> None:
    """The weights of (91) make z₀ᵀ Y z₀ the integral of P_d; checked on a matrix of two oscillators with a drive."""
    tokens = eq(91).tex
    weights = tokens.split(r"\mathrm{diag}(")[1].split(")")[0].split(",")
    assert [w.strip() for w in weights] == ["0", "0", "0", "c_1", "0", "c_3", "0", "0"]
    p = other()
    with mpmath.workdps(20):
        a = eq(6)
        names = ["x_1", "w", "x_3", "dot_x_1", "dot_w", "dot_x_3"]
        rows = []
        zeros = {n: mpmath.mpf(0) for n in [*names, "f_1", "f_2", "f_3"]}
        # Columns of N by unit states; the last two lanes are cos θ and sin θ.
        for j in range(8):
            state = {**zeros, **{names[i]: mpmath.mpf(i == j) for i in range(6)}}
            values = a.values({**NUMERIC, **p, **state, "theta": mpmath.mpf(0), "sin": lambda _: mpmath.mpf(j == 7)})
            column = [state["dot_x_1"], state["dot_w"], state["dot_x_3"], values["a_1"], values["a_w"], values["a_3"]]
            rows.append(column + [-p["omega_1"] * (j == 7), p["omega_1"] * (j == 6)])
        N = mpmath.matrix(rows).T
        diagonal = mpmath.diag([p.get(w.strip(), mpmath.mpf(0)) for w in weights])
        span = mpmath.mpf("0.4")
        Y = mpmath.zeros(8)
        for node, weight in zip(NODES, WEIGHTS):
            for u in (node, 1 - node):
                flow = mpmath.expm(N * (u * span))
                Y += weight * span * (flow.T * diagonal * flow)
        z = start(p)
        z_0 = mpmath.matrix([z[0], z[1] - z[0], z[2], z[3], z[4] - z[3], z[5], mpmath.cos(z[6]), mpmath.sin(z[6])])
        form = eq(91).relations[0].right({"z_0": Transposable(z_0), "Y": Y})
        assert abs(form - integral(p, "P_d", z, span)) < mpmath.mpf(10) ** -11


class Transposable:
    """A column for the page's z_0^T Y z_0, which is a number."""

    def __init__(self, column: Any):
        self.column = column

    @property
    def T(self) -> Any:
        return Row(self.column.T)


class Row:
    """A row on its way through the product."""

    def __init__(self, row: Any):
        self.row = row

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, Transposable):
            return (self.row * other.column)[0]
        return Row(self.row * other)


def test_eq_92_93_work_of_the_drive_in_closed_form() -> None:
    """The derivative of Γ (92) with (93), plus P̄, is the drive's power along (7)."""
    env = in_time(["x_1"])
    constants = eq(93).values()
    gamma = eq(92)("Gamma", {**env, **constants, "theta": eq(4)("theta", {"t": t})})
    a_1 = eq(6)("a_1", {**env, "theta": eq(4)("theta", {"t": t}), "f_1": 0})
    rate = gamma.diff(t).subs(env["ddot_x_1"], a_1)
    power = eq(89)("P_F", {**env, "theta": eq(4)("theta", {"t": t}), "f_1": 0, "f_2": 0, "f_3": 0})
    assert zero(rate + constants["bar_P"] - power)


def test_eq_93_mean_power_of_the_steady_state() -> None:
    """P̄ of (93) is the mean of the drive's power for the box's own steady state."""
    w, m, k, c, f = (sympy.Symbol(n, positive=True) for n in ("omega_1", "m_1", "k_1", "c_1", "F_10"))
    response = f / (k - m * w**2 + sympy.I * c * w)
    # x1 = Im(H e^{iθ}), so x1' = Im(iωH e^{iθ}); the mean of sin θ Im(z e^{iθ}) is Re(z)/2.
    mean = f * sympy.re(sympy.expand(sympy.I * w * response, complex=True)) / 2
    given = eq(93).values({"omega_1": w, "m_1": m, "k_1": k, "c_1": c, "F_10": f})["bar_P"]
    assert zero(given - mean)
