// The distribution of the richness indices of a flight so far.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace ilp {

/// The indices of a flight may differ little; a rank shows how interesting an image is compared with the others.
/// Indices are counted in bins. When their number reaches `most_images`, all counts are halved, so that old indices
/// lose weight.
class IndexRanks {
 public:
  static constexpr std::size_t bins = 256;
  /// With fewer images every rank is 0.5.
  static constexpr std::uint32_t fewest_images = 10;
  static constexpr std::uint32_t most_images = 4096;

  void add(double index);
  /// The share of images with a lower index, 0 to 1. Images in the same bin count half.
  [[nodiscard]] double rank(double index) const;

 private:
  static std::size_t bin_of(double index);
  [[nodiscard]] std::uint32_t images() const;

  std::array<std::uint32_t, bins> counts_{};
};

}  // namespace ilp
