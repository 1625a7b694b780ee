"""Computes many motions in parts: in this process or on an executor, with finished parts optionally kept in a folder.

The folder has the layout of the command line's long studies: ``manifest.toml`` describes the computation, and a file ``00000.part``
holds each finished part, written completely or not at all. A part is a line with the SHA-256 checksum of its rows, then the rows as JSON.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Optional, Protocol, Union

from ._progress import Bar

#: Number of parts at which a study aims; smallest and largest number of rows of a part, which take precedence.
_PARTS, _LEAST, _MOST = 200, 8, 4096
#: Version of the format of a part; parts of other versions are refused.
_FORM = 3


class Work(Protocol):
    """Rows of many motions; must be picklable, because other processes compute parts."""

    def count(self) -> int:
        """Number of rows."""

    def part(self, begin: int, end: int) -> Work:
        """Returns the work of the rows from `begin` to `end`."""

    def told(self) -> Iterator[bytes]:
        """Yields everything on which the rows depend, as bytes to hash."""

    def rows(self, report: Any) -> list[Any]:
        """Computes the rows."""


def _computed(work: Work) -> list[Any]:
    """Computes the rows of a part, in another process."""
    return work.rows(None)


def rows_of(work: Work, executor: Any, checkpoint: Union[None, str, os.PathLike[str]], progress: bool) -> list[Any]:
    """Returns all rows; computes the rows that the checkpoint does not hold yet.

    Raises
    ------
    KeyboardInterrupt
        The rows computed before it are its attribute ``partial``, which has None for each missing row.
    """
    if executor is not None and not callable(getattr(executor, "submit", None)):
        raise TypeError(
            f"executor is of type {type(executor).__name__}: expected an object with `submit`, such as an executor of concurrent.futures, "
            "loky or mpi4py, or a dask Client"
        )
    if checkpoint is not None and not isinstance(checkpoint, (str, os.PathLike)):
        raise TypeError(f"checkpoint = {checkpoint!r} is of type {type(checkpoint).__name__}: expected the path of a folder")
    count = work.count()
    if executor is None and checkpoint is None:
        with Bar(progress, count, "motions") as bar:
            return work.rows(bar.report)
    size = min(max(-(-count // _PARTS), _LEAST), _MOST)
    ends = [(begin, min(begin + size, count)) for begin in range(0, count, size)]
    folder = None if checkpoint is None else _Folder(Path(checkpoint), work, count, size)
    found: list[Optional[list[Any]]] = [None if folder is None else folder.load(k) for k in range(len(ends))]
    missing = [k for k, rows in enumerate(found) if rows is None]
    with Bar(progress, len(ends), "parts") as bar, _partial(found, ends):
        parts = _here(work, ends, missing) if executor is None else _there(executor, work, ends, missing)
        for done, (k, rows) in enumerate(parts):
            if folder is not None:
                folder.save(k, rows)
            found[k] = rows
            if bar.report is not None:
                bar.report(len(ends) - len(missing) + done + 1, len(ends))
    return [row for rows in found for row in rows or ()]


def _here(work: Work, ends: list[tuple[int, int]], missing: list[int]) -> Iterator[tuple[int, list[Any]]]:
    for k in missing:
        try:
            yield k, work.part(*ends[k]).rows(None)
        except Exception as error:
            _place(error, ends[k][0])
            raise


def _there(executor: Any, work: Work, ends: list[tuple[int, int]], missing: list[int]) -> Iterator[tuple[int, list[Any]]]:
    """Yields parts computed by an executor, in order; cancels parts that have not begun if the work ends early."""
    # Dask may reuse the result of an earlier, equal call; equal parts have equal rows.
    futures = [(k, executor.submit(_computed, work.part(*ends[k]))) for k in missing]
    try:
        for k, future in futures:
            try:
                yield k, future.result()
            except Exception as error:
                _place(error, ends[k][0])
                raise
    finally:
        for _, future in futures:
            if not future.done():
                future.cancel()


def _place(error: Exception, begin: int) -> None:
    """Shifts the number of the motion in a part's error message by the index of the part's first row."""
    if begin and error.args and isinstance(error.args[0], str) and error.args[0].startswith("motion "):
        number, _, rest = error.args[0][len("motion ") :].partition(":")
        if number.isdecimal():
            error.args = (f"motion {int(number) + begin}:{rest}", *error.args[1:])


@contextlib.contextmanager
def _partial(found: list[Optional[list[Any]]], ends: list[tuple[int, int]]) -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt as interrupt:
        kept = [row for rows, (begin, end) in zip(found, ends) for row in (rows or [None] * (end - begin))]
        setattr(interrupt, "partial", kept)  # noqa: B010 (not in its type)
        raise


def _sum_of(rows: bytes) -> bytes:
    """Returns the checksum that reveals a damaged part."""
    return hashlib.sha256(rows).hexdigest().encode()


class _Folder:
    """Finished parts, kept in a folder."""

    def __init__(self, path: Path, work: Work, count: int, size: int) -> None:
        from ._native import __version__

        digest = hashlib.sha256()
        for part in work.told():
            digest.update(len(part).to_bytes(8, "little") + part)
        manifest = f'program = "vibro_impact"\nversion = "{__version__}"\nform = {_FORM}\nrows = {count}\npart = {size}\nwork = "{digest.hexdigest()}"\n'
        self.path = path
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as problem:
            raise type(problem)(f"checkpoint = {path}: {problem}: expected a folder") from problem
        own = path / "manifest.toml"
        if own.exists():
            there = own.read_text(encoding="utf-8")
            if there != manifest:
                lines = zip(there.splitlines(), manifest.splitlines())
                other = "; ".join(f"`{a}` instead of `{b}`" for a, b in lines if a != b) or "its manifest.toml is cut short"
                raise ValueError(f"checkpoint = {path}: holds parts of other work, {other}: use another folder, or empty this one")
        elif any(path.iterdir()):
            raise ValueError(f"checkpoint = {path}: holds files but no manifest.toml of parts: expected an empty or a new folder")
        else:
            self._write(own, manifest)

    def _file(self, k: int) -> Path:
        return self.path / f"{k:05d}.part"

    def load(self, k: int) -> Optional[list[Any]]:
        """Returns the rows of a part, or None if it is not finished."""
        if not self._file(k).exists():
            return None
        total, _, rows = self._file(k).read_bytes().partition(b"\n")
        if total != _sum_of(rows):
            raise ValueError(f"{self._file(k)} is damaged, its checksum does not match its rows: delete this file")
        found: list[Any] = json.loads(rows)
        return found

    def save(self, k: int, rows: list[Any]) -> None:
        """Writes a part, completely or not at all."""
        text = json.dumps(rows)
        self._write(self._file(k), f"{_sum_of(text.encode()).decode()}\n{text}")

    def _write(self, path: Path, text: str) -> None:
        beside = path.with_name(f"{path.name}.{os.getpid()}.writing")
        with beside.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        beside.replace(path)
