//! Loss functions of residuals.

/// Loss of a residual, as a function of its square z in units of the variance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Loss {
    /// z.
    #[default]
    Linear,
    /// 2 (√(1 + z) - 1).
    SoftL1,
    /// z up to 1, then 2 √z - 1.
    Huber,
}

impl Loss {
    /// Loss of a residual and its derivative with respect to z.
    fn of(self, residual: f64) -> (f64, f64) {
        let z = residual * residual;
        match self {
            Self::Linear => (z, 1.0),
            Self::SoftL1 => (2.0 * ((1.0 + z).sqrt() - 1.0), 1.0 / (1.0 + z).sqrt()),
            Self::Huber if z <= 1.0 => (z, 1.0),
            Self::Huber => (2.0 * z.sqrt() - 1.0, 1.0 / z.sqrt()),
        }
    }

    /// Sum of losses over residuals.
    pub fn sum(self, residuals: impl Iterator<Item = f64>) -> f64 {
        residuals.map(|r| self.of(r).0).sum()
    }

    /// Factor of a residual and its row of the Jacobian in a step.
    pub fn weight(self, residual: f64) -> f64 {
        self.of(residual).1.sqrt()
    }

    /// Score: half the derivative of the loss with respect to the residual.
    pub fn score(self, residual: f64) -> f64 {
        residual * self.of(residual).1
    }

    /// Derivative of the score with respect to the residual.
    pub fn slope(self, residual: f64) -> f64 {
        let z = residual * residual;
        match self {
            Self::Linear => 1.0,
            Self::SoftL1 => (1.0 + z).powf(-1.5),
            Self::Huber => f64::from(u8::from(z <= 1.0)),
        }
    }
}
