"""Threads, processes, signals, progress."""

import gc
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import vibro_impact as vi

DAMPER = Path(__file__).parents[2] / "examples" / "assembly" / "damper_with_buffer.toml"
#: The gap of its steel stop, m.
GAP = "stop.steel.gap"

# A person notices a delay of a fifth of a second.
PROMPT = 0.2

LONG = {
    "simulate": lambda m, **more: m.simulate(periods=400_000, per_period=10, **more),
    "poincare": lambda m, **more: m.poincare(periods=50_000_000, **more),
    "lyapunov": lambda m, **more: m.spectrum(periods=400_000, **more),
    "many": lambda m, **more: vi.simulate_many(m, starts=np.zeros((300_000, 6)), periods=100, **more),
    "bifurcation": lambda m, **more: m.bifurcation(f10=np.linspace(0.5, 4, 2000), periods=(100, 100), **more),
    "basins": lambda m, **more: m.basins(v2=(-2, 2, 200), x1=(-1, 1, 2000), **more),
}
LONG_OF_DESCRIBED = {
    "simulate": lambda a, **more: a.simulate(1000.0, samples=1_000_000, **more),
    "many": lambda a, **more: vi.simulate_many([a] * 20_000, until=20.0, **more),
    "measure": lambda a, **more: vi.measure_many([a] * 20_000, ["class"], **more),
    "bifurcation": lambda a, **more: a.bifurcation("box.s", periods=(100, 100), **{GAP: np.linspace(0.01, 0.13, 2000)}, **more),
}


@pytest.fixture
def signals():
    """Sets Python's own handler: a process that was started in the background may ignore Ctrl-C."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    # Hypothesis times the garbage collector: a KeyboardInterrupt raised within its callback is
    # lost.
    callbacks, gc.callbacks[:] = gc.callbacks[:], []
    yield
    gc.callbacks[:] = callbacks
    signal.signal(signal.SIGINT, before)


@pytest.mark.skipif(os.name == "nt", reason="signals of another kind")
@pytest.mark.parametrize("call", [*LONG, *(f"described {name}" for name in LONG_OF_DESCRIBED)])
def test_a_signal_ends_a_long_call_at_once(call, signals):
    name = call.removeprefix("described ")
    if name == call:
        work, machine = LONG[name], vi.PaperMachine.from_groups(f10=2.8)
    else:
        work, machine = LONG_OF_DESCRIBED[name], vi.Machine(DAMPER)
    delays = []
    # The shortest of three delays, because another process may hold the processor.
    for _ in range(3):
        sent, over = [], threading.Event()

        def interrupt(sent=sent, over=over):
            # Python drops a KeyboardInterrupt that it raises while an object is finalized.
            while not over.wait(0.3 if not sent else 1.0):
                sent.append(time.perf_counter())
                os.kill(os.getpid(), signal.SIGINT)

        sender = threading.Thread(target=interrupt)
        sender.start()
        with pytest.raises(KeyboardInterrupt):
            work(machine)
        delays.append(time.perf_counter() - sent[-1])
        over.set()
        sender.join()
        if delays[-1] < PROMPT:
            break
    assert min(delays) < PROMPT, delays


#: Prints the number of motions finished at Ctrl-C, and whether their rows are correct.
INTERRUPTED = """
import os, signal, sys, threading
import vibro_impact as vi
machine, names = (vi.PaperMachine(), ["impacts"]) if sys.argv[1] == "machine" else (vi.Machine(sys.argv[1]), ["amplitude.box.s"])
only = dict(periods=20) if sys.argv[1] == "machine" else dict(until=0.5)
# The vectors of machines end together, some thousands.
least = 30_000 if sys.argv[1:] == ["machine", "ends"] else 4
signal.signal(signal.SIGINT, signal.default_int_handler)
own = dict(periods=4, settle=20)
def done(done, total):
    if done >= least:
        os.kill(os.getpid(), signal.SIGINT)
def ends(machines):
    found = vi.simulate_many(machines, **only)
    return getattr(found, "states", None) if sys.argv[1] == "machine" else found.values
def rows(machines):
    return vi.measure_many(machines, names, **own)
call = {"ends": ends, "rows": rows}[sys.argv[2]]
wanted = call([machine])[0]
wanted = {name: wanted[name] for name in names} if sys.argv[2] == "rows" else wanted
vi._progress.Bar.report = property(lambda self: done)
try:
    call([machine] * 100_000)
except KeyboardInterrupt as stop:
    found = [row for row in stop.partial if row is not None]
    same = [row == wanted if sys.argv[2] == "rows" else (row == wanted).all() for row in found]
    print(len(stop.partial), len(found), all(same))
