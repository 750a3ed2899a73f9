"""Products of small matrices inside compiled functions: plain loops, a third of the time that a call of BLAS takes."""

from __future__ import annotations

import numpy as np

from .array import Array
from .compiled import MATRIX, VECTOR, compiled


@compiled(MATRIX, VECTOR)
def times(A: Array, x: Array) -> Array:
    """Return A x, shape (m,), of A (m, n) and x (n,)."""
    if A.shape[1] != len(x):
        raise ValueError("the shapes of a product do not fit")
    y = np.empty(A.shape[0])
    for i in range(A.shape[0]):
        entry = 0.0
        for j in range(A.shape[1]):
            entry += A[i, j] * x[j]
        y[i] = entry
    return y


@compiled(VECTOR, VECTOR)
def dot(x: Array, y: Array) -> float:
    """Return xᵀy of x and y (n,)."""
    if len(x) != len(y):
        raise ValueError("the shapes of a product do not fit")
    total = 0.0
    for i in range(len(x)):
        total += x[i] * y[i]
    return total


@compiled(VECTOR, MATRIX, VECTOR)
def add_times(y: Array, A: Array, x: Array) -> None:
    """Add A x to y, of A (m, n), x (n,) and y (m,)."""
    if A.shape[0] != len(y) or A.shape[1] != len(x):
        raise ValueError("the shapes of a product do not fit")
    for i in range(A.shape[0]):
        for j in range(A.shape[1]):
            y[i] += A[i, j] * x[j]


@compiled(MATRIX, MATRIX)
def product(A: Array, B: Array) -> Array:
    """Return A B, shape (m, k), of A (m, n) and B (n, k)."""
    if A.shape[1] != B.shape[0]:
        raise ValueError("the shapes of a product do not fit")
    C = np.zeros((A.shape[0], B.shape[1]))
    for i in range(A.shape[0]):
        for j in range(A.shape[1]):
            for k in range(B.shape[1]):
                C[i, k] += A[i, j] * B[j, k]
    return C


@compiled(MATRIX, MATRIX)
def product_with_transpose(A: Array, B: Array) -> Array:
    """Return A Bᵀ, shape (m, k), of A (m, n) and B (k, n)."""
    if A.shape[1] != B.shape[1]:
        raise ValueError("the shapes of a product do not fit")
    C = np.empty((A.shape[0], B.shape[0]))
    for i in range(A.shape[0]):
        for k in range(B.shape[0]):
            entry = 0.0
            for j in range(A.shape[1]):
                entry += A[i, j] * B[k, j]
            C[i, k] = entry
    return C


@compiled(MATRIX, MATRIX)
def transpose_times(A: Array, B: Array) -> Array:
    """Return Aᵀ B, shape (n, k), of A (m, n) and B (m, k)."""
    if A.shape[0] != B.shape[0]:
        raise ValueError("the shapes of a product do not fit")
    C = np.zeros((A.shape[1], B.shape[1]))
    for i in range(A.shape[0]):
        for j in range(A.shape[1]):
            for k in range(B.shape[1]):
                C[j, k] += A[i, j] * B[i, k]
    return C
