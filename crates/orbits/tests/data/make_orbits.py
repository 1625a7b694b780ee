"""Writes orbits.csv beside it: special points of the default set over f10 in thirty digits, of all types and words.

Run once with the requirements of tests/theory: `python crates/orbits/tests/data/make_orbits.py`. The orbits solve the equations of
docs/theory.md, section 14, which tests/theory compares with the motion itself. The special points are found from the eigenvalues of the
map (106) and not from the determinants (108), so that the library's method is checked too.
"""

import csv
import sys
from pathlib import Path
from typing import Any, List, Tuple

import mpmath

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[2] / "tests" / "theory"))

from orbits import Word  # noqa: E402
from simulation import basic  # noqa: E402

DIGITS = 34
# Label, word, closing sign, half drive periods, f10 and phases to some digits.
POINTS: List[Tuple[str, str, int, int, float, List[float]]] = [
    ("LP", "U", -1, 1, 0.540953, [-0.48391]),
    ("BP", "U", -1, 1, 2.039589, [-1.78627]),
    ("NS", "U", -1, 1, 0.914660, [-1.42188]),
    ("PD", "UL", 1, 2, 2.373075, [5.09776, 6.9199]),
    ("NS", "UUL", 1, 2, 2.477106, [3.55768, 5.77447, 7.81504]),
    ("LP", "UUL", 1, 2, 3.851214, [3.50292, 4.79295, 7.77482]),
    ("PD", "UUL", 1, 2, 3.961163, [3.33137, 4.66995, 7.8512]),
    ("BP", "UULU", -1, 3, 4.206060, [3.88952, 5.30899, 7.30747, 10.83436]),
    ("GR", "UUL", 1, 2, 2.899802, [3.46202, 6.65884, 8.44782]),
    ("GR", "UULUL", 1, 4, 2.631685, [3.80569, 6.60751, 8.5745, 9.94366, 14.21856]),
    ("PD", "UULUL", 1, 4, 2.587578, [3.73279, 6.57124, 8.51928, 9.90889, 14.30898]),
    ("LP", "UULUUL", 1, 4, 2.914357, [3.58416, 5.26319, 7.62247, 10.16171, 12.01576, 14.00589]),
    ("LP", "UULUULUUL", 1, 6, 3.289875, [3.74882, 5.29431, 7.53555, 10.28981, 12.0933, 13.93954, 16.14946, 17.55815, 20.26643]),
    ("GR", "UULUULUULUUL", 1, 8, 3.312912, [4.10107, 6.54371, 8.32084, 9.66646, 11.94496, 13.60891, 16.66031, 18.7221, 20.44529, 22.11978, 23.77219, 26.3698]),
]


def condition(label: str, word: Word, phases: List[Any]) -> Any:
    """Zero at the special point."""
    if label == "GR":
        return min((rate * word.stop(i + 1) for i, rate in enumerate(word.rates(phases))), key=abs)
    multipliers = mpmath.eig(word.monodromy(phases), left=False, right=False)
    if label == "NS":
        pairs = [m for m in multipliers if abs(mpmath.im(m)) > mpmath.mpf(10) ** -12]
        return min((abs(m) ** 2 - 1 for m in pairs), key=abs)
    target = 1 if label == "LP" else -1
    product = mpmath.mpf(1)
    for m in multipliers:
        product = product * (m - target)
    return mpmath.re(product)


def solve(label: str, letters: str, sigma: int, half: int, f10: float, guess: List[float]) -> Tuple[Any, List[Any], Any]:
    stops = [1 if letter == "U" else -1 for letter in letters]

    def word(force: Any) -> Word:
        return Word(basic(F_10=force), stops, sigma, half)

    if label in ("LP", "GR"):
        # The parameter turns, or a phase does: all unknowns are solved at once, with differences
        # for derivatives.
        def equations(*u: Any) -> List[Any]:
            at, phases = word(u[-1]), list(u[:-1])
            return [*at.residual(phases), condition(label, at, phases)]

        start = [mpmath.mpf(x) for x in [*guess, f10 / 10]]
        found = list(mpmath.findroot(equations, start, tol=mpmath.mpf(10) ** -50, maxsteps=12, verify=False))
        return found[-1], found[:-1], equations(*found)

    def along(force: Any) -> Any:
        at = word(force)
        return condition(label, at, at.solve(guess))

    force = mpmath.mpf(f10) / 10
    step = mpmath.mpf(10) ** -7
    force = mpmath.findroot(along, (force, force + step), solver="secant", tol=mpmath.mpf(10) ** -50, maxsteps=15, verify=False)
    return force, word(force).solve(guess), [along(force)]


def main() -> None:
    mpmath.mp.dps = DIGITS
    with (HERE / "orbits.csv").open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["label", "word", "closing", "half periods", "f10", "phases"])
        for label, letters, sigma, half, f10, guess in POINTS:
            force, phases, left = solve(label, letters, sigma, half, f10, guess)
            worst = max(abs(x) for x in left)
            print(label, letters, mpmath.nstr(10 * force, 20), mpmath.nstr(worst, 3), flush=True)
            assert worst < mpmath.mpf(10) ** -26
            digits = " ".join(mpmath.nstr(x, 30) for x in phases)
            out.writerow([label, letters, sigma, half, mpmath.nstr(10 * force, 30), digits])


if __name__ == "__main__":
    main()
