"""``vi.reduce`` against closed forms and SciPy; the program is the one that the environment variable VIBRO names."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse
import vibro_impact as vi

LENGTH, E, RHO, WIDTH, HEIGHT, ELEMENTS = 0.5, 210e9, 7850.0, 0.02, 0.005, 40
# Beam elements converge with the fourth power of their number.
DISCRETE = 1e-5
# SciPy's eigenvalues of full matrices err by roundings of the largest one, 1e9 times the smallest.
SAME = 1e-7


def beam():
    """Stiffness and mass of a cantilever of beam elements, SI, and the names of its dofs."""
    ei, m, h = E * WIDTH * HEIGHT**3 / 12, RHO * WIDTH * HEIGHT, LENGTH / ELEMENTS
    k = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h],
                  [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]]) * ei / h**3
    c = np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h],
                  [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]]) * m * h / 420
    stiffness, mass = np.zeros((2, 2 * ELEMENTS + 2, 2 * ELEMENTS + 2))
    for e in range(ELEMENTS):
        at = slice(2 * e, 2 * e + 4)
        stiffness[at, at] += k
        mass[at, at] += c
    names = [f"{node}.{way}" for node in range(1, ELEMENTS + 2) for way in ("y", "rz")]
    return stiffness, mass, names


def reduced(stiffness, mass, names, **others):
    options = {"units": "SI", "modes": 6, "interface": {"tip": f"{ELEMENTS + 1}.y"}, "clamp": "1", "name": "beam"}
    return vi.reduce(stiffness, mass, dofs=names, **{**options, **others})


def test_closed_form_frequency_and_static_flexibility_of_a_cantilever():
    found = reduced(*beam(), damping_ratio=0.01)
    ei, m = E * WIDTH * HEIGHT**3 / 12, RHO * WIDTH * HEIGHT
    first = (1.875104068711961 / LENGTH) ** 2 * np.sqrt(ei / m) / (2 * np.pi)
    assert abs(found.frequencies[0] / first - 1) < DISCRETE
    # The modes and the residual together have the static flexibility L³/(3 EI).
    tip = list(found.dofs).index(f"{ELEMENTS + 1}.y")
    soft = np.sum((found.basis[tip] / (2 * np.pi * found.frequencies)) ** 2) + found.residual[0, 0]
    assert abs(soft / (LENGTH**3 / (3 * ei)) - 1) < DISCRETE
    machine = vi.Machine(found.text + '\n[stop.tip]\nbetween = ["ground", "beam.tip"]\ngap = "1 mm"\nstiffness = "50 kN/m"\n'
                         '[load.shaker]\non = "beam.tip"\namplitude = "4 N"\nfrequency = "15 Hz"\n')
    assert machine.simulate(until=1.0).events.size > 0


def test_second_method_sparse_matrices_are_reduced_as_full_ones_and_frequencies_are_scipys():
    stiffness, mass, names = beam()
    full = reduced(stiffness, mass, names)
    sparse = reduced(scipy.sparse.csr_array(stiffness), scipy.sparse.csc_matrix(mass), names)
    assert sparse.text == full.text
    moving = np.array([not name.startswith("1.") for name in names])
    inner = np.ix_(moving, moving)
    squares = scipy.linalg.eigh(stiffness[inner], mass[inner], eigvals_only=True)[:6]
    assert np.max(np.abs(full.frequencies / (np.sqrt(squares) / (2 * np.pi)) - 1)) < SAME


def test_second_method_verify_counts_the_events_of_both_bodies():
    rest = ('\n[stop.tip]\nbetween = ["ground", "beam.tip"]\ngap = "1 mm"\nstiffness = "50 kN/m"\n'
            '[load.shaker]\non = "beam.tip"\namplitude = "4 N"\nfrequency = "15 Hz"\n')
    found = reduced(*beam(), damping_ratio=0.01, verify=rest, until=0.3)
    bodies = [found.text, reduced(*beam(), damping_ratio=0.01, modes=9).text]
    few, many = (vi.Machine(body + rest).simulate(until=0.3).events.size for body in bodies)
    assert found.verified.startswith("machine with 6 and 9 modes over 0.3 s"), found.verified
    counts = f"the same {few} in" if few == many and "the same" in found.verified else f"{few} with 6 modes, {many} with 9"
    assert few > 10 and counts in found.verified, (few, many, found.verified)
    with pytest.raises(ValueError, match="until: missing"):
        reduced(*beam(), verify=rest)


def test_invariant_refusals_name_what_is_wrong():
    stiffness, mass, names = beam()
    with pytest.raises(ValueError, match="99: no such node"):
        reduced(stiffness, mass, names, interface={"tip": "99.y"})
    skew = stiffness.copy()
    skew[4, 6] *= 2
    with pytest.raises(ValueError, match="symmetric"):
        reduced(skew, mass, names)
    with pytest.raises(ValueError, match="82 rows and 81 columns"):
        reduced(stiffness[:, 1:], mass, names)
    with pytest.raises(ValueError, match="damping_ratio"):
        reduced(stiffness, mass, names, damping_ratio=float("nan"))
    with pytest.raises(ValueError, match="mass: missing"):
        reduced(stiffness, None, names)
    with pytest.raises(FileNotFoundError, match="no program /nowhere"):
        reduced(stiffness, mass, names, program="/nowhere")
