#include "sim/ground/model/sub_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <memory_resource>
#include <utility>

#include "sim/ground/model/growth.hpp"
#include "sim/ground/model/normal_equations.hpp"
#include "sim/ground/model/thinned_closing.hpp"

namespace ilp::model {
namespace {

constexpr double robust_px = 0.5;
/// What an adjustment that closes loops leaves, the one with the last bound takes in its first step.
constexpr double closing_tolerance = 1e-2;
/// What the last adjustment leaves is in the equations, and the adjustment of all sub-maps takes it.
constexpr double last_tolerance = 1e-2;

/// The part of a scene that a plan names, with numbers of its own; its own tracks come first.
struct PartOfScene {
  std::unique_ptr<std::pmr::monotonic_buffer_resource> memory;  ///< of the tracks, which stand beside each other in it
  Scene scene;
  std::size_t own_tracks = 0;
  std::vector<std::uint32_t> sighting_of;  ///< its number in the whole track; sightings track after track
  std::vector<std::size_t> first;          ///< by track, in `sighting_of`
};

PartOfScene part_of(const Scene& whole, const SubMapPlan& plan) {
  PartOfScene part;
  part.memory = std::make_unique<std::pmr::monotonic_buffer_resource>();
  part.own_tracks = plan.tracks.size();
  std::vector<std::uint32_t> number(whole.views.size(), static_cast<std::uint32_t>(plan.views.size()));
  for (const std::uint32_t v : plan.views) {
    const View& from = whole.views[v];
    number[v] = static_cast<std::uint32_t>(part.scene.views.size());
    View& view = part.scene.views.emplace_back();
    view.keyframe_id = from.keyframe_id;
    view.strip_id = from.strip_id;
    view.camera = from.camera;
    view.posed = from.posed;
    view.camera_from_strip = from.camera_from_strip;
  }
  for (std::size_t i = 0; i < plan.tracks.size() + plan.support.size(); ++i) {
    const Track& from = whole.tracks[i < plan.tracks.size() ? plan.tracks[i] : plan.support[i - plan.tracks.size()]];
    const auto in_part = [&](const Sighting& seen) { return number[seen.view] != plan.views.size(); };
    Track& track = part.scene.tracks.emplace_back(
        Track{from.of_flight, from.strip_id, from.strip_position, Sightings(part.memory.get())});
    track.seen.reserve(static_cast<std::size_t>(std::count_if(from.seen.begin(), from.seen.end(), in_part)));
    part.first.push_back(part.sighting_of.size());
    for (std::size_t s = 0; s < from.seen.size(); ++s) {
      if (!in_part(from.seen[s])) continue;
      track.seen.push_back({number[from.seen[s].view], from.seen[s].x, from.seen[s].y});
      part.sighting_of.push_back(static_cast<std::uint32_t>(s));
    }
  }
  return part;
}

std::uint64_t digest_of(const Scene& part, std::size_t own_tracks) {
  intake::InputDigest digest("sub-map 5");
  digest.add_value(part.views.size()).add_value(part.tracks.size()).add_value(own_tracks);
  std::vector<double> numbers;
  for (const View& view : part.views) {
    digest.add_value(view.keyframe_id).add_value(view.strip_id).add_value(view.posed);
    const CameraModel& camera = view.camera;
    numbers.insert(numbers.end(), {camera.fx, camera.fy, camera.cx, camera.cy});
    const RigidTransform& pose = view.camera_from_strip;
    numbers.insert(numbers.end(), pose.rotation.data(), pose.rotation.data() + 9);
    numbers.insert(numbers.end(), pose.translation.data(), pose.translation.data() + 3);
  }
  for (const Track& track : part.tracks) {
    digest.add_value(track.of_flight).add_value(track.strip_id).add_value(track.seen.size());
    numbers.insert(numbers.end(), track.strip_position.data(), track.strip_position.data() + 3);
    for (const Sighting& seen : track.seen) {
      digest.add_value(seen.view);
      numbers.insert(numbers.end(), {seen.x, seen.y});
    }
  }
  return digest.add({reinterpret_cast<const std::uint8_t*>(numbers.data()), numbers.size() * sizeof(double)}).value();
}

/// The strip with most poses begins, as in the whole model.
Model grown_model(const Scene& part) {
  const std::vector<Unit> units = units_of(part);
  const auto seed = std::max_element(units.begin(), units.end(), [](const Unit& a, const Unit& b) {
    return std::pair(a.rigid, a.views.size()) < std::pair(b.rigid, b.views.size());
  });
  if (seed == units.end() || !seed->rigid) return {};
  std::vector<std::uint8_t> taken(units.size(), 0);
  taken[static_cast<std::size_t>(seed - units.begin())] = 1;
  Model model = model_of_strip(part, seed->strip_id);
  triangulate(part, placing_px, model);
  place_all(part, units, taken, model);
  close_loops_by_few(part, most_drift_px, model, closing_tolerance);
  ModelExtent before = extent_of(part, model);
  if (before.refused != 0 || before.largest_error_px > final_px) {
    adjust_in_steps(part, adjusted_px, model, last_tolerance);
    before = extent_of(part, model);
  }
  adjust_in_steps(part, final_px, model, last_tolerance);
  if (!extent_of(part, model).same_parts(before)) adjust_in_steps(part, final_px, model, last_tolerance);
  return model;
}

double mean_weight(const AdjustmentProblem& problem) {
  double sum = 0;
  for (const AdjustedObservation& seen : problem.observations) {
    const AdjustedCamera& camera = problem.cameras[seen.camera];
    const Vec3 p = camera.cam_from_world * (problem.points[seen.point] - camera.centre);
    const Vec2 error(camera.fx * p.x() / p.z() + camera.cx - seen.x, camera.fy * p.y() / p.z() + camera.cy - seen.y);
    sum += 1 / (1 + error.squaredNorm() / (robust_px * robust_px));
  }
  return problem.observations.empty() ? 1 : sum / static_cast<double>(problem.observations.size());
}

/// Without the points of other sub-maps.
ModelProblem own_problem(const ModelProblem& all, std::size_t own_tracks) {
  ModelProblem own;
  own.cameras = all.cameras;
  own.view_of = all.view_of;
  for (std::size_t p = 0; p < all.points.size() && all.track_of[p] < own_tracks; ++p) {
    own.points.push_back(all.points[p]);
    own.track_of.push_back(all.track_of[p]);
  }
  const auto is_own = [&](const auto& one) { return one.point < own.points.size(); };
  std::copy_if(all.observations.begin(), all.observations.end(), std::back_inserter(own.observations), is_own);
  std::copy_if(all.depths.begin(), all.depths.end(), std::back_inserter(own.depths), is_own);
  return own;
}

/// Cameras of which nothing is known are left out.
void add_equations(const ModelProblem& problem, const Model& model, const CameraEquations& equations, SubMap& map) {
  std::vector<std::uint8_t> known(problem.cameras.size(), 0);
  for (const CameraBlock& block : equations.blocks) known[block.row] |= block.row == block.column ? 1 : 0;
  std::vector<std::uint32_t> place(problem.cameras.size(), 0);
  for (std::size_t c = 0; c < problem.cameras.size(); ++c) {
    if (known[c] == 0) continue;
    const std::size_t view = problem.view_of[c];
    place[c] = static_cast<std::uint32_t>(map.cameras.size());
    map.cameras.push_back({static_cast<std::uint32_t>(view), model.views[view].camera_from_model, equations.right[c]});
  }
  for (const CameraBlock& block : equations.blocks)
    map.blocks.push_back({place[block.row], place[block.column], block.block});
}

/// Views, tracks and sightings by their numbers in the part. Empty where the model is.
SubMap sub_map_of(const Scene& part, std::size_t own_tracks, const Model& model) {
  SubMap map;
  if (model.size() < 2) return map;
  const ModelProblem problem = own_problem(problem_of(part, model), own_tracks);
  map.squares = 2 * cost_of(problem, {0, 0});
  map.redundancy = 2.0 * static_cast<double>(problem.observations.size()) + static_cast<double>(problem.depths.size()) -
                   3.0 * static_cast<double>(problem.points.size());
  map.weight = mean_weight(problem);
  map.common = common_errors_of(problem, robust_px);
  const double free = map.redundancy - 6.0 * static_cast<double>(problem.cameras.size()) + 7;
  if (!(free > 0) || !std::isfinite(map.squares)) return {};
  const auto equations = NormalEquations(problem).of_cameras(problem, {robust_px, map.squares / free});
  if (!equations) return {};
  add_equations(problem, model, *equations, map);
  for (std::size_t t = 0; t < own_tracks; ++t) {
    for (std::size_t s = 0; s < part.tracks[t].seen.size(); ++s) {
      if (model.refuses(t, s)) map.refused.push_back({t, s});
    }
    const ModelPoint& point = model.points[t];
    if (point.placed) map.points.push_back({t, point.by_depth, point.position});
  }
  return map;
}

constexpr std::size_t per_map = 3 + sizeof(CommonErrors) / sizeof(double), per_camera = 18, per_block = 36,
                      per_point = 4;

/// Numbers of the whole map.
std::array<double*, per_map> whole_numbers(SubMap& map) {
  std::array<double*, per_map> numbers = {&map.squares, &map.weight, &map.redundancy};
  std::size_t next = 3;
  for (CommonErrors::InParts& parts : map.common.in_parts) {
    for (double* one : {&parts.of_sums, &parts.independent, &parts.counts, &parts.squared_counts})
      numbers[next++] = one;
  }
  return numbers;
}

void append(SubMap& map, std::vector<std::uint8_t>& bytes) {
  std::vector<std::uint32_t> numbers;
  std::vector<double> values;
  for (const double* one : whole_numbers(map)) values.push_back(*one);
  for (const SubMapCamera& camera : map.cameras) {
    numbers.push_back(camera.view);
    const RigidTransform& pose = camera.camera_from_map;
    values.insert(values.end(), pose.rotation.data(), pose.rotation.data() + 9);
    values.insert(values.end(), pose.translation.data(), pose.translation.data() + 3);
    values.insert(values.end(), camera.right.data(), camera.right.data() + 6);
  }
  intake::append(numbers, bytes);
  numbers.clear();
  for (const CameraBlock& block : map.blocks) {
    numbers.insert(numbers.end(), {block.row, block.column});
    values.insert(values.end(), block.block.data(), block.block.data() + per_block);
  }
  intake::append(numbers, bytes);
  numbers.clear();
  for (const SubMap::Point& point : map.points) {
    numbers.push_back(static_cast<std::uint32_t>(point.track));
    values.push_back(point.by_depth ? 1 : 0);
    values.insert(values.end(), point.position.data(), point.position.data() + 3);
  }
  intake::append(numbers, bytes);
  intake::append(values, bytes);
  intake::append(map.refused, bytes);
}

/// False where the bytes hold none.
bool take(std::span<const std::uint8_t> bytes, SubMap& map) {
  std::vector<std::uint32_t> views, places, points;
  std::vector<double> values;
  if (!intake::take(bytes, views) || !intake::take(bytes, places) || !intake::take(bytes, points) ||
      !intake::take(bytes, values) || !intake::take(bytes, map.refused) || places.size() % 2 != 0 ||
      values.size() !=
          per_map + per_camera * views.size() + per_block * (places.size() / 2) + per_point * points.size()) {
    return false;
  }
  const double* next = values.data();
  const auto copy = [&next](std::size_t count, double* to) {
    std::copy_n(next, count, to);
    next += count;
  };
  for (double* one : whole_numbers(map)) copy(1, one);
  for (const std::uint32_t view : views) {
    SubMapCamera& camera = map.cameras.emplace_back();
    camera.view = view;
    copy(9, camera.camera_from_map.rotation.data());
    copy(3, camera.camera_from_map.translation.data());
    copy(6, camera.right.data());
  }
  for (std::size_t i = 0; i < places.size(); i += 2) {
    CameraBlock& block = map.blocks.emplace_back();
    block.row = places[i];
    block.column = places[i + 1];
    copy(per_block, block.block.data());
  }
  for (const std::uint32_t track : points) {
    SubMap::Point& point = map.points.emplace_back();
    point.track = track;
    point.by_depth = *next++ != 0;
    copy(3, point.position.data());
  }
  return true;
}

bool fits(const PartOfScene& part, const SubMap& map) {
  const auto cameras = static_cast<std::uint32_t>(map.cameras.size());
  return std::all_of(map.cameras.begin(), map.cameras.end(),
                     [&](const SubMapCamera& camera) { return camera.view < part.scene.views.size(); }) &&
         std::all_of(map.blocks.begin(), map.blocks.end(),
                     [&](const CameraBlock& block) { return block.row < cameras && block.column < cameras; }) &&
         std::all_of(map.points.begin(), map.points.end(),
                     [&](const SubMap::Point& point) { return point.track < part.own_tracks; }) &&
         std::all_of(map.refused.begin(), map.refused.end(), [&](const SubMap::Refused& one) {
           return one.track < part.own_tracks && one.sighting < part.scene.tracks[one.track].seen.size();
         });
}

SubMap adjusted_once(const PartOfScene& part, intake::ResultCache* results) {
  if (results == nullptr) return sub_map_of(part.scene, part.own_tracks, grown_model(part.scene));
  const std::uint64_t digest = digest_of(part.scene, part.own_tracks);
  SubMap map;
  if (const auto known = results->result(digest)) {
    if (take(*known, map) && fits(part, map)) return map;
  }
  map = sub_map_of(part.scene, part.own_tracks, grown_model(part.scene));
  std::vector<std::uint8_t> bytes;
  append(map, bytes);
  results->put_result(digest, bytes);
  return map;
}

}  // namespace

std::optional<SubMap> adjusted_sub_map(const Scene& scene, const SubMapPlan& plan) {
  const PartOfScene part = part_of(scene, plan);
  SubMap map = adjusted_once(part, scene.results);
  if (map.cameras.size() < 2) return std::nullopt;
  for (SubMapCamera& camera : map.cameras) camera.view = plan.views[camera.view];
  for (SubMap::Point& point : map.points) point.track = plan.tracks[point.track];
  for (SubMap::Refused& one : map.refused)
    one = {plan.tracks[one.track], part.sighting_of[part.first[one.track] + one.sighting]};
  return map;
}

}  // namespace ilp::model
