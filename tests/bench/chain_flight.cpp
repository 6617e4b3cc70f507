#include "tests/bench/chain_flight.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <map>
#include <memory>
#include <stdexcept>

#include "bsp/flight/flight_software.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/executive/frame_timing.hpp"
#include "hal/clock/virtual_clock.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "sim/host/parallel.hpp"
#include "sim/host/status_error.hpp"
#include "sim/world/flight_renderer.hpp"
#include "sim/world/scenario.hpp"
#include "tests/faults/reveal.hpp"
#include "tests/support/flight_kit.hpp"

namespace ilp::faults {
ILP_REVEAL(FlightSoftware, components_);
ILP_REVEAL(DenseMatcher, work_);
}  // namespace ilp::faults

namespace ilp::bench {
namespace {

/// Of a flight whose images have this many pixels.
constexpr std::size_t store_bytes(std::size_t pixels) {
  return std::max(std::size_t{192} << 20U, 160 * pixels);
}
constexpr TimeNs longest_flight_ns = 3600 * ns_per_s;

class RenderedCamera final : public Camera {
 public:
  explicit RenderedCamera(const world::Scenario& scenario) {
    const world::FlightRenderer renderer(scenario);
    times_ = renderer.trajectory().exposures();
    images_.resize(times_.size());
    host::for_each_parallel(images_.size(), [&](std::size_t k) {
      world::RenderedFrame frame;
      renderer.render(times_[k], static_cast<std::int64_t>(k), frame);
      images_[k] = frame.grey.samples;
    });
  }

  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override {
    if (next_ == images_.size()) return {StatusCode::end_of_stream, static_cast<std::int64_t>(next_)};
    if (times_[next_] > now) return StatusCode::not_ready;
    ILP_TRY(image.resize(width, height));
    std::memcpy(image.view().data, images_[next_].data(), images_[next_].size());
    frame = {};
    frame.time_ns = times_[next_];
    frame.sequence = static_cast<std::int64_t>(++next_);
    return {};
  }
  [[nodiscard]] TimeNs next_due() const override { return next_ < images_.size() ? times_[next_] : 0; }

  std::int32_t width = 0, height = 0;

 private:
  std::vector<std::int64_t> times_;
  std::vector<std::vector<std::uint8_t>> images_;
  std::size_t next_ = 0;
};

/// The far end confirms every file at once.
class ConfirmingLink final : public Link {
 public:
  Status begin_file(const char* name) override {
    open_ = name;
    files_[open_] = {};
    return {};
  }
  Status write(std::span<const std::uint8_t> bytes) override {
    File& file = files_[open_];
    file.bytes += static_cast<std::uint32_t>(bytes.size());
    file.crc = crc32(bytes, file.crc);
    return {};
  }
  Status end_file() override {
    open_.clear();
    return {};
  }
  Status acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) override {
    const auto file = files_.find(name);
    if (file == files_.end() || open_ == name) return StatusCode::not_ready;
    bytes = file->second.bytes;
    crc32 = file->second.crc;
    return {};
  }

 private:
  struct File {
    std::uint32_t bytes = 0, crc = 0;
  };
  std::map<std::string, File> files_;
  std::string open_;
};

/// By phase of the dense matcher, the part of the work that it belongs to.
constexpr std::array<const char*, 16> matcher_parts = {"idle",   "idle",   "resample", "match",  "depth",  "depth",
                                                       "errors", "mask",   "mask",     "record", "record", "record",
                                                       "record", "record", "record",   "record"};

/// The executive asks for the processor time before and after each step. Whoever is named meanwhile gets what has
/// passed: to ask again for the benchmark would take as long as many a step.
class StepClock final : public Clock {
 public:
  TimeNs now() override { return clock_.now(); }
  void sleep_until(TimeNs time) override { clock_.sleep_until(time); }
  TimeNs processor_time() override {
    const double now_ms = processor_ms();
    if (part_ms_ != nullptr) *part_ms_ += now_ms - begun_ms_;
    part_ms_ = nullptr;
    begun_ms_ = now_ms;
    return static_cast<TimeNs>(1e6 * now_ms);
  }
  void give_step_to(double& part_ms) { part_ms_ = &part_ms; }

