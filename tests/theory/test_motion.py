"""Sections 2 and 3: equations of motion, impact, rest, chatter."""

from typing import Any, Dict, List

import mpmath
import sympy
from equations import eq, sym, zero

t = sympy.Symbol("t", real=True)


def in_time(names: List[str]) -> Dict[str, Any]:
    """Coordinates as functions of time, with their derivatives by name."""
    environment: Dict[str, Any] = {}
    for name in names:
        x = sympy.Function(name, real=True)(t)
        environment.update({name: x, f"dot_{name}": x.diff(t), f"ddot_{name}": x.diff(t, 2)})
    return environment


def test_eq_1_2_3_motion_from_lagranges_equations() -> None:
    """(1), (2) and Lagrange's equations give (3)."""
    env = in_time(["x_1", "x_2", "x_3"])
    lagrangian = eq(1)("T", env) - eq(1)("V", env)
    dissipation = eq(2)("R", env)
    for i, relation in enumerate(eq(3).relations, start=1):
        x, v = env[f"x_{i}"], env[f"dot_x_{i}"]
        left = lagrangian.diff(v).diff(t) - lagrangian.diff(x) + dissipation.diff(v)
        assert zero(left - eq(2)(f"Q_{i}", env) - (relation.left(env) - relation.right(env)))


def test_eq_1_2_3_numbers_of_one_configuration() -> None:
    """(1) to (3) against numbers worked out by hand, so that an error common to all three shows."""
    values = dict(m_1=2, m_2=3, m_3=5, k_1=7, k_3=11, k_23=13, c_1=17, c_3=19, F_10=0, theta=0, f_1=0, f_2=0, f_3=0)
    values.update({"lambda": 0, "s": 1})
    # Only the block is displaced: its coupling pulls it back and the secondary oscillator along.
    state = dict(x_1=0, x_2=1, x_3=0, dot_x_1=0, dot_x_2=0, dot_x_3=0)
    env = {**values, **state}
    solved = [sympy.solve(r.left(env) - r.right(env), sym(f"ddot_x_{i}"))[0] for i, r in enumerate(eq(3).relations, 1)]
    assert solved == [0, sympy.Rational(-13, 3), sympy.Rational(13, 5)]
    assert eq(1)("V", env) == sympy.Rational(13, 2) and eq(2)("R", {**env, "dot_x_3": 2}) == 38


def test_eq_97_loads_of_an_off_centre_gap() -> None:
    """(3) in the coordinate of the coupling spring, without loads, is (3) under the loads of (97) in the coordinate of the gap's middle."""
    env = in_time(["x_1", "bar_x_2", "x_3"])
    offset = eq(97)("x_2", env)
    no_loads = {"f_1": 0, "f_2": 0, "f_3": 0}
    spring = {**env, "x_2": env["bar_x_2"], "dot_x_2": env["dot_bar_x_2"], "ddot_x_2": env["ddot_bar_x_2"], **no_loads}
    middle = {**env, "x_2": offset, "dot_x_2": offset.diff(t), "ddot_x_2": offset.diff(t, 2), "f_1": 0}
    middle.update({name: eq(97)(name, env) for name in ("f_2", "f_3")})
    for relation in eq(3).relations:
        assert zero(relation.left(spring) - relation.right(spring) - relation.left(middle) + relation.right(middle))
    # The stops: w = s L in the middle's coordinate where the block touches at b + s L in the
    # spring's.
    stop = sympy.solve(env["bar_x_2"] - env["x_1"] - sym("b") - sym("s") * sym("L"), env["bar_x_2"])[0]
    assert zero((offset - env["x_1"]).subs(env["bar_x_2"], stop) - sym("s") * sym("L"))


def accelerations() -> Dict[str, Any]:
    """(6) evaluated with its own names."""
    return eq(6).values()


def test_eq_5_6_7_flight_from_the_equations_of_motion() -> None:
    """(3) without contact, solved for the accelerations, in the coordinates (5), is (6), (7)."""
    a = accelerations()
    x_2 = sympy.solve(eq(5).relation("w").left() - eq(5)("w"), sym("x_2"))[0]
    assert zero(eq(5).relations[1].left({"x_2": x_2}) - eq(5).relations[1].right())
    env = {"x_2": x_2, "lambda": sympy.Integer(0)}
    names = ["ddot_x_1", "ddot_x_2", "ddot_x_3"]
    solved = [sympy.solve(r.left(env) - r.right(env), sym(n))[0] for n, r in zip(names, eq(3).relations)]
    assert zero(solved[0] - a["a_1"]) and zero(solved[1] - a["a_2"]) and zero(solved[2] - a["a_3"])
    assert zero(eq(7)("ddot_x_1", a) - solved[0]) and zero(eq(7)("ddot_x_3", a) - solved[2])
    assert zero(eq(7)("ddot_w", a) - (solved[1] - solved[0]))


