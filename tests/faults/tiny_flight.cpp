#include "tests/faults/tiny_flight.hpp"

#include <sys/mman.h>

#include <cstring>
#include <fstream>
#include <new>
#include <set>

#include "bsp/flight/boot.hpp"
#include "bsp/flight/packet_links.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/executive/frame_timing.hpp"
#include "hal/camera/directory/directory_camera.hpp"
#include "hal/camera/directory/pgm.hpp"
#include "hal/clock/virtual_clock.hpp"
#include "hal/link/outbox/outbox_link.hpp"
#include "hal/nonvolatile/file_nonvolatile.hpp"
#include "hal/store/sqlite/sqlite_memory.hpp"
#include "sim/host/colmap.hpp"
#include "sim/world/render_flight.hpp"
#include "tests/faults/packet_ground.hpp"
#include "tests/support/calm_scenario.hpp"

namespace ilp::faults {
namespace fs = std::filesystem;
namespace {

constexpr int images = 12;
constexpr TimeNs interval_ns = 500 * ns_per_ms;
constexpr std::int64_t longest_lock_wait_at_end_ms = 2000;
/// Minor frames between two looks for the disk of a flight in memory.
constexpr std::int64_t look_frames = 10;

alignas(Arena::alignment) std::byte store_region[limits::ram_store_bytes];
Arena sqlite_arena;
StaticMemory memory;
bool with_packets = false;

world::Scenario tiny_scenario() {
  return test::calm_scenario(images, 160, 120, 137);
}

/// Virtual time that reports every reading of the processor's time: the executive takes it before and after each step.
class WatchedClock final : public Clock {
 public:
  WatchedClock(TimeNs start, const std::function<void()>& step) : clock_(start), step_(step) {}
  TimeNs now() override { return clock_.now(); }
  void sleep_until(TimeNs time) override { clock_.sleep_until(time); }
  TimeNs processor_time() override {
    if (step_) step_();
    return 0;
  }

 private:
  VirtualClock clock_;
  const std::function<void()>& step_;
};

alignas(MissionParameters) std::byte mission_place[sizeof(MissionParameters)];
alignas(WatchedClock) std::byte clock_place[sizeof(WatchedClock)];
alignas(FlightStore) std::byte disk_place[sizeof(FlightStore)];
alignas(LedgerStore) std::byte ledger_place[sizeof(LedgerStore)];
alignas(test::FailingStore) std::byte store_place[sizeof(test::FailingStore)];
alignas(DirectoryCamera) std::byte camera_place[sizeof(DirectoryCamera)];
alignas(OutboxLink) std::byte link_place[sizeof(OutboxLink)];
alignas(PacketGround) std::byte ground_place[sizeof(PacketGround)];
alignas(FileNonvolatile) std::byte nonvolatile_memory_place[sizeof(FileNonvolatile)];
alignas(FlightSoftware) std::byte software_place[sizeof(FlightSoftware)];

/// The far end of the link: confirms whole files, and keeps what it has confirmed. Of packets it knows nothing any
/// more after a restart but the files that it had kept.
class Receiver {
 public:
  explicit Receiver(const fs::path& folder) : folder_(folder) {}
  void receive() {
    if (with_packets) return;
    for (const auto& entry : fs::directory_iterator(folder_ / "outbox")) {
      const std::string name = entry.path().filename().string();
      if (entry.path().extension() == ".part" || !seen_.insert(name).second) continue;
      const fs::path confirmation = folder_ / "acknowledged" / (name + ".ack");
      if (fs::exists(confirmation)) continue;
      std::ifstream in(entry.path(), std::ios::binary);
      const std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
      std::ofstream(confirmation) << bytes.size() << " "
                                  << crc32({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}) << "\n";
    }
  }
  /// In every minor frame.
  void listen() {
    if (!with_packets) return;
    static const ground_cfdp::CfdpReceiver::Keep keep = [this](const std::string& name,
                                                               const std::vector<std::uint8_t>& file) {
      const fs::path part = folder_ / "outbox" / (name + ".part");
      std::ofstream(part, std::ios::binary)
          .write(reinterpret_cast<const char*>(file.data()), static_cast<std::streamsize>(file.size()));
      fs::rename(part, folder_ / "outbox" / name);
      return true;
    };
    reinterpret_cast<PacketGround*>(ground_place)->listen(keep);
  }

