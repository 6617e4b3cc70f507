#include "sim/ground/model/moving.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "sim/ground/intake/move_keyframe.hpp"
#include "sim/host/alignment.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::model {
namespace {

bool in_metres(const intake::Flight& flight, std::int64_t strip_id) {
  const auto strip = flight.strips.find(strip_id);
  return strip != flight.strips.end() && std::string(intake::unit_of(flight, strip->second)) == "m";
}

/// How much longer the model's unit is than the keyframe's strip's, by the depths of the points that it sees.
double scale_of(const Scene& scene, const Model& model, const TracksByView& seen_by, std::uint32_t v,
                double otherwise) {
  std::vector<double> ratios;
  for (const auto& [t, s] : seen_by[v]) {
    const Track& track = scene.tracks[t];
    if (!track.of_flight || !model.points[t].placed || track.strip_id != scene.views[v].strip_id) continue;
    const double before = (scene.views[v].camera_from_strip * track.strip_position).z();
    const double after = (model.views[v].camera_from_model * model.points[t].position).z();
    if (before > 0 && after > 0 && std::isfinite(after / before)) ratios.push_back(after / before);
  }
  return ratios.size() < 8 ? otherwise : host::median(std::move(ratios));
}

PoseRecord new_pose(const intake::Keyframe& keyframe) {
  PoseRecord pose = keyframe.pose.value_or(PoseRecord{});
  pose.id = keyframe.id;
  pose.state = PoseState::final;
  pose.verdict = PoseVerdict::ok;
  return pose;
}

void move_into(const Scene& scene, const Model& model, const TracksByView& seen_by, std::uint32_t v,
               const Similarity& strip_to_model, ScaleSource unit, std::int64_t strip_id, intake::Keyframe& keyframe) {
  const View& view = scene.views[v];
  const RigidTransform& to = model.views[v].camera_from_model;
  if (!view.posed) {
    keyframe.pose = new_pose(keyframe);
    const Pose pose = pose_from(to);
    std::copy_n(pose.q_cam_from_world, 4, keyframe.pose->q_cam_from_world);
    std::copy_n(pose.centre, 3, keyframe.pose->centre);
  } else {
    // Camera, points and depths of a keyframe move together; the camera stands exactly where the model has it.
    Similarity by;
    by.scale = scale_of(scene, model, seen_by, v, strip_to_model.scale);
    by.rotation = to.rotation.transpose() * view.camera_from_strip.rotation;
    by.translation = centre_of(to) - by.scale * (by.rotation * centre_of(view.camera_from_strip));
    intake::move(by, keyframe);
  }
  if (const auto& covariance = model.views[v].covariance) {
    constexpr std::size_t diagonal[] = {9, 14, 20};  // of the centre
    std::copy(covariance->begin(), covariance->end(), keyframe.pose->covariance);
    for (std::size_t k = 0; k < 3; ++k) keyframe.pose->sigma[k] = std::sqrt((*covariance)[diagonal[k]]);
  }
  keyframe.pose->strip_id = strip_id;
  keyframe.pose->scale_source = unit;
  keyframe.strip_id = strip_id;
}

}  // namespace

std::int64_t reference_strip(const intake::Flight& flight, const Scene& scene, const Model& model) {
  std::map<std::int64_t, std::size_t> posed;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    if (model.views[v].in && scene.views[v].posed) ++posed[scene.views[v].strip_id];
  }
  std::int64_t first = 0;
  for (const auto& [strip, count] : posed) {
    if (count < 2) continue;
    if (in_metres(flight, strip)) return strip;
    if (first == 0) first = strip;
  }
  return first;
}

std::optional<Similarity> model_from_strip(const Scene& scene, const Model& model, std::int64_t strip_id) {
  std::vector<Vec3> strip, in_model;
  std::vector<Mat3> strip_attitudes, model_attitudes;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    if (!model.views[v].in || !view.posed || view.strip_id != strip_id) continue;
    strip.push_back(centre_of(view.camera_from_strip));
    strip_attitudes.push_back(view.camera_from_strip.rotation);
    in_model.push_back(centre_of(model.views[v].camera_from_model));
    model_attitudes.push_back(model.views[v].camera_from_model.rotation);
  }
  double reach = 0;
  for (const Vec3& c : in_model) reach = std::max(reach, (c - in_model.front()).norm());
  if (!(reach > 0)) return std::nullopt;
  const auto aligned = host::align_cameras(strip, strip_attitudes, in_model, model_attitudes, reach);
  if (!aligned) return std::nullopt;
  Similarity similarity;
  similarity.scale = aligned->scale;
  similarity.rotation = aligned->rotation;
  similarity.translation = aligned->translation;
  return similarity;
}

void move_flight(const Scene& scene, const Model& model, std::int64_t strip_id, bool in_metres,
                 intake::Flight& flight) {
  std::map<std::int64_t, Similarity> by_strip;
  const TracksByView seen_by = tracks_by_view(scene);
  ScaleSource unit = ScaleSource::first_baseline;
  for (const std::int64_t id : flight.strips.at(strip_id).keyframes) {
    if (flight.keyframes.at(id).posed()) unit = flight.keyframes.at(id).pose->scale_source;
  }
  if (in_metres) unit = ScaleSource::navigation;
  for (std::uint32_t v = 0; v < scene.views.size(); ++v) {
    if (!model.views[v].in) continue;
    const View& view = scene.views[v];
    if (view.posed && !by_strip.contains(view.strip_id))
      by_strip[view.strip_id] = model_from_strip(scene, model, view.strip_id).value_or(Similarity{});
    const Similarity strip_to_model = view.posed ? by_strip[view.strip_id] : Similarity{};
    move_into(scene, model, seen_by, v, strip_to_model, unit, strip_id, flight.keyframes.at(view.keyframe_id));
  }
}

}  // namespace ilp::model
