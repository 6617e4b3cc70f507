// Against Eigen, to the last bit: the results of a flight must not depend on which of the two solves the equations.

#include "fsw/vision/geometry/symmetric_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cstring>

#include "fsw/base/rng.hpp"

namespace ilp {
namespace {

/// J^T J of random `rows` x N, so that fewer rows than unknowns leave it singular; and entries of many magnitudes.
template <int N>
void expect_same_bits_as_eigen(std::uint64_t seed) {
  Rng rng(seed);
  for (int trial = 0; trial < 3000; ++trial) {
    const int rows = 1 + static_cast<int>(rng.below(2 * N));
    Eigen::Matrix<double, N, N> a = Eigen::Matrix<double, N, N>::Zero();
    for (int r = 0; r < rows; ++r) {
      Eigen::Matrix<double, N, 1> row;
      for (int i = 0; i < N; ++i) row[i] = (rng.uniform() - 0.5) * (i % 3 == 0 ? 1000 : 1);
      a += (trial % 7 == 0 && r % 2 == 1 ? -1 : 1) * row * row.transpose();
    }
    if (trial % 11 == 0) a.row(N - 1).setZero(), a.col(N - 1).setZero();
    if (trial % 997 == 0) a.setZero();
    Eigen::Matrix<double, N, 1> b;
    for (int i = 0; i < N; ++i) b[i] = rng.uniform() - 0.5;
    const Eigen::Matrix<double, N, 1> reference = a.ldlt().solve(b);
    const Eigen::Matrix<double, N, 1> x = solve_symmetric<N>(a, b);
    ASSERT_EQ(std::memcmp(x.data(), reference.data(), N * sizeof(double)), 0)
        << "size " << N << ", trial " << trial << "\n"
        << a << "\n"
        << b.transpose() << "\n"
        << (x - reference).transpose();
  }
}

TEST(SymmetricSolver, GivesTheSameBitsAsEigen) {
  expect_same_bits_as_eigen<3>(1);
  // Its sums have every length, and Eigen takes another product for it than for smaller ones.
  expect_same_bits_as_eigen<8>(6);
}

}  // namespace
}  // namespace ilp
