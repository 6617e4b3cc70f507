// Keyframes over planted worlds as the richness scorer meets them: image, depth of the flight software's own stereo,
// mask of the newly seen part, and what truly is to be seen there.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "sim/host/image_io.hpp"
#include "sim/world/camera_effects.hpp"
#include "sim/world/terrain_posts.hpp"
#include "sim/world/world_params.hpp"

namespace ilp::richness {

// Worlds that decide whether the Image Richness Index finds what is interesting: plain ground of several kinds, each
// with one kind of feature planted in places far enough apart that some images show one and others do not.

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

/// A planted feature is large enough to be seen when its diameter (of a channel the width) covers this many pixels and
/// its relief is this share of the height of flight: half a pixel of parallax between keyframes.
inline constexpr double smallest_feature_px = 12;
inline constexpr double smallest_relief = 0.01;
/// A boulder field counts within two radii of its boulders of this diameter and more.
inline constexpr double smallest_boulder_px = 5;
/// An image is interesting when such features cover this share of its newly seen part; plain when less than the other
/// lies on or near any planted feature, large enough or not (near: the ejecta of a crater, the foot of a scarp).
/// Between them it is neither, and left out; so is one whose newly seen part is less than this share of the image: of
/// ground that stereo could not match there are only fragments.
inline constexpr double least_newly_seen = 0.1;
inline constexpr double interesting_share = 0.05;
inline constexpr double plain_share = 0.005;

enum class Label : std::uint8_t { plain, interesting, neither };

struct PlantedKeyframe {
  CameraModel camera;
  host::Raster<std::uint8_t> grey;
  host::Raster<float> inverse_depth;  ///< 1/m, inside the mask only, quantised as it is sent
  host::Raster<float> sigma;          ///< 0: no depth
  host::Raster<std::uint8_t> mask;
  double newly_seen = 0;     ///< share of the image
  double feature_share = 0;  ///< of the newly seen part: features that are large enough
  double near_share = 0;     ///< of the newly seen part: on or near any planted feature

  [[nodiscard]] Label label() const {
    if (newly_seen < least_newly_seen) return Label::neither;
    if (feature_share >= interesting_share) return Label::interesting;
    return near_share < plain_share ? Label::plain : Label::neither;
  }
};

struct Viewing {
  int keyframes = 8;
  double overlap = 0.82;
  double gain = 1;           ///< times the world's own
  double offset_grey = 0;    ///< added to every pixel
  double height = 1;         ///< times the world's altitude; the baseline goes with it
  double read_noise = 0;     ///< grey levels more
  double haze = 0;           ///< more
  bool true_depth = false;   ///< instead of stereo
  bool same_ground = false;  ///< the mask is a patch of ground that does not depend on the height
};

struct StereoScratch;
struct StereoScratchDeleter {
  void operator()(StereoScratch* scratch) const;
};
/// Memory of the stereo kernel; one per thread.
using StereoScratchPointer = std::unique_ptr<StereoScratch, StereoScratchDeleter>;
[[nodiscard]] StereoScratchPointer make_stereo_scratch();

/// A strip from the origin along x. Poses are the true ones, turned a little at random; everything else is what the
/// flight software makes of the images. The mask is that of dense matching (mask.hpp): the first keyframe's is the
/// whole overlap, the others' the strip of new ground; with `same_ground` a patch of 0.3 x 0.6 of what the base height
/// sees, in the middle of the pair. std::runtime_error when a pair cannot be rectified.
[[nodiscard]] std::vector<PlantedKeyframe> planted_keyframes(const PlantedWorld& planted, const Viewing& viewing,
                                                             StereoScratch& scratch);

}  // namespace ilp::richness
