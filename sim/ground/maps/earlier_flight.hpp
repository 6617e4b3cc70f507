// What ilp-ground made of an earlier flight, as the rasters of a map.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace ilp::maps {

struct EarlierModel {
  std::filesystem::path image, heights;
  std::optional<double> place_sigma_m;  ///< one sigma to each side, with that of the map it stands on; none: not known
  std::string place;                    ///< in words, or why there is none
};

/// `folder`: results of ilp-ground, the folder of a flight that has them in `ground`, or its `outbox` beside them.
/// `strip`: its number; 0 for the first. std::runtime_error names what is missing, and how it is made.
[[nodiscard]] EarlierModel earlier_model(const std::filesystem::path& folder, std::int64_t strip);

}  // namespace ilp::maps
