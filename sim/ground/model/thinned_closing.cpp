#include "sim/ground/model/thinned_closing.hpp"

#include <algorithm>
#include <memory_resource>
#include <numeric>
#include <utility>

#include "sim/ground/model/point_refinement.hpp"

namespace ilp::model {
namespace {

constexpr std::uint32_t enough_in_common = 8;

/// The numbers below `count`, each once, so that any that follow each other lie far apart: tracks of one part of an
/// image have numbers beside each other.
std::vector<std::size_t> scattered(std::size_t count) {
  std::size_t stride = std::max<std::size_t>(1, static_cast<std::size_t>(0.618 * static_cast<double>(count)));
  while (std::gcd(stride, count) > 1) ++stride;
  std::vector<std::size_t> numbers(count);
  for (std::size_t i = 1; i < count; ++i) numbers[i] = (numbers[i - 1] + stride) % count;
  return numbers;
}

std::vector<std::size_t> few_tracks(const Scene& scene) {
  const std::size_t views = scene.views.size();
  std::vector<std::uint32_t> common(views * views, 0);
  std::vector<std::size_t> few;
  for (const std::size_t t : scattered(scene.tracks.size())) {
    const Sightings& seen = scene.tracks[t].seen;
    bool needed = false;
    for (std::size_t i = 0; i < seen.size() && !needed; ++i) {
      for (std::size_t j = 0; j < i && !needed; ++j) {
        const auto [a, b] = std::minmax(seen[i].view, seen[j].view);
        needed = common[a * views + b] < enough_in_common;
      }
    }
    if (!needed) continue;
    few.push_back(t);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const auto [a, b] = std::minmax(seen[i].view, seen[j].view);
        ++common[a * views + b];
      }
    }
  }
  std::sort(few.begin(), few.end());
  return few;
}

void copy_point(const Model& from, std::size_t from_track, std::size_t sightings, std::size_t to_track, Model& to) {
  to.points[to_track] = from.points[from_track];
  for (std::size_t s = 0; s < sightings; ++s) to.refuse(to_track, s, from.refuses(from_track, s));
}

/// So that it keeps its place in the last view that sees it.
void move_with_view(const Scene& scene, const Model& before, std::size_t track, Model& model) {
  const Sightings& seen = scene.tracks[track].seen;
  for (std::size_t s = seen.size(); s-- > 0;) {
    if (!model.sees(scene, track, s)) continue;
    const Vec3 in_camera = before.views[seen[s].view].camera_from_model * model.points[track].position;
    model.points[track].position = inverse(model.views[seen[s].view].camera_from_model) * in_camera;
    return;
  }
}

}  // namespace

void close_loops_by_few(const Scene& scene, double drift_px, Model& model, double tolerance) {
  const std::vector<std::size_t> few = few_tracks(scene);
  std::pmr::monotonic_buffer_resource memory;
  Scene thinned;
  thinned.views = scene.views;
  for (const std::size_t t : few) {
    const Track& from = scene.tracks[t];
    thinned.tracks.push_back(Track{from.of_flight, from.strip_id, from.strip_position, Sightings(from.seen, &memory)});
  }
  Model by_few;
  by_few.views = model.views;
  grow(thinned, by_few);
  for (std::size_t i = 0; i < few.size(); ++i) copy_point(model, few[i], scene.tracks[few[i]].seen.size(), i, by_few);
  close_loops(thinned, drift_px, by_few, tolerance);

  const Model before = model;
  model.views = by_few.views;
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    if (model.points[t].placed) move_with_view(scene, before, t, model);
  }
  for (std::size_t i = 0; i < few.size(); ++i) copy_point(by_few, i, scene.tracks[few[i]].seen.size(), few[i], model);
  refine_points(scene, drift_px, model);
  triangulate(scene, placing_px, model);
}

}  // namespace ilp::model