 private:
  VirtualClock clock_;
  double* part_ms_ = nullptr;
  double begun_ms_ = 0;
};

/// Stands in the executive's table for a component and takes the time of its steps.
class TimedComponent final : public Component {
 public:
  TimedComponent(Component& component, ComponentId id, StepClock& clock)
      : component_(component), id_(id), clock_(clock) {}

  [[nodiscard]] const char* name() const override { return component_.name(); }
  Status restore() override { return component_.restore(); }
  StepResult step() override {
    clock_.give_step_to(by_phase.at(phase_now()));
    return component_.step();
  }
  [[nodiscard]] LastingMemory lasting() const override { return component_.lasting(); }
  [[nodiscard]] double total_ms() const {
    double sum = 0;
    for (const double ms : by_phase) sum += ms;
    return sum;
  }

  std::array<double, matcher_parts.size()> by_phase{};

 private:
  [[nodiscard]] std::size_t phase_now() const {
    if (id_ != ComponentId::dense_matcher) return 0;
    const auto& matcher = static_cast<const DenseMatcher&>(component_);
    return static_cast<std::size_t>((matcher.*revealed(faults::DenseMatcher_work_{})).phase);
  }

  Component& component_;
  ComponentId id_;
  StepClock& clock_;
};

using Timed = std::vector<std::unique_ptr<TimedComponent>>;

std::vector<PartTime> part_times(const Timed& timed, double all_ms, int keyframes) {
  std::vector<PartTime> parts;
  double rest = all_ms;
  for (const Stage& stage : schedule) {
    const TimedComponent& component = *timed[place_of(stage.component)];
    rest -= component.total_ms();
    parts.push_back({stage.name, component.total_ms() / keyframes});
    if (stage.component != ComponentId::dense_matcher) continue;
    std::map<std::string, double> by_part;
    for (std::size_t phase = 0; phase < matcher_parts.size(); ++phase) {
      by_part[matcher_parts[phase]] += component.by_phase[phase] / keyframes;
    }
    for (const auto& [part, ms] : by_part) parts.push_back({std::string(stage.name) + "/" + part, ms});
  }
  parts.push_back({"executive", rest / keyframes});
  return parts;
}

int record_count(Store& store, RecordType type) {
  std::int64_t count = 0;
  host::require(store.count(record_info(type), count), "counting records");
  return static_cast<int>(count);
}

}  // namespace

double ChainTimes::of(const std::string& name) const {
  for (const PartTime& part : parts) {
    if (part.name == name) return part.ms;
  }
  throw std::invalid_argument("no part " + name);
}

double processor_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

ChainTimes fly_chain(int frames, Reference& reference, std::vector<world::ScenarioEntry> settings) {
  settings.push_back({"flight", "frames", std::to_string(frames), "bench_chain"});
  const world::Scenario scenario = world::load_scenario(std::string(world::default_scenario), settings);
  RenderedCamera camera(scenario);
  camera.width = scenario.flight.camera.width;
  camera.height = scenario.flight.camera.height;
  MissionParameters mission;
  StepClock clock;
  std::vector<std::byte> region(
      store_bytes(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height)));
  RamStore store(region);
  ConfirmingLink link;
  test::FlightKit flight({store, camera, link, clock}, mission);
  auto& components = (*flight).*revealed(faults::FlightSoftware_components_{});
  Timed timed;
  for (std::size_t i = 0; i < stage_count; ++i) {
    timed.push_back(std::make_unique<TimedComponent>(*components[i], schedule[i].component, clock));
    components[i] = timed.back().get();
  }
  host::require(flight.start(scenario.flight.camera), "the start of the flight");
  ChainTimes times;
  std::vector<double> references;
  double all_ms = 0;
  for (TimeNs next = 0; !flight->drained() && clock.now() < longest_flight_ns;) {
    const double begun = processor_ms();
    flight->executive().run_minor_frame(next);
    all_ms += processor_ms() - begun;
    next = next_frame_begin(next, clock.now());
    clock.sleep_until(next);
    const int keyframes = record_count(store, RecordType::keyframe);
    if (keyframes > times.keyframes) references.push_back(reference.run());
    times.keyframes = keyframes;
  }
  times.frames = record_count(store, RecordType::frame);
  if (times.keyframes == 0) throw std::runtime_error("the flight has no keyframes");
  times.all_ms = all_ms / times.keyframes;
  times.reference_ms = median(references);
  times.parts = part_times(timed, all_ms, times.keyframes);
  return times;
}

}  // namespace ilp::bench
