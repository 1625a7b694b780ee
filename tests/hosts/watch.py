"""Counts its steps, and the impact times at which a step began; made into an FMU by pythonfmu."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real

TOLERANCE = 1e-9  # s, of sums of time


class Watch(Fmi2Slave):
    """Records how a master steps."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.impact, self.seen = 0.0, 0.0
        self.steps, self.met = 0, 0
        self.begins = []
        self.register_variable(Real("impact", causality=Fmi2Causality.input))
        for name in ("steps", "met"):
            self.register_variable(
                Integer(name, causality=Fmi2Causality.output, variability=Fmi2Variability.discrete)
            )

    def do_step(self, current_time, step_size):
        self.steps += 1
        # A master may report an impact one step late.
        self.begins = [*self.begins[-2:], current_time]
        if self.impact != self.seen:
            self.met += any(abs(self.impact - begin) < TOLERANCE for begin in self.begins)
            self.seen = self.impact
        return True
