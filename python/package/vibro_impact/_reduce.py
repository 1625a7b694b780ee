"""Reduction of finite-element matrices to a body of a machine, by the program ``vibro``."""

from __future__ import annotations

import dataclasses
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from ._arguments import Floats, number
from ._result import Result

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: A matrix of NumPy or SciPy, or the path of a file of a finite-element program.
MatrixOrFile = Union[str, "os.PathLike[str]", Any]


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Reduced(Result):
    """A body with a few modes in place of finite-element matrices."""

    text: str
    "The body as text of a machine's file, with the table ``[modal.NAME]``."
    report: str
    "Mass, first frequency, sag, and the statement of what the modes lack at each node."
    frequencies: Floats
    "Frequencies of the coordinates, shape (n,), Hz."
    basis: Floats
    "Displacements of all dofs by each coordinate, shape (dofs, n): for stresses and pictures."
    dofs: NDArray[np.str_]
    "Names of the dofs, as ``node.direction``."
    interface: NDArray[np.str_]
    "Names of the dofs at which others are attached."
    residual: Floats
    "Residual flexibility between the dofs of the interface, m/N."
    verified: str = ""
    "With ``verify``: how far positions and events differ from a body of 1.5 times as many modes."


def reduce(
    stiffness: MatrixOrFile,
    mass: Optional[MatrixOrFile] = None,
    *,
    units: str,
    modes: int,
    interface: Mapping[str, str],
    dofs: Optional[Sequence[str]] = None,
    clamp: Union[str, Iterable[str]] = (),
    method: str = "macneal",
    damping: Optional[MatrixOrFile] = None,
    damping_ratio: Optional[float] = None,
    rayleigh: Optional[tuple[float, float]] = None,
    gravity: Optional[str] = None,
    contact_stiffness: Optional[float] = None,
    load_frequency: Optional[float] = None,
    verify: Optional[str] = None,
    until: Optional[float] = None,
    name: str = "body",
    program: Union[str, "os.PathLike[str]", None] = None,
) -> Reduced:
    """Reduces a stiffness and a mass matrix to a body of a machine's file.

    The work is done by the program ``vibro``, built with the feature ``reduce``; its options have the same names (``docs/reduce.md``).

    Parameters
    ----------
    stiffness, mass
        Matrices of NumPy or SciPy, in ``units``, or paths of files. A file may have both matrices: then ``mass`` is left out.
    units
        ``"SI"``, or units of force, length, mass and time of the matrices, such as ``"N,mm,t,s"``.
    modes
        Number of modes.
    interface
        Nodes at which others are attached, such as ``{"tip": "41.y"}``.
    dofs
        Names of the rows, as ``node.direction``. Without names a dof is called by its row, counted from 1.
    clamp
        Clamped nodes, such as ``"1"`` or ``["1", "7.xz"]``.
    method
        ``"macneal"``, ``"rubin"`` or ``"craig-bampton"``.
    damping, damping_ratio, rayleigh
        Damping matrix, whose damping between different modes is left out; damping ratio of every mode; or (α, β) of the damping α M + β K.
    gravity
        Direction of the weight, such as ``"-z"``.
    contact_stiffness, load_frequency
        Stiffness of the contacts, N/m, and highest frequency of the loads, Hz, for the statement of errors.
    verify, until
        Text of a machine's file without the body, and a time, s: the machine moves until then with the body and with one of 1.5 times as many modes.
    name
        Name of the body.
    program
        The program; by default the one that the environment variable ``VIBRO`` names, or ``vibro`` on the path.

    Returns
    -------
    Reduced
        ``text`` begins a machine's file: ``vi.Machine(found.text + surroundings)``.

    Raises
    ------
    FileNotFoundError
        If the program is not found.
    ValueError
        With the program's message if it refuses the matrices or an argument.
    """
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        command = [_program(program), "reduce", f"--units={units}", f"--modes={modes}", f"--method={method}"]
        command += [f"--name={name}", f"--out={place / 'reduced'}"]
        for role, matrix in (("stiffness", stiffness), ("mass", mass)):
            if matrix is not None:
                command.append(_matrix(place, role, matrix, alone=mass is None))
        if damping is not None:
            command.append(_matrix(place, "damping", damping, alone=False))
        if dofs is not None:
            (place / "names.txt").write_text("".join(f"{dof}\n" for dof in dofs))
            command.append(f"--dofs={place / 'names.txt'}")
        clamped = [clamp] if isinstance(clamp, str) else list(clamp)
        command += [f"--clamp={node}" for node in clamped]
        command += [f"--interface={node}={at}" for node, at in interface.items()]
        if gravity is not None:
            command.append(f"--gravity={gravity}")
        if rayleigh is not None:
            command.append("--rayleigh=" + ",".join(repr(number("rayleigh", x)) for x in rayleigh))
        numbers = {"damping-ratio": damping_ratio, "contact-stiffness": contact_stiffness, "load-frequency": load_frequency}
        command += [f"--{key}={number(key.replace('-', '_'), x)!r}" for key, x in numbers.items() if x is not None]
        if (verify is None) != (until is None):
            missing, given = ("until", "verify") if until is None else ("verify", "until")
            raise ValueError(f"{missing}: missing; expected with `{given}`")
        if verify is not None:
            (place / "rest.toml").write_text(verify)
            command += [f"--verify={place / 'rest.toml'}", f"--until={number('until', until)!r}"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise ValueError(done.stderr.strip().removeprefix("error: ") or f"{command[0]} ended with {done.returncode}")
        with np.load(place / "reduced.npz") as arrays:
            found = {key: arrays[key] for key in ("frequencies", "basis", "dofs", "interface", "residual")}
        text, report = ((place / f"reduced.{ending}").read_text() for ending in ("toml", "txt"))
        # Lines about the motions follow the names of the written files.
        said = done.stdout.partition("\nwrote ")[2].partition("\n")[2].strip()
        verified = said.replace(f"{place / 'rest.toml'}", "machine")
        return Reduced(text=text, report=report, verified=verified, **found)


def _program(given: Union[str, "os.PathLike[str]", None]) -> str:
    found = os.fspath(given) if given is not None else os.environ.get("VIBRO") or shutil.which("vibro")
    if not found or not (shutil.which(found) or Path(found).is_file()):
        what = f"no program {found}" if found else "no program `vibro` on the path"
        raise FileNotFoundError(
            f"{what}; build it with `cargo install --path crates/command-line --features reduce`, or name it by `program`"
        )
    return found


def _matrix(folder: Path, role: str, matrix: MatrixOrFile, alone: bool) -> str:
    """Returns the argument that names a matrix's file; a matrix is written to one first."""
    if isinstance(matrix, (str, os.PathLike)):
        return os.fspath(matrix) if alone else f"--{role}={os.fspath(matrix)}"
    if alone:
        raise ValueError("mass: missing; expected a matrix, or a file with both matrices as `stiffness`")
    entries = matrix.tocoo() if hasattr(matrix, "tocoo") else None
    if entries is None:
        full = np.asarray(matrix, dtype=float)
        if full.ndim != 2:
            raise ValueError(f"{role}: an array of {full.ndim} dimensions; expected a square matrix")
        rows, columns = np.nonzero(full)
        values, shape = full[rows, columns], full.shape
    else:
        rows, columns, values, shape = entries.row, entries.col, entries.data, entries.shape
    if shape[0] != shape[1]:
        raise ValueError(f"{role}: {shape[0]} rows and {shape[1]} columns; expected a square matrix")
    file = folder / f"{role}.mtx"
    with file.open("w") as out:
        out.write(f"%%MatrixMarket matrix coordinate real general\n{shape[0]} {shape[1]} {len(values)}\n")
        out.writelines(f"{i + 1} {j + 1} {float(x)!r}\n" for i, j, x in zip(rows, columns, values))
    return f"--{role}={file}"
