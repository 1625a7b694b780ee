//! The content of `modelDescription.xml` of a machine, for FMI 2.0 and 3.0.

use crate::experiment::experiment;
use crate::machine::OUTPUT_ORDER;
use crate::plan::Plan;
use crate::structure::{Structure, of_roles};
use crate::table::{Quantity, Role, VariableRow};
use crate::units::{self, Declared};
use fmi_doors::Base;
use fmi_doors::description::{
    self, Capabilities, Causality, CoSimulation, Description, Kind, ModelExchange, Variability, Variable,
};
use vibro_machine::system::StopRows;

/// Returns a bound of a variable's value, if there is one.
fn bound(bound: f64) -> Option<f64> {
    Some(bound).filter(|bound| bound.is_finite() && bound.abs() < f64::MAX)
}

fn variability(is_tunable: bool) -> Variability {
    if is_tunable { Variability::Tunable } else { Variability::Fixed }
}

impl Plan {
    /// Returns the model description of this machine.
    pub fn description(&self) -> Description {
        let machine = &self.assembly.description;
        let declared = || {
            units::DECLARED
                .iter()
                .filter(|d| self.table.rows.iter().any(|row| Declared::of(row.unit).unit == d.unit))
        };
        let rebounds = self.assembly.system().stops.iter().any(StopRows::may_rebound);
        let types = declared().map(Declared::declared_type).chain(units::enumerations(rebounds)).collect();
        let structure = Structure::new(self);
        let outputs = of_roles(self, &[Role::Output, Role::Discrete]);
        let initial_unknowns = of_roles(self, &[Role::Calculated, Role::Output, Role::Discrete]);
        let derivatives: Vec<_> = self.rates().collect();
        Description {
            model_name: machine.name.clone().into(),
            model_identifier: machine.name.clone().into(),
            token: self.token().to_owned().into(),
            description: self.summary().into(),
            author: "".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            copyright: "".into(),
            license: env!("CARGO_PKG_LICENSE").into(),
            generation_tool: concat!("vibro-impact ", env!("CARGO_PKG_VERSION")).into(),
            generation_date_and_time: None,
            structured_names: true,
            model_exchange: Some(ModelExchange {
                needs_completed_integrator_step: true,
                number_of_event_indicators: self.table.indicators.len(),
            }),
            co_simulation: Some(CoSimulation {
                can_interpolate_inputs: true,
                max_output_derivative_order: OUTPUT_ORDER,
                recommended_intermediate_input_smoothness: 3,
                provides_intermediate_update: true,
                can_return_early_after_intermediate_update: true,
                might_return_early_from_do_step: true,
                has_event_mode: true,
                ..CoSimulation::default()
            }),
            capabilities: Capabilities {
                can_get_and_set_fmu_state: true,
                can_serialize_fmu_state: true,
                provides_directional_derivatives: true,
                provides_adjoint_derivatives: true,
                ..Capabilities::default()
            },
            units: declared().filter_map(Declared::unit).collect(),
            types,
            log_categories: fmi_doors::messages::log_categories(
                "Impacts, stops that open or close, friction that sticks or slips, knots of signals",
                "Values that the machine cannot take, and steps that end early",
            )
            .to_vec(),
            experiment: experiment(&self.assembly),
            variables: (1..)
                .zip(&self.table.rows)
                .map(|(reference, row)| self.variable(reference, row))
                .collect(),
            outputs: structure.unknowns(&outputs, false),
            derivatives: structure.unknowns(&derivatives, false),
            initial_unknowns: structure.unknowns(&initial_unknowns, true),
            event_indicators: structure.unknowns(&of_roles(self, &[Role::Local]), false),
        }
    }

    /// Returns a line that describes the machine.
    fn summary(&self) -> String {
        let machine = &self.assembly.description;
        let bodies = machine.bodies.len();
        let bodies = if bodies == 1 { "one body".to_owned() } else { format!("{bodies} bodies") };
        format!("{}, a machine of {bodies} with {} states", machine.name, self.nominals.len())
    }

    /// Returns the derivatives of the continuous states, with value references.
    fn rates(&self) -> impl Iterator<Item = (u32, Quantity)> {
        let quantities = self.states.iter().map(|[_, rate]| Quantity::Column(*rate));
        quantities.filter_map(|quantity| Some((self.table.reference_of(quantity)?, quantity)))
    }

    /// Adds the attributes of continuous states to a quantity's variable: whether it may be
    /// reinitialized, the state whose derivative it is, and the nominal value.
    fn in_exchange(&self, quantity: vibro_machine::Quantity, mut variable: Variable) -> Variable {
        let all = &self.states;
        if let Some([state, _]) = all.iter().find(|[_, rate]| *rate == quantity)
            && let Some(state) = self.table.reference_of(Quantity::Column(*state))
        {
            variable = variable.derivative_of(state);
        }
        if let Some(place) = all.iter().position(|[state, _]| *state == quantity) {
            variable = variable.reinitialized();
            if let Kind::Real { nominal, .. } = &mut variable.kind {
                *nominal = self.nominals.get(place).copied();
            }
        }
        variable
    }

    fn variable(&self, reference: u32, row: &VariableRow) -> Variable {
        let causality = match row.role {
            Role::Independent => Causality::Independent,
            Role::Parameter | Role::Tunable => Causality::Parameter,
            Role::Calculated => Causality::CalculatedParameter,
            Role::Local | Role::Sensitivity => Causality::Local,
            Role::Input => Causality::Input,
            Role::Output | Role::Discrete => Causality::Output,
        };
        let declared = Declared::of(row.unit).declared_type();
        let (name, meaning) = (row.name.clone(), row.meaning.clone());
        let real = Variable {
            intermediate_update: row.is_seen_within_steps(),
            dimensions: row.dimensions.clone(),
            ..Variable::real(reference, name, &declared, causality, meaning)
        };
        match (row.quantity, row.base) {
            (Quantity::Parameter(place), _) => {
                let parameter = &self.table.parameters[place];
                let variability = variability(row.role == Role::Tunable);
                let [min, max] = parameter.bounds.map(bound);
                Variable { min, max, variability, ..real.starting_at(parameter.value) }
            }
            (Quantity::Following(place), _) => {
                let own = &self.table.following[place];
                let sources = self.assembly.description.named.sources_of(&own.name);
                let is_tunable = |name: &&str| self.table.role(name) == Some(Role::Tunable);
                let variability = variability(!sources.is_empty() && sources.iter().all(is_tunable));
                Variable { min: bound(own.range.min), max: bound(own.range.max), variability, ..real }
            }
            (Quantity::Input(_), _) => real.starting_at(0.0),
            (quantity, Base::Enumeration) => {
                let stop = matches!(quantity, Quantity::StopState(_));
                let name = if stop { units::STOP_STATE } else { units::FRICTION_STATE };
                let declared_type = Some(name.into());
                Variable {
                    kind: Kind::Enumeration,
                    declared_type,
                    variability: Variability::Discrete,
                    ..real
                }
            }
            (_, Base::Integer) => real.counting(),
            _ if row.role == Role::Discrete => Variable { variability: Variability::Discrete, ..real },
            (Quantity::Column(quantity), _) => self.in_exchange(quantity, real),
            _ => real,
        }
    }

    /// Returns the text of `modelDescription.xml` for an FMI version.
    pub fn xml(&self, version: fmi_doors::Version, date: Option<String>) -> String {
        let date = date.map(Into::into);
        description::Description { generation_date_and_time: date, ..self.description() }.xml(version)
    }
}
