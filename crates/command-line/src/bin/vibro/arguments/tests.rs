use super::*;

/// Texts that no option accepts.
const NONE: [&str; 8] = ["abc", "1.5.2", "-", "1e", "0x1", "½", "1 000", "nan"];
/// Options that are parsed after the machine, its axis or a file is known; tests of the whole
/// program cover their errors.
const READ_LATER: [&str; 4] = ["at", "mark", "set", "from"];
/// Axes whose parameters depend on the machine.
const AXES: [&str; 2] = ["vary", "over"];
/// Value names of options, besides numbers, that are parsed with the command line.
const FORMS: [&str; 12] = [
    "TIME",
    "PERCENT",
    "I/N",
    "NAME=FROM:TO",
    "NAME=FROM:TO[:COUNT]",
    "NAME=FROM:TO[:COUNT]|V,V,…",
    "NAME=V,V,…",
    "NAME=VALUE,…",
    "X,Y",
    "BODY=FORCE",
    "BODY=FORCE|FILE",
    "FILE[:ROW|:LABEL@VALUE]",
];

/// The program's error for an option with a value.
fn error(path: &[String], option: &str, value: &str) -> String {
    let words = path.iter().cloned().chain([format!("--{option}"), value.to_owned()]);
    command().try_get_matches_from(words).map_or_else(|error| error.to_string(), |_| "taken".into())
}

/// Calls `look` for each option with a value of each command, with the words that name the command.
fn each_option(command: &clap::Command, path: &[String], look: &mut dyn FnMut(&[String], &clap::Arg)) {
    let path: Vec<String> = path.iter().cloned().chain([command.get_name().to_owned()]).collect();
    let takes = |arg: &&clap::Arg| arg.get_action().takes_values() && !arg.is_positional();
    command.get_arguments().filter(takes).for_each(|arg| look(&path, arg));
    command.get_subcommands().for_each(|sub| each_option(sub, &path, look));
}

#[test]
fn every_option_that_takes_numbers_says_what_it_allows() {
    let (mut numbers, mut others) = (0, 0);
    each_option(&command(), &[], &mut |path, arg| {
        let (Some(option), Some([form])) = (arg.get_long(), arg.get_value_names()) else { return };
        let number = ["N", "X"].contains(&form.as_str());
        let takes = |commands: &[&str]| path.iter().any(|word| commands.contains(&word.as_str()));
        let of_both = AXES.contains(&option)
            && takes(&["sweep", "design", "bifurcation", "lyapunov", "response", "orbits", "locus"])
            || option == "start"
                && takes(&[
                    "run",
                    "sweep",
                    "design",
                    "bifurcation",
                    "lyapunov",
                    "fit",
                    "orbit",
                    "orbits",
                    "response",
                    "basin",
                    "section",
                ]);
        let later = READ_LATER.contains(&option) || of_both;
        if !number && (later || !FORMS.contains(&form.as_str())) {
            return;
        }
        *(if number { &mut numbers } else { &mut others }) += 1;
        // A number below zero must not be taken for an option.
        for value in NONE.into_iter().chain(number.then_some("-5")) {
            let told = error(path, option, value);
            let named = told.contains(&format!("invalid value '{value}' for '--{option} <{form}>'"));
            let ways = ["expected", "possible values", "is named", "did you mean", "is not in"];
            assert!(named && ways.iter().any(|way| told.contains(way)), "{path:?}: {told}");
        }
    });
    assert!(numbers > 30 && others > 20, "{numbers} {others}");
}

/// The defaults of `sweep --again`, which the command line has as text.
#[test]
fn second_method_defaults_of_either_machine_are_the_librarys() {
    use vibro_studies::design_sweep::DesignMachine as _;
    let again = |line: &str| {
        let found = Arguments::try_parse_from(line.split(' ')).unwrap();
        let Command::Sweep(sweep) = found.command else { panic!("{line}") };
        sweep.again
    };
    assert_eq!(again("vibro sweep"), vibro_studies::paper::ParameterSet::AGAIN);
    assert_eq!(again("vibro sweep machine.toml"), vibro_studies::Machine::AGAIN);
}
