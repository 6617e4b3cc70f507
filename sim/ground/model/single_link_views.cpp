#include "sim/ground/model/single_link_views.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/geometry/camera.hpp"
#include "sim/ground/model/view_similarity.hpp"

namespace ilp::model {
namespace {

constexpr std::size_t least_shared = 24;
constexpr double least_relief = 0.01;

int highest_rung(const Model& model) {
  int highest = 0;
  for (const ModelView& view : model.views) highest = std::max(highest, view.in ? view.rung : 0);
  return highest;
}

/// The points that views below this rung measure.
World world_below(const Scene& scene, const Model& model, int rung) {
  return {[&scene, &model, rung](std::size_t t) -> const Vec3* {
            const ModelPoint& point = model.points[t];
            if (!point.placed || point.by_depth) return nullptr;
            for (const Sighting& seen : scene.tracks[t].seen) {
              if (model.views[seen.view].in && model.views[seen.view].rung >= rung) return nullptr;
            }
            return &point.position;
          },
          [&model](std::uint32_t v) { return model.views[v].in ? &model.views[v].camera_from_model : nullptr; }};
}

/// A view of the model and the points that it shares with a view outside.
struct Hold {
  std::uint32_t view = 0;
  std::size_t shared = 0;
};

Hold best_hold(const Scene& scene, const TracksByView& seen_by, std::uint32_t v, const Model& model) {
  const std::vector<std::size_t> shared = shared_points(scene, seen_by, v, model);
  const auto most = std::max_element(shared.begin(), shared.end());
  return {static_cast<std::uint32_t>(most - shared.begin()), *most};
}

Vec3 point_at_depth(const Scene& scene, const Model& model, const Sighting& seen, double inverse_depth) {
  const Vec2 n = normalised_from_ideal(scene.views[seen.view].camera, Vec2(seen.x, seen.y));
  const RigidTransform& pose = model.views[seen.view].camera_from_model;
  return pose.rotation.transpose() * (Vec3(n.x(), n.y(), 1) / inverse_depth - pose.translation);
}

std::vector<SeenPoint> points_of_hold(const Scene& scene, const TracksByView& seen_by, std::uint32_t v,
                                      const Hold& hold, const ViewDepths& depths, const Model& model) {
  std::vector<SeenPoint> points;
  for (const SeenTrack& one : seen_by[v]) {
    const Track& track = scene.tracks[one.track];
    const Sighting* const there = scene.sighting(track, hold.view);
    const auto inverse = there == nullptr ? std::nullopt : depths.any(hold.view, there->x, there->y);
    if (!inverse) continue;
    points.push_back({point_at_depth(scene, model, *there, *inverse), track.seen[one.sighting]});
  }
  return points;
}

bool attach(const Scene& scene, const TracksByView& seen_by, std::uint32_t v, const Hold& hold, Model& model) {
  const int rung = model.views[hold.view].rung + 1;
  const World world = world_below(scene, model, rung);
  const ViewDepths depths(scene, world);
  const std::vector<SeenPoint> points = points_of_hold(scene, seen_by, v, hold, depths, model);
  if (points.size() < least_shared) return false;
  const auto resected = resect_view(scene, v, points, world);
  if (!resected || resected->inliers < least_shared || 2 * resected->inliers < points.size()) return false;
  model.views[v] = {true, resected->camera_from_world};
  model.views[v].attached_to = hold.view;
  model.views[v].rung = rung;
  return true;
}

/// Those that it measures with others.
std::size_t points_of(const Scene& scene, const TracksByView& seen_by, std::uint32_t v, const Model& model) {
  return static_cast<std::size_t>(std::count_if(seen_by[v].begin(), seen_by[v].end(), [&](const SeenTrack& one) {
    return model.points[one.track].placed && model.sees(scene, one.track, one.sighting);
  }));
}

}  // namespace

SingleLinkDepths::SingleLinkDepths(const Scene& scene, const Model& model)
    : scene_(scene), model_(model), sigma_(scene.views.size(), 0) {
  const int highest = highest_rung(model);
  for (int rung = 0; rung <= highest && highest > 0; ++rung)
    below_.emplace_back(scene, world_below(scene, model, rung));
  if (highest == 0) return;
  std::vector<std::size_t> points(scene.views.size(), 0);
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    if (const auto view = single_link_view(t)) ++points[*view];
  }
  for (std::uint32_t v = 0; v < scene.views.size(); ++v) {
    const ModelView& view = model.views[v];
    if (!view.attached_to) continue;
    const double relief = below_[static_cast<std::size_t>(view.rung)].relief(*view.attached_to).value_or(least_relief);
    sigma_[v] = std::max(least_relief, relief) * std::sqrt(static_cast<double>(points[v]));
  }
}

