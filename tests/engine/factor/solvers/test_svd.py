"""Every method reaches the optimum of Eckart and Young, also where the paper's power iteration does not."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.factor.solvers import svd as decompose
from engine.factor.solvers.svd import (
    ASYMMETRY,
    Decomposition,
    Method,
    asymmetry,
    condition_number,
    power,
    svd,
    symmetric,
)

U = 2.0**-53


def orthogonal(size: int, seed: int = 0) -> np.ndarray:
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(size, size)))[0]


def with_eigenvalues(values: list[float], size: int = 40, seed: int = 0) -> np.ndarray:
    q = orthogonal(size, seed)[:, : len(values)]
    matrix = (q * values) @ q.T
    return 0.5 * (matrix + matrix.T)


def with_singular_values(values: list[float], size: int = 40) -> np.ndarray:
    return (orthogonal(size, 1)[:, : len(values)] * values) @ orthogonal(size, 2)[:, : len(values)].T


def residual(matrix: np.ndarray, found: Decomposition, terms: int | None = None) -> float:
    left, value, right = found.left[:, :terms], found.value[:terms], found.right[:, :terms]
    return float(np.linalg.norm(matrix - (left * value) @ right.T))


def assert_optimal(matrix: np.ndarray, method: Method, terms: int) -> Decomposition:
    """Eckart and Young's optimum to 1e-6 for every number of terms, and orthonormal vectors."""
    found = method(matrix, terms, 1)
    sigma = np.linalg.svd(matrix, compute_uv=False)
    norm = float(np.linalg.norm(matrix))
    rounding = 64 * max(matrix.shape) * U * norm
    assert found.converged
    best = float(np.sqrt((sigma[terms:] ** 2).sum()))
    assert residual(matrix, found) <= (1.0 + 1e-6) * best + rounding
    errors = [residual(matrix, found, count) for count in range(terms + 1)]
    for before, after in itertools.pairwise(errors):
        assert after <= before * (1.0 + 4.0 * U) + rounding
    for vectors in (found.left, found.right):
        kept = vectors[:, : found.rank]
        assert np.abs(kept.T @ kept - np.eye(found.rank)).max(initial=0.0) <= 1e-10
    assert np.isfinite(found.left).all()
    return found


BOTH = pytest.mark.parametrize("method", [symmetric, svd, power])
ANY = pytest.mark.parametrize("method", [svd, power])


@BOTH
def test_W1_the_zero_matrix_has_zero_terms(method: Method) -> None:
    found = method(np.zeros((9, 9)), 4, 1)
    assert found.value.tolist() == [0.0] * 4
    assert not found.left.any()
    assert (found.rank, found.iterations, found.converged) == (0, 1, True)


@BOTH
@pytest.mark.parametrize("size", [8, 300])
def test_W2_a_matrix_of_rank_1_has_one_term(method: Method, size: int) -> None:
    found = assert_optimal(with_eigenvalues([3.0], size), method, 4)
    assert found.rank == 1
    assert found.value[0] == pytest.approx(3.0, rel=1e-12)


SPECTRA = {
    "W3 equal": [1.0, 1.0, 1.0, 1.0, 0.3, 0.3, 0.1],
    "W3 equal at the cut": [1.0, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5],
    "W4 opposite": [1.0, -1.0, 0.1, 0.05, 0.01],
    "W4 nearly opposite": [1.0, -0.999999, 0.5, 0.1, 0.05],
    "W5 gap of 1e-6": [1.0, 1.0 - 1e-6, 0.5, 0.5 - 1e-6, 0.5 - 2e-6, 0.4],
    "clustered": [1.0 + 1e-8 * k for k in range(20)] + [0.9] * 10 + [1e-3] * 5,
    "steep": [10.0**-k for k in range(16)],
    "flat": [(-1.0) ** k * (1.0 - 0.01 * k) for k in range(35)],
}


@BOTH
@pytest.mark.parametrize("name", SPECTRA)
@pytest.mark.parametrize("size", [40, 250])
def test_W3_W4_W5_W8_W13_eigenvalues_that_crowd_together(method: Method, name: str, size: int) -> None:
    assert_optimal(with_eigenvalues(SPECTRA[name], size), method, 4)


