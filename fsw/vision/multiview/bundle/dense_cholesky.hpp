// Cholesky factorisation of a small dense symmetric matrix whose size is known at run time.
#pragma once

#include <cstddef>

namespace ilp {

/// Replaces the lower triangle of the row-major n x n matrix `a` (row stride n) by L, A = L L^T. Returns false if A is
/// not positive definite to working precision, or not finite.
[[nodiscard]] bool cholesky_factor(double* a, std::size_t n);
/// cholesky_solve_lower: x <- L^-1 x. cholesky_solve_upper: x <- L^-T x. `l` is the result of cholesky_factor.
void cholesky_solve_lower(const double* l, std::size_t n, double* x);
void cholesky_solve_upper(const double* l, std::size_t n, double* x);
/// x <- (L L^T)^-1 x: both.
void cholesky_solve(const double* l, std::size_t n, double* x);

}  // namespace ilp
