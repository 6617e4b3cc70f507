#include "sim/sil/sil_flight.hpp"

#include <sys/resource.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bsp/flight/flight_software.hpp"
#include "bsp/flight/mission_file.hpp"
#include "cfg/version.hpp"
#include "hal/clock/virtual_clock.hpp"
#include "hal/link/outbox/outbox_link.hpp"
#include "hal/store/sqlite/sqlite_memory.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#include "sim/io/status_error.hpp"
#include "sim/sil/receiver.hpp"

namespace ilp::sim {
namespace fs = std::filesystem;
namespace {

using Seconds = std::chrono::duration<double>;

// After the last image the link may still need this long; then the flight ends with what has been sent.
constexpr std::int64_t longest_drain_frames = 4 * 3600 * (ns_per_s / minor_frame_ns);

MissionParameters load_mission(const FlightOptions& options) {
  MissionParameters mission;
  mission.seed = static_cast<double>(options.seed & 0xFFFFFFFFU);
  if (options.mission_file.empty()) return mission;
  MissionFileError error;
  const Status status = read_mission_file(options.mission_file.c_str(), mission, error);
  if (status.ok()) return mission;
  std::string message = "mission file " + options.mission_file + ": ";
  if (error.key[0] != 0) {
    message += "[" + std::string(error.section) + "] " + error.key + " = " + error.value + ": ";
    message += status.is(StatusCode::not_found) ? "no such parameter (docs/parameters.md lists them)"
                                                : "not a number in the parameter's range (docs/parameters.md)";
  } else {
    message += describe(status);
  }
  throw std::runtime_error(message);
}

/// As on board: SQLite lives in its arena.
Arena& sqlite_arena() {
  alignas(Arena::alignment) static std::array<std::byte, limits::sqlite_arena_bytes> region;
  static Arena arena;
  static const bool configured = [] {
    arena.init(region.data(), region.size());
    require(configure_sqlite_memory(arena), "configuring SQLite's memory");
    return true;
  }();
  static_cast<void>(configured);
  return arena;
}

double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

double peak_memory_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

std::int64_t record_count(Store& store, RecordType type) {
  std::int64_t count = 0;
  require(store.count(record_info(type), count), "counting records");
  return count;
}

class ProgressBar {
 public:
  ProgressBar(bool shown, std::size_t total) : shown_(shown), total_(total) {}
  void update(std::int64_t frames, std::int64_t keyframes) {
    if (!shown_ || frames == last_) return;
    last_ = frames;
    std::cerr << "\r\033[K";
    if (total_ > 0) {
      constexpr int width = 40;
      const int filled = static_cast<int>(width * std::min<double>(1.0, double(frames) / double(total_)));
      std::cerr << "flying [" << std::string(size_t(filled), '#') << std::string(size_t(width - filled), '.') << "] ";
    }
    std::cerr << frames << (total_ > 0 ? "/" + std::to_string(total_) : "") << " frames, " << keyframes << " keyframes"
              << std::flush;
  }
  void end() const {
    if (shown_) std::cerr << "\n";
  }

