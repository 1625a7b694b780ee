"""Errors name the argument, its value and the accepted values."""

import numpy as np
import pytest
import vibro_impact as vi

M = vi.PaperMachine()
NAN = float("nan")

REFUSED = [
    (lambda: vi.PaperMachine(kapa=0.5), TypeError, "no parameter is named `kapa`; did you mean `kappa`?"),
    (lambda: vi.PaperMachine(box_mass=0.5), TypeError, r"did you mean `box_m`\? `box_m`: Mass of the box"),
    (lambda: vi.PaperMachine(box_m=-1), ValueError, "box_m = -1: expected a finite number > 0"),
    (lambda: vi.PaperMachine(box_m=NAN), ValueError, "box_m = nan: expected a finite number"),
    (lambda: vi.PaperMachine(box_m=10**400), ValueError, "expected a finite number"),
    (lambda: vi.PaperMachine(box_m="2"), ValueError, "box_m = '2': expected a number in kg, or a text with a unit"),
    (lambda: vi.PaperMachine(box_m=True), TypeError, "box_m = True is of type bool"),
    (lambda: vi.PaperMachine(box_m=np.zeros(2)), TypeError, "is of type ndarray"),
    (lambda: vi.PaperMachine(stop_restitution=1.5), ValueError, "stop_restitution = 1.5: expected 0 <= stop_restitution <= 1"),
    (lambda: vi.PaperMachine(box_k=0.0, kappa=0.5), ValueError, "box_k = 0: the dimensionless form requires box_k > 0"),
    (lambda: vi.PaperMachine(m1=1.0, box_m=2.0), TypeError, "box_m is given twice"),
    (lambda: vi.PaperMachine().simulate(9, start={"x2": 0.1, "block_s": 0.3}), ValueError, "x2 and block.s are the same coordinate"),
    (lambda: vi.PaperMachine().measure(["impacts"], start={"box_v": 0.1, "v1": 0.3}), ValueError, "box.v and v1 are the same coordinate"),
    (lambda: vi.PaperMachine.from_groups(box_m=1.0), TypeError, "box_m is a physical parameter: expected one of epsilon, kappa"),
    (lambda: M.replace(sigma1=-11.0), ValueError, "sigma1 = -11: expected a finite number > -1/epsilon"),
    (lambda: M.box_mas, AttributeError, "did you mean `box_m`?"),
    (lambda: M.simulate(periods=1.5), TypeError, "periods = 1.5 is of type float: expected a whole number"),
    (lambda: M.simulate(periods=-1), ValueError, "periods = -1: expected a whole number from 0 to"),
    (lambda: M.simulate(periods=10**9, per_period=10**8), ValueError, "periods \\* per_period \\+ 1"),
    (lambda: M.simulate(times=[1.0, 0.5]), ValueError, r"times\[1\] = 0.5 after 1: expected at least one time, with finite, ascending times >= 0"),
    (lambda: M.simulate(times=[-1.0]), ValueError, r"times\[0\] = -1: expected at least one time, with finite, ascending times >= 0"),
    (lambda: M.simulate(times=[]), ValueError, "times is empty: expected at least one time, with finite, ascending times >= 0"),
    (lambda: M.simulate("9"), ValueError, "until = '9': expected a number in s, or a text with a unit"),
    (lambda: M.replace({1: 2}), TypeError, "1 is not a name: expected the name of a parameter"),
    (lambda: M.replace({"kappa": 0.3, "stop_restitution": 0.6}), TypeError, "kappa cannot be combined with stop_restitution, which it determines"),
    (lambda: M.sweep(["class"], {"f10": [1.0], "drive.amplitude": [0.1]}), TypeError, "f10 cannot be combined with drive_amplitude"),
    (lambda: M.measure(None), TypeError, "measures = None: expected a sequence of names"),
    (lambda: M.orbit(symmetric=True), TypeError, "symmetric = True: requires `word`"),
    (lambda: M.orbit("UL").follow("f10", None, 2), TypeError, "low = None is of type NoneType"),
    (lambda: vi.simulate_many(M, starts=5), TypeError, "starts is of type int: expected a start, or a sequence"),
    (lambda: vi.simulate_many(M, starts=[]), ValueError, "starts is empty"),
    (lambda: vi.simulate_many(M, {"kappa": [[0.1, 0.2], [0.3]]}), ValueError, "kappa is not an array"),
    (lambda: vi.plot.branch(M.response("f10", 1.4, 1.5, seeds=1)), TypeError, "branch is of type list: expected Branch or PaperBranch; plot.response"),
    (lambda: M.simulate(times=[[1.0]]), ValueError, r"times has the shape \(1, 1\): expected an array of shape \(n,\)"),
    (lambda: M.simulate(times=["a"]), TypeError, "times has the dtype <U1: expected"),
    (lambda: M.simulate(times=[1.0, NAN]), ValueError, r"times\[1\] = nan: expected"),
    (lambda: M.simulate(times=[[1.0], [1.0, 2.0]]), ValueError, "times is not an array"),
    (lambda: M.simulate(9, start={"x4": 1.0}), ValueError, "a name in start = 'x4': expected one of 'x1'"),
    (lambda: M.simulate(9, start={"blok_s": 1.0}), ValueError, "did you mean 'block.s'"),
    (lambda: M.simulate(9, start={"x1": "a"}), ValueError, r"start\['x1'\] = 'a': expected a number"),
    (lambda: M.simulate(9, start=[0.0] * 5), ValueError, r"start has the shape \(5,\): expected \(6,\): box.s, block.s"),
    (lambda: M.simulate(9, start={"x2": 1.5}), ValueError, "block_s - box_s = 1.5 m: expected -stop_gap <="),
    (lambda: M.simulate(times=[1e300], start={"time": 1e300}), ValueError, "time times the fastest rate"),
    (lambda: M.simulate(9, loads=[1]), TypeError, r"loads\[0\] = 1 is of type int: expected Load"),
    (lambda: M.simulate(9, loads=3), TypeError, "loads = 3: expected a sequence of Load"),
    (lambda: M.simulate(9, loads=[vi.Load("box", [0, 1], [1e300, 1e300])]), ValueError, "load over its body's mass"),
    (lambda: M.replace(drive_frequency=0.0).simulate(periods=9), ValueError, "drive_frequency = 0.0: a run over periods"),
    (lambda: M.replace(drive_frequency=1e-310).simulate(periods=9), ValueError, "drive_frequency = 1e-310: .* with a finite period"),
    (lambda: M.replace(drive_frequency=1e-305).simulate(periods=200), ValueError, "periods = 200: the run must end at a finite time"),
    (lambda: M.replace(drive_frequency=0.0).spectrum(), ValueError, "drive_frequency = 0.0"),
    (lambda: vi.simulate_many([M.replace(drive_frequency=0.0)]), ValueError, r"machines\[0\]: drive_frequency = 0.0"),
    (lambda: vi.Load("boxx", [0, 1], [0, 1]), ValueError, "body = 'boxx': expected one of 'box', 'block', 'secondary'; did you mean 'box'"),
    (lambda: vi.Load("box", [0, 1], [0, 1, 2]), ValueError, r"force has the shape \(3,\): expected the shape of t, \(2,\)"),
    (lambda: vi.Load("box", [0, 0], [0, 1]), ValueError, "a time later than the time of the previous sample"),
    (lambda: vi.Load("box", [0], [0]), ValueError, "samples"),
    (lambda: vi.Load("box", [0, 1], [0, 1], "spline"), ValueError, "interpolation = 'spline'"),
    (lambda: vi.simulate_many([M, 1]), TypeError, r"machines\[1\] is of type int: expected PaperMachine"),
    (lambda: vi.simulate_many([M, M], starts=np.zeros((3, 6))), ValueError, "starts has 3 rows"),
    (lambda: vi.simulate_many([M, M], starts=np.zeros((2, 5))), ValueError, r"starts has the shape \(2, 5\): expected \(n, 6\)"),
    (lambda: vi.simulate_many([M, M], starts=[{"x2": 0.1}, {"x2": 2.0}]), ValueError, "motion 1: block_s - box_s = 2 m"),
    (lambda: M.poincare("top"), ValueError, "section = 'top': expected one of 'upper', 'lower'"),
    (lambda: M.poincare("upper", phase=1.0), ValueError, "phase = 1.0: must be 0 at a section of a stop's impacts"),
    (lambda: M.simulate(), TypeError, "expected exactly one of until, periods and times"),
    (lambda: M.simulate(9, periods=3), TypeError, "until, periods: expected exactly one of until, periods and times"),
    (lambda: M.simulate({"x2": 0.5}), TypeError, "until = {'x2': 0.5} is of type dict: expected a finite number"),
    (lambda: M.measure(["impacts"], start={"time": "2 m"}), ValueError, r"start\['time'\] = '2 m': expected a number in s"),
    (lambda: M.basins(v2=(-1, 1, 3), x1=(-1, 1, 3), start={"time": 1.0}), ValueError, "time = 1.0: must be 0, where this study begins"),
    (lambda: M.orbit("UL", period=2), ValueError, "period = 2: expected '1T' to '1000T', or a multiple of the drive's period, 6.04"),
    (lambda: M.replace({"stop.gap": "4 mN"}), ValueError, "stop.gap = '4 mN': expected a number in m"),
    (lambda: M.replace({"stop.gap": 1.0}, **{"stop.gap": 2.0}), TypeError, "stop.gap is given twice"),
    (lambda: M.replace([1]), TypeError, "changes is of type list: expected a dictionary"),
    (lambda: M.poincare(phase=NAN), ValueError, "phase = nan"),
    (lambda: M.spectrum(periods=0), ValueError, "periods = 0: expected a whole number from 1"),
    (lambda: M.measure(["amplitude.x9"]), ValueError, "no output is named `amplitude.x9`; did you mean"),
    (lambda: M.measure("impacts"), TypeError, "measures = 'impacts': expected a sequence of names"),
    (lambda: M.steady(sheet="uper"), ValueError, "sheet = 'uper': expected one of 'upper', 'lower'; did you mean 'upper'"),
    (lambda: M.orbit("UX"), ValueError, "a word of the letters U and L"),
    (lambda: M.orbit(3), TypeError, "word = 3: expected a word"),
    (lambda: M.orbit("U", period="2T", symmetric=True), ValueError, "an odd number of half periods"),
    (lambda: M.orbit("UUUUL", tries=3), RuntimeError, "no orbit with the word UUUUL"),
    (lambda: M.orbit("UL").follow("f10", 2.0, 3.0), ValueError, "expected a range that contains f10 = "),
    (lambda: M.orbit("UL").follow("f11", 1.0, 3.0), TypeError, "did you mean `f10`?"),
    (lambda: M.bifurcation(), TypeError, "expected exactly one parameter with its values"),
    (lambda: M.bifurcation(f10=[1, 2], kappa=[0, 1]), TypeError, "expected exactly one parameter"),
    (lambda: M.bifurcation(f11=[1, 2]), TypeError, "no parameter is named `f11`; did you mean `f10`?"),
    (lambda: M.bifurcation(f10=[1, 2, 4]), ValueError, r"f10 is not equally spaced, f10\[1\] = 2 instead of 2.5: expected"),
    (lambda: M.bifurcation(f10=[2, 1]), ValueError, r"f10 does not increase, f10\[0\] = 2 and f10\[1\] = 1"),
    (lambda: M.bifurcation(f10=[1]), ValueError, r"len\(f10\) = 1: expected a whole number from 2"),
    (lambda: M.bifurcation(kappa=[0.5, 1.5]), ValueError, "kappa = 1.5: expected 0 <= kappa <= 1"),
    (lambda: M.bifurcation(f10=[1, 2], periods=3), TypeError, "periods = 3: expected a pair of whole numbers"),
    (lambda: M.bifurcation(f10=[1, 2], of="y"), ValueError, "of = 'y': expected one of 'x1'"),
    (lambda: M.basins(v2=(-1, 1, 3)), TypeError, "expected two of x1, x2"),
    (lambda: M.basins(v2=(-1, 1, 3), v4=(-1, 1, 3)), ValueError, "a name of a range = 'v4'"),
    (lambda: M.basins(v2=(1, -1, 3), v1=(-1, 1, 3)), ValueError, "expected from < to"),
    (lambda: M.basins(v2=(-1, 1), v1=(-1, 1, 3)), TypeError, r"expected \(from, to, cells\)"),
    (lambda: vi.fmu_path(1), ValueError, "version = 1: expected a whole number from 2 to 3"),
    (lambda: M.steady().exact_orbit.motion([[0.0]]), ValueError, "theta has the shape"),
]


@pytest.mark.parametrize("call, kind, words", REFUSED, ids=[words for *_, words in REFUSED])
def test_refused(call, kind, words):
    with pytest.raises(kind, match=words):
        call()


def test_a_motion_that_does_not_get_on_says_what_to_do():
    # A constant force presses the box against an elastic block, whose bounces are just too high to
    # count as closed.
    machine = vi.PaperMachine(
        stop_restitution=1.0,
        box_k=0.0,
        coupling_k=0.0,
        drive_frequency=0.0,
        drive_phase=np.pi / 2,
        drive_amplitude=-100.0,
    )
    with pytest.raises(RuntimeError, match="Remedy: advance again from there.*or set stop_restitution below 0.999"):
        machine.simulate(start={"x2": 1.0, "block_v": -3e-5}, times=[30.0])


def test_a_missing_archive_is_named_with_the_command(monkeypatch):
    monkeypatch.setattr(vi._fmu, "_NAMES", {2: "none.fmu", 3: "none.fmu"})
    with pytest.raises(FileNotFoundError, match="none.fmu is missing.*cargo run --bin fmu-build"):
        vi.fmu_path()
