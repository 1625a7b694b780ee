"""An unbalanced motor as an FMU, made by pythonfmu: `pythonfmu build -f drive_train.py`.

A rotor with an eccentric mass sits on the box and shakes it. The motor is not ideal: its torque falls with the speed, and
the box's motion acts back on it (the Sommerfeld effect). For the rotor angle φ and the box's acceleration a:

    J φ'' = T (1 - φ'/ω0) - m r a cos φ          force on the box: m r (φ'² sin φ - φ'' cos φ)

The acceleration alone is not enough to couple the two through impacts. At an impact, the box's velocity jumps by ΔP/m1, where ΔP is the
impulse on the box, and no value of a contains that jump, however short the step. The rotor jumps by -m r cos φ ΔP/(m1 J) at that moment.
This is not small: without it, a motor near the machine's resonance runs at another speed. So the box's impulse since the start is a second
input. Its increment over the last step, divided by the current step h, makes a the mean acceleration of docs/theory.md (114):

    a = acceleration + ΔP/(m1 h)

and the rotor's response to the jump acts on the box as part of the force. (If the box's velocity can be connected, its
increment divided by h is already that mean.) Heun's method integrates φ with its own small steps.
"""

import math

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

LONGEST_STEP = 0.01  # s, of Heun's method: less than a hundredth of a turn at 1 rad/s


class DriveTrain(Fmi2Slave):  # type: ignore[misc] # pythonfmu comes without types
    """A motor of limited power with an eccentric mass."""

    author = "vibro-impact examples"
    description = "Motor of limited power that shakes its own foundation"

    def __init__(self, **kwargs: object) -> None:
        super().__init__(**kwargs)
        self.inertia, self.eccentricity = 0.5, 0.14
        self.torque, self.idle = 0.4, 1.3
        self.acceleration = self.impulse = self.before = 0.0
        self.mass = 1.0
        self.mean = 0.0
        self.angle = 0.0
        self.speed = 0.5
        self.force = 0.0
        for name, text in (
            ("inertia", "moment of inertia J, kg.m2"),
            ("eccentricity", "eccentric mass times its radius, kg.m"),
            ("torque", "torque at standstill T, N.m"),
            ("idle", "idle speed ω0, rad/s"),
            ("mass", "mass of the box m1, kg"),
        ):
            self.register_variable(
                Real(name, causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable, description=text)
            )
        text = "acceleration of the box, m/s2"
        self.register_variable(Real("acceleration", causality=Fmi2Causality.input, description=text))
        text = "impulse of the stops on the box since the start, N.s"
        self.register_variable(Real("impulse", causality=Fmi2Causality.input, description=text))
        for name, text in (
            ("force", "force on the box, N"),
            ("speed", "speed of the rotor, rad/s"),
            ("angle", "angle of the rotor, rad"),
        ):
            self.register_variable(Real(name, causality=Fmi2Causality.output, description=text))

    def _rate(self, angle: float, speed: float) -> float:
        drive = self.torque * (1.0 - speed / self.idle)
        return (drive - self.eccentricity * self.mean * math.cos(angle)) / self.inertia

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Heun's method, second order."""
        count = max(1, math.ceil(step_size / LONGEST_STEP - 1e-9))  # the margin absorbs a master's rounding
        h = step_size / count
        self.mean = self.acceleration + (self.impulse - self.before) / (self.mass * step_size)
        self.before = self.impulse
        for _ in range(count):
            rate = self._rate(self.angle, self.speed)
            ahead = self._rate(self.angle + h * self.speed, self.speed + h * rate)
            self.angle += h * (self.speed + h * rate / 2.0)
            self.speed += h * (rate + ahead) / 2.0
        rate = self._rate(self.angle, self.speed)
        self.force = self.eccentricity * (self.speed**2 * math.sin(self.angle) - rate * math.cos(self.angle))
        return True
