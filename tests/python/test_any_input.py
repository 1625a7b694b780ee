"""Any input gives an answer without NaN or a documented exception; the interpreter survives.

`--minutes=10` runs for that time (cargo test -p fmu-build --test python_package -- --ignored).
"""

import contextlib
import pickle
import signal
import time

import numpy as np
import vibro_impact as vi
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

REFUSALS = (ValueError, TypeError, RuntimeError)

wild = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.integers(-(10**30), 10**30),
    st.none(),
    st.text(max_size=3),
    st.booleans(),
    st.lists(st.floats(), max_size=7),
    st.just(np.zeros((2, 2))),
)
fair = st.floats(-4, 4)
mostly_fair = st.one_of(fair, fair, fair, st.floats(1e-12, 1e12), wild)
names = st.sampled_from([*vi.SI_NAMES, *vi.GROUP_NAMES, "m1", "kapa", "", "ε", "box.m"])
parameters = st.dictionaries(names, mostly_fair, max_size=4)
starts = st.one_of(
    st.none(),
    st.lists(mostly_fair, min_size=6, max_size=6),
    st.dictionaries(st.sampled_from(["x1", "x2", "v2", "block_s", "box_v", "no"]), mostly_fair, max_size=3),
    wild,
)
# Without accepted numbers of periods that would take minutes.
few = st.one_of(st.integers(0, 12), st.integers(0, 12), wild.filter(lambda x: type(x) is not int or not 12 < x <= 10**9))


def checked(*arrays):
    for array in arrays:
        assert not np.isnan(np.asarray(array)).any()


def ask(changes, start, periods, kind, values):
    try:
        machine = vi.PaperMachine(**changes)
        again = pickle.loads(pickle.dumps(machine))
        assert again == machine and eval(repr(machine), {"PaperMachine": vi.PaperMachine}) == machine
        if kind == "simulate":
            run = machine.simulate(start=start, periods=periods, per_period=3)
            checked(run.t, run.s, run.v, *(run.energy[n] for n in run.energy.dtype.names))
            checked(*(run.impacts[n] for n in run.impacts.dtype.names))
        elif kind == "times":
            load = vi.Load("block", values, values[::-1])
            checked(machine.simulate(start=start, times=sorted(values), loads=[load]).s)
        elif kind == "many":
            checked(vi.simulate_many([machine] * 3, starts=start, periods=periods).states)
        elif kind == "section":
            checked(machine.poincare("upper", start=start, periods=periods, settle=periods).s)
        elif kind == "exponents":
            checked(machine.spectrum(start=start, periods=periods, settle=periods).exponents)
        elif kind == "steady":
            for found in (machine.steady().exact_orbit, machine.steady(sheet="lower").multiple_scales):
                if found is not None:
                    checked(found.amplitudes, *found.motion(values))
        elif kind == "bifurcation":
            name = "f10" if not changes else next(iter(changes))
            found = machine.bifurcation(**{name: values}, periods=(periods, periods))
            checked(found.up.maxima, found.down.impacts)
        elif kind == "basins":
            checked(machine.basins(x1=(-1, 1, 2), v2=(-1, 1, 2), settle=periods).cells)
        elif kind == "measure":
            checked([x for x in machine.measure(["amplitude.x1", "power.input"], start=start, periods=periods).values() if x is not None])
        else:
            orbit = machine.orbit("UL", tries=4)
            checked(orbit.phases, orbit.speeds, *orbit.motion([0.0, 1.0]))
    except REFUSALS as error:
        assert str(error), "an exception says what was wrong"


class TooLong(Exception):
    """A call that takes minutes, e.g. for a machine with widely separated rates."""


@contextlib.contextmanager
def seconds(most):
    """Interrupts a call as Ctrl-C does, on systems with timers."""
    if not hasattr(signal, "setitimer"):
        yield
        return

    def end(*_):
        raise TooLong

    before = signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, most)
    try:
        yield
    except TooLong:
        pass
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def ask_for_seconds(changes, start, periods, kind, values):
    with seconds(3.0):
        ask(changes, start, periods, kind, values)


KINDS = ["simulate", "times", "many", "section", "exponents", "steady", "bifurcation", "basins", "measure", "orbit"]
ANYTHING = given(
    changes=parameters,
    start=starts,
    periods=few,
    kind=st.sampled_from(KINDS),
    values=st.one_of(st.just([0.5, 1.0, 1.5]), st.lists(fair, max_size=5), wild),
)
QUIET = {"deadline": None, "suppress_health_check": list(HealthCheck), "database": None}


def test_any_input_is_answered_or_refused(request):
    end = time.monotonic() + 60 * request.config.getoption("--minutes")
    rounds = 0
    while rounds == 0 or time.monotonic() < end:
        # The first round has a fixed seed, later ones have new seeds.
        settings(max_examples=300, derandomize=rounds == 0, **QUIET)(ANYTHING(ask_for_seconds))()
        rounds += 1
    print(f"{300 * rounds} questions")
