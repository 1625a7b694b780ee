"""A host of the layered standard for WebAssembly (draft of FMI-LS-WASM) around wasmtime.

    pip install wasmtime

The host's functions cannot call the component back while it runs, so values are read and inputs are set between steps.
"""

import re
import zipfile
from bisect import bisect_right
from decimal import Decimal
from pathlib import Path

import wasmtime
from wasmtime import component as wasm

PACKAGE = "fmi:fmi3/{}@3.0.0"
FOLDER = "binaries/wasm32-wasip2/"


class Refused(Exception):
    """A call that returns a status other than ok and warning."""


#: Compiled components by their bytes: archives of different machines have the same one.
COMPILED = {}


class Archive:
    """An FMU with a component."""

    def __init__(self, path: Path) -> None:
        with zipfile.ZipFile(path) as files:
            names = files.namelist()
            found = [name for name in names if name.startswith(FOLDER)]
            if not found:
                raise Refused(f"{path} has no WebAssembly component: make it by `cargo run --bin fmu-build -- --wasm`")
            [name] = found
            text = files.read("modelDescription.xml").decode()
            self.token = re.search(r'instantiationToken="([^"]+)"', text).group(1)
            variables = re.findall(r'<(?:Float64|Int\d+|Boolean|Enumeration|Clock)\b[^>]*', text)
            read = lambda key, tag: re.search(rf'\b{key}="([^"]+)"', tag).group(1)
            self.references = {read("name", tag): int(read("valueReference", tag)) for tag in variables if "valueReference" in tag}
            self.resources = {
                name.removeprefix("resources/"): files.read(name) for name in names if name.startswith("resources/")
            }
            code = files.read(name)
        if code not in COMPILED:
            engine = wasmtime.Engine()
            COMPILED[code] = engine, wasm.Component(engine, code)
        self.engine, self.component = COMPILED[code]


class Instance:
    """An instance of an archive; methods have the names of WIT with underscores."""

    def __init__(self, archive: Archive, kind: str, *arguments, update=None, files=None) -> None:
        self.log = []
        self.store = wasmtime.Store(archive.engine)
        self.store.set_wasi(wasmtime.WasiConfig())
        self.resources = archive.resources if files is None else files
        linker = wasm.Linker(archive.engine)
        linker.add_wasip2()
        with linker.root() as root:
            with root.add_instance(PACKAGE.format("callbacks")) as callbacks:
                callbacks.add_func("log-message", lambda _, *message: self.log.append(message))
                for name in ("clock-update", "lock-preemption", "unlock-preemption"):
                    callbacks.add_func(name, lambda _: None)
            with root.add_instance(PACKAGE.format("intermediate-update-callbacks")) as updates:
                updates.add_func("intermediate-update", lambda _, *flags: update(*flags))
            with root.add_instance(PACKAGE.format("resource-dir-callbacks")) as resources:
                resources.add_func("read-file", lambda _, path: self.read(path))
        self.exports = linker.instantiate(self.store, archive.component)
        self.kind = kind
        self.handle = self.call(f"[static]{kind}-instance.instantiate-{kind}", *arguments)

    def read(self, path: str):
        return self.resources.get(path, f"no file {path}")

    def call(self, name: str, *arguments, interface: str = ""):
        parent = self.exports.get_export_index(self.store, PACKAGE.format(interface or self.kind))
        function = self.exports.get_func(self.store, self.exports.get_export_index(self.store, name, parent))
        found = function(self.store, *arguments)
        function.post_return(self.store)
        return found

    def __getattr__(self, name: str):
        method = f"[method]{self.kind}-instance.{name.replace('_', '-')}"

        def called(*arguments):
            found = self.call(method, self.handle, *arguments)
            # A result is its value or its status: the two have different types.
            if isinstance(found, str) and found not in ("ok", "warning"):
                raise Refused(found)
            return found

        return called


def value_at(table, time):
    """A linear input of (time, value) rows; at a jump, the value after it."""
    table = [(float(t), float(x)) for t, x in table]
    times = [row[0] for row in table]
    k = bisect_right(times, time) - 1
    if k < 0 or k + 1 == len(table):
        return table[max(k, 0)][1]
    (t0, x0), (t1, x1) = table[k], table[k + 1]
    return x0 + (x1 - x0) * (time - t0) / (t1 - t0)


def rows(archive, names, steps, step, inputs):
    """Rows (time, values by name) of Co-Simulation; inputs of (time, value) rows are set at each step's begin."""
    own = Archive(archive)
    log = []
    instance = Instance(own, "co-simulation", "machine", own.token, False, False, False, False, [])
    if instance.handle is None:
        raise Refused(instance.log[-1][-1] if instance.log else "no instance")
    wanted, given = [own.references[name] for name in names], [own.references[name] for name in inputs]
    instance.enter_initialization_mode(None, 0.0, None)
    if given:
        instance.set_float64(given, [value_at(table, 0.0) for table in inputs.values()])
    instance.exit_initialization_mode()
    for k in range(steps + 1):
        log.append((Decimal(repr(k * step)), dict(zip(names, (Decimal(repr(x)) for x in instance.get_float64(wanted))))))
        if k < steps:
            if given:
                instance.set_float64(given, [value_at(table, k * step) for table in inputs.values()])
            instance.do_step(k * step, (k + 1) * step - k * step, True)
    return log
