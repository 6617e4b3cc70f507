#include "sim/ground/model/joined_model.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "sim/ground/model/growth.hpp"
#include "sim/ground/model/hanging.hpp"
#include "sim/ground/model/join_summary.hpp"
#include "sim/ground/model/link_sightings.hpp"
#include "sim/ground/model/model_relations.hpp"
#include "sim/ground/model/moving.hpp"
#include "sim/ground/model/pair_matching.hpp"
#include "sim/ground/model/sub_mapped_model.hpp"
#include "sim/ground/model/ties.hpp"

namespace ilp::model {
namespace {

bool has_link_within(const intake::Flight& flight, std::int64_t strip_id) {
  return std::any_of(flight.links.begin(), flight.links.end(), [&](const LinkRecord& link) {
    return link.strip_id == strip_id && link.place_strip_id == strip_id;
  });
}

void regroup(intake::Flight& flight) {
  for (auto& [id, strip] : flight.strips) strip.keyframes.clear();
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (keyframe.strip_id > 0) flight.strips[keyframe.strip_id].keyframes.push_back(id);
  }
}

/// Strips that no points join stand where their ties put them.
bool place_by_ties(const intake::Flight& flight, const Scene& scene, const std::vector<Unit>& units,
                   std::vector<std::uint8_t>& taken, Model& model) {
  bool any = false;
  for (const TieRecord& tie : flight.ties) {
    const auto unit = std::find_if(units.begin(), units.end(), [&](const Unit& one) {
      return one.strip_id == tie.id && scene.views[one.views.front()].posed;
    });
    if (unit == units.end() || taken[static_cast<std::size_t>(unit - units.begin())] != 0) continue;
    const auto similarity = similarity_by_tie(flight, tie);
    const auto known = model_from_strip(scene, model, tie.to_strip_id);
    if (!known || !similarity) continue;
    place_by(scene, *unit, compose(*known, *similarity), model);
    taken[static_cast<std::size_t>(unit - units.begin())] = 1;
    any = true;
  }
  return any;
}

std::vector<std::size_t> seeds_of(const std::vector<Unit>& units) {
  std::vector<std::size_t> seeds;
  for (std::size_t u = 0; u < units.size(); ++u) {
    if (units[u].rigid) seeds.push_back(u);
  }
  std::stable_sort(seeds.begin(), seeds.end(),
                   [&](std::size_t a, std::size_t b) { return units[a].views.size() > units[b].views.size(); });
  return seeds;
}

/// By the links within a strip, how far its poses see its earlier ground from where it is.
double drift_px(const intake::Flight& flight, const Scene& scene, std::int64_t strip_id) {
  double drift = 0;
  for (const LinkRecord& link : flight.links) {
    const std::int32_t view = scene.view_of(link.keyframe_id);
    if (view < 0 || link.strip_id != strip_id || link.place_strip_id != strip_id) continue;
    drift = std::max(drift, link.closing_error * scene.views[static_cast<std::size_t>(view)].camera.fx);
  }
  return std::min(drift, most_drift_px);
}

/// Sightings that were refused before the last adjustment may fit after it. `before`: before that adjustment.
void settle_finally(const Scene& scene, ModelExtent before, Model& model) {
  for (int round = 0; round < 2; ++round) {
    const ModelExtent now = extent_of(scene, model);
    if (now.same_parts(before)) return;
    settle(scene, final_px, model);
    before = now;
  }
}

/// What hangs at the model may lead to more, and, where the model stands then, to more points in common.
void hang_all(const std::vector<Unit>& units, Scene& scene, std::vector<std::uint8_t>& taken, Model& model,
              const JoinProgress& progress) {
  bool any = false;
  while (hang_one(scene, units, taken, model)) {
    any = true;
    triangulate(scene, placing_px, model);
    place_all(scene, units, taken, model);
  }
  if (!any) return;
  progress("Adjusting what hangs at one keyframe");
  for (const double bound : {placing_px, adjusted_px, final_px}) {
    settle(scene, bound, model);
    match_pairs(relations_by_model(scene, model), scene);
    grow(scene, model);
    triangulate(scene, bound, model);
    review_hanging(scene, model);
    place_all(scene, units, taken, model);
  }
  settle_finally(scene, {}, model);
}

/// Grows a model from one strip. False if nothing joins it and no link closes a loop in it: it stays as it is.
bool grow_from(const intake::Flight& flight, const std::vector<Unit>& units, std::size_t seed, Scene& scene,
               std::vector<std::uint8_t>& taken, Model& model, const JoinProgress& progress) {
  taken[seed] = 1;
  const bool linked = has_link_within(flight, units[seed].strip_id);
  if (grow_in_sub_maps(flight, units, seed, scene, taken, model, progress))
    return linked || strips_in(scene, model) > 1;
  model = model_of_strip(scene, units[seed].strip_id);
  triangulate(scene, placing_px, model);
  place_all(scene, units, taken, model);
  if (model.size() == units[seed].views.size() && !linked) return false;
  close_loops(scene, drift_px(flight, scene, units[seed].strip_id), model);
  ModelExtent before_last;
  for (const double bound : {adjusted_px, final_px}) {
    progress("Adjusting the model of strip " + std::to_string(units[seed].strip_id));
    before_last = extent_of(scene, model);
    settle(scene, bound, model);
    match_pairs(relations_by_model(scene, model), scene);
    grow(scene, model);
    triangulate(scene, adjusted_px, model);
    place_all(scene, units, taken, model);
  }
  settle_finally(scene, before_last, model);
  hang_all(units, scene, taken, model, progress);
  return true;
}

/// Links and sightings that hold anything may lead an adjustment to what is no place: no strip is moved there.
bool is_sound(const Scene& scene, const Model& model) {
  constexpr double largest_scale = 1e6;
  std::set<std::int64_t> strips;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const ModelView& view = model.views[v];
    if (!view.in) continue;
    if (!view.camera_from_model.rotation.allFinite() || !view.camera_from_model.translation.allFinite()) return false;
    const bool next_strip = scene.views[v].posed && strips.insert(scene.views[v].strip_id).second;
    const auto similarity = next_strip ? model_from_strip(scene, model, scene.views[v].strip_id) : std::nullopt;
    if (similarity && !(similarity->scale > 1 / largest_scale && similarity->scale < largest_scale)) return false;
  }
  return std::isfinite(median_error_px(scene, model)) &&
         std::all_of(model.points.begin(), model.points.end(),
                     [](const ModelPoint& point) { return !point.placed || point.position.allFinite(); });
}