def test_eq_8_series_of_the_flow_under_polynomial_loads() -> None:
    """(8) sums to the matrix exponential of the system with the loads' derivatives as states of their own."""
    with mpmath.workdps(30):
        # Two coordinates suffice: the recurrence holds for any matrices.
        N = mpmath.matrix([[0, 1, 0], [-2, mpmath.mpf("-0.3"), 1], [0, mpmath.mpf("0.7"), -1]])
        K = mpmath.matrix([[0], [1], [mpmath.mpf("0.5")]])
        z, loads, span = mpmath.matrix([1, -2, mpmath.mpf("0.4")]), [3, -1, 2, mpmath.mpf("0.6")], mpmath.mpf("0.8")
        whole = mpmath.zeros(7)
        whole[:3, :3] = N
        for i in range(3):
            whole[i, 3] = K[i]
            whole[3 + i, 4 + i] = 1
        expected = mpmath.expm(whole * span) * mpmath.matrix([*z, *loads])
        total, term = z, z
        for k in range(40):
            d = mpmath.matrix([loads[k] if k < 4 else 0])
            env = {"N": N, "z_k": term, "K": K, "d_k": d, "r": span, "k": mpmath.mpf(k)}
            term = eq(8).relations[0].right({**env, "factorial": mpmath.factorial, "number": mpmath.mpf})
            total = total + term
        assert max(abs(total[i] - expected[i]) for i in range(3)) < mpmath.mpf(10) ** -25


def after_impact() -> Dict[str, Any]:
    """(9) solved for the velocities after an impact at stop s with the approach speed of (10)."""
    v, s, m_1, m_2 = sym("v"), sym("s"), sym("m_1"), sym("m_2")
    before = {"dot_x_1_minus": sym("dot_x_1_minus"), "dot_x_2_minus": sym("dot_x_1_minus") + v / s}
    momentum = eq(9).relations[0]
    restitution = eq(9).relation("dot_w_plus")
    w_minus = before["dot_x_2_minus"] - before["dot_x_1_minus"]
    x_1, x_2 = sym("dot_x_1_plus"), sym("dot_x_2_plus")
    equations = [momentum.left() - momentum.right(before), x_2 - x_1 - restitution.right({"dot_w_minus": w_minus})]
    found = sympy.solve(equations, [x_1, x_2], dict=True)[0]
    assert zero(eq(10)("v", {"dot_w_minus": w_minus}) - v)
    return {**before, "plus_1": found[x_1], "plus_2": found[x_2], "m_1": m_1, "m_2": m_2, "v": v, "s": s}


def side(expression: Any) -> Any:
    """Simplifies, given s² = 1."""
    return sympy.simplify(sympy.simplify(expression).subs(sym("s") ** -1, sym("s")).subs(sym("s") ** 2, 1))


def test_eq_9_10_11_impact_law_from_momentum_and_restitution() -> None:
    """Momentum and restitution (9) give the impulse (10) and the velocities (11), at either stop."""
    e = after_impact()
    m_r = eq(10)("m_r")
    p = eq(10)("p", {"m_r": m_r})
    for s in (1, -1):
        impulse = s * e["m_1"] * (e["plus_1"] - e["dot_x_1_minus"])
        assert zero((impulse - p).subs(e["s"], s))
        for i in (1, 2):
            value = eq(11)(f"dot_x_{i}_plus", {**e, "m_r": m_r})
            assert zero((value - e[f"plus_{i}"]).subs(e["s"], s)), (i, s)


def test_eq_12_energy_lost_at_an_impact() -> None:
    """(12) is the kinetic energy before less that after, by (9)."""
    e = after_impact()
    energy = [sym("m_1") * a**2 / 2 + sym("m_2") * b**2 / 2 for a, b in
              [(e["dot_x_1_minus"], e["dot_x_2_minus"]), (e["plus_1"], e["plus_2"])]]  # fmt: skip
    for s in (1, -1):
        lost = (energy[0] - energy[1]).subs(e["s"], s)
        assert zero(lost - eq(12)("E_i", {"m_r": eq(10)("m_r")}))


