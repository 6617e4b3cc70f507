// Gauss-Newton registration of two images of the same size: estimates a similarity or a projectivity, a gain and an
// offset.
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
inline constexpr std::int32_t registration_block_px = 8;    ///< side of a block; half of it for sides up to 128 px

struct RegistrationTemplate {
  static constexpr std::size_t max_pixels =
      static_cast<std::size_t>(registration_max_side) * static_cast<std::size_t>(registration_max_side);
  static constexpr std::size_t max_blocks = max_pixels / (std::size_t{registration_block_px} * registration_block_px);

  /// Sums over one block of a; gradients are central differences without the division by 2.
  struct Block {
    float x, y;  ///< centre, px from the image's centre
    std::int32_t gxx, gxy, gyy, gx, gy, gxa, gya, a, aa;
  };
  /// The terms of the normal equations of a similarity that depend on image a alone. All are multiples of 1/16 below
  /// 2^53, so that sums are exact in any order.
  struct SimilarityTerms {
    double step[10];   ///< lower triangle of the four unknowns of the step, row by row
    double gain[4];    ///< products of the gain and the step
    double offset[4];  ///< products of the offset and the step
    double a, aa;      ///< sums of a and a^2
    double detail_aa;  ///< sum of a^2 after the mean of each block is removed
  };
  static constexpr std::int32_t max_columns = registration_max_side / registration_block_px;

  std::int32_t width = 0, height = 0;
  std::int32_t block_px = 0;
  std::int32_t block_columns = 0, block_rows = 0;
  std::array<Block, max_blocks> blocks;
  /// Running sums along each row of blocks: entry k of a row has the sum of its first k blocks.
  std::array<SimilarityTerms, max_blocks> similarity_sums;
  // Stored block by block, so that a block is contiguous in memory.
  std::array<std::int16_t, max_pixels> value, gradient_x, gradient_y;
};

/// Image b with each 2 x 2 pixels in one word, so that a bilinear sample is one load. From the lowest byte: the pixel,
/// its right neighbour, its lower neighbour, and its lower right neighbour. The words of the last column and row are
/// not written.
class RegistrationImage {
 public:
  /// Returns `image_too_large` if a side is above registration_max_side.
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

/// Agreement of the mapped image a with image b.
struct RegistrationFit {
  static constexpr std::int32_t region_columns = 4;
  static constexpr std::size_t max_regions = static_cast<std::size_t>(region_columns) * region_columns;

  double ncc = 0;  ///< over the blocks of a that b covers
  double detail_ncc =
      0;  ///< the same after the mean of every block is removed from both images: independent of shading, needs detail
  double covered = 0;   ///< share of a's blocks that b covers
  double sigma_px = 0;  ///< standard deviation of the shift, from the residuals, px of this level
  bool converged = false;
  /// One of the 4 x 4 parts of image a; only those of which b covers at least half are listed.
  struct Region {
    double ncc;       ///< as detail_ncc
    double contrast;  ///< share of the image's detail per block, in the image where it is larger
  };
  std::size_t region_count = 0;
  Region regions[max_regions] = {};
};

/// Returns `image_too_large` if a side is above registration_max_side.
Status prepare_registration(GrayView a, RegistrationTemplate& out);

/// Computes `fit` for `b_from_a`, then refines `b_from_a` by one step. With `wanted` false it computes `fit` only.
/// Returns true if there was a step and more may follow; `image_size_changed` if the sizes of a and b differ. A
/// registration that does not converge is no error: see RegistrationFit::converged.
Result<bool> step_similarity(const RegistrationTemplate& a, const RegistrationImage& b, bool wanted,
                             CentredSimilarity& b_from_a, RegistrationFit& fit);
/// Refines a projectivity (the eight parameters of a plane in two views) in at most `max_iterations` steps.
Status register_projectivity(const RegistrationTemplate& a, const RegistrationImage& b, int max_iterations,
                             CentredProjectivity& b_from_a, RegistrationFit& fit);

}  // namespace ilp
