#include "sim/ground/export/colmap_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <vector>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/host/colmap.hpp"
#include "sim/host/files.hpp"

namespace ilp::exports {
namespace {

struct Model {
  host::ColmapText text;
  std::map<std::int64_t, std::size_t> views;  // by keyframe, index in text.views
  std::vector<StructureObservation> first;    // of each point
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
    if (model.views.contains(o.keyframe_id) && std::isfinite(o.x) && std::isfinite(o.y) && !repeated) {
      seen.push_back(&o);
    }
  }
  if (seen.size() < 2 || !finite(point)) return;
  const StructurePoint& p = point.point;
  host::ColmapPoint added{
      Vec3(p.position[0], p.position[1], p.position[2]), 128, std::isfinite(p.error_px) ? p.error_px : 0, {}};
  for (const StructureObservation* o : seen) {
    std::vector<host::ColmapObservation>& observations = model.text.views[model.views.at(o->keyframe_id)].seen;
    added.track.emplace_back(o->keyframe_id, observations.size());
    observations.push_back({o->x, o->y, model.text.points.size()});
  }
  model.text.points.push_back(std::move(added));
  model.first.push_back(*seen[0]);
}

/// Every image is decoded once.
void colour(const intake::Flight& flight, Model& model) {
  std::map<std::int64_t, std::vector<std::size_t>> by_image;
  for (std::size_t i = 0; i < model.first.size(); ++i) by_image[model.first[i].keyframe_id].push_back(i);
  for (const auto& [id, points] : by_image) {
    const intake::KeyframeRasters rasters = intake::decode_products(flight.keyframes.at(id)).rasters;
    for (const std::size_t i : points) model.text.points[i].grey = grey_at(rasters.image, model.first[i]);
  }
}

host::ColmapView view_of(const intake::Keyframe& keyframe) {
  const double(&q)[4] = keyframe.pose->q_cam_from_world;
  return {
      keyframe.id, {q[0], q[1], q[2], q[3]}, cam_from_world(pose_of(*keyframe.pose)).translation, keyframe.name, {}};
}

Model collect(const intake::Flight& flight, const intake::Strip& strip) {
  Model model;
  std::set<std::int64_t> posed;
  for (const std::int64_t id : strip.keyframes) {
    if (flight.keyframes.at(id).posed()) posed.insert(id);
  }
  for (const std::int64_t id : posed) {
    model.views[id] = model.text.views.size();
    model.text.views.push_back(view_of(flight.keyframes.at(id)));
  }
  for (const std::int64_t id : strip.keyframes) {
    for (const intake::StructureTrackPoint& point : intake::points_of(flight.keyframes.at(id))) add_track(point, model);
  }
  colour(flight, model);
  return model;
}

std::string cameras_text(const CameraModel& c) {
  std::string text = "# Camera list with one line of data per camera:\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  return text + host::colmap_camera_line(c);
}

}  // namespace

ColmapCounts write_colmap_model(const intake::Flight& flight, const intake::Strip& strip,
                                const std::filesystem::path& folder) {
  const Model model = collect(flight, strip);
  if (model.views.empty()) return {};
  host::make_output_folder(folder);
  host::update_file(folder / "cameras.txt", cameras_text(flight.keyframes.at(model.views.begin()->first).camera));
  host::write_colmap_text(model.text, folder);
  ColmapCounts counts{model.text.views.size(), model.text.points.size(), 0};
  for (const host::ColmapPoint& point : model.text.points) counts.observations += point.track.size();
  return counts;
}

}  // namespace ilp::exports
