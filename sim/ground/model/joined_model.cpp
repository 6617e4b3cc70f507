#include "sim/ground/model/joined_model.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "sim/ground/model/growth.hpp"
#include "sim/ground/model/join_summary.hpp"
#include "sim/ground/model/link_sightings.hpp"
#include "sim/ground/model/map_fixes.hpp"
#include "sim/ground/model/model_relations.hpp"
#include "sim/ground/model/moving.hpp"
#include "sim/ground/model/pair_matching.hpp"
#include "sim/ground/model/single_link_views.hpp"
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

/// Adjusts, and seeks more points in common where the model stands then.
void adjust_and_match(const std::vector<Unit>& units, double bound, Scene& scene, std::vector<std::uint8_t>& taken,
                      Model& model) {
  adjust_in_steps(scene, bound, model);
  match_pairs(relations_by_model(scene, model), scene);
  grow(scene, model);
  triangulate(scene, adjusted_px, model);
  place_all(scene, units, taken, model);
}

/// Sightings that were refused before the last adjustment may fit after it. `before`: before that adjustment.
void adjust_finally(const Scene& scene, ModelExtent before, Model& model) {
  for (int round = 0; round < 2; ++round) {
    const ModelExtent now = extent_of(scene, model);
    if (now.same_parts(before)) return;
    adjust_in_steps(scene, final_px, model);
    before = now;
  }
}

/// A single-link view may lead to more of them, and to more points in common where the model is placed then.
void attach_single_link_views(const std::vector<Unit>& units, Scene& scene, std::vector<std::uint8_t>& taken,
                              Model& model, const JoinProgress& progress) {
  bool any = false;
  while (attach_single_link_view(scene, units, taken, model)) {
    any = true;
    triangulate(scene, placing_px, model);
    place_all(scene, units, taken, model);
  }
  if (!any) return;
  progress("Adjusting keyframes with a single link");
  for (const double bound : {placing_px, adjusted_px, final_px}) {
    adjust_in_steps(scene, bound, model);
    match_pairs(relations_by_model(scene, model), scene);
    grow(scene, model);
    triangulate(scene, bound, model);
    review_single_link_views(scene, model);
    place_all(scene, units, taken, model);
  }
  adjust_finally(scene, {}, model);
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
    adjust_and_match(units, bound, scene, taken, model);
  }
  adjust_finally(scene, before_last, model);
  attach_single_link_views(units, scene, taken, model, progress);
  return true;
}

/// Links and sightings that hold anything may lead an adjustment to what is no place: no strip is moved there.
bool is_valid(const Scene& scene, const Model& model) {
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
  const std::vector<std::uint8_t> weak = weakly_connected_views(scene);
  if (std::find(weak.begin(), weak.end(), 1) == weak.end()) return scene;
  progress("Finding corners");
  add_images(scene);
  std::vector<PairRelation> relations = relations_by_links(flight, scene);
  const std::vector<PairRelation> more = relations_by_features(scene, relations);
  relations.insert(relations.end(), more.begin(), more.end());
  progress("Matching keyframes that show the same ground");
  match_pairs(relations, scene);
  return scene;
}

/// A model that has grown as far as points and ties lead.
struct Grown {
  Model model;
  bool adjusted = false, tied = false;
};

/// The fixes take out what the model has drifted.
void adjust_on_map(const std::vector<Unit>& units, Scene& scene, std::vector<std::uint8_t>& taken, Model& model,
                   const JoinProgress& progress) {
  progress("Adjusting the model to the map");
  for (int round = 0; round < 2; ++round) {
    (void)weigh_fixes(scene, false, model);
    adjust_in_steps(scene, placing_px, model);
  }
  for (const double bound : {adjusted_px, final_px}) {
    (void)weigh_fixes(scene, true, model);
    adjust_and_match(units, bound, scene, taken, model);
  }
  constexpr int most_rounds = 6;
  for (int round = 0; round < most_rounds; ++round) {
    const bool changed = weigh_fixes(scene, true, model);
    if (!changed && round > 0) break;
    adjust_in_steps(scene, final_px, model);
  }
}

