// One brightness and one contrast for the keyframes of an orthoimage.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "sim/ground/map/ground_grid.hpp"

namespace ilp::map {

/// The orthoimage shows gain * grey + offset of a keyframe's grey, in 0 to 255, and a ramp about the middle of what it
/// shows of the keyframe: ground is brighter from one side than from the other, and images are darker at their edges.
struct Balance {
  double gain = 1, offset = 0;
  std::array<double, 2> ramp{};          ///< grey for each ramp_cells of the map to the right, and down
  std::array<std::int64_t, 2> middle{};  ///< column and row of the world
  /// At the middle.
  [[nodiscard]] double of(double grey) const { return gain * grey + offset; }
  /// In a cell of the world.
  [[nodiscard]] double of(double grey, std::int64_t column, std::int64_t row) const {
    return of(grey) +
           (ramp[0] * static_cast<double>(column - middle[0]) + ramp[1] * static_cast<double>(row - middle[1])) /
               ramp_cells;
  }
  bool operator==(const Balance&) const = default;
  static constexpr double ramp_cells = 256;
};

/// Counts by grey value, rising; a few octets for each, because a map has thousands of histograms.
class GreyHistogram {
 public:
  using Entry = std::pair<std::uint8_t, std::uint32_t>;
  GreyHistogram() = default;
  /// Entries as entries() gave them, in any order.
  explicit GreyHistogram(const std::vector<Entry>& entries);
  void add(std::uint8_t grey, std::uint32_t number);
  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
  [[nodiscard]] std::uint64_t count() const;

 private:
  std::vector<Entry> entries_;
};

/// What two keyframes show of the ground that both show, or on both sides of their border.
struct SeamGreys {
  GreyHistogram first, second;
  std::int64_t columns = 0, rows = 0;  ///< sums over the cells of `second`
};

/// The key has both ids, the smaller one first.
using Seams = std::map<std::pair<std::int64_t, std::int64_t>, SeamGreys>;

/// What one keyframe shows of a cell of ground.
struct ShownCell {
  std::int64_t keyframe = 0;
  std::uint8_t grey = 0;
};

/// Adds a cell of ground that two keyframes show, unless one of them shows it black or white.
/// Column and row are those of the world.
void add_seam_cell(const ShownCell& a, const ShownCell& b, std::int64_t column, std::int64_t row, Seams& seams);

/// Adds neighbouring measured cells of two keyframes, the left or upper one in columns [margin, width - margin), and in
/// rows likewise; `keyframes` has the ids by source - 1.
void add_seams(const GroundGrid& grid, const std::vector<std::int64_t>& keyframes, std::int32_t margin, Seams& seams);

/// Mean and spread of grey.
struct GreyLevel {
  double mean = 0, spread = 0;
};

/// How two keyframes show the same ground, about a place of the world.
struct SeamLevels {
  std::int64_t first = 0, second = 0;  ///< ids
  double column = 0, row = 0;
  double cells = 0;  ///< less than they are, where there are many
  GreyLevel first_level, second_level;
};

/// Those of enough cells, without a twentieth of the darkest and of the brightest.
[[nodiscard]] std::vector<SeamLevels> seam_levels_of(const Seams& seams);

/// What the map shows of a keyframe, before the balance.
struct ShownPatch {
  std::uint64_t cells = 0;
  std::uint64_t grey = 0;              ///< sum over its cells
  std::int64_t columns = 0, rows = 0;  ///< of the world, sums over its cells
  std::uint64_t pairs = 0;             ///< of cells contrast_cells apart along a row or column
  std::uint64_t differences = 0;       ///< sum of their absolute differences
  void add(const ShownPatch& other);
};
inline constexpr std::int32_t contrast_cells = 8;

/// Adds the cells and pairs as add_seams does; `shown` is by source - 1.
void add_shown(const GroundGrid& grid, std::int32_t margin, std::vector<ShownPatch>& shown);

/// Gain, offset and ramp of each keyframe, by robust least squares over all seams: first contrasts, whose ratios are
/// those of the spreads of grey of both, then brightnesses and ramps. A weak pull takes contrast and mean of each patch
/// to those of the map, and its ramp to none. Seams alone err in one direction where images are darker or blurred at
/// one edge, and this adds up along a strip. The map is for the eye: real differences over many keyframes are made
/// smaller too. Gains lie within a factor of most_gain; ground of hardly any contrast, and a patch without a seam,
/// keep their contrast. Over all cells the mean logarithm of the gains is 0 and the mean grey what it was, in a
/// map of 100 keyframes and more to within a thirty-second and 4.
[[nodiscard]] std::map<std::int64_t, Balance> balance_patches(std::vector<SeamLevels> seams,
                                                              const std::map<std::int64_t, ShownPatch>& patches);
inline constexpr double most_gain = 4;

}  // namespace ilp::map
