"""Writes the matrices of the blade in blade_tip.toml as CalculiX does, in N, mm, t: beam elements, clamped at node 1.

    python3 blade_tip.py
    vibro reduce blade.sti blade.mas blade.dof --units N,mm,t,s --clamp 1 --interface tip=21 \
        --interface middle=11 --modes 8 --damping-ratio 0.005
"""

from math import cos, radians, sin

LENGTH, WIDTH, HEIGHT = 200.0, 40.0, 4.0  # mm
MODULUS, DENSITY = 210e3, 7.85e-9  # MPa, t/mm3
STAGGER = radians(60)  # from the casing, along x, to the blade
ELEMENTS = 20


def element():
    """Returns stiffness and mass of an element: displacements along and across the blade and slope of either end."""
    h, area = LENGTH / ELEMENTS, WIDTH * HEIGHT
    bend, line = MODULUS * WIDTH * HEIGHT**3 / 12 / h**3, DENSITY * area * h / 420
    k = [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h],
         [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]]
    m = [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h],
         [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]]
    across, along = [1, 2, 4, 5], [0, 3]
    parts = (k, bend, [[1, -1], [-1, 1]], MODULUS * area / h), (m, line, [[140, 70], [70, 140]], line)
    both = []
    for bending, factor, axial, other in parts:
        whole = [[0.0] * 6 for _ in range(6)]
        for dofs, block, scale in (across, bending, factor), (along, axial, other):
            for row, i in zip(block, dofs):
                for x, j in zip(row, dofs):
                    whole[i][j] = scale * x
        both.append(turned(whole))
    return both


def turned(part):
    """Returns a matrix for displacements in x and y: R^T part R."""
    c, s = cos(STAGGER), sin(STAGGER)
    turn = [[c, s, 0], [-s, c, 0], [0, 0, 1]]
    r = [[turn[i % 3][j % 3] if i // 3 == j // 3 else 0.0 for j in range(6)] for i in range(6)]
    half = [[sum(part[i][k] * r[k][j] for k in range(6)) for j in range(6)] for i in range(6)]
    return [[sum(r[k][i] * half[k][j] for k in range(6)) for j in range(6)] for i in range(6)]


def write(path, part):
    """Adds the elements up and writes the upper triangle: row, column, value."""
    sums = {}
    for first in range(1, 3 * ELEMENTS, 3):
        for i in range(6):
            for j in range(i, 6):
                place = first + i, first + j
                sums[place] = sums.get(place, 0.0) + part[i][j]
    with open(path, "w") as file:
        file.writelines(f"{i} {j} {x:.16e}\n" for (i, j), x in sorted(sums.items()) if x)


if __name__ == "__main__":
    stiffness, mass = element()
    write("blade.sti", stiffness)
    write("blade.mas", mass)
    with open("blade.dof", "w") as file:
        file.writelines(f"{node}.{way}\n" for node in range(1, ELEMENTS + 2) for way in (1, 2, 6))
