// The flight's map against another terrain model: aligned, subtracted, measured.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/compare/alignment_of_heights.hpp"
#include "sim/ground/compare/difference_raster.hpp"
#include "sim/ground/compare/difference_statistics.hpp"

namespace ilp::compare {

struct ComparisonOptions {
  std::filesystem::path map;    ///< a raster of heights, or a folder with the results of ilp-ground or of sim/fly
  std::filesystem::path other;  ///< the other terrain model
  std::filesystem::path out;    ///< empty: the folder `comparison` beside the map
  int strip = 0;                ///< of a folder; 0: the first
  FrameOptions frame;
  AlignmentParams alignment;
};

struct Comparison {
  std::filesystem::path map, other, out;
  Fit fit = Fit::shift;
  HeightAlignment alignment;
  CellCounts counts;
  DifferenceStatistics difference;
  DifferenceOverview overview;
  double max_slope_rad = 0;
  double cell = 0;        ///< of the difference, metres
  double other_cell = 0;  ///< of the other model as it was compared, metres
  bool has_sigma = false;
  std::vector<std::string> remarks;
};

/// The raster that `path` names, or that lies in the folder.
[[nodiscard]] std::filesystem::path find_map(const std::filesystem::path& path, int strip);

/// Writes difference.tif, difference.png, comparison.html and comparison.json into the folder for results. Throws
/// std::runtime_error with a message for the user: what cannot be read or placed, and models without common ground.
[[nodiscard]] Comparison compare_heights(const ComparisonOptions& options);

/// For the terminal.
[[nodiscard]] std::vector<std::string> summary_of(const Comparison& comparison);

}  // namespace ilp::compare