 private:
  bool shown_;
  std::size_t total_;
  std::int64_t last_ = -1;
};

nlohmann::json component_times(Executive& executive) {
  nlohmann::json list = nlohmann::json::array();
  for (const Stage& stage : schedule) {
    const ComponentStats& stats = executive.stats(stage.component);
    list.push_back({{"name", stage.name},
                    {"steps", stats.steps},
                    {"busy_ms", 1e-6 * static_cast<double>(stats.busy_ns)},
                    {"longest_ms", 1e-6 * static_cast<double>(stats.longest_ns)},
                    {"budget_ms", 1e-6 * static_cast<double>(stage.budget_ns)},
                    {"overruns", stats.overruns},
                    {"faults", stats.faults},
                    {"restarts", stats.restarts}});
  }
  return list;
}

}  // namespace

void prepare_folder(const FlightOptions& options) {
  const fs::path out = options.out;
  std::error_code error;
  const bool holds_flight = fs::exists(out / "flight.db", error);
  if (options.resume) {
    if (!holds_flight) throw std::runtime_error("--resume: there is no flight.db in " + options.out);
    return;
  }
  if (fs::exists(out, error) && !fs::is_directory(out, error)) {
    throw std::runtime_error(options.out + " is not a folder");
  }
  if (fs::is_directory(out, error) && !fs::is_empty(out, error)) {
    throw std::runtime_error("the folder " + options.out +
                             " is not empty: name a new one, so that no earlier flight is lost" +
                             (holds_flight ? ", or --resume the flight in it" : ""));
  }
  for (const char* folder : {"outbox", "acknowledged"}) {
    fs::create_directories(out / folder, error);
    if (error) throw std::runtime_error("cannot create " + (out / folder).string() + ": " + error.message());
  }
  const fs::path probe = out / ".probe";
  if (!(std::ofstream(probe) << "x").flush()) throw std::runtime_error("cannot write into " + options.out);
  fs::remove(probe, error);
}

int fly(const FlightOptions& options, ImageSource& source) {
  const auto begin = std::chrono::steady_clock::now();
  const double cpu_begin = processor_seconds();
  const fs::path out = options.out;
  const MissionParameters mission = load_mission(options);

  const Arena& sqlite_memory = sqlite_arena();
  SqliteStore store;
  require(store.open((out / "flight.db").c_str()), "opening " + (out / "flight.db").string());
  OutboxLink link;
  require(link.open((out / "outbox").c_str(), (out / "acknowledged").c_str()), "opening the outbox");
  VirtualClock clock;
  auto software = std::make_unique<FlightSoftware>(store, source.camera(), link, clock, mission);
  require(software->start(source.model), "starting the flight software");
  Executive& executive = software->executive();
  Receiver receiver(out / "outbox", out / "acknowledged");
  ProgressBar progress(options.progress, source.frames);

  TimeNs next = 0;
  std::int64_t drain_frames = 0;
  bool housekeeping = false;
  for (std::int64_t frame = 0;; ++frame) {
    if (options.power_cut_after > 0 && frame >= options.power_cut_after) std::_Exit(9);
    executive.run_minor_frame();
    if (frame % 10 == 0) {
      receiver.receive();
      progress.update(record_count(store, RecordType::frame), record_count(store, RecordType::keyframe));
    }
    if (software->processed() && ++drain_frames > longest_drain_frames) break;
    if (software->drained()) {
      if (housekeeping) break;
      housekeeping = true;
      require(executive.write_housekeeping(), "writing housekeeping");
    }
    next += minor_frame_ns;
    clock.sleep_until(next);
  }
  progress.end();

  const std::int64_t frames = record_count(store, RecordType::frame);
  const std::int64_t keyframes = record_count(store, RecordType::keyframe);
  const double cpu = processor_seconds() - cpu_begin;
  TimeNs busy = 0;
  for (const Stage& stage : schedule) busy += executive.stats(stage.component).busy_ns;
  std::size_t static_bytes = 0;
  nlohmann::json memory = nlohmann::json::array();
  for (const MemoryRegion& region : memory_map()) {
    static_bytes += region.bytes;
    memory.push_back({{"name", region.name}, {"bytes", region.bytes}});
  }
  const nlohmann::json info = {
      {"software", software_version},
      {"profile", limits::profile},
      {"source", source.description},
      {"seed", options.seed},
      {"frames", frames},
      {"keyframes", keyframes},
      {"wall_s", Seconds(std::chrono::steady_clock::now() - begin).count()},
      {"cpu_s", cpu},
      {"flight_software_cpu_s", 1e-9 * static_cast<double>(busy)},
      {"cpu_ms_per_keyframe", keyframes > 0 ? 1e-6 * static_cast<double>(busy) / static_cast<double>(keyframes) : 0.0},
      {"peak_rss_mib", peak_memory_mib()},
      {"static_bytes", static_bytes},
      {"memory_map", memory},
      {"components", component_times(executive)},
      {"downlinked_bytes", receiver.bytes()},
      {"downlinked_files", receiver.files()},
      {"target_overlap", mission.target_overlap},
      {"min_overlap", mission.min_overlap},
      {"sqlite_arena_peak_bytes", sqlite_memory.stats().peak},
      {"events_lost", executive.events().lost()},
  };
  std::ofstream(out / "flight-info.json") << info.dump(2) << "\n";
  std::cerr << "Flight over: " << frames << " frames, " << keyframes << " keyframes, " << receiver.files()
            << " files with " << receiver.bytes() << " bytes in " << (out / "outbox").string() << "\n";
  if (frames == 0) {
    std::cerr << "ilp-sil: the source gave no usable frame\n";
    return 1;
  }
  return 0;
}

void print_memory_map(std::ostream& out) {
  std::size_t total = 0;
  out << "Static memory of the flight, profile " << limits::profile << "\n";
  for (const MemoryRegion& region : memory_map()) {
    total += region.bytes;
    out << std::setw(12) << region.bytes << "  " << region.name << "\n";
  }
  out << std::setw(12) << total << "  total (" << std::fixed << std::setprecision(1)
      << static_cast<double>(total) / 1048576.0 << " MiB)\n";
}

}  // namespace ilp::sim
