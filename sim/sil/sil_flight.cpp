#include "sim/sil/sil_flight.hpp"

#include <sys/resource.h>
#include <unistd.h>

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
#include "bsp/flight/flight_store.hpp"
#include "cfg/version.hpp"
#include "fsw/executive/frame_timing.hpp"
#include "fsw/packets/pass_schedule.hpp"
#include "hal/clock/utc.hpp"
#include "hal/link/outbox/outbox_link.hpp"
#include "hal/maps/directory_map_source.hpp"
#include "hal/navigation/csv/navigation_file.hpp"
#include "hal/nonvolatile/file_nonvolatile.hpp"
#include "hal/nonvolatile/ram_nonvolatile.hpp"
#include "hal/store/sqlite/sqlite_memory.hpp"
#include "sim/host/mission_input.hpp"
#include "sim/host/progress.hpp"
#include "sim/host/status_error.hpp"
#include "sim/sil/faulty_camera.hpp"
#include "sim/sil/faulty_link.hpp"
#include "sim/sil/faulty_store.hpp"
#include "sim/sil/flight_folder.hpp"
#include "sim/sil/power_cut.hpp"
#include "sim/sil/real_time.hpp"
#include "sim/sil/telecommands.hpp"

namespace ilp::sil {
namespace fs = std::filesystem;
namespace {

using Seconds = std::chrono::duration<double>;

// After the last image the link may still need this long; then the flight ends with what has been sent.
constexpr std::int64_t longest_drain_frames = 4 * 3600 * (ns_per_s / minor_frame_ns);
// Behind the last image, beyond the longest time that the store is full. The pipeline needs no mission time at all.
constexpr TimeNs longest_standstill_ns = 120 * ns_per_s;
constexpr double longest_wait_for_store_s = 3600;
/// With less, the database cannot grow.
constexpr std::uintmax_t least_free_bytes = 1U << 20U;

Arena sqlite_arena;
/// As on board.
alignas(Arena::alignment) std::array<std::byte, limits::ram_store_bytes> store_region;

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
  host::require(store.count(record_info(type), count), "counting records");
  return count;
}

/// What the link could have carried until now.
double link_capacity(const MissionParameters& mission, TimeNs now) {
  return mission.link_bytes_per_s * 1e-9 * static_cast<double>(contact_between(mission, 0, now));
}

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

void configure_store_memory() {
  sqlite_arena.init(store_region.data(), limits::sqlite_arena_bytes);
  host::require(configure_sqlite_memory(sqlite_arena), "configuring SQLite's memory");
}

MissionParameters load_mission(const FlightOptions& options, MissionParameters mission) {
  mission.seed = static_cast<std::uint32_t>(options.seed & 0xFFFFFFFFU);
  return host::read_mission(options.mission_file, mission);
}

namespace {

/// Everything that flies, and what goes wrong with it.
class Flight {
 public:
  Flight(const FlightOptions& options, ImageSource& source, const MissionParameters& mission);
  void run();
  [[nodiscard]] nlohmann::json fault_counts() const;

  std::int64_t count(RecordType type) { return record_count(store_, type); }
  /// A flight over a link ends at any time: what is provisional there may become final.
  [[nodiscard]] std::int64_t keyframes_with_pose() {
    std::int64_t posed = 0;
    PoseRecord pose;
    for (std::int64_t id = 0; next(store_, id, pose).ok(); id = pose.id)
      posed += pose.state == PoseState::final || (options_.linked() && is_open(pose.state)) ? 1 : 0;
    return posed;
  }
  [[nodiscard]] Executive& executive() { return software_->executive(); }
  [[nodiscard]] const Receiver& receiver() const { return receiver_; }
  [[nodiscard]] TimeNs now() { return clock_.now(); }
  [[nodiscard]] std::uint64_t files_delivered() const { return software_->files_delivered(); }
  [[nodiscard]] bool all_sent() const { return software_->drained(); }
  /// As telecommands have left it.
  [[nodiscard]] const MissionParameters& mission() const { return mission_; }

 private:
  [[nodiscard]] PastBoots boots_so_far();
  void plan_cuts(std::size_t frames);
  void meet_power_cuts(std::int64_t frame);
  void show_progress();
  void end_standstill();

