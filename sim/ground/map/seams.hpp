// Where the pieces of a strip meet: one surface and one brightness from the masked pieces of its keyframes.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "sim/ground/map/ground_grid.hpp"

namespace ilp::map {

/// Closing and comparing seams in a part of a map depends on cells up to this far outside the part.
inline constexpr std::int32_t seam_reach_cells = 6;

/// Masks are disjoint, so that between two pieces a cell or two may stay empty. Such a cell, with covered cells of
/// different keyframes within two cells on opposite sides and no cliff between them, takes the height and brightness of
/// the line between these. Its count stays 0: nothing was measured there. Gaps inside a piece stay open: there the
/// ground was seen and not matched.
void close_seams(GroundGrid& grid);

/// Counts by step, rising; a few octets for each, because a map has thousands of histograms.
class StepHistogram {
 public:
  using Entry = std::pair<std::int32_t, std::uint32_t>;
  StepHistogram() = default;
  /// Entries as entries() gave them, in any order.
  explicit StepHistogram(std::vector<Entry> entries);
  void add(std::int32_t step, std::uint32_t number);
  void add(const StepHistogram& other);
  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
  [[nodiscard]] auto begin() const { return entries_.begin(); }
  [[nodiscard]] auto end() const { return entries_.end(); }

 private:
  std::vector<Entry> entries_;
};

/// Histograms of the logarithm of the ratio of brightness of two keyframes where they meet, in steps of 1/512; the key
/// has both ids, the smaller one first.
using SeamRatios = std::map<std::pair<std::int64_t, std::int64_t>, StepHistogram>;

/// Adds the cells in columns [margin, width - margin), and in rows likewise; `keyframes` has the ids by source - 1.
void add_seam_ratios(const GroundGrid& grid, const std::vector<std::int64_t>& keyframes, std::int32_t margin,
                     SeamRatios& ratios);

/// What the map shows of a keyframe.
struct ShownPiece {
  std::uint64_t cells = 0;
  std::uint64_t grey = 0;  ///< sum over its cells, before gains
};

/// Gains for the brightness of each keyframe, by least squares: keyframes agree at their seams, and a weak pull takes
/// the mean brightness of each to that of the map. Seams alone err in one direction where images are darker at one
/// edge, and this adds up along a strip. The map is for the eye: real differences over many keyframes are made smaller
/// too. The mean logarithm of the gains over all cells is 0, in a map of
/// 100 keyframes and more to within a thirty-second.
[[nodiscard]] std::map<std::int64_t, double> balance_exposures(const SeamRatios& ratios,
                                                               const std::map<std::int64_t, ShownPiece>& pieces);

}  // namespace ilp::map
