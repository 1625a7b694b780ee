//! Steps of RKF45 and of classical RK4 (sources: see [`crate::reference`]).

use super::Reference;
use super::law::Vector;

impl Reference {
    /// One RKF45 step: the state after the step, the box's acceleration by the drive at that state,
    /// and the local error in units of the tolerance.
    #[inline]
    #[rustfmt::skip]
    pub(super) fn fehlberg(&self, h: f64) -> (Vector, f64, f64) {
        let (law, y, t) = (&self.law, &self.y, self.time);
        let slope = |y: &Vector, time: f64| law.slope(y, law.drive(time), time, self.side);
        let k1 = law.slope(y, self.drive, t, self.side);
        let k2 = slope(&add(y, h, [(0.25, &k1)]), t + 0.25 * h);
        let k3 = slope(&add(y, h, [(3.0 / 32.0, &k1), (9.0 / 32.0, &k2)]), t + 0.375 * h);
        let at = add(y, h, [(1932.0 / 2197.0, &k1), (-7200.0 / 2197.0, &k2), (7296.0 / 2197.0, &k3)]);
        let k4 = slope(&at, t + 12.0 / 13.0 * h);
        let drive = law.drive(t + h);
        let at = add(y, h, [(439.0 / 216.0, &k1), (-8.0, &k2), (3680.0 / 513.0, &k3), (-845.0 / 4104.0, &k4)]);
        let k5 = law.slope(&at, drive, t + h, self.side);
        let at = add(y, h, [(-8.0 / 27.0, &k1), (2.0, &k2), (-3544.0 / 2565.0, &k3), (1859.0 / 4104.0, &k4), (-11.0 / 40.0, &k5)]);
        let k6 = slope(&at, t + 0.5 * h);
        let mut next = add(y, h, [(16.0 / 135.0, &k1), (6656.0 / 12825.0, &k3), (28561.0 / 56430.0, &k4), (-9.0 / 50.0, &k5), (2.0 / 55.0, &k6)]);
        let lost = add(&[0.0; 6], h, [(1.0 / 360.0, &k1), (-128.0 / 4275.0, &k3), (-2197.0 / 75240.0, &k4), (1.0 / 50.0, &k5), (2.0 / 55.0, &k6)]);
        if self.side != 0.0 {
            next[1] = next[0] + self.side * law.gap; // rounding must not open or close the contact
            next[4] = next[3];
        }
        let mut error = 0.0;
        for ((lost, scale), y) in lost.iter().zip(&self.scale).zip(y) {
            let ratio = lost.abs() / (scale + y.abs());
            error = if ratio <= error { error } else { ratio }; // `max` would drop a NaN
        }
        (next, drive, error / self.tolerance.step)
    }

    /// One step of classical RK4 from `y`, `elapsed` after the present.
    pub(super) fn runge_kutta(&self, y: &Vector, elapsed: f64, h: f64) -> Vector {
        let (law, side, t) = (&self.law, self.side, self.time + elapsed);
        let (middle, last) = (t + 0.5 * h, t + h);
        let half = law.drive(middle);
        let k1 = law.slope(y, if elapsed == 0.0 { self.drive } else { law.drive(t) }, t, side);
        let k2 = law.slope(&add(y, 0.5 * h, [(1.0, &k1)]), half, middle, side);
        let k3 = law.slope(&add(y, 0.5 * h, [(1.0, &k2)]), half, middle, side);
        let k4 = law.slope(&add(y, h, [(1.0, &k3)]), law.drive(last), last, side);
        add(y, h / 6.0, [(1.0, &k1), (2.0, &k2), (2.0, &k3), (1.0, &k4)])
    }
}

/// y + h Σ weight·slope.
#[inline(always)] // there are thirteen calls a step, each with its own N
fn add<const N: usize>(y: &Vector, h: f64, terms: [(f64, &Vector); N]) -> Vector {
    let mut sum = [0.0; 6];
    for (weight, k) in terms {
        for (sum, k) in sum.iter_mut().zip(k) {
            *sum += weight * k;
        }
    }
    for (sum, y) in sum.iter_mut().zip(y) {
        *sum = y + h * *sum;
    }
    sum
}
