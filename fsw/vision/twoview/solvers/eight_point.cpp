#include "fsw/vision/twoview/solvers/eight_point.hpp"

#include "fsw/vision/twoview/solvers/homogeneous_system.hpp"
#include "fsw/vision/twoview/solvers/singular_values.hpp"

namespace ilp {

bool eight_point(const NormalisedPairs& pairs, const PairSelection& selection, Mat3& fundamental) {
  if (selection.count < 8) return false;
  HomogeneousSystem system;
  for (std::size_t i = 0; i < selection.count; ++i) {
    const NormalisedPair& p = pairs.exact[selection.indices[i]];
    system.add({p.xb * p.xa, p.xb * p.ya, p.xb, p.yb * p.xa, p.yb * p.ya, p.yb, p.xa, p.ya, 1});
  }
  Mat3 f;
  if (!system.solve(f)) return false;
  SingularValues svd;
  if (!singular_values(f, svd)) return false;
  svd.values[2] = 0;
  fundamental = svd.u * svd.values.asDiagonal() * svd.v.transpose();
  return true;
}

}  // namespace ilp
