#include "sim/ground/model/sub_mapped_model.hpp"

#include <algorithm>
#include <set>

#include "sim/ground/model/growth.hpp"
#include "sim/ground/model/model_relations.hpp"
#include "sim/ground/model/moving.hpp"
#include "sim/ground/model/point_refinement.hpp"
#include "sim/ground/model/sub_map_network.hpp"

namespace ilp::model {
namespace {

constexpr int rounds_of_matching = 2;

/// Empty where one adjustment holds them all.
std::vector<std::uint8_t> views_of_long_model(const Scene& scene, const std::vector<Unit>& units, std::size_t seed,
                                              const std::vector<std::uint8_t>& taken) {
  std::vector<std::uint8_t> wanted = connected_views(scene, units[seed].views.front());
  for (std::size_t u = 0; u < units.size(); ++u) {
    if (taken[u] == 0 || u == seed) continue;
    for (const std::uint32_t v : units[u].views) wanted[v] = 0;
  }
  const auto count = static_cast<std::size_t>(std::count(wanted.begin(), wanted.end(), 1));
  return count > whole_model_views ? wanted : std::vector<std::uint8_t>{};
}

std::vector<SubMap> adjusted_sub_maps(const Scene& scene, const std::vector<std::uint8_t>& wanted) {
  std::vector<SubMap> maps;
  for (const SubMapPlan& plan : plan_sub_maps(scene, wanted)) {
    if (auto map = adjusted_sub_map(scene, plan)) maps.push_back(std::move(*map));
  }
  return maps;
}

/// The first sub-map that has two keyframes of the unit, or none.
std::size_t map_of_unit(const std::vector<SubMap>& maps, const Unit& unit) {
  const auto has_two = [&](const SubMap& map) {
    return std::count_if(map.cameras.begin(), map.cameras.end(), [&](const SubMapCamera& camera) {
             return std::binary_search(unit.views.begin(), unit.views.end(), camera.view);
           }) >= 2;
  };
  return static_cast<std::size_t>(std::find_if(maps.begin(), maps.end(), has_two) - maps.begin());
}

/// All views of the model, from the sub-maps that are connected with the unit's.
bool place_views(const intake::Flight& flight, const Scene& scene, const Unit& unit, const std::vector<SubMap>& maps,
                 Model& model, std::vector<const SubMap*>& placed) {
  const std::size_t first = map_of_unit(maps, unit);
  if (first == maps.size()) return false;
  model = Model{};
  model.views.resize(scene.views.size());
  std::vector<std::uint8_t> taken(maps.size(), 0);
  placed = place_sub_maps(maps, first, taken, model);
  const auto to_world = [&](Model& moving) {
    const std::int64_t strip_id = reference_strip(flight, scene, moving);
    if (const auto back = model_from_strip(scene, moving, strip_id)) move(inverse(*back), moving);
  };
  to_world(model);
  return adjust_network(placed, to_world, model);
}

/// All points that fit where the views stand now.
void place_points(const Scene& scene, const std::vector<const SubMap*>& maps, Model& model) {
  grow(scene, model);
  for (const SubMap* map : maps) {
    for (const SubMap::Refused& one : map->refused) model.refuse(one.track, one.sighting, true);
    const Similarity model_from_map = model_from_sub_map(*map, model).value_or(Similarity{});
    for (const SubMap::Point& point : map->points) {
      ModelPoint& placed = model.points[point.track];
      placed.placed = true;
      placed.by_depth = point.by_depth;
      placed.position = model_from_map * point.position;
    }
  }
  refine_points(scene, final_px / 3, model);
  triangulate(scene, final_px, model);
  refuse_outliers(scene, final_px, model);
}

std::size_t sightings_in(const Scene& scene) {
  std::size_t count = 0;
  for (const Track& track : scene.tracks) count += track.seen.size();
  return count;
}

}  // namespace

bool grow_in_sub_maps(const intake::Flight& flight, const std::vector<Unit>& units, std::size_t seed, Scene& scene,
                      std::vector<std::uint8_t>& taken, Model& model, const JoinProgress& progress) {
  const std::vector<std::uint8_t> weak = weakly_connected_views(scene);
  const bool matching = std::find(weak.begin(), weak.end(), 1) != weak.end();
  Model grown;
  for (int round = 0; round <= rounds_of_matching; ++round) {
    const std::vector<std::uint8_t> wanted = views_of_long_model(scene, units, seed, taken);
    if (wanted.empty()) return false;
    progress("Adjusting the sub-maps of strip " + std::to_string(units[seed].strip_id));
    const std::vector<SubMap> maps = adjusted_sub_maps(scene, wanted);
    std::vector<const SubMap*> placed;
    if (!place_views(flight, scene, units[seed], maps, grown, placed)) return false;
    place_points(scene, placed, grown);
    if (round == rounds_of_matching || !matching) break;
    const std::size_t before = sightings_in(scene);
    match_pairs(relations_by_model(scene, grown), scene);
    if (sightings_in(scene) == before) break;
  }
  grown.by_sub_maps = true;
  model = std::move(grown);
  for (std::size_t u = 0; u < units.size(); ++u) {
    if (std::any_of(units[u].views.begin(), units[u].views.end(), [&](std::uint32_t v) { return model.views[v].in; }))
      taken[u] = 1;
  }
  return true;
}

std::size_t strips_in(const Scene& scene, const Model& model) {
  std::set<std::int64_t> strips;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    if (model.views[v].in) strips.insert(scene.views[v].strip_id);
  }
  return strips.size();
}

}  // namespace ilp::model
