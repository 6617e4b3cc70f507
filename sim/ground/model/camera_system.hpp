// A sparse Cholesky solver for symmetric positive definite equations of many cameras with six unknowns each. A block of
// 6 x 6 numbers relates two cameras, and few pairs of cameras have one.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ilp::model {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// For each camera, the cameras that it has a block with. One direction is enough, and repetitions are allowed.
using RelatedCameras = std::vector<std::vector<std::uint32_t>>;

/// A block of the equations. The equations also have its transpose at (column, row).
struct CameraBlock {
  std::uint32_t row = 0, column = 0;  ///< indices of cameras
  Mat6 block;
};

/// Block Cholesky factorisation. The elimination order chooses next the camera that fills the fewest empty blocks (T.
/// Davis, "Direct Methods for Sparse Linear Systems", 4 and 7). Equal equations have bitwise equal solutions.
class CameraSystem {
 public:
  explicit CameraSystem(const RelatedCameras& related);

  void clear();
  /// Adds to the block of row `a` and column `b`, and to its transpose. The cameras must be related or equal. For equal
  /// cameras `block` must be symmetric.
  void add(std::uint32_t a, std::uint32_t b, const Mat6& block);
  /// The sums of the added blocks, without zero blocks. Each pair of cameras occurs once, in either order.
  [[nodiscard]] std::vector<CameraBlock> blocks() const;
  /// Decouples an unknown (0 to 5) of a camera from the others: its solution is its right side.
  void hold(std::uint32_t camera, int unknown);

  /// Computes the factors. Returns false if the equations are not positive definite. Afterwards only solve() and
  /// inverse_diagonal() may be called, until clear().
  [[nodiscard]] bool factor();
  /// Number of 6 x 6 blocks in the lower triangle of the factors: the size of factor()'s work.
  [[nodiscard]] std::size_t factor_blocks() const { return rows_.size(); }
  /// Replaces the right sides, one of each camera, by the solution.
  void solve(std::vector<Vec6>& right) const;
  /// The diagonal block of the inverse for each camera (K. Takahashi et al. 1973). Computes only blocks of the inverse
  /// where the factors have one.
  [[nodiscard]] std::vector<Mat6> inverse_diagonal() const;

 private:
  struct Update {
    std::uint32_t column = 0;
    std::size_t at = 0;  ///< index in blocks_ of the row's block in this column
  };
  [[nodiscard]] std::size_t find(std::uint32_t row, std::uint32_t column) const;
  void update_column(std::uint32_t column, std::vector<std::size_t>& place);
  [[nodiscard]] bool finish_column(std::uint32_t column);
  void invert_column(std::uint32_t column, std::vector<Mat6>& inverse) const;

  // Rows and columns are positions of cameras in the elimination order.
  std::vector<std::uint32_t> order_;       ///< position of each camera
  std::vector<std::size_t> first_;         ///< for each column, its first index in rows_ and blocks_; and the end
  std::vector<std::uint32_t> rows_;        ///< rows of each column's blocks, ascending from the diagonal
  std::vector<Mat6> blocks_;               ///< the lower triangle, in the order of rows_
  std::vector<std::vector<Update>> left_;  ///< for each row, its blocks in earlier columns
};

}  // namespace ilp::model
