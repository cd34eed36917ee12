"""Gauss-Legendre rules on [0, 1] and the integrals of their Lagrange basis."""

from functools import cache

import numpy as np


@cache
def gauss_legendre(count) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes (count,) and weights (count,) on [0, 1], float64; the arrays are read-only."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    nodes.flags.writeable = weights.flags.writeable = False
    return nodes, weights


@cache
def cumulative_matrix(count) -> np.ndarray:
    """Return A (count, count): sum_j A[i, j] f(node_j) is the integral from 0 to node_i of the interpolant of f.

    Built through Legendre polynomials, which keeps all digits: the basis polynomial of node j is
    w_j sum_n (2n + 1) P_n(x_j) P_n(x), and the integral of P_n is (P_(n+1) - P_(n-1)) / (2n + 1).
    """
    nodes, weights = gauss_legendre(count)
    legendre = np.polynomial.legendre.legvander(2.0 * nodes - 1.0, count)
    integrals = np.empty((count, count))
    integrals[:, 0] = nodes  # of P_0 = 1 on the unit interval
    for n in range(1, count):
        integrals[:, n] = 0.5 * (legendre[:, n + 1] - legendre[:, n - 1]) / (2 * n + 1)
    degrees = 2 * np.arange(count) + 1
    matrix = (integrals * degrees) @ legendre[:, :count].T * weights
    matrix.flags.writeable = False
    return matrix
