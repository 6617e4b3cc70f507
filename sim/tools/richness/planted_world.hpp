// Worlds that decide whether the Image Richness Index finds what is interesting: plain ground of several kinds, each
// with one kind of feature planted in places far enough apart that some images show one and others do not.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "fsw/base/geometry.hpp"
#include "sim/world/camera_effects.hpp"
#include "sim/world/terrain_posts.hpp"
#include "sim/world/world_params.hpp"

namespace ilp::richness {

/// plains: rolling; dunes: ripples everywhere; hills: long steep slopes; hazy: thick haze and noise; stark: a low sun
/// on ground of strong brightness pattern.
enum class GroundKind : std::uint8_t { plains, dunes, hills, hazy, stark, count };
[[nodiscard]] std::string_view name_of(GroundKind ground);

/// What is planted, in the order of tables.
[[nodiscard]] std::span<const world::FeatureKind> planted_kinds();
[[nodiscard]] std::string_view name_of(world::FeatureKind feature);

/// Two sets of worlds: `held_out` has other seeds, wider ranges of the ground's parameters and of the light, other
/// sizes of features, other altitudes and another camera.
enum class WorldSet : std::uint8_t { tuning, held_out };

/// A world and how it is seen.
struct PlantedWorld {
  WorldSet set = WorldSet::tuning;
  GroundKind ground = GroundKind::plains;
  world::FeatureKind feature = world::FeatureKind::crater;
  std::uint64_t seed = 0;
  world::WorldParams world;
  world::CameraEffects effects;
  CameraModel camera;
  double altitude_m = 100;
  double background_crater_m = 0;  ///< radius of the largest crater of plain ground
};

/// Deterministic: the same world for the same arguments.
[[nodiscard]] PlantedWorld planted_world(WorldSet set, GroundKind ground, world::FeatureKind feature,
                                         std::uint64_t seed);

}  // namespace ilp::richness