@pytest.mark.campaign(rounds=20)
@pytest.mark.parametrize("method", [symmetric, svd])
def test_equal_leading_values_however_small_their_gaps(method: Method, seed: int) -> None:
    """LAPACK's full decomposition is the judge; ARPACK was kept busy for ever by some of these."""
    draw = np.random.default_rng(seed)
    for _ in range(4):
        size, equal, gap = int(draw.integers(201, 420)), int(draw.integers(2, 17)), 10.0 ** -draw.uniform(3.0, 15.0)
        values = [*(1.0 - gap * np.arange(equal)), *(draw.uniform(0.3, 0.9) * 0.97 ** np.arange(150))]
        matrix = with_eigenvalues(values, size, int(draw.integers(1000)))
        terms = int(draw.integers(1, 9))
        found = assert_optimal(matrix, method, terms)
        left, sigma, right = np.linalg.svd(matrix)
        assert found.value == pytest.approx(sigma[:terms], rel=1e-8)
        cluster = max(equal, terms)
        for vectors, exact in ((found.left, left), (found.right, right.T)):
            outside = vectors - exact[:, :cluster] @ (exact[:, :cluster].T @ vectors)
            assert np.abs(outside).max() <= 1e-4, (size, equal, gap, terms)


@pytest.mark.parametrize("shape", [(260, 260), (260, 230), (230, 260)])
def test_more_equal_values_than_a_block_is_wide_are_left_to_lapack(
    monkeypatch: pytest.MonkeyPatch, shape: tuple[int, int]
) -> None:
    monkeypatch.setattr(decompose, "MAX_SPACES", 1)
    matrix = with_singular_values([1.0 - 1e-6 * k for k in range(220)], 260)[: shape[0], : shape[1]]
    assert_optimal(matrix, svd, 4)
    monkeypatch.setattr(decompose, "MAX_DENSE", 200)
    found = svd(matrix, 4)
    assert found.iterations <= decompose.MAX_ITERATIONS
    assert np.isfinite(found.left).all()


@pytest.mark.parametrize(("size", "terms"), [(220, 4), (260, 6)])
def test_more_equal_and_opposite_values_than_a_block_is_wide(size: int, terms: int) -> None:
    """A block within the cluster of MᵀM mixes eigenvectors of 1 and of −1: its Ritz values are anything between."""
    draw = np.random.default_rng(size)
    values = [*draw.choice([-1.0, 1.0], 36) * (1.0 + 1e-14 * draw.normal(size=36)), *(0.5 * 0.9 ** np.arange(100))]
    found = assert_optimal(with_eigenvalues(values, size), symmetric, terms)
    assert found.converged
    assert found.value == pytest.approx(np.ones(terms), rel=1e-9)


def test_W8_sixteen_terms_stay_orthonormal() -> None:
    values = [0.9**k * (-1) ** k for k in range(60)]
    for method in (symmetric, svd, power):
        assert_optimal(with_eigenvalues(values, 260), method, 16)


@BOTH
def test_X1_singular_values_are_the_absolute_eigenvalues(method: Method) -> None:
    found = method(with_eigenvalues([2.0, -1.5, 0.5], 3), 3, 1)
    assert found.value == pytest.approx([2.0, 1.5, 0.5], rel=1e-12)


@BOTH
def test_X2_the_papers_iteration_fails_where_ours_does_not(method: Method) -> None:
    matrix = with_eigenvalues([1.0, -1.0, 0.1, 0.05, 0.01], 5)
    rest, start = matrix.copy(), np.random.default_rng(0).normal(size=5)
    before = np.inf
    for _ in range(1000):
        start = rest @ start
        start /= np.linalg.norm(start)
        quotient = start @ rest @ start
        if abs(quotient - before) <= 1e-6:
            break
        before = quotient
    assert abs(abs(quotient) - 1.0) > 0.01, "one vector, watched by its Rayleigh quotient, stops anywhere"
    found = assert_optimal(matrix, method, 4)
    assert found.value[:2] == pytest.approx([1.0, 1.0], rel=1e-12)


@ANY
@pytest.mark.parametrize("size", [(30, 30), (250, 220), (60, 300)])
def test_W6_asymmetric_matrices(method: Method, size: tuple[int, int]) -> None:
    assert_optimal(np.random.default_rng(4).normal(size=size), method, 6)
    smaller = min(size)
    matrix = with_singular_values([1.0, 1.0, 1.0 - 1e-6, 0.3, 0.3, 0.3, 0.1, 0.05], max(size))[: size[0], : size[1]]
    assert smaller >= 30
    assert_optimal(matrix, method, 4)


@ANY
@pytest.mark.parametrize("size", [8, 250])
def test_W7_X3_nilpotent_matrices(method: Method, size: int) -> None:
    """The power iteration on M itself removes nothing from these matrices."""
    assert_optimal(np.triu(np.ones((size, size)), 1), method, 4)
    assert_optimal(np.eye(size, k=1), method, 4)


