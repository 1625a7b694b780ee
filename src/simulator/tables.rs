//! Precomputed tables of a simulator. A change of parameters makes them stale; each part is filled
//! when it is first needed.

use super::Simulator;
use crate::energy::Gramians;
use crate::flow::{CORE, LOAD, Local, SubstepTable};
use crate::model::{Model, SmoothMode};
use std::sync::Arc;

/// Tables of one smooth mode.
#[derive(Clone, Debug)]
pub(super) struct ModeTables {
    pub(super) core: SubstepTable<CORE>,
    pub(super) load: SubstepTable<LOAD>,
    pub(super) energy: Gramians,
    /// Series about interval centres, for flight only.
    pub(super) local: Local,
    pub(super) core_ready: bool,
    pub(super) load_ready: bool,
    pub(super) energy_ready: bool,
}

impl ModeTables {
    pub(super) fn zero() -> Self {
        Self {
            core: SubstepTable::zero(),
            load: SubstepTable::zero(),
            energy: Gramians::zero(),
            local: Local::zero(),
            core_ready: false,
            load_ready: false,
            energy_ready: false,
        }
    }

    /// Fills the tables of flight by the best instruction set of this machine. No operation is
    /// fused, so that the tables are bit-identical for all instruction sets.
    fn fill_flight(&mut self, model: &Model, substep: f64) {
        struct Fill<'a>(&'a mut ModeTables, &'a Model, f64);
        impl pulp::WithSimd for Fill<'_> {
            type Output = ();

            #[inline(always)]
            fn with_simd<S: pulp::Simd>(self, simd: S) {
                let Self(tables, model, substep) = self;
                tables.core.fill(simd, model, SmoothMode::Flight, substep);
                tables.local.fill(&tables.core, model, substep);
            }
        }
        pulp::Arch::new().dispatch(Fill(self, model, substep));
    }
}

impl Simulator {
    /// Marks all tables stale and fills the tables that flight needs.
    pub(super) fn renew_tables(&mut self) {
        for (tables, mode) in [(&mut self.flight, SmoothMode::Flight), (&mut self.rest, SmoothMode::Rest)] {
            let tables = Arc::make_mut(tables);
            tables.energy.set_powers(&self.parameters, &self.model, mode);
            tables.load_ready = false;
            tables.energy_ready = false;
            tables.core_ready = mode == SmoothMode::Flight;
            if tables.core_ready {
                tables.fill_flight(&self.model, self.substep);
            }
        }
        self.prepare_load_tables();
    }

    /// Fills the load tables when loads act and they are stale.
    pub(super) fn prepare_load_tables(&mut self) {
        if self.loaded() {
            for (tables, mode) in [(&mut self.flight, SmoothMode::Flight), (&mut self.rest, SmoothMode::Rest)]
            {
                if tables.core_ready && tables.load_ready {
                    continue;
                }
                let tables = Arc::make_mut(tables);
                if !tables.core_ready {
                    tables.core.fill(pulp::Scalar, &self.model, mode, self.substep);
                    tables.core_ready = true;
                }
                if !tables.load_ready {
                    tables.load.fill(&tables.core, &self.model, mode, self.substep);
                    tables.load_ready = true;
                }
            }
        }
    }
}
