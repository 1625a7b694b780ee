"""Small pictures of results as SVG for notebooks, a few kilobytes each, without matplotlib."""

from __future__ import annotations

import base64
import struct
import zlib
from collections.abc import Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from ._arguments import Floats

#: Colours of lines and areas (Okabe and Ito).
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
#: Size of a picture and of the rectangle within it, pixels.
_WIDTH, _HEIGHT, _LEFT, _RIGHT, _TOP, _BOTTOM = 420, 200, 8, 412, 22, 178
#: Largest numbers, to keep a picture small: windows of a line, each with its minimum and maximum; dots; cells in one direction.
_WINDOWS, _DOTS, _CELLS = 250, 1500, 120


class Line:
    """A line or dots of a picture."""

    def __init__(self, x: Floats, y: Floats, label: str = "", *, dots: bool = False, dashed: bool = False, colour: int = 0) -> None:
        finite = np.isfinite(np.ma.filled(x, np.nan)) & np.isfinite(np.ma.filled(y, np.nan))
        self.x, self.y = np.asarray(x)[finite], np.asarray(y)[finite]
        self.label, self.dots, self.dashed, self.colour = label, dots, dashed, COLOURS[colour % len(COLOURS)]

    def drawn(self, x: Floats, y: Floats) -> str:
        """Returns the SVG path for these coordinates in pixels."""
        if self.dots or len(x) == 1:
            step, width = -(-len(x) // _DOTS) or 1, 1.6 if self.dots else 4
            path = "".join(f"M{a:.0f} {b:.0f}h0" for a, b in zip(x[::step], y[::step]))
            return f'<path d="{path}" stroke="{self.colour}" stroke-width="{width}" stroke-linecap="round"/>'
        x, y = _thinned(x, y)
        path = "L".join(f"{a:.0f} {b:.1f}" for a, b in zip(x, y))
        dash = ' stroke-dasharray="4 3"' if self.dashed else ""
        return f'<path d="M{path}" fill="none" stroke="{self.colour}" stroke-width="1.1"{dash}/>' if path else ""


def _thinned(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Replaces a long line by the minimum and maximum in each of some windows."""
    if len(x) <= 2 * _WINDOWS:
        return x, y
    parts = np.array_split(np.arange(len(x)), _WINDOWS)
    kept = np.array([sorted((part[y[part].argmin()], part[y[part].argmax()])) for part in parts]).reshape(-1)
    return x[kept], y[kept]


def pieces(x: Floats, y: Floats, stable: NDArray[np.bool_]) -> list[Line]:
    """Splits a branch into lines of one stability, each to the first point of the next line; dashed if unstable."""
    begins = np.flatnonzero(np.append(True, np.diff(stable.astype(int)) != 0)) if len(x) else np.empty(0, dtype=int)
    ends = np.append(begins[1:] + 1, len(x))
    return [Line(x[begin:end], y[begin:end], dashed=not stable[begin]) for begin, end in zip(begins, ends)]


def lines(some: Sequence[Line], across: str, up: str) -> str:
    """Draws lines and dots over a common axis, with the ends of both axes as numbers."""
    some = [line for line in some if len(line.x)]
    if not some:
        return ""
    (x0, x1), (y0, y1) = (_ends([getattr(line, axis) for line in some]) for axis in "xy")
    drawn = "".join(
        line.drawn(_LEFT + (line.x - x0) * ((_RIGHT - _LEFT) / (x1 - x0)), _BOTTOM - (line.y - y0) * ((_BOTTOM - _TOP) / (y1 - y0)))
        for line in some
    )
    labels = [f'<tspan fill="{line.colour}">{escape(line.label)} </tspan>' for line in some if line.label]
    return _framed(drawn, (x0, x1, across), (y0, y1, up), "".join(labels))


def _ends(arrays: list[Floats]) -> tuple[float, float]:
    low, high = min(float(a.min()) for a in arrays), max(float(a.max()) for a in arrays)
    margin = max(abs(low), abs(high), 1e-300) * 1e-3
    return (low, high) if high - low > 1e-12 * max(abs(low), abs(high)) and high > low else (low - margin, high + margin)


def cells(numbers: NDArray[np.int32], edges: tuple[float, float, float, float], across: str, up: str) -> str:
    """Draws a plane of cells, with a colour for each number from 0 on and white or grey for negative numbers."""
    step = [-(-count // _CELLS) for count in numbers.shape]
    shown = np.asarray(numbers)[:: step[0], :: step[1]][::-1]
    palette = bytes(byte for colour in ("#ffffff", "#b0b0b0", "#606060", *COLOURS) for byte in bytes.fromhex(colour[1:]))
    known = np.where(shown >= 0, 3 + shown % len(COLOURS), np.clip(-1 - shown, 0, 2)).astype(np.uint8)
    return _image(known, palette, edges, across, up)


def shades(values: Floats, edges: tuple[float, float, float, float], across: str, up: str, what: str) -> str:
    """Draws a plane of numbers, from light for the smallest to dark for the largest."""
    plain = np.ma.filled(values.astype(float), np.nan)
    step = [-(-count // _CELLS) for count in plain.shape]
    shown = plain[:: step[0], :: step[1]][::-1]
    finite = np.isfinite(shown)
    low, high = (float(shown[finite].min()), float(shown[finite].max())) if finite.any() else (0.0, 1.0)
    part = np.where(finite, (shown - low) / ((high - low) or 1.0), 0.0)
    palette = b"\xff\xff\xff" + bytes(c for k in range(255) for c in (235 - 235 * k // 254, 240 - 170 * k // 254, 250 - 72 * k // 254))
    index = np.where(finite, 1 + np.round(254 * part), 0).astype(np.uint8)
    return _image(index, palette, edges, across, up, f"{what} {low:.4g} to {high:.4g}")


def _image(index: NDArray[np.uint8], palette: bytes, edges: tuple[float, float, float, float], across: str, up: str, label: str = "") -> str:
    height, width = index.shape
    rows = b"".join(b"\0" + row.tobytes() for row in index)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)
    png = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"PLTE", palette) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")
    data = base64.b64encode(png).decode()
    image = (
        f'<image x="{_LEFT}" y="{_TOP}" width="{_RIGHT - _LEFT}" height="{_BOTTOM - _TOP}" preserveAspectRatio="none" '
        f'style="image-rendering:pixelated" href="data:image/png;base64,{data}"/>'
    )
    left, right, bottom, top = edges
    return _framed(image, (left, right, across), (bottom, top, up), f"<tspan>{escape(label)}</tspan>" if label else "")


def _framed(drawn: str, x: tuple[float, float, str], y: tuple[float, float, str], labels: str) -> str:
    middle = (_LEFT + _RIGHT) // 2
    texts = (
        f'<text x="{_LEFT}" y="194">{x[0]:.4g}</text><text x="{_RIGHT}" y="194" text-anchor="end">{x[1]:.4g}</text>'
        f'<text x="{middle}" y="194" text-anchor="middle">{escape(x[2])}</text>'
        f'<text x="{_LEFT}" y="12">{escape(y[2])}: {y[0]:.4g} to {y[1]:.4g}</text><text x="{_RIGHT}" y="12" text-anchor="end">{labels}</text>'
    )
    frame = f'<rect x="{_LEFT}" y="{_TOP}" width="{_RIGHT - _LEFT}" height="{_BOTTOM - _TOP}" fill="none" stroke="#888"/>'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH}" height="{_HEIGHT}" viewBox="0 0 {_WIDTH} {_HEIGHT}">'
        f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="#fff"/>{drawn}{frame}'
        f'<g font-family="sans-serif" font-size="11" fill="#222">{texts}</g></svg>'
    )


def page(title: str, numbers: Sequence[tuple[str, str]], picture: str) -> str:
    """Returns a result as HTML: its numbers next to its picture."""
    cell = "text-align:left;padding:1px 8px"
    rows = "".join(f'<tr><th style="{cell}">{escape(name)}</th><td style="{cell}">{escape(text)}</td></tr>' for name, text in numbers)
    return f"<div><b>{escape(title)}</b><div>{picture}</div><table>{rows}</table></div>"