/// `before`: where all fixes together have put the strips.
OnMap reported_of_map(const Scene& scene, const intake::MapPlace& map, const std::vector<ModelView>& before,
                      const Model& model) {
  OnMap on_map;
  on_map.map = map;
  on_map.error_factor = model.fix_weights.error_factor;
  on_map.image_factor = model.fix_weights.image_factor;
  const std::vector<double> errors = fix_errors(scene, model);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const bool used = errors[i] < contradicting_fix;
    on_map.fixes.push_back({scene.views[model.fixes[i].view].keyframe_id, errors[i], used});
    on_map.used += used ? 1U : 0U;
  }
  std::sort(on_map.fixes.begin(), on_map.fixes.end(),
            [](const OnMap::Fix& a, const OnMap::Fix& b) { return a.keyframe_id < b.keyframe_id; });
  std::vector<double> removed, sigmas;
  for (std::size_t v = 0; v < model.views.size(); ++v) {
    if (!model.views[v].in) continue;
    if (before[v].in)
      removed.push_back((centre_of(model.views[v].camera_from_model) - centre_of(before[v].camera_from_model)).norm());
    if (const auto& c = model.views[v].covariance) sigmas.push_back(std::sqrt(0.5 * ((*c)[9] + (*c)[14])));
  }
  on_map.removed_m = host::summarise(removed);
  on_map.map.place_sigma_m = sigmas.empty() ? 0 : host::median(std::move(sigmas));
  return on_map;
}

struct Finished {
  Model model;
  JoinedModel reported;
};

std::optional<Finished> finished_in_strip(const intake::Flight& flight, const Scene& scene, Grown grown) {
  if (!grown.adjusted && !grown.tied) return std::nullopt;
  Model& model = grown.model;
  const std::int64_t strip_id = reference_strip(flight, scene, model);
  if (!is_valid(scene, model)) return std::nullopt;
  if (const auto back = model_from_strip(scene, model, strip_id)) move(inverse(*back), model);
  if (grown.adjusted && !model.by_sub_maps) state_errors(scene, model);
  Finished out{{}, summary_of(flight, scene, model, strip_id)};
  out.reported.by_ties = grown.tied;
  out.model = std::move(model);
  return out;
}

/// Models with fixes on the map, each as it has grown and as it stands there.
struct OnOneMap {
  std::vector<Grown> grown;
  std::vector<Model> parts;
};

/// One model of all of them. None where it is unsound.
std::optional<Finished> finished_on_map(const intake::Flight& flight, const intake::MapPlace& map,
                                        const std::vector<Unit>& units, const OnOneMap& all, Scene& scene,
                                        std::vector<std::uint8_t>& taken, const JoinProgress& progress) {
  Model model = united(scene, all.parts);
  const std::vector<ModelView> before = model.views;
  adjust_on_map(units, scene, taken, model, progress);
  if (!is_valid(scene, model)) return std::nullopt;
  state_errors(scene, model);
  Finished out{{}, summary_of(flight, scene, model, reference_strip(flight, scene, model))};
  out.reported.by_ties = std::any_of(all.grown.begin(), all.grown.end(), [](const Grown& one) { return one.tied; });
  out.reported.on_map = reported_of_map(scene, map, before, model);
  out.model = std::move(model);
  return out;
}

}  // namespace

JoinedFlight join_strips(intake::Flight& flight, const JoinProgress& progress, intake::ResultCache* results) {
  JoinedFlight joined;
  const std::optional<intake::MapPlace> map = map_of(flight);
  if (flight.links.empty() && !map) return joined;
  Scene scene = matched_scene(flight, results, progress);
  const std::vector<Unit> units = units_of(scene);
  std::vector<std::uint8_t> taken(units.size(), 0);
  OnOneMap on_map;
  std::vector<Finished> finished;
  const auto finish = [&](Grown grown) {
    if (auto one = finished_in_strip(flight, scene, std::move(grown))) finished.push_back(std::move(*one));
  };
  for (const std::size_t seed : seeds_of(units)) {
    if (taken[seed] != 0) continue;
    Grown grown;
    grown.adjusted = grow_from(flight, units, seed, scene, taken, grown.model, progress);
    grown.tied = place_by_ties(flight, scene, units, taken, grown.model);
    if (Model part = map ? grown.model : Model{}; map && place_on_map(scene, *map, part)) {
      on_map.grown.push_back(std::move(grown));
      on_map.parts.push_back(std::move(part));
    } else {
      finish(std::move(grown));
    }
  }
  if (!on_map.parts.empty()) {
    if (auto one = finished_on_map(flight, *map, units, on_map, scene, taken, progress)) {
      finished.push_back(std::move(*one));
    } else {
      for (Grown& grown : on_map.grown) {
        grow(scene, grown.model);
        finish(std::move(grown));
      }
    }
  }
  for (Finished& one : finished) {
    grow(scene, one.model);
    move_flight(scene, one.model, one.reported.strip_id, one.reported.on_map.has_value(), flight);
    if (one.reported.on_map) flight.strips.at(one.reported.strip_id).map = one.reported.on_map->map;
    joined.models.push_back(std::move(one.reported));
  }
  joined.apart = strips_apart(flight, joined.models);
  regroup(flight);
  return joined;
}

}  // namespace ilp::model
