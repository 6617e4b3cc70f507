// One brightness and one contrast for the pieces of a map.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "sim/ground/map/ground_grid.hpp"

namespace ilp::map {

/// The orthoimage shows gain * grey + offset of a keyframe's grey, in 0 to 255.
struct Balance {
  double gain = 1, offset = 0;
  [[nodiscard]] double of(double grey) const { return gain * grey + offset; }
  bool operator==(const Balance&) const = default;
};

/// Counts by grey value, rising; a few octets for each, because a map has thousands of histograms.
class GreyHistogram {
 public:
  using Entry = std::pair<std::uint8_t, std::uint32_t>;
  GreyHistogram() = default;
  /// Entries as entries() gave them, in any order.
  explicit GreyHistogram(const std::vector<Entry>& entries);
  void add(std::uint8_t grey, std::uint32_t number);
  void add(const GreyHistogram& other);
  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
  [[nodiscard]] std::uint64_t count() const;

 private:
  std::vector<Entry> entries_;
};

/// What two keyframes show of the ground where they meet.
struct SeamGreys {
  GreyHistogram first, second;
};

/// The key has both ids, the smaller one first.
using Seams = std::map<std::pair<std::int64_t, std::int64_t>, SeamGreys>;

/// Adds a piece of ground that two keyframes show, unless one of them shows it black or white.
void add_meeting(std::int64_t id_a, std::uint8_t grey_a, std::int64_t id_b, std::uint8_t grey_b, Seams& seams);

/// Adds neighbouring measured cells of two keyframes, the left or upper one in columns [margin, width - margin), and in
/// rows likewise; `keyframes` has the ids by source - 1.
void add_seams(const GroundGrid& grid, const std::vector<std::int64_t>& keyframes, std::int32_t margin, Seams& seams);

/// What the map shows of a keyframe, before the balance.
struct ShownPatch {
  std::uint64_t cells = 0;
  std::uint64_t grey = 0;         ///< sum over its cells
  std::uint64_t pairs = 0;        ///< of cells contrast_cells apart along a row or column
  std::uint64_t differences = 0;  ///< sum of their absolute differences
  void add(const ShownPatch& other);
};
inline constexpr std::int32_t contrast_cells = 8;

/// Adds the cells and pairs as add_seams does; `shown` is by source - 1.
void add_shown(const GroundGrid& grid, std::int32_t margin, std::vector<ShownPatch>& shown);

/// Gain and offset of each keyframe, by robust least squares over all seams: first contrasts, whose ratios are those of
/// the spreads of grey on both sides of a seam, then brightnesses. A weak pull takes contrast and mean of each piece to
/// those of the map. Seams alone err in one direction where images are darker or blurred at one edge, and this adds up
/// along a strip. The map is for the eye: real differences over many keyframes are made smaller too. Gains lie within a
/// factor of most_gain; ground of hardly any contrast, and a piece that meets no other one, keep their contrast. Over
/// all cells the mean logarithm of the gains is 0 and the mean grey what it was, in a map of 100 keyframes and more to
/// within a thirty-second and 4.
[[nodiscard]] std::map<std::int64_t, Balance> balance_patches(const Seams& seams,
                                                              const std::map<std::int64_t, ShownPatch>& patches);
inline constexpr double most_gain = 4;

}  // namespace ilp::map
