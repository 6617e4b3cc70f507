// Equalises brightness and contrast of the keyframes in an orthoimage.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "sim/ground/map/ground_grid.hpp"

namespace ilp::map {

/// The correction of one keyframe's grey values in the orthoimage: gain * grey + offset + ramp, clamped to 0 to 255.
/// The ramp is linear in column and row and is 0 in the middle of the keyframe's patch. It removes what depends on the
/// position in the image: ground is brighter from one side than from the other, and images are darker at their edges.
struct Balance {
  double gain = 1, offset = 0;
  std::array<double, 2> ramp{};          ///< change of grey over ramp_cells cells, to the right and downwards
  std::array<std::int64_t, 2> middle{};  ///< mean column and row of the patch, in cells from the world's origin
  /// The corrected grey at `middle`, not clamped.
  [[nodiscard]] double of(double grey) const { return gain * grey + offset; }
  /// The corrected grey in a cell, counted from the world's origin; not clamped.
  [[nodiscard]] double of(double grey, std::int64_t column, std::int64_t row) const {
    return of(grey) +
           (ramp[0] * static_cast<double>(column - middle[0]) + ramp[1] * static_cast<double>(row - middle[1])) /
               ramp_cells;
  }
  bool operator==(const Balance&) const = default;
  static constexpr double ramp_cells = 256;
};

/// A sparse histogram: counts of the grey values that occur, ascending. It is small, because a map has thousands.
class GreyHistogram {
 public:
  using Entry = std::pair<std::uint8_t, std::uint32_t>;
  GreyHistogram() = default;
  /// From the entries of a histogram, in any order.
  explicit GreyHistogram(const std::vector<Entry>& entries);
  void add(std::uint8_t grey, std::uint32_t number);
  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
  [[nodiscard]] std::uint64_t count() const;

 private:
  std::vector<Entry> entries_;
};

/// Grey values of two keyframes in cells that both show, and in neighbouring cells on both sides of their border.
struct SeamGreys {
  GreyHistogram first, second;
  std::int64_t columns = 0, rows = 0;  ///< sums of columns and rows over all cells, counted from the world's origin
};

/// Key: the ids of the two keyframes, the smaller one first.
using Seams = std::map<std::pair<std::int64_t, std::int64_t>, SeamGreys>;

/// The grey value that a keyframe shows in a cell; `keyframe` is its id.
struct ShownCell {
  std::int64_t keyframe = 0;
  std::uint8_t grey = 0;
};

/// Adds the grey values of two keyframes in one cell, except where one of them is saturated (black or white).
/// `column` and `row` are counted from the world's origin.
void add_seam_cell(const ShownCell& a, const ShownCell& b, std::int64_t column, std::int64_t row, Seams& seams);

/// Adds pairs of measured cells next to a border of two keyframes. The left or upper cell of a pair is in columns
/// [margin, width - margin) and rows [margin, height - margin). `keyframes`: ids, index source - 1.
void add_seams(const GroundGrid& grid, const std::vector<std::int64_t>& keyframes, std::int32_t margin, Seams& seams);

/// Mean and standard deviation of grey values.
struct GreyLevel {
  double mean = 0, spread = 0;
};

/// Grey levels of two keyframes on the ground that both show.
struct SeamLevels {
  std::int64_t first = 0, second = 0;  ///< ids of the keyframes
  double column = 0, row = 0;          ///< mean position, in cells from the world's origin
  double cells = 0;                    ///< weight: the number of cells n, saturating as n / (1 + n / 1000)
  GreyLevel first_level, second_level;
};

/// Levels of the seams with at least 20 cells, without the darkest and the brightest twentieth of their cells.
[[nodiscard]] std::vector<SeamLevels> seam_levels_of(const Seams& seams);

/// Sums over the cells in which the map shows a keyframe, before the balance.
struct ShownPatch {
  std::uint64_t cells = 0;             ///< number of cells
  std::uint64_t grey = 0;              ///< sum of the grey values
  std::int64_t columns = 0, rows = 0;  ///< sums of columns and rows, counted from the world's origin
  std::uint64_t pairs = 0;             ///< number of pairs of cells contrast_cells apart along a row or column
  std::uint64_t differences = 0;       ///< sum of the absolute grey differences of these pairs
  void add(const ShownPatch& other);
};
inline constexpr std::int32_t contrast_cells = 8;

/// Adds the cells of a grid, with the margin as in add_seams. `shown`: index source - 1.
void add_shown(const GroundGrid& grid, std::int32_t margin, std::vector<ShownPatch>& shown);

/// Computes gain, offset and ramp of each keyframe by robust least squares over all seams. Gains come first, from the
/// ratios of the standard deviations of grey at seams; offsets and ramps follow, from the differences of the means.
/// Weak priors draw contrast and mean of each patch to those of the map, and its ramp to 0. They limit drift along a
/// strip: where images are darker or blurred at one edge, all seams err in the same direction. They also reduce real
/// differences over many keyframes, which is accepted because the map is for viewing. Gains are from 1 / most_gain to
/// most_gain. Ground with hardly any contrast keeps its contrast, and so does a patch without a seam. Averaged over all
/// cells, the logarithm of the gain is 0 and the mean grey does not change; in a map of 100 keyframes or more, to
/// within 1/32 and 4 grey values.
[[nodiscard]] std::map<std::int64_t, Balance> balance_patches(std::vector<SeamLevels> seams,
                                                              const std::map<std::int64_t, ShownPatch>& patches);
inline constexpr double most_gain = 4;

}  // namespace ilp::map
