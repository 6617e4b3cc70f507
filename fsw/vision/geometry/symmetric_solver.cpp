#include "fsw/vision/geometry/symmetric_solver.hpp"

#include <Eigen/Cholesky>

namespace ilp {

template <int N>
Eigen::Matrix<double, N, 1> solve_symmetric(const Eigen::Matrix<double, N, N>& a,
                                            const Eigen::Matrix<double, N, 1>& b) {
  return a.ldlt().solve(b);
}

template <int N>
Eigen::Matrix<double, N, N> inverse_of_symmetric(const Eigen::Matrix<double, N, N>& a) {
  const auto factors = a.ldlt();
  Eigen::Matrix<double, N, N> inverse;
  for (int k = 0; k < N; ++k) inverse.col(k) = factors.solve(Eigen::Matrix<double, N, 1>::Unit(k));
  return inverse;
}

template Eigen::Matrix<double, 7, 7> inverse_of_symmetric<7>(const Eigen::Matrix<double, 7, 7>&);
template Eigen::Matrix<double, 3, 1> solve_symmetric<3>(const Eigen::Matrix<double, 3, 3>&,
                                                        const Eigen::Matrix<double, 3, 1>&);
template Eigen::Matrix<double, 5, 1> solve_symmetric<5>(const Eigen::Matrix<double, 5, 5>&,
                                                        const Eigen::Matrix<double, 5, 1>&);
template Eigen::Matrix<double, 6, 1> solve_symmetric<6>(const Eigen::Matrix<double, 6, 6>&,
                                                        const Eigen::Matrix<double, 6, 1>&);
template Eigen::Matrix<double, 7, 1> solve_symmetric<7>(const Eigen::Matrix<double, 7, 7>&,
                                                        const Eigen::Matrix<double, 7, 1>&);
template Eigen::Matrix<double, 8, 1> solve_symmetric<8>(const Eigen::Matrix<double, 8, 8>&,
                                                        const Eigen::Matrix<double, 8, 1>&);

}  // namespace ilp
