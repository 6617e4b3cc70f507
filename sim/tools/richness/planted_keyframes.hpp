// Makes keyframes over planted worlds as input of the richness scorer: image, depth from the flight software's stereo,
// mask of the newly seen part, and the true label.
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

// Worlds for testing whether the Image Richness Index finds interesting images: plain ground of several kinds with one
// kind of feature each. The features are so far apart that some images show one and others do not.

/// plains: rolling; dunes: ripples everywhere; hills: long steep slopes; hazy: thick haze and noise; stark: a low sun
/// on ground of strong brightness pattern.
enum class GroundKind : std::uint8_t { plains, dunes, hills, hazy, stark, count };
[[nodiscard]] std::string_view name_of(GroundKind ground);

/// The planted kinds, in the order of tables.
[[nodiscard]] std::span<const world::FeatureKind> planted_kinds();
[[nodiscard]] std::string_view name_of(world::FeatureKind feature);

/// `tuning` is used to fit parameters. `held_out` has other seeds, wider ranges of the parameters of ground and light,
/// other sizes of features, other altitudes and another camera.
enum class WorldSet : std::uint8_t { tuning, held_out };

/// A world with camera, camera effects and altitude.
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

/// The world of these arguments; always the same.
[[nodiscard]] PlantedWorld planted_world(WorldSet set, GroundKind ground, world::FeatureKind feature,
                                         std::uint64_t seed);

/// A planted feature is large enough if its diameter (width of a channel; any for a scarp) covers at least this number
/// of pixels, and its relief is at least this share of the flying height: half a pixel of parallax between keyframes.
inline constexpr double smallest_feature_px = 12;
inline constexpr double smallest_relief = 0.01;
/// A boulder field counts only within two radii of its boulders with at least this diameter.
inline constexpr double smallest_boulder_px = 5;
/// An image is interesting if large enough features cover at least `interesting_share` of its newly seen part. It is
/// plain if less than `plain_share` of this part lies on or near planted features of any size (near: the ejecta of a
/// crater, the foot of a scarp). Other images are neither and left out, and also images whose newly seen part is
/// smaller than `least_newly_seen` of the image, because it may consist of fragments that stereo could not match
/// before.
inline constexpr double least_newly_seen = 0.1;
inline constexpr double interesting_share = 0.05;
inline constexpr double plain_share = 0.005;

enum class Label : std::uint8_t { plain, interesting, neither };

struct PlantedKeyframe {
  CameraModel camera;
  host::Raster<std::uint8_t> grey;
  host::Raster<float> inverse_depth;  ///< 1/m, inside the mask only, quantised as for the downlink
  host::Raster<float> sigma;          ///< of inverse_depth, 1/m; 0: no depth
  host::Raster<std::uint8_t> mask;
  double newly_seen = 0;     ///< share of the image
  double feature_share = 0;  ///< share of the newly seen part with large enough features
  double near_share = 0;     ///< share of the newly seen part on or near any planted feature

  [[nodiscard]] Label label() const {
    if (newly_seen < least_newly_seen) return Label::neither;
    if (feature_share >= interesting_share) return Label::interesting;
    return near_share < plain_share ? Label::plain : Label::neither;
  }
};

/// Viewing conditions.
struct Viewing {
  int keyframes = 8;         ///< number of keyframes in the strip
  double overlap = 0.82;     ///< of consecutive keyframes
  double gain = 1;           ///< factor on the world's gain
  double offset_grey = 0;    ///< added to every pixel
  double height = 1;         ///< factor on the world's altitude and on the baseline
  double read_noise = 0;     ///< added to the world's, grey levels
  double haze = 0;           ///< added to the world's
  bool true_depth = false;   ///< true depths instead of those of stereo
  bool same_ground = false;  ///< the mask is a patch of ground that does not depend on the height
};

struct StereoScratch;
struct StereoScratchDeleter {
  void operator()(StereoScratch* scratch) const;
};
/// Memory of the stereo kernel; one per thread.
using StereoScratchPointer = std::unique_ptr<StereoScratch, StereoScratchDeleter>;
[[nodiscard]] StereoScratchPointer make_stereo_scratch();

/// Flies a strip from the origin along x. The cameras look down with small random rotations, and their poses are known
/// exactly; depths and masks are computed by the flight software. The mask is that of dense matching (mask.hpp): the
/// overlap with the next image for the first keyframe, the new ground for the others. With `same_ground` it is a patch
/// in the middle of the pair, 0.3 x 0.6 of the image's footprint at the height factor 1. Throws std::runtime_error if a
/// pair cannot be rectified.
[[nodiscard]] std::vector<PlantedKeyframe> planted_keyframes(const PlantedWorld& planted, const Viewing& viewing,
                                                             StereoScratch& scratch);

}  // namespace ilp::richness
