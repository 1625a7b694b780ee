"""A damped oscillator hung on a moving flange by a spring, made into an FMU by pythonfmu: `pythonfmu build -f oscillator.py`.

m x'' + c x' + k x = f,  f = kc (s - x). The input is the flange's motion, held as s + v t + a t²/2 during a step (the
position–velocity–acceleration–force flange of the Modelica Standard Library's FMU adaptors). The solution for this input
is known in closed form, so all errors come from the coupling. The force on the flange is -f.
"""

import cmath

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Oscillator(Fmi2Slave):  # type: ignore[misc] # pythonfmu comes without types
    """One degree of freedom behind a coupling spring."""

    author = "vibro-impact examples"
    description = "Damped oscillator coupled to a flange by a spring"

    def __init__(self, **kwargs: object) -> None:
        super().__init__(**kwargs)
        self.m, self.k, self.c, self.kc = 0.1, 0.1, 0.006, 0.006
        self.s = self.v = self.a = 0.0
        self.x = self.dx = 0.0
        for name, text in (
            ("m", "mass, kg"),
            ("k", "stiffness to ground, N/m"),
            ("c", "damping to ground, N.s/m"),
            ("kc", "stiffness of the coupling spring, N/m"),
        ):
            self.register_variable(
                Real(name, causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable, description=text)
            )
        for name, text in (
            ("s", "displacement of the flange, m"),
            ("v", "its velocity, m/s"),
            ("a", "its acceleration, m/s2"),
        ):
            self.register_variable(Real(name, causality=Fmi2Causality.input, description=text))
        self.register_variable(Real("x", causality=Fmi2Causality.output, description="displacement, m"))
        self.register_variable(Real("dx", causality=Fmi2Causality.output, description="velocity, m/s"))
        outputs = (
            ("f", "force of the spring on the flange, N", lambda: self.kc * (self.x - self.s)),
            ("df", "its rate, N/s", lambda: self.kc * (self.dx - self.v)),
            ("ddf", "its second derivative, N/s2", lambda: self.kc * (self.acceleration() - self.a)),
        )
        for name, text, getter in outputs:
            self.register_variable(Real(name, causality=Fmi2Causality.output, description=text, getter=getter))

    def acceleration(self) -> float:
        """x'' from the equation of motion, m/s2."""
        return (self.kc * (self.s - self.x) - self.k * self.x - self.c * self.dx) / self.m

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Computes the exact motion for the flange's polynomial: a particular polynomial plus free vibration."""
        h, stiffness = step_size, self.k + self.kc
        p2 = self.kc * self.a / 2.0 / stiffness
        p1 = (self.kc * self.v - 2.0 * self.c * p2) / stiffness
        p0 = (self.kc * self.s - self.c * p1 - 2.0 * self.m * p2) / stiffness
        z, dz = self.x - p0, self.dx - p1
        decay = self.c / (2.0 * self.m)
        root = cmath.sqrt(stiffness / self.m - decay * decay)
        cosine, sine = cmath.cos(root * h), cmath.sin(root * h) / root if root else h
        damped = cmath.exp(-decay * h)
        free = damped * (z * cosine + (dz + decay * z) * sine)
        rate = damped * (dz * cosine - (decay * dz + stiffness / self.m * z) * sine)
        self.x = free.real + p0 + p1 * h + p2 * h * h
        self.dx = rate.real + p1 + 2.0 * p2 * h
        # Position and velocity of the flange at the end of the step.
        self.s, self.v = self.s + self.v * h + self.a * h * h / 2.0, self.v + self.a * h
        return True
