//! A component whose variables are known only at instantiation: a file in the FMU's resources
//! names them.
#![allow(unsafe_code)] // the C interface

use fmi_doors::hybrid::{Met, StepEnd, Until};
use fmi_doors::log::Log;
use fmi_doors::{Base, Bases, Handled, Hybrid, Instantiation, Life, Model, Named, Phase, Problem};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::ptr::{null, null_mut};

fmi_doors::export!(Table);

/// One Real per line of the file, with the line as its name; references count from 1.
#[derive(Debug)]
struct Table {
    life: Life,
    names: Vec<String>,
    values: Vec<f64>,
}

impl Table {
    fn place(&self, reference: u32, bases: Bases) -> Result<usize, Problem> {
        let place = (reference as usize).wrapping_sub(1);
        let found = || format!("there are {}", self.names.len());
        let known = place < self.names.len() && bases.contains(Base::Real);
        known.then_some(place).ok_or_else(|| Problem::Reference {
            reference,
            wanted: bases.name,
            found: found(),
        })
    }
}

impl Model for Table {
    type Problem = Problem;
    type State = ();

    fn instantiate(request: &Instantiation<'_>) -> Result<Self, Problem> {
        let file = request.resource_folder()?.join("names.txt");
        let refused =
            |error: std::io::Error| Problem::Sequence { what: format!("{}: {error}", file.display()).into() };
        let text = std::fs::read_to_string(&file).map_err(refused)?;
        // Library and file of different machines refuse each other.
        request.check_token(&fmi_doors::identifier::identifier(&text))?;
        let names: Vec<_> = text.lines().map(str::to_owned).collect();
        Ok(Self { life: request.life(), values: vec![0.0; names.len()], names })
    }

    fn life(&self) -> &Life {
        &self.life
    }

    fn life_mut(&mut self) -> &mut Life {
        &mut self.life
    }

    fn reset(&mut self) {
        self.life.phase = Phase::Instantiated;
        self.values.fill(0.0);
    }

    fn time(&self) -> f64 {
        0.0
    }

    fn variable(&self, reference: u32) -> Result<Named<'_>, Problem> {
        let name = self.names[self.place(reference, Bases::ANY)?].as_str().into();
        Ok(Named { name, continuous_input: true, intermediate_update: false })
    }

    fn get(
        &mut self,
        bases: Bases,
        references: &[u32],
        mut write: impl FnMut(usize, f64),
    ) -> Result<(), Problem> {
        let places = references.iter().map(|reference| self.place(*reference, bases));
        let places: Vec<_> = places.collect::<Result<_, _>>()?;
        places.into_iter().enumerate().for_each(|(i, place)| write(i, self.values[place]));
        Ok(())
    }

    fn set(&mut self, bases: Bases, references: &[u32], read: impl Fn(usize) -> f64) -> Result<(), Problem> {
        for (i, &reference) in references.iter().enumerate() {
            let place = self.place(reference, bases)?;
            if !read(i).is_finite() {
                return Err(Problem::value(self.names[place].clone(), read(i), "a finite number"));
            }
        }
        for (i, &reference) in references.iter().enumerate() {
            let place = self.place(reference, bases)?;
            self.values[place] = read(i);
        }
        Ok(())
    }
}

impl Hybrid for Table {
    type Shown = ();
    type Undo = ();

    fn start(&mut self, _: &mut dyn Log) -> Result<(), Problem> {
        Ok(())
    }

    fn take_over(&mut self, _: StepEnd, _: &mut dyn Log) -> Result<((), bool), Problem> {
        Ok(((), false))
    }

    fn run(&mut self, _: StepEnd, _: Until, _: &mut dyn Log) -> Result<Met, Problem> {
        Ok(Met::default())
    }

    fn undo(&mut self, (): (), problem: Problem) -> Problem {
        problem
    }

    fn apply_law(&mut self, _: &mut dyn Log) -> Result<(), Problem> {
        Ok(())
    }

    fn shown(&self) {}

    fn carry_out(&mut self, _: &mut dyn Log) -> Result<Handled, Problem> {
        Ok(Handled::default())
    }
}

unsafe extern "C-unwind" fn keep(text: *mut c_void, _: c_int, _: *const c_char, message: *const c_char) {
    let message = unsafe { CStr::from_ptr(message) }.to_str().unwrap().to_owned();
    unsafe { *text.cast::<String>() = message };
}

/// A folder of resources that names these variables, and its token.
fn resources(folder: &str, names: &str) -> (CString, CString) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(folder);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("names.txt"), names).unwrap();
    let token = fmi_doors::identifier::identifier(names);
    (CString::new(folder.to_str().unwrap()).unwrap(), CString::new(token).unwrap())
}

#[test]
fn two_instances_of_one_library_have_variables_of_their_own() {
    let (one, one_token) = resources("one", "mass");
    let (two, two_token) = resources("two", "gap\nstiffness\n");
    let mut message = Box::new(String::new());
    let environment = std::ptr::from_mut(&mut *message).cast();
    let instantiate = |folder: &CStr, token: &CStr| unsafe {
        fmi3InstantiateModelExchange(
            c"a".as_ptr(),
            token.as_ptr(),
            folder.as_ptr(),
            0,
            1,
            environment,
            Some(keep),
        )
    };
    let (a, b) = (instantiate(&one, &one_token), instantiate(&two, &two_token));
    unsafe {
        assert_eq!(fmi3SetFloat64(a, &1, 1, &1.5, 1), 0);
        assert_eq!(fmi3SetFloat64(b, &2, 1, &2.5, 1), 0);
        let mut values = [0.0; 2];
        assert_eq!(fmi3GetFloat64(b, [1, 2].as_ptr(), 2, values.as_mut_ptr(), 2), 0);
        assert_eq!(values, [0.0, 2.5]);
        // Names belong to the instance.
        assert_eq!(fmi3SetFloat64(b, &2, 1, &f64::NAN, 1), 2);
        assert_eq!(*message, "fmi3SetFloat64: stiffness = NaN: expected a finite number");
        assert_eq!(fmi3GetFloat64(a, &2, 1, values.as_mut_ptr(), 1), 3);
        assert!(
            message.ends_with("value reference 2 is not a variable of type Float64: there are 1"),
            "{message}"
        );
        fmi3FreeInstance(a);
        fmi3FreeInstance(b);
    }
    // A file of another machine, no file, and no location given.
    assert!(instantiate(&one, &two_token).is_null());
    assert!(message.starts_with("fmi3InstantiateModelExchange: instantiationToken = "), "{message}");
    assert!(instantiate(c"/nowhere", &one_token).is_null());
    assert!(message.contains("names.txt: "), "{message}");
    let none = unsafe { fmi2Instantiate(c"a".as_ptr(), 1, one_token.as_ptr(), null(), null(), 0, 0) };
    assert_eq!(none, null_mut());
    // The location of the resources in the form of FMI 2.0.
    let uri = CString::new(format!("file://{}", one.to_str().unwrap())).unwrap();
    unsafe {
        let c = fmi2Instantiate(c"a".as_ptr(), 1, one_token.as_ptr(), uri.as_ptr(), null(), 0, 0);
        assert_eq!(fmi2SetReal(c, &1, 1, &0.5), 0);
        fmi2FreeInstance(c);
    }
}
