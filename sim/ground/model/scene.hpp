// The input of a joined model: views, which are keyframes with corners to match, and tracks, which are ground points
// with their sightings.
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
  bool posed = false;                ///< the flight has a final pose
  RigidTransform camera_from_strip;  ///< the flight's pose; valid if posed
  const intake::Keyframe* keyframe = nullptr;
  bool has_image = false;            ///< the image came down and can be decoded
  std::uint64_t image_digest = 0;    ///< of the coded image
  host::Raster<std::uint8_t> image;  ///< empty until load_images() or add_images() decodes it
  std::vector<Corner>
      corners;  ///< at most limits::max_corners; first those of the flight's points, then others of the image
  std::vector<std::int32_t> track_of_corner;  ///< index of the track; -1: none yet
  std::vector<PlaceFeature> features;
  std::uint64_t corners_digest = 0, features_digest = 0;
};

/// An observation of a track in a view.
struct Sighting {
  std::uint32_t view = 0;
  double x = 0, y = 0;  ///< ideal px (without distortion)
};

/// A list whose memory may be in a block that many tracks share.
using Sightings = std::pmr::vector<Sighting>;

struct Track {
  bool of_flight = false;              ///< a point of the flight's structure
  std::int64_t strip_id = 0;           ///< strip of the flight's point; 0: not of the flight
  Vec3 strip_position = Vec3::Zero();  ///< position of the flight's point in the strip's world
  Sightings seen;                      ///< at most one in each view
};

struct Scene {
  std::vector<View> views;  ///< in the order of the keyframe ids
  std::vector<Track> tracks;
  intake::ResultCache* results = nullptr;  ///< cache for work on images and for adjustments; null: none

  /// Index of the keyframe's view; -1: it has none.
  [[nodiscard]] std::int32_t view_of(std::int64_t keyframe_id) const;
  /// The track's sighting in a view; null: none.
  [[nodiscard]] const Sighting* sighting(const Track& track, std::uint32_t view) const;
};

/// A track that a view sees: index of the track, and of the sighting in it.
struct SeenTrack {
  std::size_t track = 0, sighting = 0;
};
/// For each view, the tracks that it sees, in the order of the tracks.
using TracksByView = std::vector<std::vector<SeenTrack>>;
[[nodiscard]] TracksByView tracks_by_view(const Scene& scene);

/// Adds a corner to a view. `track`: index of its track; -1: none. Returns false if the list of corners is full.
[[nodiscard]] bool add_corner(const Corner& corner, std::int32_t track, View& view);

/// Makes views of all keyframes with a valid camera and a pose or an image, and tracks of the flight's points. The
/// keyframes must outlive the scene.
[[nodiscard]] Scene scene_of(const intake::Flight& flight);

/// Finds the corners and features of all images, or takes them from the cache, and sets View::has_image.
void add_images(Scene& scene);
/// Decodes the images of these views, except those that are decoded already.
void load_images(const std::vector<std::uint32_t>& views, Scene& scene);

}  // namespace ilp::model
