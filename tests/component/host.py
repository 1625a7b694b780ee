"""A host of the layered standard for WebAssembly (draft of FMI-LS-WASM) around wasmtime, for the tests of the component."""

import zipfile
from pathlib import Path

import wasmtime
from wasmtime import component as wasm

PACKAGE = "fmi:fmi3/{}@3.0.0"
FOLDER = "binaries/wasm32-wasip2/"


class Refused(Exception):
    """A call that returns a status other than ok and warning."""


class Archive:
    """An FMU with a component, compiled once."""

    def __init__(self, path: Path) -> None:
        with zipfile.ZipFile(path) as files:
            names = files.namelist()
            [name] = [name for name in names if name.startswith(FOLDER)]
            self.resources = {
                name.removeprefix("resources/"): files.read(name) for name in names if name.startswith("resources/")
            }
            self.engine = wasmtime.Engine()
            self.component = wasm.Component(self.engine, files.read(name))


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