"""


@pytest.mark.skipif(os.name == "nt", reason="signals of another kind")
@pytest.mark.parametrize("call", ["rows", "ends"])
@pytest.mark.parametrize("machine", ["machine", str(DAMPER)])
def test_a_signal_leaves_what_is_found(machine, call):
    told = subprocess.run([sys.executable, "-c", INTERRUPTED, machine, call], capture_output=True, text=True, timeout=60)
    motions, found, same = told.stdout.split() or [told.stderr, 0, 0]
    assert (motions, same) == ("100000", "True") and 4 <= int(found) < 100_000


def test_other_threads_run_while_one_computes():
    machine, ticks = vi.PaperMachine(), 0
    thread = threading.Thread(target=lambda: machine.simulate(periods=30_000, per_period=4))
    thread.start()
    while thread.is_alive():
        time.sleep(0.002)
        ticks += 1
    assert ticks > 10, "the thread that computes holds the interpreter's lock"


def test_threads_find_what_one_finds():
    machines = [vi.PaperMachine.from_groups(f10=f10) for f10 in (0.6, 1.5, 2.8, 3.6)]
    found = {}

    def run(machine):
        diagram = machine.bifurcation(kappa=np.linspace(0.3, 0.8, 6), periods=(20, 20))
        found[machine] = (machine.simulate(periods=50).end, diagram.up.maxima)

    def run_described(machine):
        diagram = machine.bifurcation("box.s", periods=(20, 20), **{GAP: np.linspace(0.01, 0.1, 6)})
        found[machine] = (machine.simulate(5.0).values, diagram.up.maxima)

    assemblies = [vi.Machine(DAMPER).replace({"body.block.mass": m}) for m in (0.3, 0.5)]
    threads = [threading.Thread(target=run, args=[m]) for m in machines]
    threads += [threading.Thread(target=run_described, args=[m]) for m in assemblies]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    together = dict(found)
    for machine in [*machines, *assemblies]:
        (run_described if machine in assemblies else run)(machine)
        for a, b in zip(found[machine], together[machine]):
            np.testing.assert_array_equal(a, b)


def _end(machine):
    if isinstance(machine, vi.Machine):
        return vi.simulate_many([machine] * 8, until=1.0).values[0][:3]
    return vi.simulate_many([machine] * 40, periods=20).s[0]


@pytest.mark.parametrize("method", multiprocessing.get_all_start_methods())
def test_processes_made_in_any_way(method):
    machines = [vi.PaperMachine.from_groups(f10=f10) for f10 in (1.0, 2.0)]
    machines += [vi.Machine(DAMPER).replace({GAP: gap}) for gap in (0.004, 0.05)]
    expected = [_end(m) for m in machines]  # starts the parent's threads
    with multiprocessing.get_context(method).Pool(2) as pool:
        found = pool.map_async(_end, machines).get(timeout=120)
    np.testing.assert_array_equal(found, expected)


def test_progress_is_shown_and_its_errors_end_the_call(capsys, monkeypatch):
    vi.PaperMachine().bifurcation(f10=np.linspace(1, 2, 30), periods=(20, 20), progress=True)
    done, total = map(int, re.findall(r"(\d+)/(\d+)", capsys.readouterr().err)[-1])
    assert done == total > 1
    # Without tqdm.
    monkeypatch.setitem(__import__("sys").modules, "tqdm.auto", None)
    vi.PaperMachine().simulate(periods=100, progress=True)
    assert "100 %" in capsys.readouterr().err

    def refuse(done, total):
        raise KeyError("stop")

    with pytest.raises(KeyError):
        vi._native.paper_simulate(vi.PaperMachine()._system, [0.0] * 6, 0.0, np.arange(10.0), [], refuse)


#: Times whose motion does not fit into the memory limit of the process.
TOO_MANY = """
import resource, sys, numpy as np, vibro_impact as vi
machine = vi.PaperMachine() if sys.argv[1] == "machine" else vi.Machine(sys.argv[1])
resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
try:
    machine.simulate(times=np.linspace(0.0, 1.0, 20_000_000))
except MemoryError:
    print("refused", machine.simulate(times=[0.0, 1.0]).t[-1])
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are those of Linux")
@pytest.mark.parametrize("machine", ["machine", str(DAMPER)])
def test_what_does_not_fit_into_memory_is_refused_before_it_begins(machine):
    asked = subprocess.run([sys.executable, "-c", TOO_MANY, machine], capture_output=True, text=True)
    assert asked.stdout == "refused 1.0\n", asked.stderr[-2000:]