def test_X3_asymmetry_is_measured_and_gates_the_symmetric_method() -> None:
    matrix = with_eigenvalues([1.0, 0.5, 0.2], 20)
    assert asymmetry(matrix) == 0.0
    assert asymmetry(np.triu(np.ones((8, 8)), 1)) == pytest.approx(np.sqrt(2.0))
    assert asymmetry(np.zeros((4, 4))) == 0.0
    assert asymmetry(np.ones((3, 4))) == np.inf
    matrix[0, 1] += 1e-9
    assert asymmetry(matrix) > ASYMMETRY
    with pytest.raises(ValueError, match="not symmetric"):
        symmetric(matrix, 2)


def test_W9_a_start_orthogonal_to_the_first_vector_finds_it_all_the_same() -> None:
    matrix = np.diag([5.0, 1.0, 0.5, *[0.1] * 30])
    start = np.eye(33)[:, 1:2]
    found = power(matrix, 1, start=start)
    assert found.value[0] == pytest.approx(5.0, rel=1e-12)


@BOTH
@pytest.mark.parametrize("size", [30, 240])
def test_W10_the_scale_does_not_matter(method: Method, size: int) -> None:
    matrix = with_eigenvalues([1.0, -0.7, 0.5, 0.2, 0.1, 0.05], size)
    found = method(matrix, 3, 1)
    for exponent in (-99, 7, 100):
        scaled = method(np.ldexp(matrix, exponent), 3, 1)
        assert np.array_equal(scaled.value, np.ldexp(found.value, exponent))
        assert np.array_equal(scaled.right, found.right)
        assert np.array_equal(scaled.left, found.left)
    for factor in (1e-30, 1e30):
        assert method(matrix * factor, 3, 1).value == pytest.approx(found.value * factor, rel=1e-12)


@BOTH
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_W11_entries_that_are_no_numbers_are_named(method: Method, bad: float) -> None:
    matrix = np.ones((6, 6))
    matrix[2, 3] = bad
    with pytest.raises(ValueError, match="row 2, column 3"):
        method(matrix, 2, 1)


def test_W12_a_cap_gives_the_best_so_far_and_says_so() -> None:
    matrix = with_eigenvalues([1.0 - 1e-3 * k for k in range(200)], 260)
    found = power(matrix, 4, max_iterations=3)
    assert not found.converged
    assert found.iterations == 3
    assert residual(matrix, found) < np.linalg.norm(matrix)


@BOTH
def test_W14_left_and_right_vectors_of_a_symmetric_matrix_differ_by_sign(method: Method) -> None:
    matrix = with_eigenvalues([2.0, -1.5, 0.5, -0.1], 30)
    found = method(matrix, 4, 1)
    for k, sign in enumerate((1, -1, 1, -1)):
        assert np.abs(found.left[:, k] - sign * found.right[:, k]).max() <= 1e-12
    assert residual(matrix, found) <= 1e-14 * 30


def test_W16_the_same_bits_on_one_thread_and_on_two(tmp_path: Path) -> None:
    program = (
        "import hashlib, numpy as np\n"
        "from engine.factor.solvers.svd import power, svd, symmetric\n"
        "a = np.random.default_rng(3).normal(size=(450, 450)); a = a + a.T\n"
        "for method in (symmetric, svd, power):\n"
        "    found = method(a * 0.97 ** np.arange(450) * 0.97 ** np.arange(450)[:, None], 8, 1)\n"
        "    print(hashlib.sha256(found.left.tobytes() + found.value.tobytes()).hexdigest())\n"
    )
    outputs = []
    for threads in "12":
        names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
        environment = os.environ | dict.fromkeys(names, threads)
        root = Path(__file__).resolve().parents[4]
        command = [sys.executable, "-c", program]
        outputs.append(subprocess.run(command, env=environment, cwd=root, capture_output=True, check=True).stdout)
    assert outputs[0] == outputs[1]
    assert len(outputs[0].split()) == 3


@given(
    values=st.lists(st.floats(-1.0, 1.0).map(lambda x: round(x, 2)), min_size=1, max_size=12),
    terms=st.integers(1, 6),
    seed=st.integers(0, 100),
)
def test_any_spectrum_is_cut_at_its_optimum(values: list[float], terms: int, seed: int) -> None:
    matrix = with_eigenvalues(values, 16, seed)
    for method in (symmetric, svd, power):
        assert_optimal(matrix, method, terms)


def test_the_condition_number_is_that_of_the_terms_that_are_kept() -> None:
    assert condition_number(np.array([4.0, 2.0, 0.5, 0.0])) == 8.0
    assert condition_number(np.zeros(3)) == 1.0
