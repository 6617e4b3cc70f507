// Symmetric positive definite equations of many cameras with six unknowns each, of which few pairs have anything in
// common.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ilp::model {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// By camera, others of which a point or a prior relates it to; one direction is enough, and repetitions do no harm.
using RelatedCameras = std::vector<std::vector<std::uint32_t>>;

/// A block of equations; the mirror image belongs to it.
struct CameraBlock {
  std::uint32_t row = 0, column = 0;  ///< cameras
  Mat6 block;
};

/// Cholesky factors by blocks, the columns in the order in which each fills fewest blocks that were empty (T. Davis,
/// "Direct Methods for Sparse Linear Systems", 4 and 7). The same equations have the same bits of solution.
class CameraSystem {
 public:
  explicit CameraSystem(const RelatedCameras& related);

  void clear();
  /// Adds to the block of row camera `a` and column camera `b`, which must be related or the same, and to its mirror
  /// image. A block of one camera must be symmetric.
  void add(std::uint32_t a, std::uint32_t b, const Mat6& block);
  /// All that was added, but for blocks of zeros. Of two cameras either one is the row.
  [[nodiscard]] std::vector<CameraBlock> blocks() const;
  /// The unknown has no effect and becomes what its right side is.
  void hold(std::uint32_t camera, int unknown);

  /// False where the equations are not positive definite. Afterwards only solve() and inverse_diagonal() have a
  /// meaning.
  [[nodiscard]] bool factor();
  /// Of 6 x 6 numbers, in the lower triangle of the factors: what factor() has to compute.
  [[nodiscard]] std::size_t factor_blocks() const { return rows_.size(); }
  /// In place, by camera.
  void solve(std::vector<Vec6>& right) const;
  /// By camera, its block of the inverse (K. Takahashi et al. 1973): only blocks that the factors have are computed.
  [[nodiscard]] std::vector<Mat6> inverse_diagonal() const;

 private:
  struct Update {
    std::uint32_t column = 0;
    std::size_t at = 0;  ///< of the block in the row in question
  };
  [[nodiscard]] std::size_t find(std::uint32_t row, std::uint32_t column) const;
  void update_column(std::uint32_t column, std::vector<std::size_t>& place);
  [[nodiscard]] bool finish_column(std::uint32_t column);
  void invert_column(std::uint32_t column, std::vector<Mat6>& inverse) const;

  // Cameras stand for their numbers in the order of elimination.
  std::vector<std::uint32_t> order_;       ///< by camera
  std::vector<std::size_t> first_;         ///< by column, and the end
  std::vector<std::uint32_t> rows_;        ///< of each column, ascending, its own first
  std::vector<Mat6> blocks_;               ///< likewise; the lower triangle
  std::vector<std::vector<Update>> left_;  ///< by row, the blocks of it in earlier columns
};

}  // namespace ilp::model
