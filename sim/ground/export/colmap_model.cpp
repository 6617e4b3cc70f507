#include "sim/ground/export/colmap_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <vector>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/host/files.hpp"

namespace ilp::exports {
namespace {

std::string text_of(double value, const char* format = "%.17g") {
  std::array<char, 40> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, value);
  return buffer.data();
}

struct Point2 {
  float x = 0, y = 0;  // pixel centres at integers
  std::size_t point_id = 0;
};

struct Track {
  const intake::StructureTrackPoint* point = nullptr;
  std::vector<std::pair<std::int64_t, std::size_t>> elements;  // keyframe, index of its 2D point
  StructureObservation first;
  std::uint8_t grey = 128;
};

struct Model {
  std::map<std::int64_t, std::vector<Point2>> images;
  std::vector<Track> tracks;  // point id = index + 1
};

bool finite(const intake::StructureTrackPoint& track) {
  return std::isfinite(track.point.position[0]) && std::isfinite(track.point.position[1]) &&
         std::isfinite(track.point.position[2]);
}

std::uint8_t grey_at(const host::Raster<std::uint8_t>& image, const StructureObservation& seen) {
  const double x = std::floor(seen.x + 0.5), y = std::floor(seen.y + 0.5);
  if (!(x >= 0) || !(y >= 0) || x >= image.width || y >= image.height) return 128;
  return image.at(static_cast<std::int32_t>(x), static_cast<std::int32_t>(y));
}

void add_track(const intake::StructureTrackPoint& point, Model& model) {
  std::vector<const StructureObservation*> seen;
  for (const StructureObservation& o : point.observations) {
    const bool repeated =
        std::any_of(seen.begin(), seen.end(), [&](const auto* other) { return other->keyframe_id == o.keyframe_id; });
    if (model.images.contains(o.keyframe_id) && std::isfinite(o.x) && std::isfinite(o.y) && !repeated) {
      seen.push_back(&o);
    }
  }
  if (seen.size() < 2 || !finite(point)) return;
  Track track;
  track.point = &point;
  track.first = *seen[0];
  for (const StructureObservation* o : seen) {
    std::vector<Point2>& points = model.images[o->keyframe_id];
    track.elements.emplace_back(o->keyframe_id, points.size());
    points.push_back({o->x, o->y, model.tracks.size() + 1});
  }
  model.tracks.push_back(std::move(track));
}

/// Every image is decoded once.
void colour(const intake::Flight& flight, Model& model) {
  std::map<std::int64_t, std::vector<Track*>> by_image;
  for (Track& track : model.tracks) by_image[track.first.keyframe_id].push_back(&track);
  for (const auto& [id, tracks] : by_image) {
    const intake::KeyframeRasters rasters = intake::decode_products(flight.keyframes.at(id)).rasters;
    for (Track* track : tracks) track->grey = grey_at(rasters.image, track->first);
  }
}

Model collect(const intake::Flight& flight, const intake::Strip& strip) {
  Model model;
  for (const std::int64_t id : strip.keyframes) {
    if (flight.keyframes.at(id).posed()) model.images[id];
  }
  for (const std::int64_t id : strip.keyframes) {
    for (const intake::StructureTrackPoint& point : flight.keyframes.at(id).points) add_track(point, model);
  }
  colour(flight, model);
  return model;
}

std::string cameras_text(const CameraModel& c) {
  std::string text = "# Camera list with one line of data per camera:\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  text += std::string("1 ") + (c.has_distortion() ? "OPENCV " : "PINHOLE ") + std::to_string(c.width) + " " +
          std::to_string(c.height);
  for (const double p : {c.fx, c.fy, c.cx + 0.5, c.cy + 0.5}) text += " " + text_of(p);
  if (c.has_distortion()) {
    for (const double p : {c.k1, c.k2, c.p1, c.p2}) text += " " + text_of(p);
  }
  return text + "\n";
}

std::string images_text(const intake::Flight& flight, const Model& model) {
  std::string text =
      "# Image list with two lines of data per image:\n"
      "#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n#   POINTS2D[] as (X, Y, POINT3D_ID)\n";
  for (const auto& [id, points] : model.images) {
    const intake::Keyframe& keyframe = flight.keyframes.at(id);
    const RigidTransform t = cam_from_world(pose_of(*keyframe.pose));
    text += std::to_string(id);
    for (const double q : keyframe.pose->q_cam_from_world) text += " " + text_of(q);
    for (int i = 0; i < 3; ++i) text += " " + text_of(t.translation[i]);
    text += " 1 " + keyframe.name + "\n";
    const char* blank = "";
    for (const Point2& p : points) {
      text += blank + text_of(p.x + 0.5, "%.9g") + " " + text_of(p.y + 0.5, "%.9g") + " " + std::to_string(p.point_id);
      blank = " ";
    }
    text += "\n";
  }
  return text;
}

std::string points_text(const Model& model) {
  std::string text =
      "# 3D point list with one line of data per point:\n"
      "#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  for (std::size_t i = 0; i < model.tracks.size(); ++i) {
    const Track& track = model.tracks[i];
    text += std::to_string(i + 1);
    for (const double x : track.point->point.position) text += " " + text_of(x);
    const std::string grey = " " + std::to_string(track.grey);
    text += grey + grey + grey + " " +
            text_of(std::isfinite(track.point->point.error_px) ? track.point->point.error_px : 0, "%.6g");
    for (const auto& [image, index] : track.elements) text += " " + std::to_string(image) + " " + std::to_string(index);
    text += "\n";
  }
  return text;
}

}  // namespace

ColmapCounts write_colmap_model(const intake::Flight& flight, const intake::Strip& strip,
                                const std::filesystem::path& folder) {
  const Model model = collect(flight, strip);
  if (model.images.empty()) return {};
  host::make_output_folder(folder);
  host::write_file(folder / "cameras.txt", cameras_text(flight.keyframes.at(model.images.begin()->first).camera));
  host::write_file(folder / "images.txt", images_text(flight, model));
  host::write_file(folder / "points3D.txt", points_text(model));
  ColmapCounts counts{model.images.size(), model.tracks.size(), 0};
  for (const Track& track : model.tracks) counts.observations += track.elements.size();
  return counts;
}

}  // namespace ilp::exports
