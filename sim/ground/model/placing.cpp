#include "sim/ground/model/placing.hpp"

#include <algorithm>
#include <map>
#include <optional>

#include "sim/ground/model/view_similarity.hpp"

namespace ilp::model {
namespace {

World world_of(const Model& model) {
  return {[&model](std::size_t t) { return model.points[t].placed ? &model.points[t].position : nullptr; },
          [&model](std::uint32_t v) { return model.views[v].in ? &model.views[v].camera_from_model : nullptr; }};
}

World world_of(const Scene& scene, const Unit& unit) {
  return {[&scene, &unit](std::size_t t) {
            const Track& track = scene.tracks[t];
            return unit.rigid && track.of_flight && track.strip_id == unit.strip_id ? &track.strip_position : nullptr;
          },
          [&scene, &unit](std::uint32_t v) {
            const bool in = unit.rigid && std::binary_search(unit.views.begin(), unit.views.end(), v);
            return in ? &scene.views[v].camera_from_strip : nullptr;
          }};
}

/// Points of one world, in views of the other.
std::size_t fitting(const Scene& scene, const SeenPoints& seen, const World& views,
                    const Similarity& points_from_views) {
  std::size_t count = 0;
  for (std::uint32_t v = 0; v < seen.size(); ++v) {
    if (seen[v].empty()) continue;
    const RigidTransform pose = moved(points_from_views, *views.pose(v));
    for (const SeenPoint& one : seen[v])
      count += reprojection_error(pose, scene.views[v].camera, one.position, one.seen) < fits_px ? 1 : 0;
  }
  return count;
}

std::size_t count_of(const SeenPoints& seen) {
  std::size_t count = 0;
  for (const auto& of_view : seen) count += of_view.size();
  return count;
}

/// a_from_b, or none if too few sightings between the two worlds agree.
std::optional<Similarity> similarity_between(const Scene& scene, const World& a, const World& b) {
  const ViewDepths depths_a(scene, a), depths_b(scene, b);
  const SeenPoints a_in_b = seen_points(scene, a, depths_a, [&](std::uint32_t v) { return b.pose(v) != nullptr; });
  const SeenPoints b_in_a = seen_points(scene, b, depths_b, [&](std::uint32_t v) { return a.pose(v) != nullptr; });
  const std::size_t all = count_of(a_in_b) + count_of(b_in_a);
  if (all < min_sightings) return std::nullopt;
  std::size_t most = 0;
  std::optional<Similarity> best;
  const auto consider = [&](const Similarity& a_from_b) {
    const std::size_t count = fitting(scene, a_in_b, b, a_from_b) + fitting(scene, b_in_a, a, inverse(a_from_b));
    if (count <= most) return;
    most = count;
    best = a_from_b;
  };
  for (std::uint32_t v = 0; v < scene.views.size(); ++v) {
    if (b.pose(v) != nullptr) {
      if (const auto found = similarity_by_view(scene, v, a_in_b[v], a, *b.pose(v), depths_b)) consider(*found);
    } else if (a.pose(v) != nullptr) {
      if (const auto found = similarity_by_view(scene, v, b_in_a[v], b, *a.pose(v), depths_a))
        consider(inverse(*found));
    }
  }
  return enough(most, all) ? best : std::nullopt;
}

/// The lowest rung of the model's views with which a unit that moves as a whole shares points.
int rung_of(const Scene& scene, const TracksByView& seen_by, const Unit& unit, const Model& model) {
  if (std::none_of(model.views.begin(), model.views.end(), [](const ModelView& view) { return view.rung > 0; }))
    return 0;
  std::optional<int> lowest;
  for (const std::uint32_t v : unit.views) {
    const std::vector<std::size_t> shared = shared_points(scene, seen_by, v, model);
    for (std::size_t other = 0; other < shared.size(); ++other) {
      const int rung = model.views[other].rung;
      if (shared[other] >= min_sightings) lowest = std::min(lowest.value_or(rung), rung);
    }
  }
  return lowest.value_or(0);
}

bool resect_single(const Scene& scene, const TracksByView& seen_by, std::uint32_t v, Model& model) {
  const auto rung = rung_by_points(scene, seen_by, v, model);
  if (!rung) return false;
  const World world = world_of(model);
  const ViewDepths depths(scene, world);
  const SeenPoints seen = seen_points(scene, world, depths, [&](std::uint32_t view) { return view == v; });
  const auto resected = resect_view(scene, v, seen[v], world);
  if (!resected || !enough(resected->inliers, seen[v].size())) return false;
  model.views[v] = {true, resected->camera_from_world};
  model.views[v].rung = *rung;
  return true;
}

}  // namespace

std::vector<Unit> units_of(const Scene& scene) {
  std::map<std::int64_t, Unit> strips;
  std::vector<Unit> units;
  for (std::uint32_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    if (!view.posed) {
      units.push_back({view.strip_id, false, {v}});
      continue;
    }
    Unit& strip = strips[view.strip_id];
    strip.strip_id = view.strip_id;
    strip.views.push_back(v);
  }
  for (auto& [id, strip] : strips) {
    strip.rigid = strip.views.size() > 1;
    units.push_back(std::move(strip));
  }
  return units;
}

std::vector<std::size_t> shared_points(const Scene& scene, const TracksByView& seen_by, std::uint32_t v,
                                       const Model& model) {
  std::vector<std::size_t> shared(scene.views.size(), 0);
  for (const SeenTrack& seen_track : seen_by[v]) {
    for (const Sighting& seen : scene.tracks[seen_track.track].seen)
      shared[seen.view] += seen.view != v && model.views[seen.view].in ? 1 : 0;
  }
  return shared;
}

std::optional<int> rung_by_points(const Scene& scene, const TracksByView& seen_by, std::uint32_t v,
                                  const Model& model) {
  const std::vector<std::size_t> shared = shared_points(scene, seen_by, v, model);
  std::vector<int> rungs;
  for (std::size_t other = 0; other < shared.size(); ++other) {
    if (shared[other] >= min_sightings && model.views[other].attached_to != v) rungs.push_back(model.views[other].rung);
  }
  if (rungs.size() < 2) return std::nullopt;
  std::nth_element(rungs.begin(), rungs.begin() + 1, rungs.end());
  return rungs[1];
}

std::vector<std::size_t> common_tracks(const Scene& scene, const Model& model, const std::vector<Unit>& units) {
  std::vector<std::size_t> unit_of(scene.views.size(), units.size()), count(units.size(), 0);
  for (std::size_t u = 0; u < units.size(); ++u) {
    for (const std::uint32_t view : units[u].views) unit_of[view] = u;
  }
  std::vector<std::size_t> seeing;
  for (const Track& track : scene.tracks) {
    if (std::none_of(track.seen.begin(), track.seen.end(), [&](const Sighting& s) { return model.views[s.view].in; }))
      continue;
    seeing.clear();
    for (const Sighting& seen : track.seen) {
      const std::size_t unit = unit_of[seen.view];
      if (unit < units.size() && std::find(seeing.begin(), seeing.end(), unit) == seeing.end()) seeing.push_back(unit);
    }
    for (const std::size_t unit : seeing) ++count[unit];
  }
  return count;
}

bool place(const Scene& scene, const TracksByView& seen_by, const Unit& unit, Model& model) {
  if (!unit.rigid) return resect_single(scene, seen_by, unit.views.front(), model);
  const auto model_from_strip = similarity_between(scene, world_of(model), world_of(scene, unit));
  if (!model_from_strip) return false;
  const int rung = rung_of(scene, seen_by, unit, model);
  place_by(scene, unit, *model_from_strip, model);
  for (const std::uint32_t view : unit.views) model.views[view].rung = rung;
  return true;
}

void place_by(const Scene& scene, const Unit& unit, const Similarity& model_from_strip, Model& model) {
  for (const std::uint32_t view : unit.views)
    model.views[view] = {true, moved(model_from_strip, scene.views[view].camera_from_strip)};
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    const Track& track = scene.tracks[t];
    if (!track.of_flight || track.strip_id != unit.strip_id || model.points[t].placed) continue;
    model.points[t].placed = true;
    model.points[t].position = model_from_strip * track.strip_position;
  }
}

}  // namespace ilp::model
