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
  view.keyframe = &keyframe;
  view.posed = keyframe.posed();
  if (view.posed) view.camera_from_strip = cam_from_world(pose_of(*keyframe.pose));
  return view;
}

void add_points_of_flight(const intake::Keyframe& keyframe, Scene& scene) {
  for (const intake::StructureTrackPoint& point : intake::points_of(keyframe)) {
    Track track;
    track.of_flight = true;
    track.strip_id = keyframe.strip_id;
    track.strip_position = Vec3(point.point.position[0], point.point.position[1], point.point.position[2]);
    if (!track.strip_position.allFinite()) continue;
    track.seen.reserve(point.observations.size());
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
    // A full list leaves the point without a corner: it is not sought elsewhere, and its sightings count.
    for (const auto& [index, corner] : corners)
      (void)add_corner(corner, static_cast<std::int32_t>(scene.tracks.size()), scene.views[index]);
    scene.tracks.push_back(std::move(track));
  }
}

/// Empty where it does not decode, or has another size than the camera.
host::Raster<std::uint8_t> decoded_image(const View& view) {
  constexpr auto kind = static_cast<std::size_t>(ProductKind::image);
  intake::Keyframe image_only;
  image_only.image = view.keyframe->image;
  image_only.product_files[kind] = view.keyframe->product_files[kind];
  host::Raster<std::uint8_t> image = std::move(intake::decode_products(image_only).rasters.image);
  return image.same_size(view.camera.width, view.camera.height) ? image : host::Raster<std::uint8_t>();
}

std::uint64_t digest_of_image(const View& view) {
  const intake::Keyframe& keyframe = *view.keyframe;
  return intake::InputDigest("image 1")
      .add(keyframe.product_files[static_cast<std::size_t>(ProductKind::image)].bytes())
      .add(keyframe.image.samples)
      .add_value(view.camera.width)
      .add_value(view.camera.height)
      .value();
}

/// What an image holds for matching. `usable`: not empty if it decodes.
struct ImageContent {
  std::vector<std::uint8_t> usable;
  Corners corners;
  PlaceFeatures features;
};

ImageContent content_of(View& view) {
  thread_local const auto harris = std::make_unique<HarrisWorkspace>();
  thread_local const auto scratch = std::make_unique<PlaceFeatureWorkspace>();
  ImageContent content;
  view.image = decoded_image(view);
  if (view.image.empty()) return content;
  content.usable.push_back(1);
  if (!detect_corners(view.image.view(), {}, *harris, content.corners).ok()) content.corners.clear();
  if (!find_place_features(view.image.view(), limits::max_place_features, *harris, *scratch, content.features).ok())
    content.features.clear();
  return content;
}

ImageContent kept_content(View& view, intake::ResultCache* results) {
  ImageContent content;
  const std::uint64_t digest = intake::InputDigest("corners and features 2").add_value(view.image_digest).value();
  if (const auto known = results == nullptr ? std::nullopt : results->result(digest)) {
    std::span<const std::uint8_t> bytes = *known;
    const bool whole = intake::take(bytes, content.corners) && intake::take(bytes, content.features);
    if (whole && bytes.size() <= 1) {
      content.usable.assign(bytes.begin(), bytes.end());
      return content;
    }
  }
  content = content_of(view);
  if (results == nullptr) return content;
  std::vector<std::uint8_t> bytes;
  intake::append(content.corners, bytes);
  intake::append(content.features, bytes);
  bytes.insert(bytes.end(), content.usable.begin(), content.usable.end());
  results->put_result(digest, bytes);
  return content;
}

void add_corners_of_image(intake::ResultCache* results, View& view) {
  view.image_digest = digest_of_image(view);
  const ImageContent content = kept_content(view, results);
  view.has_image = !content.usable.empty();
  view.features.assign(content.features.begin(), content.features.end());
  const std::size_t of_flight = view.corners.size();
  for (const Corner& corner : content.corners) {
    bool known = false;
    for (std::size_t i = 0; i < of_flight && !known; ++i) {
      known =
          std::max(std::fabs(view.corners[i].x - corner.x), std::fabs(view.corners[i].y - corner.y)) < same_corner_px;
    }
    if (known) continue;
    if (!add_corner(corner, -1, view)) break;
  }
  std::vector<std::uint8_t> bytes;
  intake::append(view.corners, bytes);
  view.corners_digest = intake::InputDigest("corners").add(bytes).value();
  bytes.clear();
  intake::append(view.features, bytes);
  view.features_digest = intake::InputDigest("features").add(bytes).value();
}

}  // namespace

bool add_corner(const Corner& corner, std::int32_t track, View& view) {
  if (view.corners.size() == limits::max_corners) return false;
  view.corners.push_back(corner);
  view.track_of_corner.push_back(track);
  return true;
}

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
    const Sightings& seen = scene.tracks[t].seen;
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

void add_images(Scene& scene) {
  host::for_each_parallel(scene.views.size(), [&](std::size_t i) {
    if (scene.views[i].keyframe->has_image()) add_corners_of_image(scene.results, scene.views[i]);
  });
}

void load_images(const std::vector<std::uint32_t>& views, Scene& scene) {
  host::for_each_parallel(views.size(), [&](std::size_t i) {
    View& view = scene.views[views[i]];
    if (view.has_image && view.image.empty()) view.image = decoded_image(view);
  });
}

}  // namespace ilp::model