def test_eq_13_14_rest_from_the_constraint() -> None:
    """(3) with the constraint that box and block accelerate alike gives (13) and the contact force (14)."""
    a = accelerations()
    m_r = eq(10)("m_r")
    x_2 = sym("x_1") + sym("w")
    joint, force = sym("joint"), sym("lambda")
    env = {"x_2": x_2, "ddot_x_1": joint, "ddot_x_2": joint, "dot_x_2": sym("dot_x_1")}
    r_1, r_2, r_3 = eq(3).relations
    for s in (1, -1):
        both = {**env, "s": sympy.Integer(s)}
        equations = [r_1.left(both) - r_1.right(both), r_2.left(both) - r_2.right(both)]
        found = sympy.solve(equations, [joint, force], dict=True)[0]
        assert zero(found[joint] - eq(13)("ddot_x_1", {**a, "m_r": m_r}))
        assert zero(found[force] - eq(14)("lambda", {**a, "m_r": m_r, "s": sympy.Integer(s)}))
    assert eq(13)("ddot_w") == 0
    assert zero(eq(13)("ddot_x_3", a) - sympy.solve(r_3.left(env) - r_3.right(env), sym("ddot_x_3"))[0])


def test_eq_16_sums_of_a_chatter_run() -> None:
    """(16) sums flights of 2u/a and losses (12) of all further impacts."""
    u, a, m_r = mpmath.mpf("0.3"), mpmath.mpf("1.7"), mpmath.mpf("0.2")
    x, speed, pull = sympy.symbols("x u a", positive=True)
    flight = [root for root in sympy.solve(-speed * x + pull * x**2 / 2, x) if root != 0]
    assert flight == [2 * speed / pull]
    for kappa in (mpmath.mpf("0.1"), mpmath.mpf("0.75"), mpmath.mpf("0.95")):
        env = {"u": u, "a": a, "m_r": m_r, "kappa": kappa, "number": mpmath.mpf}
        time = mpmath.nsum(lambda n: 2 * u * kappa**n / a, [0, mpmath.inf])
        loss = mpmath.nsum(lambda n: eq(12)("E_i", {**env, "v": u * kappa**n}), [0, mpmath.inf])
        assert abs(eq(16)("t_c", env) - time) < 1e-12 and abs(eq(16)("E_c", env) - loss) < 1e-12


def test_eq_17_merge_keeps_momentum_and_loses_the_relative_energy() -> None:
    """(17) is (11) and (12) with no restitution, and loses what the run of (16) would."""
    e = after_impact()
    m_r = eq(10)("m_r")
    w_minus = sym("dot_w_minus")
    for s in (1, -1):
        plastic = e["plus_1"].subs(sym("kappa"), 0).subs(e["v"], s * w_minus).subs(e["s"], s)
        env = {"m_r": m_r, "dot_w_minus": w_minus}
        assert zero(plastic - eq(17)("dot_x_1_plus", env))
        assert eq(17)("dot_w_plus") == 0
        assert zero(eq(12)("E_i", {"kappa": 0, "m_r": m_r, "v": s * w_minus}) - eq(17)("E_c", env))
        assert zero(eq(16)("E_c", {"u": s * w_minus, "m_r": m_r}) - eq(17)("E_c", env))


def test_eq_18_limits_of_the_rebound_speed() -> None:
    """(18) solves u t_c = e_c L with (16), and u²/(2a) = e_h L for the height of a bounce."""
    u, u2, L, e_c, e_h, a = sym("u"), sym("u2"), sym("L"), sym("e_c"), sym("e_h"), sym("a")
    moved = sympy.expand(u * eq(16)("t_c")).subs(u**2, u2)
    right = {r.key: r.right() for r in eq(18).relations}
    assert zero(sympy.solve(moved - e_c * L, u2)[0] - right["u_c^2"])
    assert zero(sympy.solve(u2 / (2 * a) - e_h * L, u2)[0] - right["u_h^2"])
    # Half a unit in the last place of a double near 1, and what the simulator's LEAST_BOUNCE is.
    assert right["e_c"] == sympy.Rational(2) ** -53 and right["e_h"] == sympy.Rational(10) ** -12
