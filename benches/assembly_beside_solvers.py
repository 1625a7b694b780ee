"""A driven chain of bodies with clearances by this engine and by solvers with root finding: SciPy's DOP853, CVODE and heyoka.

The clearances are compliant, so that every solver can follow the motion; with `rigid` they are the stops of `chain` in
benches/assembly.rs, at which the bodies bounce ever faster. Each solver has relative and absolute tolerances of 1e-10 and locates every
contact as a root. After a contact heyoka restarts; with rigid stops all solvers do. CVODE's functions are compiled by numba, heyoka
compiles its own; compile time is excluded. Ways alternate.

pip install ./python scipy scikit-sundae heyoka numba
python benches/assembly_beside_solvers.py [BODIES] [SECONDS] [rigid]
"""

import sys
import time

import heyoka as hy
import numba
import numpy as np
import vibro_impact as vi
from scipy.integrate import solve_ivp
from sksundae.cvode import CVODE

GAP, RESTITUTION, CONTACT = 0.05, 0.6, 2e4
FORCE, OMEGA = 10.0, 2.0 * np.pi
TOLERANCE = 1e-10
# Seconds of work after which a solver is stopped; number of turns, of which the smallest time
# counts; smallest duration of a turn, s.
PATIENCE, TURNS, TURN = 60.0, 3, 0.2


class Chain:
    """Every second joint has play on both sides, the others have a spring; every body weighs 1 kg."""

    def __init__(self, bodies, rigid):
        self.bodies, self.rigid = bodies, rigid
        self.k, self.c = np.diag(np.full(bodies, 20.0)), np.diag(np.full(bodies, 0.2))
        joints = range(1, bodies)
        self.stops = [pair for i in joints if i % 2 for pair in ((i - 1, i), (i, i - 1))]
        for i in (i for i in joints if i % 2 == 0):
            for matrix, value in ((self.k, 400.0), (self.c, 0.1)):
                matrix[[i - 1, i], [i - 1, i]] += value
                matrix[[i - 1, i], [i, i - 1]] -= value

    def description(self):
        """The machine as input of `vi.Machine`."""
        spring = {f"g{i}": {"between": ["ground", f"b{i}"], "stiffness": 20.0, "damping": 0.2} for i in range(self.bodies)}
        for i in range(2, self.bodies, 2):
            spring[f"k{i}"] = {"between": [f"b{i - 1}", f"b{i}"], "stiffness": 400.0, "damping": 0.1}
        law = {"restitution": RESTITUTION} if self.rigid else {"stiffness": CONTACT}
        return {
            "name": "Chain",
            "body": {f"b{i}": {"mass": 1.0} for i in range(self.bodies)},
            "spring": spring,
            "stop": {f"s{n}": {"between": [f"b{a}", f"b{b}"], "gap": GAP, **law} for n, (a, b) in enumerate(self.stops)},
            "load": {"drive": {"on": "b0", "amplitude": FORCE, "frequency": OMEGA / (2.0 * np.pi)}},
        }

    def after_contact(self, z, stop):
        """The state after a contact: a rigid stop's law of restitution."""
        a, b = self.stops[stop]
        z = z.copy()
        if self.rigid:
            change = 0.5 * (1.0 + RESTITUTION) * (z[self.bodies + b] - z[self.bodies + a])
            z[self.bodies + a] += change
            z[self.bodies + b] -= change
            # The bodies leave the stop by a rounding, since a root at the start does not count.
            z[b] -= max(0.0, z[b] - z[a] - GAP) + 1e-14
        return z


def functions(chain):
    """Right-hand side and roots, compiled."""
    n, k, c, contact = chain.bodies, chain.k, chain.c, 0.0 if chain.rigid else CONTACT
    first, second = np.array(chain.stops).T.copy()

    @numba.njit
    def rate(t, z, dz):
        dz[:n] = z[n:]
        dz[n:] = -(k @ z[:n]) - c @ z[n:]
        dz[n] += FORCE * np.sin(OMEGA * t)
        for stop in range(len(first)):
            force = contact * max(0.0, z[second[stop]] - z[first[stop]] - GAP)
            dz[n + first[stop]] += force
            dz[n + second[stop]] -= force

    @numba.njit
    def roots(t, z, values):
        for stop in range(len(first)):
            values[stop] = z[second[stop]] - z[first[stop]] - GAP

    return rate, roots


class Engine:
    """This engine, with all of its accounts and event tables."""

    name = "this engine"

    def __init__(self, chain):
        self.machine = vi.Machine(chain.description())
        self.columns = [f"b{i}.{what}" for what in "sv" for i in range(chain.bodies)]

    def run(self, end):
        found = self.machine.simulate(times=[0.0, end])
        return len(found.events), end, np.array([found[name][-1] for name in self.columns])


class Cvode:
    """CVODE with the method for non-stiff motions."""

    name = "CVODE (Adams)"

    def __init__(self, chain):
        rate, roots = functions(chain)

        def events(t, z, values):  # functions compiled by numba have no attributes
            roots(t, z, values)

        count = len(chain.stops)
        events.terminal, events.direction = [chain.rigid] * count, [1 if chain.rigid else 0] * count
        self.chain = chain
        self.solver = CVODE(
            lambda t, z, dz: rate(t, z, dz), method="Adams", rtol=TOLERANCE, atol=TOLERANCE,
            max_num_steps=10**6, eventsfn=events, num_events=count,
        )  # fmt: skip

    def run(self, end):
        t, z, count, begin = 0.0, np.zeros(2 * self.chain.bodies), 0, time.process_time()
        while t < end and time.process_time() - begin < PATIENCE:
            found = self.solver.solve([t, end], z)
            t, z = found.t[-1], found.y[-1].copy()
            if found.t_events is None:
                continue
            count += len(np.unique(found.t_events))  # a contact may be reported more than once
            if self.chain.rigid:
                t, z = found.t_events[-1], found.y_events[-1]
                for stop in np.flatnonzero(found.i_events[-1]):
                    z = self.chain.after_contact(z, stop)
        return count, t, z


