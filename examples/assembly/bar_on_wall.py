"""Prints bar_on_wall.toml: a free steel bar in its rigid motion and its first modes (`python3 bar_on_wall.py 10`)."""

import math
import sys

LENGTH, AREA = 1.0, 4e-4  # m, m2
MODULUS, DENSITY = 210e9, 7850.0  # Pa, kg/m3
HEAD = """# A steel bar of 1 m flies against a rigid wall: rigid motion, {count} modes and their residual flexibility; `python3 bar_on_wall.py {count}`.
# Held against: the waves in the bar, in crates/command-line/tests/gallery/figures.rs.
name = "BarOnWall"
"""


def listed(values, unit=""):
    """Returns a list of the file."""
    quote = '"' if unit else ""
    return "[" + ", ".join(f"{quote}{value:.12g}{unit}{quote}" for value in values) + "]"


def written(count):
    """Returns the file: modes cos(k pi x/L), the front at x = 0, the back at x = L."""
    mass, speed = DENSITY * AREA * LENGTH, math.sqrt(MODULUS / DENSITY)
    modes = range(1, count + 1)
    # The sum of 2/(mass omega^2) over all modes is L^2/(3 mass c^2), with alternating signs -1/2 of it.
    whole = LENGTH**2 / (3 * mass * speed**2)
    kept = [2 / (mass * (k * math.pi * speed / LENGTH) ** 2) for k in modes]
    same = whole - sum(kept)
    across = -whole / 2 - sum(x * (-1) ** k for k, x in zip(modes, kept))
    return HEAD.format(count=count) + f"""
[modal.bar]                                   # coordinate 0 is the rigid motion, the others are cos(k pi x/L)
frequencies = {listed([0] + [k * speed / (2 * LENGTH) for k in modes], " Hz")}
masses = {listed([mass] + [mass / 2] * count, " kg")}
nodes = {{ front = {listed([1] * (count + 1))}, back = {listed([(-1) ** k for k in range(count + 1)])} }}
residual = {{ nodes = ["front", "back"], flexibility = [[{same:.12g}, {across:.12g}], [{across:.12g}, {same:.12g}]] }}
start = {{ q = {listed([0] * (count + 1))}, v = {listed([1] + [0] * count)} }}

[stop.wall]                                   # rigid, without restitution: the wave brings the bar back
between = ["ground", "bar.front"]
gap = "0.1 mm"
"""


if __name__ == "__main__":
    print(written(int(sys.argv[1])), end="")
