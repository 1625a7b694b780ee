"""Ways to run a case: fmpy, wasmtime, any command line, a folder of results."""

import shlex
import shutil
import subprocess
from decimal import Decimal
from pathlib import Path

import cases
from machine import read_inputs
from results import BadResult, Result, read_events, read_rows

TARGET = Path(__file__).resolve().parent.parent / "target" / "truth"
TOLERANCE = 1e-10

# fmpy: title, version of FMI, options.
FMPY = {
    "FMI 2.0 CS": (2, {"fmi_type": "CoSimulation"}),
    "FMI 3.0 CS": (3, {"fmi_type": "CoSimulation"}),
    "FMI 3.0 CS, event mode and early return": (3, {"fmi_type": "CoSimulation", "use_event_mode": True, "early_return_allowed": True}),
    "FMI 2.0 ME, CVode": (2, {"fmi_type": "ModelExchange", "relative_tolerance": TOLERANCE}),
    "FMI 3.0 ME, CVode": (3, {"fmi_type": "ModelExchange", "relative_tolerance": TOLERANCE}),
}


def archive(case, version, folder=TARGET):
    name = "".join(word.capitalize() for word in case.name.split("_"))
    path = Path(folder) / (f"{name}.fmu" if version == 2 else f"{name}-FMI3.fmu")
    if not path.exists():
        raise BadResult(f"{path}: no such file; make it by `python truth/build.py`")
    return path


def by_fmpy(way, folder=TARGET):
    version, options = FMPY[way]

    def run(case, names):
        import fmpy
        import numpy

        fmu = str(archive(case, version, folder))
        inputs, signals = read_inputs(case.folder / "input.csv"), None
        if inputs:
            table = next(iter(inputs.values()))[0]
            columns = [("time", float)] + [(name, float) for name in inputs]
            signals = numpy.array([(row[0], *(rows[k][1] for rows, _ in inputs.values())) for k, row in enumerate(table)], dtype=columns)
        try:
            found = fmpy.simulate_fmu(fmu, stop_time=float(case.stop), output_interval=float(case.step),
                                      output=names, input=signals, **options)
        except Exception as error:  # whatever the host raises is its result
            raise BadResult(f"fmpy ends with {type(error).__name__}: {error}") from error
        rows = [(Decimal(repr(float(row["time"]))), {n: finite(row[n], n, k) for n in names}) for k, row in enumerate(found)]
        return Result(rows)
    return run


def by_wasmtime(folder=TARGET):
    """The WebAssembly components of archives from a kit with `--wasm`."""
    def run(case, names):
        import component

        inputs = {name: rows for name, (rows, _) in read_inputs(case.folder / "input.csv").items()}
        try:
            return Result(component.rows(archive(case, 3, folder), names, case.steps, float(case.step), inputs))
        except BadResult:
            raise
        except Exception as error:  # a trap, too
            raise BadResult(f"the component ends with {type(error).__name__}: {error}") from error
    return run


def finite(value, name, row):
    value = Decimal(repr(float(value)))
    if not value.is_finite():
        raise BadResult(f"row {row}, column `{name}` is {value}: expected a finite number")
    return value


def filled(template, case, names, output, folder=TARGET):
    """The words of a command. `{input:WORD}` becomes WORD and the file of inputs, or nothing if the case has none."""
    words = []
    try:
        parts = shlex.split(template)
    except ValueError as error:
        raise BadResult(f"the command cannot be split into words: {error}") from None
    if not parts:
        raise BadResult("the command has no word")
    given = case.folder / "input.csv"
    values = {"machine": case.folder / "machine.toml", "step": repr(float(case.step)), "stop": repr(float(case.stop)),
              "steps": case.steps, "output": output, "folder": output.parent / case.name, "names": ",".join(names)}
    if given.exists() and "{input:" not in template:
        raise BadResult("this case has inputs, and the command has no {input:OPTION} for their file")
    for word in parts:
        if word.startswith("{input:"):
            words += [word[7:-1], str(given)] if given.exists() else []
        elif word.startswith("{variables:"):
            words += [w for name in names for w in (word[11:-1], name)]
        else:
            if "{fmu" in word:
                values |= {"fmu": archive(case, 2, folder) if "{fmu}" in word or "{fmu2}" in word else archive(case, 3, folder)}
                word = word.replace("{fmu2}", "{fmu}").replace("{fmu3}", "{fmu}")
            words.append(with_values(word, values))
    return words


def with_values(word, values):
    """A word in which names in braces are replaced."""
    try:
        return word.format(**values)
    except (KeyError, IndexError) as error:
        names = ", ".join(f"{{{name}}}" for name in ["fmu2", "fmu3", *values])
        raise BadResult(f"the command has {{{error.args[0]}}}; expected one of {names}") from None
    except ValueError:
        raise BadResult(f"the command has a brace that is not closed: {word}") from None


def by_command(template, archives=TARGET, timeout=600):
    def run(case, names):
        output = TARGET / "run" / f"{case.name}.csv"
        output.parent.mkdir(parents=True, exist_ok=True)
        output.unlink(missing_ok=True)
        folder = output.parent / case.name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        words = filled(template, case, names, output, archives)
        try:
            done = subprocess.run(words, capture_output=True, text=True, errors="replace", timeout=timeout)
        except subprocess.TimeoutExpired:
            raise BadResult(f"{words[0]} does not end within {timeout} s") from None
        except (OSError, ValueError) as error:
            raise BadResult(f"{words[0]} cannot be run: {error}") from None
        if done.returncode:
            told = (done.stderr.strip() or done.stdout.strip() or "no message").splitlines()
            line = next((line for line in told if line.startswith("error")), told[-1])
            raise BadResult(f"{words[0]} ends with status {done.returncode}: {line}")
        if "{folder}" in template:
            return Result(read_rows(folder / "states.csv", names), read_events(folder / "events.csv"))
        return Result(read_rows(output, names))
    return run


def by_folder(folder):
    folder = Path(folder)

    def run(case, names):
        events = folder / f"{case.name}.events.csv"
        return Result(read_rows(folder / f"{case.name}.csv", names), read_events(events) if events.exists() else None)
    return run