  const FlightOptions& options_;
  MissionParameters mission_;
  fs::path out_;
  std::string database_ = out_ / "flight.db";  ///< outlives disk_, whose guard keeps the text
  PastBoots past_;
  FlightStore disk_{sqlite_arena, store_region};
  OutboxLink radio_;
  FlightClock clock_;
  FaultyStore store_;
  FaultyLink link_;
  FaultyCamera camera_;
  std::unique_ptr<PacketLinks> links_;
  Authenticator keys_;
  FileNonvolatile on_disk_;
  RamNonvolatile in_memory_;
  NavigationFile navigation_;
  DirectoryMapSource map_;
  std::unique_ptr<FlightSoftware> software_;
  Telecommands telecommands_;
  Receiver receiver_;
  std::size_t frames_;  ///< of the source; 0: not known
  host::Progress progress_{std::cerr, "Flying, frame"};
  std::int64_t flown_before_ = 0;  ///< frames of earlier boots
  StallGuard guard_;
  std::vector<PowerCut> cuts_;
  bool cut_armed_ = false;
};

Flight::Flight(const FlightOptions& options, ImageSource& source, const MissionParameters& mission)
    : options_(options),
      mission_(mission),
      out_(options.out),
      past_(options.resume ? read_past_boots(out_) : PastBoots{}),
      clock_(options.real_time, past_.clock_ns),
      store_(disk_.store(), clock_, store_full(options.faults)),
      link_(radio_, clock_, link_outage(options.faults)),
      camera_(source.camera(), options.faults, options.seed),
      telecommands_(options.telecommands),
      receiver_(out_ / "outbox", out_ / "acknowledged"),
      frames_(source.frames),
      guard_(longest_standstill_ns +
             static_cast<TimeNs>(std::min(options.faults.store_full_for_s, longest_wait_for_store_s)) * ns_per_s) {
  host::require(disk_.open(database_.c_str(), StoreTrouble::refuse, mission_), "opening " + database_);
  host::require(radio_.open((out_ / "outbox").c_str(), (out_ / "acknowledged").c_str()),
                "opening " + (out_ / "outbox").string());
  if (options.real_time)
    host::require(on_disk_.open(database_.c_str()), "opening the nonvolatile memory beside " + database_);
  links_ = open_links(options, clock_);
  const FlightDevices devices{
      .store = store_,
      .camera = camera_,
      .link = link_,
      .clock = clock_,
      .nonvolatile_memory = options.real_time ? static_cast<Nonvolatile&>(on_disk_) : in_memory_,
      .packets = links_->packets(),
      .files = links_->files(),
      .navigation = source.navigation.empty() ? nullptr : &navigation_,
      .map = options.map.empty() ? nullptr : &map_,
      .real_time = options.real_time};
  software_ = std::make_unique<FlightSoftware>(devices, mission_);
  host::require(software_->prepare({.utc = options.real_time ? std::optional(utc_now()) : std::nullopt}),
                "taking up settings and mission time");
  clock_.set(software_->time().now);
  read_keys(options, mission_, keys_);
  software_->router().authenticate_with(keys_);
  if (!source.navigation.empty()) {
    host::require(navigation_.open(source.navigation.c_str()),
                  "navigation " + source.navigation + " (its columns: docs/navigation.md)");
  }
  map_.require_key(keys_.first_key());
  if (!options.map.empty()) {
    host::require(map_.open(options.map.c_str()), "map " + options.map);
    if (!map_.has_directory()) {
      std::cerr << "ilp-sil: --map " << options.map << ": there is no " << map_directory_name
                << " in it; the flight goes on without a map until its files come (ilp-ground map-tiles makes them)\n";
    }
  }
  host::require(software_->start(source.model), "starting the flight software");
  const Status begun = software_->record_boot({}, disk_.start().in_order());
  // The flight goes on without this record where the store is full at its start.
  if (!begun.is(StatusCode::store_full)) host::require(begun, "writing the record of the start");
  flown_before_ = count(RecordType::frame);
  plan_cuts(source.frames);
}

void Flight::show_progress() {
  const auto before = static_cast<std::size_t>(flown_before_);
  const auto flown = static_cast<std::size_t>(count(RecordType::frame));
  progress_(flown - std::min(flown, before), frames_ - std::min(frames_, before));
}

void Flight::plan_cuts(std::size_t frames) {
  if (options_.faults.power_cuts == 0) return;
  if (frames == 0) {
    throw std::runtime_error(
        "[faults] power_cuts needs a source that says how many frames it has: a folder or a "
        "simulated world; use power_cut_after_s with a video");
  }
  cuts_ = plan_power_cuts(options_.faults.power_cuts, options_.seed, static_cast<std::int64_t>(frames));
}

PastBoots Flight::boots_so_far() {
  PastBoots boots = past_;
  boots.clock_ns = clock_.now();
  boots.store_refused += store_.refused();
  boots.link_refused += link_.refused();
  return boots;
}

void Flight::meet_power_cuts(std::int64_t frame) {
  if (options_.power_cut_after > 0 && frame >= options_.power_cut_after) std::_Exit(9);
  const double timed_s = options_.faults.power_cut_after_s;
  if (timed_s > 0 && past_.timed_cuts == 0 && static_cast<double>(clock_.now()) >= timed_s * 1e9) {
    PastBoots boots = boots_so_far();
    ++boots.timed_cuts;
    cut_power(out_, boots);
  }
  const auto next = static_cast<std::size_t>(past_.random_cuts);
  if (cut_armed_ || next >= cuts_.size() || camera_.newest_sequence() < cuts_[next].sequence) return;
  cut_armed_ = true;
  store_.cut_at_write(cuts_[next].writes, [this] {
    PastBoots boots = boots_so_far();
    ++boots.random_cuts;
    cut_power(out_, boots);
  });
}

void Flight::end_standstill() {
  if (!camera_.source_ended() || software_->processed() || !guard_.stalled(store_, clock_.now())) return;
  std::error_code error;
  const fs::space_info space = fs::space(out_, error);
  if (!error && space.available < least_free_bytes) {
    throw std::runtime_error("the flight has stopped because the disk of " + out_.string() +
                             " is full: free space, and continue with --resume");
  }
  std::string faults;
  for (const Stage& stage : schedule) {
    const ComponentStats& stats = executive().stats(stage.component);
    if (stats.faults == 0) continue;
    faults += (faults.empty() ? "" : ", ") + std::string(stage.name) + " " + std::to_string(stats.faults);
  }
  throw std::runtime_error("the flight does not end: the images have ended, but its stages still have work (" +
                           (faults.empty() ? "no component reports faults" : "faults: " + faults) +
                           "); the events in flight.db say more");
}

void Flight::run() {
  TimeNs next = clock_.now();
  std::int64_t drain_frames = 0;
  bool housekeeping = false;
  for (std::int64_t frame = 0;; ++frame) {
    meet_power_cuts(frame);
    telecommands_.send(store_, clock_.now());
    executive().run_minor_frame(next);
    const Contact contact = contact_at(mission_, clock_.now());
    if (frame % 10 == 0) {
      if (link_.contact() && contact.open) receiver_.receive();
      show_progress();
      end_standstill();
    }
    if (options_.real_time && (stop_requested() || software_->configuration().restart_wanted())) {
      host::require(executive().end(), "writing the housekeeping");
      software_->configuration().end_in_order(clock_.now());
      if (software_->configuration().restart_wanted())
        std::cerr << "ilp-sil: parameters that take effect at a start were reverted: continue with --resume\n";
      break;
    }
    if (!options_.linked()) {
      if (software_->processed() && (contact.over || ++drain_frames > longest_drain_frames)) break;
      if (software_->drained()) {
        if (housekeeping) break;
        housekeeping = executive().end().ok();
      }
    }
    next = next_frame_begin(next, clock_.now());
    clock_.sleep_until(next);
  }
  // What was sent at the very end has arrived too.
  receiver_.receive();
  static_cast<void>(software_->boot().end());
  progress_.end();
}

nlohmann::json Flight::fault_counts() const {
  const CameraFaultCounts& camera = camera_.counts();
  return {{"lost", camera.lost},
          {"dead", camera.dead},
          {"duplicated", camera.duplicated},
          {"late", camera.late},
          {"misstamped", camera.misstamped},
          {"black", camera.black},
          {"saturated", camera.saturated},
          {"blurred", camera.blurred},
          {"store_writes_refused", past_.store_refused + store_.refused()},
          {"link_files_refused", past_.link_refused + link_.refused()},
          {"power_cuts", past_.random_cuts + past_.timed_cuts}};
}

}  // namespace

int fly(const FlightOptions& options, const MissionParameters& mission, ImageSource& source) {
  const auto begin = std::chrono::steady_clock::now();
  const double cpu_begin = processor_seconds();
  const fs::path out = options.out;
  Flight flight(options, source, mission);
  flight_has_begun(out);
  if (options.linked()) {
    std::cerr
        << "ilp-sil: the flight continues after its last image, because telecommands may still come: Ctrl-C, or kill "
        << getpid() << ", ends it in order\n";
  }
  flight.run();
  source.finish();

  const std::int64_t frames = flight.count(RecordType::frame);
  const std::int64_t keyframes = flight.count(RecordType::keyframe);
  Executive& executive = flight.executive();
  const Receiver& receiver = flight.receiver();
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
      {"notes", source.notes},
      {"binning", source.binning},
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
      {"target_overlap", flight.mission().target_overlap},
      {"min_overlap", flight.mission().min_overlap},
      {"sqlite_arena_peak_bytes", sqlite_arena.stats().peak},
      {"events_lost", executive.events().lost()},
      {"all_sent", flight.all_sent()},
      {"link_capacity_bytes", link_capacity(flight.mission(), flight.now())},
      {"faults", flight.fault_counts()},
  };
  std::ofstream(out / "flight-info.json") << info.dump(2) << "\n";
  std::cerr << "Flight over: " << frames << " frames, " << keyframes << " keyframes, ";
  if (options.linked()) {
    std::cerr << flight.files_delivered() << " files delivered over the link\n";
  } else {
    std::cerr << receiver.files() << " files with " << receiver.bytes() << " bytes in " << (out / "outbox").string()
              << "\n";
  }
  if (!flight.all_sent()) std::cerr << "ilp-sil: the link did not carry everything\n";
  if (frames == 0) {
    std::cerr << "ilp-sil: the source gave no usable frame\n";
    return 1;
  }
  const std::string fault = source.fault();
  if (!fault.empty()) {
    std::cerr << "ilp-sil: " << fault << ": the flight ended with frame " << frames << "\n";
    return status_broken_stream;
  }
  if (flight.keyframes_with_pose() == 0) {
    std::cerr << "ilp-sil: no keyframe has a pose: there are images, but no heights and no map; "
              << (keyframes < 2 ? "a pose needs two keyframes that show the same ground from different places: bring "
                                  "more images (what became of these is in the events)"
                                : "the report says what the keyframes had in common")
              << "\n";
    return status_without_poses;
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

}  // namespace ilp::sil