class SciPy:
    """SciPy's DOP853."""

    name = "SciPy DOP853"

    def __init__(self, chain):
        self.rate, _ = functions(chain)
        self.chain = chain
        self.events = [self.event(*pair) for pair in chain.stops]

    def event(self, a, b):
        def excess(t, z):
            return z[b] - z[a] - GAP

        excess.terminal, excess.direction = self.chain.rigid, 1.0 if self.chain.rigid else 0.0
        return excess

    def run(self, end):
        t, z, count, begin = 0.0, np.zeros(2 * self.chain.bodies), 0, time.process_time()

        def rate(t, z, dz=np.zeros(2 * self.chain.bodies)):
            self.rate(t, z, dz)
            return dz.copy()

        while t < end and time.process_time() - begin < PATIENCE:
            found = solve_ivp(rate, (t, end), z, method="DOP853", rtol=TOLERANCE, atol=TOLERANCE, events=self.events)
            t, z = found.t[-1], found.y[:, -1].copy()
            for stop, times in enumerate(found.t_events):
                count += len(times)
                if self.chain.rigid and len(times):
                    z = self.chain.after_contact(z, stop)
        return count, t, z


class Heyoka:
    """heyoka's Taylor series; events change parameters that are the coefficients of each contact."""

    name = "heyoka"

    def __init__(self, chain):
        self.chain = chain
        s = [hy.expression(f"s{i}") for i in range(chain.bodies)]
        v = [hy.expression(f"v{i}") for i in range(chain.bodies)]
        a = [
            hy.sum([-float(matrix[i, j]) * x[j] for matrix, x in ((chain.k, s), (chain.c, v)) for j in np.flatnonzero(matrix[i])])
            for i in range(chain.bodies)
        ]
        a[0] += FORCE * hy.sin(OMEGA * hy.time)
        excesses = [s[b] - s[a] - GAP for a, b in chain.stops]
        if not chain.rigid:
            for stop, (first, second) in enumerate(chain.stops):
                force = hy.par[stop] * excesses[stop]
                a[first] += force
                a[second] -= force
        direction = hy.event_direction.positive if chain.rigid else hy.event_direction.any
        self.count = 0
        events = [hy.t_event(e, callback=self.contact(stop), direction=direction) for stop, e in enumerate(excesses)]
        system = list(zip(s, v)) + list(zip(v, a))
        self.solver = hy.taylor_adaptive(system, np.zeros(2 * chain.bodies), tol=TOLERANCE, t_events=events)

    def contact(self, stop):
        def callback(solver, sign):
            self.count += 1
            if self.chain.rigid:
                solver.state[:] = self.chain.after_contact(solver.state, stop)
            else:
                solver.pars[stop] = CONTACT if sign > 0 else 0.0
            return True

        return callback

    def run(self, end):
        self.solver.time, self.count, begin = 0.0, 0, time.process_time()
        self.solver.state[:], self.solver.pars[:] = 0.0, 0.0
        self.solver.reset_cooldowns()
        self.solver.propagate_until(end, callback=lambda solver: time.process_time() - begin < PATIENCE)
        return self.count, self.solver.time, self.solver.state.copy()


def main():
    words = [word for word in sys.argv[1:] if word != "rigid"]
    words += ["20", "10"][len(words) :]
    bodies, end = int(words[0]), float(words[1])
    chain = Chain(bodies, "rigid" in sys.argv)
    ways = [way(chain) for way in (Engine, Heyoka, Cvode, SciPy)]
    for way in ways:
        way.run(0.01)  # compiles the functions at first use
    least, found = [np.inf] * len(ways), [None] * len(ways)
    for _ in range(1 if chain.rigid else TURNS):
        for i, way in enumerate(ways):
            # The mean of several runs: some systems count the work of other threads by ticks.
            spent, runs = 0.0, 0
            while spent < TURN:
                begin = time.process_time()
                found[i] = way.run(end)
                spent, runs = spent + time.process_time() - begin, runs + 1
            least[i] = min(least[i], spent / runs)
    print(f"{bodies} bodies, {bodies // 2} {'rigid' if chain.rigid else 'compliant'} clearances, {end:g} s\n")
    print("| way | ms of processor time | times this engine's | contacts | reached, s | from this engine, m or m/s | beyond a gap, m |")
    print("|---|---|---|---|---|---|---|")
    for way, work, (count, reached, state) in zip(ways, least, found):
        away = f"{np.abs(state - found[0][2]).max():.0e}" if reached >= end else "-"
        beyond = max(0.0, *(state[b] - state[a] - GAP for a, b in chain.stops))
        ratio = f"{work / least[0]:.2g} | {count} | {reached:.2f} | {away} | {beyond:.0e}"
        print(f"| {way.name} | {1e3 * work:.1f} | {ratio} |")


if __name__ == "__main__":
    main()