 private:
  fs::path folder_;
  std::set<std::string> seen_;
};

/// Pages that are all zero take no memory any more: a process that branches off has fewer to share.
void give_back_zeros(std::span<std::byte> memory_of_flight) {
  constexpr std::size_t page = 4096;
  static constexpr std::byte zeros[page]{};
  const auto address = reinterpret_cast<std::uintptr_t>(memory_of_flight.data());
  for (std::size_t at = (page - address % page) % page; at + page <= memory_of_flight.size(); at += page) {
    std::byte* const place = memory_of_flight.data() + at;
    if (std::memcmp(place, zeros, page) == 0) static_cast<void>(madvise(place, page, MADV_DONTNEED));
  }
}

/// Mission time goes on while a disk is tried again.
class VirtualWait final : public DiskWait {
 public:
  explicit VirtualWait(Traces& traces) : traces_(traces) {}
  void until_next_attempt(int, const Status&) override { traces_.now_ns += ns_per_s; }
  void at_work() override {}

 private:
  Traces& traces_;
};

void report(Traces& traces, const Status& status) {
  if (!status.ok() && traces.updates < std::size(traces.statuses)) {
    traces.statuses[traces.updates++] = static_cast<std::uint16_t>(status.code);
  }
}

}  // namespace

void prepare_world(const fs::path& folder) {
  if (fs::exists(folder / "ready")) return;
  world::render_flight(folder, tiny_scenario());
  // In an eighth of the time: every minor frame costs.
  std::ofstream index(folder / "index.txt");
  for (int i = 0; i < images; ++i) {
    char name[32];
    std::snprintf(name, sizeof(name), "images/%04d.pgm", i + 1);
    index << i * interval_ns << " " << name << "\n";
  }
  index.close();
  std::ofstream(folder / "ready") << "\n";
}

MissionParameters tiny_mission() {
  MissionParameters mission;
  // What is lost on the way is sent again within the trial.
  mission.confirmation_timeout_s = 30;
  // Poses become final early, and everything costs little.
  mission.window_keyframes = 3;
  mission.corners = 300;
  mission.quality_layers = 2;
  return mission;
}

CameraModel tiny_camera(const fs::path& world) {
  return host::read_colmap_camera(world / "cameras.txt");
}

const StaticMemory& static_memory() {
  return memory;
}

void prepare_process(Downlinks downlinks) {
  sqlite_arena.init(store_region, limits::sqlite_arena_bytes);
  static_cast<void>(configure_sqlite_memory(sqlite_arena));
  // Boots share the pages that they do not write to. What they refer to is constructed by each of them, in these
  // places, before it is used.
  auto* const mission = new (mission_place) MissionParameters(tiny_mission());
  auto& clock = *reinterpret_cast<WatchedClock*>(clock_place);
  auto* const disk = new (disk_place) FlightStore(sqlite_arena, store_region);
  auto* const camera = new (camera_place) DirectoryCamera;
  auto* const link = new (link_place) OutboxLink;
  with_packets = downlinks == Downlinks::packets;
  auto* const ground = new (ground_place) PacketGround(clock);
  auto& store = *reinterpret_cast<test::FailingStore*>(store_place);
  auto* const software =
      new (software_place) FlightSoftware({.store = store,
                                           .camera = *camera,
                                           .link = *link,
                                           .clock = clock,
                                           .nonvolatile_memory = *new (nonvolatile_memory_place) FileNonvolatile,
                                           .packets = with_packets ? &ground->packets() : nullptr,
                                           .files = with_packets ? &ground->files() : nullptr},
                                          *mission);
  memory = {disk, software, mission, {store_region, limits::sqlite_arena_bytes}};
  give_back_zeros(software_place);
  give_back_zeros(disk_place);
  give_back_zeros(ground_place);
}

namespace {

/// As the board does it in virtual time.
Status begin_configuration(const std::string& database) {
  const Status opened = reinterpret_cast<FileNonvolatile*>(nonvolatile_memory_place)->open(database.c_str());
  return memory.software->prepare({.nonvolatile_memory = opened, .store = memory.store->updates()});
}

}  // namespace

namespace {

/// Looks for the disk of a flight in memory. True when all of it is there: the process ends.
bool leave_memory(const std::string& database, Boot& boot, DiskWait& wait) {
  constexpr std::int64_t free_bytes = 1 << 16;
  if (!try_disk(database.c_str(), free_bytes).ok()) return false;
  static_cast<void>(boot.end());
  if (memory.store->leave_memory(database.c_str(), &wait).ok()) return true;
  boot.record().end_ns = 0;
  static_cast<void>(boot.go_on());
  return false;
}

}  // namespace

BootEnd live(const fs::path& world, const fs::path& folder, TimeNs end_ns, Traces& traces, const Hooks& hooks) {
  FlightStore& disk = *memory.store;
  FlightSoftware& software = *memory.software;
  auto& camera = *reinterpret_cast<DirectoryCamera*>(camera_place);
  auto& link = *reinterpret_cast<OutboxLink*>(link_place);
  const CameraModel model = tiny_camera(world);
  const std::string database = folder / "flight.db";
  if (hooks.begin) hooks.begin();
  VirtualWait wait(traces);
  Status status = disk.open(database.c_str(), StoreTrouble::fly_on, *memory.mission, &wait);
  report(traces, status);
  if (!status.ok()) return boot_refused;
  for (const Status& updates : disk.start().in_order()) report(traces, updates);
  auto& clock = *new (clock_place) WatchedClock(traces.now_ns, hooks.step);
  const bool on_disk = !disk.updates().is(StatusCode::store_in_memory);
  Store* store = &disk.store();
  if (hooks.ledger != nullptr && on_disk) store = new (ledger_place) LedgerStore(*store, *hooks.ledger);
  new (store_place) test::FailingStore(*store, [&](const test::FailingStore::Call& call) {
    traces.calls = call.number;
    return hooks.call ? hooks.call(call) : Status{};
  });
  const std::string outbox = folder / "outbox", acknowledged = folder / "acknowledged";
  if (!camera.open((world / "index.txt").c_str(), model.width, model.height, read_pgm).ok()) return boot_broken;
  if (!link.open(outbox.c_str(), acknowledged.c_str()).ok()) return boot_broken;
  status = begin_configuration(database);
  if (status.ok()) status = software.start(model);
  report(traces, status);
  if (!status.ok()) return disk.damaged() ? boot_restart : boot_refused;
  Boot& boot = software.boot();
  status = software.record_boot({}, disk.start().in_order());
  report(traces, status);
  if (!status.ok()) return disk.damaged() ? boot_restart : boot_refused;
  EventLog& events = software.executive().events();
  // As in real time.
  if (disk.disk() != nullptr) sqlite::wait_for_writers(disk.disk()->session(), minor_frame_ns / ns_per_ms);
  if (hooks.started) hooks.started();

  Receiver receiver(folder);
  TimeNs next = clock.now();
  TimeNs drained_ns = -1;
  bool ends = false;
  for (traces.frames = 0; next < end_ns; ++traces.frames) {
    ends = hooks.ends && hooks.ends();
    if (ends) break;
    if (disk.damaged() || software.restart_wanted()) return boot_restart;
    if (hooks.frame) hooks.frame(traces.frames);
    software.executive().run_minor_frame(next);
    const Status updates = disk.take_updates();
    if (!updates.ok()) events.report(clock.now(), "board", updates);
    if (!on_disk && (traces.frames + 1) % look_frames == 0 && leave_memory(database, boot, wait)) return boot_restart;
    if (traces.frames % 10 == 0) receiver.receive();
    receiver.listen();
    if (!software.drained()) drained_ns = -1;
    if (software.drained() && drained_ns < 0) drained_ns = next;
    if (drained_ns >= 0 && next - drained_ns >= grace_ns) break;
    next = next_frame_begin(next, clock.now());
    clock.sleep_until(next);
    traces.now_ns = next;
  }
  const bool done = drained_ns >= 0;
  if (disk.disk() != nullptr) sqlite::wait_for_writers(disk.disk()->session(), longest_lock_wait_at_end_ms);
  static_cast<void>(software.executive().end());
  static_cast<void>(boot.end());
  if (disk.damaged()) return boot_restart;
  receiver.receive();
  if (disk.updates().is(StatusCode::store_in_memory) && hooks.without_disk) hooks.without_disk(disk.store());
  disk.close();
  if (ends) return boot_ended;
  return done ? boot_done : boot_overtime;
}

}  // namespace ilp::faults
