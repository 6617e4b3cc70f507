#include "sim/ground/model/join_summary.hpp"

#include <set>

#include "sim/host/statistics.hpp"

namespace ilp::model {
namespace {

/// Median distance between where points that both keyframes see are projected to in the newer one, and seen.
double link_error_px(const Scene& scene, const Model& model, const TracksByView& seen_by, std::uint32_t place,
                     std::uint32_t newer, bool by_flight, std::size_t& points) {
  std::vector<double> errors;
  for (const auto& [t, s] : seen_by[newer]) {
    const Track& track = scene.tracks[t];
    const Sighting& seen = track.seen[s];
    if (!model.points[t].placed || model.refuses(t, s) || scene.sighting(track, place) == nullptr) continue;
    const View& view = scene.views[newer];
    if (!by_flight) {
      errors.push_back(
          reprojection_error(model.views[newer].camera_from_model, view.camera, model.points[t].position, seen));
    } else if (track.of_flight && track.strip_id == view.strip_id) {
      errors.push_back(reprojection_error(view.camera_from_strip, view.camera, track.strip_position, seen));
    }
  }
  if (!by_flight) points = errors.size();
  return errors.empty() ? 0 : host::median(std::move(errors));
}

std::vector<ClosedLink> closed_links(const intake::Flight& flight, const Scene& scene, const Model& model) {
  const TracksByView seen_by = tracks_by_view(scene);
  std::vector<ClosedLink> links;
  for (const LinkRecord& record : flight.links) {
    const std::int32_t place = scene.view_of(record.place_id), newer = scene.view_of(record.keyframe_id);
    if (place < 0 || newer < 0) continue;
    const auto a = static_cast<std::uint32_t>(place), b = static_cast<std::uint32_t>(newer);
    if (!model.views[a].in || !model.views[b].in) continue;
    ClosedLink link{record.place_id, record.keyframe_id, record.place_strip_id, record.strip_id};
    link.after_px = link_error_px(scene, model, seen_by, a, b, false, link.points);
    const bool one_world =
        scene.views[a].posed && scene.views[b].posed && scene.views[a].strip_id == scene.views[b].strip_id;
    if (one_world) link.before_px = link_error_px(scene, model, seen_by, a, b, true, link.points);
    links.push_back(link);
  }
  return links;
}

}  // namespace

JoinedModel summary_of(const intake::Flight& flight, const Scene& scene, const Model& model, std::int64_t strip_id) {
  JoinedModel joined;
  joined.strip_id = strip_id;
  std::set<std::int64_t> strips;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    if (!model.views[v].in) continue;
    const View& view = scene.views[v];
    strips.insert(view.strip_id);
    joined.members.push_back({view.keyframe_id, view.strip_id, view.posed, view.camera_from_strip,
                              flight.keyframes.at(view.keyframe_id).depth_scale,
                              view.posed ? centre_of(view.camera_from_strip) : Vec3::Zero(),
                              centre_of(model.views[v].camera_from_model)});
    if (const auto hold = model.views[v].attached_to)
      joined.members.back().attached_to = scene.views[*hold].keyframe_id;
  }
  joined.strips.assign(strips.begin(), strips.end());
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    if (!model.points[t].placed) continue;
    ++joined.points;
    for (std::size_t s = 0; s < scene.tracks[t].seen.size(); ++s) joined.sightings += model.sees(scene, t, s) ? 1 : 0;
  }
  joined.median_error_px = median_error_px(scene, model);
  joined.links = closed_links(flight, scene, model);
  return joined;
}

std::vector<StripApart> strips_apart(const intake::Flight& flight, const std::vector<JoinedModel>& models) {
  std::set<std::int64_t> joined;
  for (const JoinedModel& model : models) {
    for (const JoinedModel::Member& member : model.members) joined.insert(member.keyframe_id);
  }
  std::set<std::int64_t> in_links;
  for (const LinkRecord& link : flight.links) in_links.insert({link.keyframe_id, link.place_id});
  std::vector<StripApart> apart;
  for (const auto& [id, strip] : flight.strips) {
    StripApart one{id, 0, {}};
    bool linked = false, images = false;
    for (const std::int64_t keyframe : strip.keyframes) {
      if (joined.contains(keyframe)) continue;
      ++one.keyframes;
      images = images || flight.keyframes.at(keyframe).has_image();
      linked = linked || in_links.contains(keyframe);
    }
    if (one.keyframes == 0) continue;
    one.why = !images  ? "no image of it came down"
              : linked ? "the flight has linked it, but too few points agree"
                       : "no other keyframe shows its ground";
    apart.push_back(std::move(one));
  }
  return apart;
}

}  // namespace ilp::model
