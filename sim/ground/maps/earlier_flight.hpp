// Finds the results of ilp-ground for an earlier flight that can serve as the rasters of a map.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace ilp::maps {

struct EarlierModel {
  std::filesystem::path image, heights;
  /// Horizontal sigma per axis of the model's position, with the error of the map that it is placed on; none: unknown.
  std::optional<double> place_sigma_m;
  std::string place;  ///< the position in words, or why there is none
};

/// Finds the rasters of a strip. `folder`: results of ilp-ground, the folder of a flight with the results in its folder
/// `ground`, or the flight's `outbox`. `strip`: id; 0: the first with heights. Throws std::runtime_error that names
/// what is missing and how it is made.
[[nodiscard]] EarlierModel earlier_model(const std::filesystem::path& folder, std::int64_t strip);

}  // namespace ilp::maps
