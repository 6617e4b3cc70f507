// Compares the flight's map with another terrain model: aligns them, subtracts the heights, and computes statistics.
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
  std::filesystem::path out;    ///< folder for the results; empty: the folder `comparison` beside the map
  int strip = 0;                ///< id of the strip if `map` is a folder; 0: the first
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
  double cell = 0;         ///< cell size of the difference, metres
  double other_cell = 0;   ///< cell size of the other model as it was compared, metres
  bool has_sigma = false;  ///< the map has estimated errors
  std::vector<std::string> remarks;
};

/// The raster file `path`, or the raster of the strip in the folder `path`.
[[nodiscard]] std::filesystem::path find_map(const std::filesystem::path& path, int strip);

/// Compares the models, and writes difference.tif, difference.png, comparison.html and comparison.json into the folder
/// for results. Throws std::runtime_error with a message for the user if a model cannot be read or placed, or the
/// models have no common ground.
[[nodiscard]] Comparison compare_heights(const ComparisonOptions& options);

/// Lines for the terminal.
[[nodiscard]] std::vector<std::string> summary_of(const Comparison& comparison);

}  // namespace ilp::compare
