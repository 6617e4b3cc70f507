// ilp-onboard: the flight binary for Linux boards. Everything is static; after start-up the heap is sealed.

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

#include "bsp/flight/flight_software.hpp"
#include "bsp/flight/key_file.hpp"
#include "bsp/flight/mission_epoch.hpp"
#include "bsp/flight/mission_file.hpp"
#include "bsp/flight/packet_links.hpp"
#include "bsp/memory/flight_heap.hpp"
#include "cfg/version.hpp"
#include "hal/camera/directory/directory_camera.hpp"
#include "hal/camera/directory/pgm.hpp"
#include "hal/clock/real_clock.hpp"
#include "hal/clock/utc.hpp"
#include "hal/clock/virtual_clock.hpp"
#include "hal/link/outbox/outbox_link.hpp"
#include "hal/store/sqlite/sqlite_memory.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"

namespace {

using namespace ilp;

struct Options {
  const char* index = nullptr;
  const char* camera = nullptr;
  const char* database = nullptr;
  const char* outbox = nullptr;
  const char* acknowledgements = nullptr;
  const char* mission = nullptr;
  PacketLinkOptions links;
  const char* key = nullptr;
  bool mission_epoch = false;
  bool virtual_time = false;
  bool trap_heap = false;
  bool memory_map = false;
};

constexpr const char* usage =
    "usage: ilp-onboard --index FILE --camera \"W H FX FY CX CY [K1 K2 P1 P2]\" --database FILE\n"
    "                   (--outbox DIR --acknowledgements DIR [--virtual-time] |\n"
    "                    [--link-udp ADDRESS:PORT [--link-udp-peer ADDRESS:PORT]] [--link-tcp ADDRESS:PORT]\n"
    "                    [--cfdp-udp ADDRESS:PORT [--cfdp-udp-peer ADDRESS:PORT]] [--key FILE])\n"
    "                   [--mission FILE.ini] [--mission-epoch] [--trap-heap]\n"
    "       ilp-onboard --memory-map\n"
    "  --index         recorded strip: a line `time_ns file.pgm [altitude_m]` per frame\n"
    "  --camera        intrinsics in px, pixel centres at integers, Brown distortion\n"
    "  --link-udp, --link-tcp  telecommands and telemetry as space packets; files go by CFDP then (docs/links.md)\n"
    "  --cfdp-udp      bare CFDP PDUs on a port of their own instead of in space packets\n"
    "  --...-peer      send there and to nobody else; else to the stations that were heard\n"
    "  --key           keys of telecommand authentication, which [link] authentication turns on\n"
    "  --mission-epoch mission time counts from the mission's [link] mission_epoch_s, not from the first start\n"
    "  --virtual-time  as fast as the machine allows, and stop when everything is worked through\n"
    "  --trap-heap     abort on any allocation after start-up\n";

bool parse(int argc, char** argv, Options& options) {
  for (int i = 1; i < argc; ++i) {
    const char* value = i + 1 < argc ? argv[i + 1] : nullptr;
    struct {
      const char* name;
      const char** to;
    } const texts[] = {{"--index", &options.index},
                       {"--camera", &options.camera},
                       {"--database", &options.database},
                       {"--outbox", &options.outbox},
                       {"--acknowledgements", &options.acknowledgements},
                       {"--mission", &options.mission},
                       {"--link-udp", &options.links.udp},
                       {"--link-udp-peer", &options.links.udp_peer},
                       {"--link-tcp", &options.links.tcp},
                       {"--key", &options.key},
                       {"--cfdp-udp", &options.links.cfdp},
                       {"--cfdp-udp-peer", &options.links.cfdp_peer}};
    struct {
      const char* name;
      bool* to;
    } const flags[] = {{"--virtual-time", &options.virtual_time},
                       {"--mission-epoch", &options.mission_epoch},
                       {"--trap-heap", &options.trap_heap},
                       {"--memory-map", &options.memory_map}};
    bool known = false;
    for (const auto& flag : flags) {
      if (std::strcmp(argv[i], flag.name) == 0) known = *flag.to = true;
    }
    for (const auto& text : texts) {
      if (known || std::strcmp(argv[i], text.name) != 0) continue;
      if (value == nullptr) return false;
      *text.to = value;
      ++i;
      known = true;
    }
    if (!known) return false;
  }
  if (options.memory_map) return true;
  const bool folders = options.outbox != nullptr && options.acknowledgements != nullptr;
  // A link to others runs in the time of others.
  if (options.links.any() ? options.virtual_time : !folders) return false;
  return options.index != nullptr && options.camera != nullptr && options.database != nullptr;
}

bool parse_camera(const char* text, CameraModel& camera) {
  double numbers[10] = {};
  int count = 0;
  for (char* end = nullptr; count < 10; ++count, text = end) {
    numbers[count] = std::strtod(text, &end);
    if (end == text) break;
  }
  if (count != 6 && count != 10) return false;
  camera = {static_cast<std::int32_t>(numbers[0]),
            static_cast<std::int32_t>(numbers[1]),
            numbers[2],
            numbers[3],
            numbers[4],
            numbers[5],
            numbers[6],
            numbers[7],
            numbers[8],
            numbers[9]};
  return true;
}

alignas(Arena::alignment) std::byte sqlite_region[limits::sqlite_arena_bytes];
Arena sqlite_arena;
alignas(PacketRouter) std::byte router_region[sizeof(PacketRouter)];
alignas(FlightSoftware) std::byte flight_region[sizeof(FlightSoftware)];
char output_buffer[BUFSIZ];
volatile std::sig_atomic_t stop_requested = 0;

void request_stop(int) {
  stop_requested = 1;
}

int fail(const char* what, const Status& status) {
  std::fprintf(stderr, "ilp-onboard: %s: %s (a = %lld, b = %lld): %s\n", what, status_text(status.code),
               static_cast<long long>(status.a), static_cast<long long>(status.b), status_advice(status.code));
  return 1;
}

int print_memory_map() {
  std::size_t total = 0;
  std::printf("Static memory of the flight, version %s, profile %s\n", software_version, limits::profile);
  const auto row = [&total](std::size_t bytes, const char* name) {
    total += bytes;
    std::printf("%12zu  %s\n", bytes, name);
  };
  for (const MemoryRegion& region : memory_map()) row(region.bytes, region.name);
  row(sizeof(SqliteStore) + sizeof(DirectoryCamera) + sizeof(OutboxLink) + sizeof(PacketLinks),
      "hardware abstraction layer");
  row(heap_region_report(HeapRegion::early).bytes, "start-up heap");
  std::printf("%12zu  total (%.1f MiB)\n", total, static_cast<double>(total) / 1048576.0);
  return 0;
}

void print_address(const char* what, const SocketAddress& address) {
  if (address == SocketAddress{}) return;
  std::fprintf(stderr, "ilp-onboard: %s at %u.%u.%u.%u:%u\n", what, address.host >> 24U, (address.host >> 16U) & 255U,
               (address.host >> 8U) & 255U, address.host & 255U, static_cast<unsigned>(address.port));
}

Status open_links(const PacketLinkOptions& options, PacketLinks& links, const char*& culprit) {
  ILP_TRY(links.open(options, culprit));
  PacketLinks::Addresses addresses;
  ILP_TRY(links.addresses(addresses));
  print_address("packets over UDP", addresses.udp);
  print_address("packets over TCP", addresses.tcp);
  print_address("CFDP over UDP", addresses.cfdp);
  return {};
}

void print_heap_use() {
  for (const HeapRegion region : {HeapRegion::early, HeapRegion::openjpeg}) {
    const HeapRegionReport report = heap_region_report(region);
    std::printf("%s: peak %zu of %zu bytes, %llu requests, %llu failed\n", report.name, report.peak, report.bytes,
                static_cast<unsigned long long>(report.requests), static_cast<unsigned long long>(report.failed));
  }
  const ArenaStats& sqlite = sqlite_arena.stats();
  std::printf("SQLite: peak %zu of %zu bytes, %llu requests, %llu failed\n", sqlite.peak, sqlite.capacity,
              static_cast<unsigned long long>(sqlite.requests), static_cast<unsigned long long>(sqlite.failed));
  std::printf("heap requests after sealing: %llu\n", static_cast<unsigned long long>(heap_trap_count()));
}

int fly(const Options& options) {
  static SqliteStore store;
  static DirectoryCamera camera;
  static OutboxLink link;
  static VirtualClock virtual_clock;
  static RealClock real_clock;
  static MissionParameters mission;

  CameraModel model;
  if (!parse_camera(options.camera, model)) {
    std::fprintf(stderr, "ilp-onboard: --camera needs 6 or 10 numbers\n");
    return 2;
  }
  MissionFileError error;
  if (options.mission != nullptr) {
    const Status status = read_mission_file(options.mission, mission, error);
    if (!status.ok()) {
      std::fprintf(stderr, "ilp-onboard: [%s] %s = %s\n", error.section, error.key, error.value);
      return fail(options.mission, status);
    }
  }
  sqlite_arena.init(sqlite_region, sizeof(sqlite_region));
  Status status = configure_sqlite_memory(sqlite_arena);
  if (!status.ok()) return fail("SQLite's memory", status);
  status = store.open(options.database);
  if (status.ok()) status = store.limit(database_limit_bytes(mission));
  if (!status.ok()) return fail(options.database, status);
  if (options.outbox != nullptr) {
    status = link.open(options.outbox, options.acknowledgements);
    if (!status.ok()) return fail("outbox", status);
  }
  status = camera.open(options.index, model.width, model.height, read_pgm);
  if (!status.ok()) return fail(options.index, status);

  Clock& clock = options.virtual_time ? static_cast<Clock&>(virtual_clock) : real_clock;
  static PacketLinks links(clock);
  const char* culprit = nullptr;
  status = open_links(options.links, links, culprit);
  if (!status.ok()) return fail(culprit, status);
  static Authenticator keys;
  status = options.key != nullptr ? read_key_file(options.key, keys) : Status{};
  if (!status.ok()) return fail(options.key, status);
  if (keys.empty() && options.links.any() && mission.authentication >= 1) {
    return fail("[link] authentication needs --key", StatusCode::authentication_off);
  }
  if (!options.virtual_time) {
    TimeNs start = 0;
    const EpochChoice epoch = options.mission_epoch ? EpochChoice::mission : EpochChoice::first_start;
    status = begin_mission_time(store, epoch, utc_now(), mission, start);
    if (!status.ok()) return fail("mission time", status);
    real_clock.set(start);
  }
  auto& router = *new (router_region) PacketRouter(links.packets(), links.files(), clock, mission);
  router.authenticate_with(keys);
  auto& software = *new (flight_region) FlightSoftware(store, camera, link, router, clock, mission);
  status = software.start(model);
  if (!status.ok()) return fail("start", status);

  seal_heap(options.trap_heap ? HeapTrapMode::strict : HeapTrapMode::report);
  TimeNs next = clock.now();
  while (stop_requested == 0 && !(options.virtual_time && software.processed())) {
    software.executive().run_minor_frame();
    next += minor_frame_ns;
    clock.sleep_until(next);
  }
  status = software.executive().write_housekeeping();
  if (!status.ok()) return fail("housekeeping", status);
  print_heap_use();
  std::int64_t frames = 0;
  status = store.count(record_info(RecordType::frame), frames);
  if (!status.ok()) return fail("counting frames", status);
  store.close();
  if (frames == 0) std::fprintf(stderr, "ilp-onboard: the source gave no usable frame; the events say why\n");
  return frames == 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  setvbuf(stdout, output_buffer, _IOFBF, sizeof(output_buffer));
  Options options;
  if (!parse(argc, argv, options)) {
    std::fputs(usage, stderr);
    return 2;
  }
  if (options.memory_map) return print_memory_map();
  std::signal(SIGTERM, request_stop);
  std::signal(SIGINT, request_stop);
  return fly(options);
}