Scene matched_scene(const intake::Flight& flight, intake::ResultCache* results, const JoinProgress& progress) {
  Scene scene = scene_of(flight);
  scene.results = results;
  add_link_sightings(flight, scene);
  const std::vector<std::uint8_t> loose = loose_views(scene);
  if (std::find(loose.begin(), loose.end(), 1) == loose.end()) return scene;
  progress("Finding corners");
  add_images(scene);
  std::vector<PairRelation> relations = relations_by_links(flight, scene);
  const std::vector<PairRelation> more = relations_by_features(scene, relations);
  relations.insert(relations.end(), more.begin(), more.end());
  progress("Matching keyframes that show the same ground");
  match_pairs(relations, scene);
  return scene;
}

}  // namespace

JoinedFlight join_strips(intake::Flight& flight, const JoinProgress& progress, intake::ResultCache* results) {
  JoinedFlight joined;
  if (flight.links.empty()) return joined;
  Scene scene = matched_scene(flight, results, progress);
  const std::vector<Unit> units = units_of(scene);
  std::vector<std::uint8_t> taken(units.size(), 0);
  std::vector<Model> models;
  for (const std::size_t seed : seeds_of(units)) {
    if (taken[seed] != 0) continue;
    Model model;
    const bool adjusted = grow_from(flight, units, seed, scene, taken, model, progress);
    const bool tied = place_by_ties(flight, scene, units, taken, model);
    if (!adjusted && !tied) continue;
    const std::int64_t strip_id = reference_strip(flight, scene, model);
    if (!is_sound(scene, model)) continue;
    if (const auto back = model_from_strip(scene, model, strip_id)) move(inverse(*back), model);
    if (adjusted && !model.by_sub_maps) state_errors(scene, model);
    joined.models.push_back(summary_of(flight, scene, model, strip_id));
    joined.models.back().by_ties = tied;
    models.push_back(std::move(model));
  }
  for (std::size_t i = 0; i < models.size(); ++i) {
    grow(scene, models[i]);
    move_flight(scene, models[i], joined.models[i].strip_id, flight);
  }
  joined.apart = strips_apart(flight, joined.models);
  regroup(flight);
  return joined;
}

}  // namespace ilp::model
