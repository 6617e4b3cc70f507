// Gauss-Newton registration of two images of one size under a similarity, a gain and an offset.
//
// Inverse compositional (S. Baker, I. Matthews, "Lucas-Kanade 20 years on", IJCV 2004): the gradients are those of
// image a, computed once. Grey values are summed over small blocks in exact integers; only the sums of the blocks are
// added in floating point.
#pragma once

#include <array>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/result.hpp"
#include "fsw/vision/overlap/centred_similarity.hpp"

namespace ilp {

inline constexpr std::int32_t registration_max_side = 256;  ///< px, of both images
inline constexpr std::int32_t registration_block_px = 8;    ///< of images up to half of that side, half of it

struct RegistrationTemplate {
  static constexpr std::size_t max_pixels =
      static_cast<std::size_t>(registration_max_side) * static_cast<std::size_t>(registration_max_side);
  static constexpr std::size_t max_blocks = max_pixels / (std::size_t{registration_block_px} * registration_block_px);

  /// Sums over one block of a; gradients are central differences without the division by 2.
  struct Block {
    float x, y;  ///< centre, from the image's centre
    std::int32_t gxx, gxy, gyy, gx, gy, gxa, gya, a, aa;
  };
  /// What blocks add to the normal equations of a similarity, whatever image b is. All are whole numbers of sixteenths
  /// below 2^53, so that sums are exact in any order.
  struct SimilarityTerms {
    double step[10];   ///< lower triangle of the four unknowns of the step, row by row
    double gain[4];    ///< of the gain and the step
    double offset[4];  ///< of the offset and the step
    double a, aa;      ///< sums of a and a^2
    double detail_aa;  ///< with the block's mean removed
  };
  static constexpr std::int32_t max_columns = registration_max_side / registration_block_px;

  std::int32_t width = 0, height = 0;
  std::int32_t block_px = 0;
  std::int32_t block_columns = 0, block_rows = 0;
  std::array<Block, max_blocks> blocks;
  /// For every row of blocks, one after the other: sums over the blocks left of each, and at its end over all of them.
  std::array<SimilarityTerms, max_blocks> similarity_sums;
  // Stored block by block, so that a block is contiguous in memory.
  std::array<std::int16_t, max_pixels> value, gradient_x, gradient_y;
};

/// Image b with each pixel in one word with its neighbours, so that a sample is one load: from the lowest byte on
/// itself, the right one, the lower one, and the one below that to the right. The last column and row have none.
class RegistrationImage {
 public:
  /// StatusCode::image_too_large beyond registration_max_side.
  Status build(GrayView image);

  [[nodiscard]] std::int32_t width() const { return width_; }
  [[nodiscard]] std::int32_t height() const { return height_; }
  [[nodiscard]] const std::uint32_t* quads() const { return quads_.data(); }  ///< rows of width()

 private:
  std::int32_t width_ = 0, height_ = 0;
  std::array<std::uint32_t, RegistrationTemplate::max_pixels> quads_;
};

/// Projective mapping between the centred coordinates of two images; h[8] = 1.
struct CentredProjectivity {
  double h[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row-major

  CentredProjectivity() = default;
  explicit CentredProjectivity(const CentredSimilarity& s)
      : h{s.m_re, -s.m_im, s.d_x, s.m_im, s.m_re, s.d_y, 0, 0, 1} {}

  void apply(double x, double y, double& out_x, double& out_y) const {
    const double w = h[6] * x + h[7] * y + h[8];
    out_x = (h[0] * x + h[1] * y + h[2]) / w;
    out_y = (h[3] * x + h[4] * y + h[5]) / w;
  }
};

/// How well image a, mapped, agrees with image b.
struct RegistrationFit {
  static constexpr std::int32_t region_columns = 4;
  static constexpr std::size_t max_regions = static_cast<std::size_t>(region_columns) * region_columns;

  double ncc = 0;  ///< over the blocks of a that b covers
  double detail_ncc =
      0;  ///< the same with the mean of every block removed from both: blind to shading, needs detail to agree
  double covered = 0;   ///< share of a's blocks
  double sigma_px = 0;  ///< one-sigma error of the shift from the residuals, px of this level
  bool converged = false;
  /// Parts of image a, 4 x 4, of which b covers at least half.
  struct Region {
    double ncc;       ///< as detail_ncc
    double contrast;  ///< share of all detail per block, in the image that has more of it
  };
  std::size_t region_count = 0;
  Region regions[max_regions] = {};
};

Status prepare_registration(GrayView a, RegistrationTemplate& out);

/// A step that refines `b_from_a` in place: `fit` says how well it agrees before the step. `wanted` is false if no step
/// may follow. Whether there was a step and more may follow; a search that does not converge is no error: see
/// RegistrationFit::converged.
Result<bool> step_similarity(const RegistrationTemplate& a, const RegistrationImage& b, bool wanted,
                             CentredSimilarity& b_from_a, RegistrationFit& fit);
/// At most `max_iterations` steps with all eight degrees of freedom of a plane in two views.
Status register_projectivity(const RegistrationTemplate& a, const RegistrationImage& b, int max_iterations,
                             CentredProjectivity& b_from_a, RegistrationFit& fit);

}  // namespace ilp
