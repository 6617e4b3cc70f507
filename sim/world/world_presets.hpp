// Worlds by name, each with the flight that suits its lengths: a ground pixel is about a post for a camera of 550 px
// focal length.
#pragma once

#include <span>
#include <string_view>

#include "sim/world/world_params.hpp"

namespace ilp::world {

struct WorldPreset {
  std::string_view name;
  std::string_view meaning;
  WorldParams world;
  double altitude_m = 100;
  double drift_m_s = 2.5;  ///< along x: 95 % overlap between frames taken every 2 s
};

/// testbed, mars-plains, mars-canyon, titan-shore, flat.
[[nodiscard]] std::span<const WorldPreset> world_presets();

/// std::invalid_argument lists the names.
[[nodiscard]] const WorldPreset& world_preset(std::string_view name);

}  // namespace ilp::world
