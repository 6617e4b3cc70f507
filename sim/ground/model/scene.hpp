// What a joined model is made from: keyframes with corners to match, and tracks, which are points on the ground with
// the keyframes that see them.
#pragma once

#include <cstdint>
#include <memory_resource>
#include <vector>

#include "fsw/vision/features/feature_types.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/place/place_features.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/intake/result_cache.hpp"

namespace ilp::model {

struct View {
  std::int64_t keyframe_id = 0, strip_id = 0;
  CameraModel camera;
  bool posed = false;                ///< by the flight
  RigidTransform camera_from_strip;  ///< where posed
  const intake::Keyframe* keyframe = nullptr;
  bool has_image = false;            ///< it came down and decodes
  std::uint64_t image_digest = 0;    ///< of its coded image
  host::Raster<std::uint8_t> image;  ///< empty until load_images() is asked for it
  std::vector<Corner>
      corners;  ///< at most as many as Corners holds; first those of the flight's points, then others of the image
  std::vector<std::int32_t> track_of_corner;  ///< -1: none yet
  std::vector<PlaceFeature> features;
  std::uint64_t corners_digest = 0, features_digest = 0;
};

struct Sighting {
  std::uint32_t view = 0;
  double x = 0, y = 0;  ///< ideal px
};

/// Its memory may be one block for many tracks, which then stand beside each other.
using Sightings = std::pmr::vector<Sighting>;

struct Track {
  bool of_flight = false;
  std::int64_t strip_id = 0;           ///< of the flight's point
  Vec3 strip_position = Vec3::Zero();  ///< likewise, in its strip's world
  Sightings seen;                      ///< by view, each once
};

struct Scene {
  std::vector<View> views;  ///< by keyframe
  std::vector<Track> tracks;
  intake::ResultCache* results = nullptr;  ///< of work on images and of adjustments; null: nothing is kept

  /// -1: the keyframe has no view.
  [[nodiscard]] std::int32_t view_of(std::int64_t keyframe_id) const;
  [[nodiscard]] const Sighting* sighting(const Track& track, std::uint32_t view) const;
};

/// By view, the tracks that it sees, with the number of the sighting in each; in the order of the tracks.
struct SeenTrack {
  std::size_t track = 0, sighting = 0;
};
using TracksByView = std::vector<std::vector<SeenTrack>>;
[[nodiscard]] TracksByView tracks_by_view(const Scene& scene);

/// False where the list of corners is full. `track`: -1 for none.
[[nodiscard]] bool add_corner(const Corner& corner, std::int32_t track, View& view);

/// All keyframes with a pose or an image, and the flight's points as tracks. The keyframes must outlive the scene.
[[nodiscard]] Scene scene_of(const intake::Flight& flight);

/// Finds the corners and features of the images.
void add_images(Scene& scene);
/// Decodes the images of these views that are not decoded yet.
void load_images(const std::vector<std::uint32_t>& views, Scene& scene);

}  // namespace ilp::model
