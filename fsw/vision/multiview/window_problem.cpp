#include "fsw/vision/multiview/window_problem.hpp"

#include <algorithm>

namespace ilp {
namespace {

constexpr std::uint16_t not_in_problem = 0xFFFF;

/// Index into SequenceState::cameras of the first free camera.
std::size_t first_free(const SequenceState& state) {
  const std::size_t count = state.cameras.size();
  const std::size_t window = state.params.window_keyframes;
  const std::size_t first = count > window ? count - window : 0;
  if (state.oldest > 0) return first;
  // The strip's first camera is the frame: it never moves. It is fixed alone, or together with the camera that is far
  // enough from it to determine the scale.
  if (first <= 1) return 1;
  return std::max<std::size_t>(first, state.first_pair.scale_camera + 1U);
}

/// Bits of the cameras that use the track, bit i for SequenceState::cameras[i].
std::uint32_t camera_bits(const SequenceState& state, const Track& track) {
  return static_cast<std::uint32_t>(track.used) << (track.first - state.oldest);
}

bool takes_part(const Track& track, std::uint32_t bits, std::uint32_t free_bits) {
  return track.phase == TrackPhase::point && (bits & free_bits) != 0 && (bits & (bits - 1)) != 0;
}

/// The cameras that take part, as bits.
std::uint32_t choose_cameras(const SequenceState& state, std::size_t free_from) {
  const std::size_t count = state.cameras.size();
  const std::uint32_t free_bits = ((1U << count) - 1U) & ~((1U << free_from) - 1U);
  std::array<std::uint32_t, limits::max_bundle_cameras> shared{};
  for (const Track& track : state.tracks) {
    const std::uint32_t bits = camera_bits(state, track);
    if (!takes_part(track, bits, free_bits)) continue;
    for (std::size_t i = 0; i < free_from; ++i) shared[i] += (bits >> i) & 1U;
  }
  std::uint32_t chosen = free_bits;
  if (free_from > 0) chosen |= 1U << (free_from - 1);
  const std::size_t reach = free_from > limits::max_fixed_keyframes ? free_from - limits::max_fixed_keyframes : 0;
  for (std::size_t i = reach; i + 1 < free_from; ++i) {
    if (shared[i] >= min_resection_inliers) chosen |= 1U << i;
  }
  return chosen;
}

void add_observations(const SequenceState& state, const Track& track, std::uint32_t bits,
                      const std::array<std::uint16_t, limits::max_bundle_cameras>& index_of_camera,
                      BundleProblem& problem) {
  const auto point = static_cast<std::uint16_t>(problem.points.size());
  for (std::uint32_t k = 0; k < track.count; ++k) {
    const std::uint32_t camera = track.first + k - state.oldest;
    if (((bits >> camera) & 1U) == 0) continue;
    (void)problem.observations.push_back({index_of_camera[camera], point, track.x[k], track.y[k]});
  }
}

}  // namespace

void build_window(const SequenceState& state, BundleProblem& problem, WindowMap& map) {
  problem.cameras.clear();
  problem.points.clear();
  problem.observations.clear();
  problem.hold = {};
  problem.attitudes.clear();
  map.left_out = 0;
  const std::size_t free_from = first_free(state);
  const std::uint32_t chosen = choose_cameras(state, free_from);
  const std::uint32_t free_bits = chosen & ~((1U << free_from) - 1U);

  std::array<std::uint16_t, limits::max_bundle_cameras> index_of_camera;
  index_of_camera.fill(not_in_problem);
  std::size_t fixed_count = 0;
  for (std::size_t i = 0; i < state.cameras.size(); ++i) {
    if (((chosen >> i) & 1U) == 0) continue;
    index_of_camera[i] = static_cast<std::uint16_t>(problem.cameras.size());
    map.camera[problem.cameras.size()] = static_cast<std::uint16_t>(i);
    BundleCamera camera;
    camera.pose = state.cameras[i].pose;
    camera.fx = state.camera.fx;
    camera.fy = state.camera.fy;
    camera.cx = state.camera.cx;
    camera.cy = state.camera.cy;
    camera.fixed = i < free_from;
    fixed_count += camera.fixed ? 1 : 0;
    (void)problem.cameras.push_back(camera);
  }
  if (fixed_count == 1 && problem.cameras.size() > 1) {
    const bool from_first = state.oldest == 0 && map.camera[0] == 0;
    problem.hold = {true, 0, from_first ? index_of_camera[state.first_pair.scale_camera] : std::uint16_t{1}};
  }

  for (std::size_t i = 0; i < state.tracks.size(); ++i) {
    const Track& track = state.tracks[i];
    const std::uint32_t bits = camera_bits(state, track) & chosen;
    if (!takes_part(track, bits, free_bits)) continue;
    if (problem.points.full() || problem.observations.size() + track.count > limits::max_bundle_observations) {
      ++map.left_out;
      continue;
    }
    map.track[problem.points.size()] = static_cast<std::uint16_t>(i);
    add_observations(state, track, bits, index_of_camera, problem);
    (void)problem.points.push_back({{track.position[0], track.position[1], track.position[2]}});
  }
}

void store_window(const BundleProblem& problem, const WindowMap& map, SequenceState& state) {
  for (std::size_t i = 0; i < problem.cameras.size(); ++i) {
    if (!problem.cameras[i].fixed) state.cameras[map.camera[i]].pose = problem.cameras[i].pose;
  }
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    for (int k = 0; k < 3; ++k) state.tracks[map.track[i]].position[k] = problem.points[i].position[k];
  }
}

}  // namespace ilp
