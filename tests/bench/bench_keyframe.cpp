// Structure and motion of a strip, from images to refined poses, with the CPU time of every stage per keyframe. The bar
// is 60 ms for a keyframe of 640x480 pixels and 1000 corners on one core of a desktop computer. Recorded strips where
// the data are beside the project, rendered ones always. Predictions (the overlap check's) are not part of it.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <memory>

#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/multiview/sequence_workspace.hpp"
#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "sim/world/flight.hpp"
#include "sim/world/renderer.hpp"
#include "sim/world/world_params.hpp"
#include "tests/support/alignment.hpp"
#include "tests/support/strip.hpp"

namespace ilp {
namespace {

struct Strip {
  CameraModel camera;
  std::vector<test::Image> images;
  std::vector<Eigen::Vector3d> centres;
  std::vector<std::array<double, 9>> planes;  ///< image k from k - 1
};

void predict(Strip& strip) {
  const auto workspace = std::make_unique<OverlapWorkspace>();
  OverlapParams params{.min_overlap = 0.35};
  strip.planes.resize(strip.images.size());
  for (std::size_t k = 1; k < strip.images.size(); ++k) {
    OverlapResult overlap;
    (void)measure_overlap(strip.images[k - 1].view(), strip.images[k].view(), params, *workspace, overlap).ok();
    std::copy_n(overlap.plane_b_from_a, 9, strip.planes[k].begin());
  }
}

Strip recorded(const std::string& folder) {
  Strip strip;
  for (const test::StripImage& image : test::read_strip(folder)) {
    strip.camera = image.camera;
    strip.images.push_back(test::read_strip_image(folder, image.name));
    strip.centres.emplace_back(image.centre[0], image.centre[1], image.centre[2]);
  }
  predict(strip);
  return strip;
}

/// Ten keyframes of the default flight over a preset world.
Strip rendered(const std::string& world, double interval_s) {
  Strip strip;
  const world::WorldPreset& preset = world::world_preset(world);
  world::FlightParams flight{
      .frames = 10, .interval_s = interval_s, .altitude_m = preset.altitude_m, .drift_m_s = preset.drift_m_s};
  strip.camera = flight.camera;
  const world::Terrain terrain(preset.world);
  const world::Renderer renderer(terrain, flight.camera, {}, 1);
  world::RenderedFrame frame;
  for (const world::CameraState& state : world::fly(flight)) {
    world::CameraMotion motion{.state = state};
    renderer.render(motion, static_cast<std::int64_t>(strip.images.size()), frame);
    test::Image image(flight.camera.width, flight.camera.height);
    image.pixels.assign(frame.grey.samples.begin(), frame.grey.samples.end());
    strip.images.push_back(image);
    strip.centres.push_back(state.centre);
  }
  predict(strip);
  return strip;
}

enum Stage : std::uint8_t { detect, match, two_view, resection, triangulation, bundle, bookkeeping, stages };
constexpr const char* stage_names[stages] = {"detect_ms",        "match_ms",  "two_view_ms",   "resection_ms",
                                             "triangulation_ms", "bundle_ms", "bookkeeping_ms"};

Stage stage_of(SequencePhase phase) {
  switch (phase) {
    case SequencePhase::relate:
    case SequencePhase::relating:
    case SequencePhase::rank:
    case SequencePhase::begin:
    case SequencePhase::decide:
      return two_view;
    case SequencePhase::extend_from_pair:
    case SequencePhase::resect:
      return resection;
    case SequencePhase::triangulate:
      return triangulation;
    case SequencePhase::adjust:
    case SequencePhase::readjust:
    case SequencePhase::state_errors:
    case SequencePhase::restate_errors:
      return bundle;
    case SequencePhase::idle:
    case SequencePhase::prune:
    case SequencePhase::conclude:
      break;
  }
  return bookkeeping;
}

double cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

class Chain {
 public:
  explicit Chain(const Strip& strip) : strip_(strip) {}

  /// One pass over the strip, up to the first keyframe that cannot be related.
  void fly() {
    centres_.clear();
    (void)sequence_.begin_strip(strip_.camera, {}).ok();
    for (std::size_t k = 0; k < strip_.images.size() && add(k); ++k) collect();
    (void)sequence_.flush().ok();
    collect();
  }

