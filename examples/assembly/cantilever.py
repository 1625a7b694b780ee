"""Writes the mass and stiffness matrices of cantilever.toml: beam elements of a clamped steel strip."""

LENGTH, WIDTH, HEIGHT = 0.5, 0.03, 0.004  # m
MODULUS, DENSITY = 210e9, 7850.0  # Pa, kg/m3
ELEMENTS = 10


def element():
    """Returns stiffness and mass of one element (Euler-Bernoulli): deflection and slope at either end."""
    h = LENGTH / ELEMENTS
    bending, line_mass = MODULUS * WIDTH * HEIGHT**3 / 12, DENSITY * WIDTH * HEIGHT
    k = [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h],
         [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]]
    m = [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h],
         [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]]
    factors = bending / h**3, line_mass * h / 420
    return [[[x * factor for x in row] for row in rows] for rows, factor in zip((k, m), factors)]


def write(path, part):
    """Assembles the elements and writes the lower triangle without the clamped end."""
    size = 2 * ELEMENTS + 2
    whole = [[0.0] * size for _ in range(size)]
    for first in range(0, 2 * ELEMENTS, 2):
        for row in range(4):
            for column in range(4):
                whole[first + row][first + column] += part[row][column]
    entries = [(i, j, whole[i + 1][j + 1]) for i in range(1, size - 1) for j in range(1, i + 1) if whole[i + 1][j + 1]]
    with open(path, "w") as file:
        file.write("%%MatrixMarket matrix coordinate real symmetric\n")
        file.write(f"{size - 2} {size - 2} {len(entries)}\n")
        file.writelines(f"{i} {j} {x!r}\n" for i, j, x in entries)


if __name__ == "__main__":
    stiffness, mass = element()
    write("cantilever_stiffness.mtx", stiffness)
    write("cantilever_mass.mtx", mass)
