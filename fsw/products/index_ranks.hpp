// The running distribution of the richness indices of a flight.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace ilp {

/// Indices lie close together: a rank says how interesting an image is among those of its flight, where the index
/// itself cannot. The indices are counted in bins. When there are `most_images` of them all counts are halved, so that
/// ground seen long ago fades.
class IndexRanks {
 public:
  static constexpr std::size_t bins = 256;
  /// With fewer images every index ranks in the middle.
  static constexpr std::uint32_t fewest_images = 10;
  static constexpr std::uint32_t most_images = 4096;

  void add(double index);
  /// The share of the images with a lower index, those of the same bin counting half; 0 to 1.
  [[nodiscard]] double rank(double index) const;

 private:
  static std::size_t bin_of(double index);
  [[nodiscard]] std::uint32_t images() const;

  std::array<std::uint32_t, bins> counts_{};
};

}  // namespace ilp