  void report(benchmark::State& state) const {
    double total = 0;
    for (std::size_t s = 0; s < stages; ++s) {
      state.counters[stage_names[s]] = sums_[s] / keyframes_;
      total += sums_[s] / keyframes_;
    }
    state.counters["total_ms"] = total;
    state.counters["worst_ms"] = worst_;
    state.counters["matches"] = matched_ / keyframes_;
    state.counters["inliers"] = inliers_ / keyframes_;
    state.counters["observations"] = observed_ / keyframes_;
    state.counters["keyframes"] = static_cast<double>(centres_.size());
    if (centres_.size() < 3) return;
    const std::vector<Eigen::Vector3d> truth(strip_.centres.begin(),
                                             strip_.centres.begin() + static_cast<std::ptrdiff_t>(centres_.size()));
    double length = 0;
    for (std::size_t k = 1; k < truth.size(); ++k) length += (truth[k] - truth[k - 1]).norm();
    state.counters["position_error_percent"] = 100 * test::alignment_errors(centres_, truth).mean / length;
  }

 private:
  bool add(std::size_t k) {
    std::array<double, stages> spent{};
    double since = cpu_ms();
    const auto charge = [&](Stage stage) {
      const double now = cpu_ms();
      spent[stage] += now - since;
      since = now;
    };
    const GrayView image = strip_.images[k].view();
    if (!detect_corners(image, {}, harris_, corners_).ok()) return false;
    charge(detect);
    matches_.clear();
    if (k > 0) {
      double plane[9];
      std::copy_n(strip_.planes[k].begin(), 9, plane);
      MatcherParams params{.search_radius_px = 40};
      (void)match_and_track_corners(strip_.images[k - 1].view(), state_->corners, image, corners_, plane, params,
                                    matcher_, matches_)
          .ok();
      charge(match);
    }
    const auto id = static_cast<std::int64_t>(k);
    static_cast<void>(sequence_.begin_keyframe(id, corners_, matches_, k));
    charge(bookkeeping);
    while (!sequence_.idle()) {
      const Stage stage = stage_of(state_->phase);
      if (!sequence_.step().ok()) return false;
      charge(stage);
    }
    const SequenceReport& report = sequence_.report();
    // The first keyframes have no window yet and are cheaper.
    if (k > 1 && report.verdict == SequenceVerdict::ok) {
      double total = 0;
      for (std::size_t s = 0; s < stages; ++s) {
        sums_[s] += spent[s];
        total += spent[s];
      }
      ++keyframes_;
      worst_ = std::max(worst_, total);
      matched_ += report.matches;
      inliers_ += report.two_view.inliers;
      observed_ += report.bundle_observations;
    }
    return report.verdict == SequenceVerdict::ok || report.verdict == SequenceVerdict::waiting;
  }

  void collect() {
    SequenceCamera camera;
    while (sequence_.take_final_camera(camera)) {
      centres_.emplace_back(camera.pose.centre[0], camera.pose.centre[1], camera.pose.centre[2]);
    }
    FinalPoint point;
    while (sequence_.take_final_point(point)) benchmark::DoNotOptimize(point);
  }

  const Strip& strip_;
  std::unique_ptr<HarrisWorkspace> harris_owner_ = std::make_unique<HarrisWorkspace>();
  std::unique_ptr<MatcherWorkspace> matcher_owner_ = std::make_unique<MatcherWorkspace>();
  std::unique_ptr<SequenceState> state_ = std::make_unique<SequenceState>();
  std::unique_ptr<SequenceWorkspace> workspace_ = std::make_unique<SequenceWorkspace>();
  HarrisWorkspace& harris_ = *harris_owner_;
  MatcherWorkspace& matcher_ = *matcher_owner_;
  Sequence sequence_{*state_, *workspace_};
  Corners corners_;
  Matches matches_;
  std::vector<Eigen::Vector3d> centres_;
  std::array<double, stages> sums_{};
  double keyframes_ = 0, matched_ = 0, inliers_ = 0, observed_ = 0, worst_ = 0;
};

void keyframes(benchmark::State& state, const Strip& strip) {
  if (strip.images.empty()) {
    state.SkipWithError("no data");
    return;
  }
  const auto chain = std::make_unique<Chain>(strip);
  for (auto _ : state) chain->fly();
  chain->report(state);
}

void recorded_strip(benchmark::State& state, const std::string& folder) {
  keyframes(state, recorded(folder));
}
BENCHMARK_CAPTURE(recorded_strip, caliterra_a, std::string("aerial_caliterra_a"))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(recorded_strip, caliterra_climb, std::string("aerial_caliterra_climb"))
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(recorded_strip, coal_oil_point, std::string("aerial_coal_oil_point"))->Unit(benchmark::kMillisecond);

void rendered_strip(benchmark::State& state, const std::string& world, double interval_s) {
  keyframes(state, rendered(world, interval_s));
}
BENCHMARK_CAPTURE(rendered_strip, testbed, std::string("testbed"), 6.0)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(rendered_strip, canyon, std::string("mars-canyon"), 6.0)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(rendered_strip, canyon_wide_baseline, std::string("mars-canyon"), 14.0)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ilp

BENCHMARK_MAIN();