/// The single-link view of the lowest rung that sees the point from its hold, if no other view measures the point.
std::optional<std::uint32_t> SingleLinkDepths::single_link_view(std::size_t track) const {
  if (!model_.points[track].placed) return std::nullopt;
  std::optional<std::uint32_t> lowest;
  for (std::size_t s = 0; s < scene_.tracks[track].seen.size(); ++s) {
    const std::uint32_t v = scene_.tracks[track].seen[s].view;
    if (!model_.sees(scene_, track, s) || !model_.views[v].attached_to) continue;
    if (!lowest || model_.views[v].rung < model_.views[*lowest].rung) lowest = v;
  }
  if (!lowest) return std::nullopt;
  bool from_hold = false;
  for (std::size_t s = 0; s < scene_.tracks[track].seen.size(); ++s) {
    const std::uint32_t v = scene_.tracks[track].seen[s].view;
    if (!model_.sees(scene_, track, s)) continue;
    const bool is_hold = v == *model_.views[*lowest].attached_to;
    from_hold = from_hold || is_hold;
    if (!is_hold && model_.views[v].rung < model_.views[*lowest].rung) return std::nullopt;
  }
  return from_hold ? lowest : std::nullopt;
}

std::optional<AdjustedDepth> SingleLinkDepths::of(std::size_t track) const {
  if (below_.empty()) return std::nullopt;
  const auto single_link = single_link_view(track);
  if (!single_link) return std::nullopt;
  const ModelView& view = model_.views[*single_link];
  const Sighting* const seen = scene_.sighting(scene_.tracks[track], *view.attached_to);
  const auto inverse = below_[static_cast<std::size_t>(view.rung)].any(seen->view, seen->x, seen->y);
  if (!inverse) return std::nullopt;
  return AdjustedDepth{*view.attached_to, 0, *inverse, sigma_[*single_link]};
}

bool attach_single_link_view(const Scene& scene, const std::vector<Unit>& units, std::vector<std::uint8_t>& taken,
                             Model& model) {
  const TracksByView seen_by = tracks_by_view(scene);
  std::vector<std::pair<Hold, std::size_t>> holds;  // with their units
  for (std::size_t u = 0; u < units.size(); ++u) {
    if (taken[u] != 0 || units[u].rigid) continue;
    const Hold hold = best_hold(scene, seen_by, units[u].views.front(), model);
    if (hold.shared >= least_shared) holds.emplace_back(hold, u);
  }
  std::stable_sort(holds.begin(), holds.end(),
                   [](const auto& a, const auto& b) { return a.first.shared > b.first.shared; });
  for (const auto& [hold, u] : holds) {
    if (!attach(scene, seen_by, units[u].views.front(), hold, model)) continue;
    taken[u] = 1;
    return true;
  }
  return false;
}

void review_single_link_views(const Scene& scene, Model& model) {
  if (highest_rung(model) == 0) return;
  const TracksByView seen_by = tracks_by_view(scene);
  for (std::uint32_t v = 0; v < scene.views.size(); ++v) {
    ModelView& view = model.views[v];
    if (!view.in || view.rung == 0) continue;
    const auto rung = rung_by_points(scene, seen_by, v, model);
    if (rung && *rung < view.rung) {
      view.rung = *rung;
      view.attached_to.reset();
    } else if (view.attached_to && points_of(scene, seen_by, v, model) < least_shared) {
      view = {};
    }
  }
}

}  // namespace ilp::model
