#include "sim/ground/model/scene.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "fsw/vision/features/harris.hpp"
#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/place/place_feature_workspace.hpp"
#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/host/parallel.hpp"

namespace ilp::model {
namespace {

/// A detected corner so near to a point of the flight is that point.
constexpr float same_corner_px = 4;

bool usable(const intake::Keyframe& keyframe) {
  return validate(keyframe.camera).ok() && (keyframe.posed() || keyframe.has_image());
}

View view_of_keyframe(const intake::Keyframe& keyframe) {
  View view;
  view.keyframe_id = keyframe.id;
  view.strip_id = keyframe.strip_id;
  view.camera = keyframe.camera;
  view.posed = keyframe.posed();
  if (view.posed) view.camera_from_strip = cam_from_world(pose_of(*keyframe.pose));
  return view;
}

void add_points_of_flight(const intake::Keyframe& keyframe, Scene& scene) {
  for (const intake::StructureTrackPoint& point : keyframe.points) {
    Track track;
    track.of_flight = true;
    track.strip_id = keyframe.strip_id;
    track.strip_position = Vec3(point.point.position[0], point.point.position[1], point.point.position[2]);
    if (!track.strip_position.allFinite()) continue;
    std::vector<std::pair<std::uint32_t, Corner>> corners;
    for (const StructureObservation& seen : point.observations) {
      const std::int32_t index = scene.view_of(seen.keyframe_id);
      if (index < 0 || !std::isfinite(seen.x) || !std::isfinite(seen.y)) continue;
      const View& view = scene.views[static_cast<std::size_t>(index)];
      if (!view.posed || view.strip_id != track.strip_id) continue;
      const auto number = static_cast<std::uint32_t>(index);
      if (scene.sighting(track, number) != nullptr) continue;
      const Vec2 ideal = ideal_from_pixel(view.camera, Vec2(seen.x, seen.y));
      track.seen.push_back({number, ideal.x(), ideal.y()});
      corners.push_back({number, Corner{seen.x, seen.y, 1}});
    }
    if (track.seen.size() < 2) continue;
    for (const auto& [index, corner] : corners) {
      View& view = scene.views[index];
      // A full list leaves the point without a corner: it is not sought elsewhere, and its sightings count.
      if (view.corners.push_back(corner))
        view.track_of_corner.push_back(static_cast<std::int32_t>(scene.tracks.size()));
    }
    scene.tracks.push_back(std::move(track));
  }
}

void add_corners_of_image(const intake::Keyframe& keyframe, View& view) {
  thread_local const auto harris = std::make_unique<HarrisWorkspace>();
  thread_local const auto scratch = std::make_unique<PlaceFeatureWorkspace>();
  intake::DecodedProducts decoded = intake::decode_products(keyframe);
  host::Raster<std::uint8_t>& image = decoded.rasters.image;
  if (!image.same_size(view.camera.width, view.camera.height)) return;
  view.image = std::move(image);
  Corners found;
  if (!detect_corners(view.image.view(), {}, *harris, found).ok()) found.clear();
  const std::size_t of_flight = view.corners.size();
  for (const Corner& corner : found) {
    bool known = false;
    for (std::size_t i = 0; i < of_flight && !known; ++i) {
      known =
          std::max(std::fabs(view.corners[i].x - corner.x), std::fabs(view.corners[i].y - corner.y)) < same_corner_px;
    }
    if (known) continue;
    if (!view.corners.push_back(corner)) break;
    view.track_of_corner.push_back(-1);
  }
  if (!find_place_features(view.image.view(), *harris, *scratch, view.features).ok()) view.features.clear();
}

}  // namespace

std::int32_t Scene::view_of(std::int64_t keyframe_id) const {
  const auto at = std::lower_bound(views.begin(), views.end(), keyframe_id,
                                   [](const View& view, std::int64_t id) { return view.keyframe_id < id; });
  return at != views.end() && at->keyframe_id == keyframe_id ? static_cast<std::int32_t>(at - views.begin()) : -1;
}

const Sighting* Scene::sighting(const Track& track, std::uint32_t view) const {
  for (const Sighting& seen : track.seen) {
    if (seen.view == view) return &seen;
  }
  return nullptr;
}

TracksByView tracks_by_view(const Scene& scene) {
  TracksByView by_view(scene.views.size());
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    const std::vector<Sighting>& seen = scene.tracks[t].seen;
    for (std::size_t s = 0; s < seen.size(); ++s) by_view[seen[s].view].push_back({t, s});
  }
  return by_view;
}

Scene scene_of(const intake::Flight& flight) {
  Scene scene;
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (usable(keyframe)) scene.views.push_back(view_of_keyframe(keyframe));
  }
  for (const auto& [id, keyframe] : flight.keyframes) add_points_of_flight(keyframe, scene);
  return scene;
}

void add_images(const intake::Flight& flight, Scene& scene) {
  host::for_each_parallel(scene.views.size(), [&](std::size_t i) {
    const intake::Keyframe& keyframe = flight.keyframes.at(scene.views[i].keyframe_id);
    if (keyframe.has_image()) add_corners_of_image(keyframe, scene.views[i]);
  });
}

}  // namespace ilp::model
