// ilp-onboard: the flight program for Linux boards. All of its memory is static; after start-up the heap is sealed.

#include <array>
#include <cerrno>
#include <cinttypes>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <new>
#include <optional>

#include "bsp/flight/disk_probe.hpp"
#include "bsp/flight/flight_software.hpp"
#include "bsp/flight/key_file.hpp"
#include "bsp/flight/lock_lease.hpp"
#include "bsp/flight/self_test.hpp"
#include "bsp/linux/board.hpp"
#include "bsp/linux/chosen_store.hpp"
#include "bsp/linux/flight_stack.hpp"
#include "bsp/linux/flight_worker.hpp"
#include "bsp/linux/image_sources.hpp"
#include "bsp/linux/memory_report.hpp"
#include "bsp/linux/node_process.hpp"
#include "bsp/linux/options.hpp"
#include "bsp/linux/shared_flight.hpp"
#include "bsp/linux/status_line.hpp"
#include "bsp/linux/timing_report.hpp"
#include "bsp/linux/watched_wait.hpp"
#include "bsp/memory/flight_heap.hpp"
#include "bsp/version/build_version.hpp"
#include "cfg/limits.hpp"
#include "cfg/version.hpp"
#include "fsw/executive/frame_timing.hpp"
#include "fsw/navigation/vehicle_packets.hpp"
#include "fsw/shared/camera_on_record.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "hal/camera/picture/reduction.hpp"
#include "hal/clock/real_clock.hpp"
#include "hal/clock/utc.hpp"
#include "hal/clock/virtual_clock.hpp"
#include "hal/compute/shared/shared_compute.hpp"
#include "hal/link/outbox/outbox_link.hpp"
#include "hal/link/udp/udp_link.hpp"
#include "hal/maps/directory_map_source.hpp"
#include "hal/navigation/csv/navigation_file.hpp"
#include "hal/nonvolatile/file_nonvolatile.hpp"
#include "hal/store/sqlite/sqlite_memory.hpp"
#include "hal/watchdog/linux_watchdog.hpp"
#include "hal/watchdog/service_watchdog.hpp"

namespace {

using namespace ilp;

/// The flight continues with a new process: its database is damaged, its records have left memory, or parameters need a
/// new start.
constexpr int exit_restart = 3;
/// In real time a minor frame waits no longer for the transactions of other processes; else the end of theirs counts.
constexpr std::int64_t longest_lock_wait_ms = minor_frame_ns / ns_per_ms;
constexpr std::int64_t longest_lock_wait_at_end_ms = 2000;
/// Minor frames between two entries of this boot in the store.
constexpr std::int64_t frames_between_entries = 100;
/// Of a job on a compute device; before the flight a driver may still compile.
constexpr TimeNs first_job_limit_ns = 60 * ns_per_s;
constexpr TimeNs job_limit_ns = 10 * ns_per_s;

alignas(Arena::alignment) std::byte store_region[limits::ram_store_bytes];
Arena sqlite_arena;
alignas(FlightSoftware) std::byte flight_region[sizeof(FlightSoftware)];
char output_buffer[BUFSIZ];
volatile std::sig_atomic_t stop_requested = 0;

void request_stop(int) {
  stop_requested = 1;
}

int fail(const char* what, const Status& status) {
  print_status(what, status);
  return 1;
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

/// Opens everything that the options name, in the same way for a recorded strip and for a camera.
class Flight {
 public:
  Flight(const Options& options, StageMask stages, ChosenStore& store)
      : options_(options), stages_(stages), store_(store) {}

  /// Exit status of the program.
  int fly();

 private:
  bool prepare();
  bool prepare_mission();
  bool prepare_store();
  bool prepare_links();
  bool assemble();
  bool prepare_start();
  bool prepare_camera();
  bool prepare_intrinsics();
  bool reduce_camera();
  bool find_source_of(const CameraModel& camera);
  bool prepare_navigation();
  bool prepare_map();
  bool start();
  void test_board();
  void prepare_compute();
  void prepare_look();
  bool done();
  void check_lock();
  void run();
  void leave_memory();
  void write_boot();
  void check_calendar();
  [[nodiscard]] bool restart_wanted() const { return left_memory_ || store_.damaged() || software_->restart_wanted(); }
  void report_unknown_camera();
  int finish();
  bool good(const char* what, const Status& status) { return status.ok() || fail(what, status) == 0; }
  /// Status ok is no event. The executive reports a lock.
  void report(const Status& status) {
    if (!status.ok() && !status.is(StatusCode::store_locked))
      software_->executive().events().report(clock().now(), "board", status);
  }
  Store& database() { return shared_ ? shared_->store() : store_.store(); }
  Camera& camera() { return shared_ ? shared_->camera() : source_->camera(); }
  Clock& clock() { return options_.virtual_time ? static_cast<Clock&>(virtual_clock_) : real_clock_; }

  const Options& options_;
  StageMask stages_;
  MissionParameters mission_;
  MissionParameters mission_of_file_;  ///< what the processes of a flight have to agree on
  CameraModel model_;
  std::int32_t width_ = 0, height_ = 0;  ///< of the source's pictures, which may be larger than the images
  int priority_ = 0;
  int lock_lease_s_ = usual_lock_lease_s;
  LockWatch lock_watch_;
  Status early_update_;  ///< of the lock, before the components have begun
  WatchdogOptions watchdog_options_;
  LinuxWatchdog linux_watchdog_;
  NullWatchdog no_watchdog_;
  Watchdog& watchdog_ = options_.watchdog != nullptr ? static_cast<Watchdog&>(linux_watchdog_) : no_watchdog_;
  ServiceWatchdog manager_;
  ChosenStore& store_;
  std::optional<SharedFlight> shared_;  ///< with other processes
  FileNonvolatile nonvolatile_memory_;
  LateCalendar calendar_;
  OutboxLink outbox_;
  VirtualClock virtual_clock_;
  RealClock real_clock_;
  ImageSources::Chosen source_;
  NavigationFile navigation_;
  DirectoryMapSource map_;
  UdpLink vehicle_link_{real_clock_};
  VehiclePackets vehicle_{vehicle_link_, mission_};
  WatchedWait wait_{watchdog_, manager_, clock()};
  PacketLinks links_{clock()};
  Authenticator keys_;
  FlightSoftware* software_ = nullptr;
  std::optional<SharedCompute> device_;
  FlightWorker worker_;
  DiskProbe look_;
  bool left_memory_ = false;  ///< all records are on the disk, and the next start takes them into the database
  bool stack_reported_ = false;
};

bool Flight::prepare_mission() {
  if (!read_mission(options_, mission_)) return false;
  mission_of_file_ = mission_;
  const char* const reached = options_.links.reached_by_others();
  if (reached == nullptr || options_.without_authentication || mission_.authentication != Authentication::none) {
    return true;
  }
  std::fprintf(stderr,
               "ilp-onboard: link %s: other computers reach this address, and whoever does could command the flight: "
               "give it --key FILE and [link] authentication = telecommands in the mission, or name 127.0.0.1, or say "
               "--without-authentication\n",
               reached);
  return false;
}

bool Flight::prepare_store() {
  if (options_.watchdog != nullptr) wait_.begin_start(linux_watchdog_, watchdog_options_);
  const Status opened = store_.open(options_, stages_, mission_, wait_);
  wait_.end_start();
  if (!opened.ok()) print_status(store_label(options_), opened, store_.message());
  // Whoever keeps the lock is told and, if it is of this flight, ended.
  while (opened.ok() && stop_requested == 0 && wait_for_lock(store_.disk())) check_lock();
  return opened.ok();
}

/// Nothing of the devices is used yet.
bool Flight::assemble() {
  source_.make(*options_.source_kind, {real_clock_, !options_.virtual_time});
  if (stages_ != all_stages) {
    const PrimaryDevices devices{source_->camera(), outbox_, links_.packets(), links_.files()};
    shared_.emplace(store_.store(), store_.sharing(), devices, clock(), stages_, options_.virtual_time);
  }
  const int error = worker_.begin(options_);
  if (error != 0) std::fprintf(stderr, "ilp-onboard: there is no worker: %s\n", std::strerror(error));
  NavigationSource* const live = options_.navigation_udp != nullptr ? &vehicle_ : nullptr;
  software_ = new (flight_region) FlightSoftware({.store = database(),
                                                  .camera = camera(),
                                                  .link = shared_ ? shared_->link() : outbox_,
                                                  .clock = clock(),
                                                  .nonvolatile_memory = nonvolatile_memory_,
                                                  .packets = shared_ ? shared_->packets() : links_.packets(),
                                                  .files = shared_ ? shared_->files() : links_.files(),
                                                  .navigation = options_.navigation != nullptr ? &navigation_ : live,
                                                  .map = options_.map != nullptr ? &map_ : nullptr,
                                                  .worker = worker_.worker(),
                                                  .image = program_image(),
                                                  .real_time = !options_.virtual_time},
                                                 mission_, stages_);
  software_->router().authenticate_with(keys_);
  return true;
}

bool Flight::prepare_start() {
  const bool no_file = std::strcmp(options_.store, "memory") == 0 && options_.state == nullptr;
  const char* const place = options_.state != nullptr ? options_.state : options_.store;
  const Status opened = no_file ? Status{StatusCode::not_found} : nonvolatile_memory_.open(place);
  if (opened.is(StatusCode::io_error) && opened.a == EWOULDBLOCK) return good(place, StatusCode::store_in_use);
  const StartFacts facts{.nonvolatile_memory = opened,
                         .store = store_.updates(),
                         .utc = options_.virtual_time ? std::nullopt : std::optional(utc_now()),
                         .epoch = options_.mission_epoch ? EpochChoice::mission : EpochChoice::first_start};
  if (!good("settings or mission time", software_->prepare(facts))) return false;
  calendar_.begin(software_->time());
  real_clock_.set(software_->time().now);
  virtual_clock_.sleep_until(software_->time().now);
  return true;
}

bool Flight::prepare_links() {
  Status opened;
  if (options_.outbox != nullptr) opened = outbox_.open(options_.outbox, options_.acknowledgements);
  if (opened.is(StatusCode::io_error) && opened.a == ENOENT) {
    std::fprintf(stderr,
                 "ilp-onboard: --outbox %s, --acknowledgements %s: there is no such folder: make it with mkdir -p\n",
                 options_.outbox, options_.acknowledgements);
    return false;
  }
  if (!good("outbox", opened)) return false;
  const char* culprit = nullptr;
  opened = open_links(options_.links, links_, culprit);
  if (!opened.ok()) {
    std::fprintf(stderr, "ilp-onboard: link %s: %s\n", culprit, link_advice(opened));
    return false;
  }
  if (options_.key != nullptr && !good(options_.key, read_key_file(options_.key, keys_))) return false;
  const bool keys_wanted = options_.links.any() && mission_.authentication != Authentication::none;
  return !keys_wanted || !keys_.empty() || good("[link] authentication needs --key", StatusCode::authentication_off);
}

/// From the camera of the source's pictures to that of the flight's images.
bool Flight::reduce_camera() {
  Reduction reduction;
  const Status found = find_reduction(width_, height_, reduction);
  if (!found.ok()) return good("--camera or --size", found);
  model_ = reduced_camera(model_, reduction);
  if (reduction.changes_nothing()) return true;
  std::fprintf(stderr,
               "ilp-onboard: pictures of %d x %d become images of %d x %d: cut to %d x %d at (%d, %d), %d x %d pixels "
               "each; camera %.3f %.3f %.3f %.3f\n",
               width_, height_, reduction.width, reduction.height, reduction.width * reduction.factor,
               reduction.height * reduction.factor, reduction.left, reduction.top, reduction.factor, reduction.factor,
               model_.fx, model_.fy, model_.cx, model_.cy);
  return true;
}

/// The size of the pictures that give the images of the camera on record: that of --size or of the source if they do,
/// else the images' own.
bool Flight::find_source_of(const CameraModel& camera) {
  const bool stated = options_.size != nullptr;
  const Status found = stated ? Status{} : source_->find_size(options_.source, width_, height_);
  Reduction reduction;
  const Status reduced = found.ok() ? find_reduction(width_, height_, reduction) : found;
  if (reduced.ok() && reduction.width == camera.width && reduction.height == camera.height) return true;
  if (stated) return good("--size", {StatusCode::image_size_changed, reduction.width, reduction.height});
  width_ = camera.width;
  height_ = camera.height;
  return true;
}

/// Without --camera: the camera with which the flight began, or a nominal one.
bool Flight::prepare_intrinsics() {
  if (options_.camera != nullptr) {
    width_ = model_.width;
    height_ = model_.height;
    const CameraSuspicion suspicion = suspicion_about(model_);
    if (suspicion != CameraSuspicion::none)
      std::fprintf(stderr, "ilp-onboard: --camera is improbable: %s\n", words_of(suspicion));
    return reduce_camera();
  }
  CameraRecord first;
  const Status begun = get_first_camera(store_.store(), first);
  if (begun.ok()) {
    model_ = camera_model(first);
    return find_source_of(model_);
  }
  if (!is_gone(begun)) return good("camera", begun);
  if (mission_.camera_known) {
    std::fputs("ilp-onboard: without --camera the mission has to say [calibration] camera_known = false\n", stderr);
    return false;
  }
  const Status found = options_.size != nullptr ? Status{} : source_->find_size(options_.source, width_, height_);
  if (!found.ok()) {
    std::fputs("ilp-onboard: without --camera the size of the images must be known: --size WIDTHxHEIGHT\n", stderr);
    return good(options_.source, found);
  }
  model_ = camera_of_field(width_, height_, mission_.field_of_view_rad);
  std::fprintf(stderr, "ilp-onboard: nominal camera: %d x %d, field of view %.4f rad, focal length %.1f px\n", width_,
               height_, mission_.field_of_view_rad, model_.fx);
  return reduce_camera();
}

bool Flight::prepare_camera() {
  return prepare_intrinsics() && good(options_.source, source_->open(options_.source, width_, height_));
}

bool Flight::prepare_navigation() {
  if (options_.navigation == nullptr && options_.navigation_udp == nullptr) return true;
  mission_.use_navigation = mission_of_file_.use_navigation = true;
  if (options_.navigation != nullptr) return good(options_.navigation, navigation_.open(options_.navigation));
  SocketAddress address;
  Status status = parse_address(options_.navigation_udp, address);
  if (status.ok()) status = vehicle_link_.open(address, nullptr);
  return good(options_.navigation_udp, status);
}

bool Flight::prepare_map() {
  if (options_.map == nullptr) return true;
  mission_.use_map = mission_of_file_.use_map = true;
  map_.require_key(keys_.first_key());
  if (!good(options_.map, map_.open(options_.map))) return false;
  if (!map_.has_directory()) {
    std::fprintf(stderr,
                 "ilp-onboard: --map %s: there is no %s in it; the flight goes on without a map until its files come "
                 "(ilp-ground map-tiles makes them)\n",
                 options_.map, map_directory_name);
  }
  return true;
}

bool Flight::prepare() {
  return (options_.camera == nullptr || parse_camera(options_.camera, model_) ||
          refused("--camera needs 6, 10, 11 or 14 numbers, or 6, fisheye and 4", options_.camera)) &&
         (options_.size == nullptr || parse_size(options_.size, width_, height_) ||
          refused("--size needs WIDTHxHEIGHT", options_.size)) &&
         read_priority(options_, priority_) && read_lock_lease(options_, lock_lease_s_) &&
         (options_.watchdog == nullptr || parse_watchdog(options_.watchdog, watchdog_options_) ||
          refused("--watchdog needs DEVICE or DEVICE:SECONDS", options_.watchdog)) &&
         prepare_mission() && prepare_store() && prepare_links() && assemble() && prepare_start() && prepare_camera() &&
         prepare_navigation() && prepare_map();
}

void Flight::test_board() {
  SelfTestResults results = run_self_tests(store_.store(), clock());
  if (store_.updates().is(StatusCode::store_in_memory)) results.note(SelfTest::disk, false, store_.updates().a);
  software_->boot().record().tested = results.tested;
  software_->boot().record().failed = results.failed;
  for (std::size_t k = 0; k < results.values.size(); ++k) {
    if ((results.failed >> k & 1U) == 0) continue;
    std::fprintf(stderr, "ilp-onboard: self-test %s failed\n", name_of(static_cast<SelfTest>(k)));
    report({StatusCode::self_test_failed, static_cast<std::int64_t>(k), results.values[k]});
  }
}

void Flight::prepare_compute() {
  FlightCompute& compute = software_->compute();
  if (options_.virtual_time) compute.compute().wait_for_answers();
  if (options_.compute == nullptr) return;
  device_.emplace(compute.forms());
  // Without it the flight is the same, only slower: the comparison says what is wrong.
  static_cast<void>(device_->open({options_.compute, first_job_limit_ns}));
  const Status accepted = software_->accept(*device_);
  if (!accepted.ok()) static_cast<void>(fail(options_.compute, accepted));
  device_->limit(job_limit_ns);
}

void Flight::prepare_look() {
  if (options_.virtual_time || !store_.updates().is(StatusCode::store_in_memory)) return;
  const int error = look_.begin(options_.store, store_.store().usage().limit_bytes, store_.look_stack());
  if (error != 0)
    std::fprintf(stderr, "ilp-onboard: the store stays in memory, because the search for its disk cannot start: %s\n",
                 std::strerror(error));
}

bool Flight::start() {
  prepare_compute();
  if (!good("start", software_->start(model_))) return false;
  const Status armed = options_.watchdog != nullptr ? linux_watchdog_.open(watchdog_options_) : Status{};
  BoardState board = board_state();
  board.watchdog_had_bitten = watchdog_.bitten();
  const std::array updates = store_.start().in_order();
  for (const Status& one : updates) good(store_label(options_), one);
  if (!good("record of the start", software_->record_boot(board, updates))) return false;
  report(armed);
  report(early_update_);
  prepare_look();
  test_board();
  if (priority_ > 0) report(ask_for_real_time(priority_));
  if (shared_ && !good("record of the node", shared_->begin(mission_of_file_))) return false;
  const Status managed = manager_.open(std::getenv("NOTIFY_SOCKET"));
  report(managed.ok() ? manager_.ready() : managed);
  return good("record of the start", software_->boot().go_on());
}

void Flight::write_boot() {
  StartRecord& record = software_->boot().record();
  record.stack_bytes = static_cast<std::uint32_t>(flight_stack_peak());
  record.heap_traps = static_cast<std::uint32_t>(heap_trap_count());
  if (!stack_reported_ && record.stack_bytes > flight_stack_bytes() / 4 * 3) {
    stack_reported_ = true;
    report({StatusCode::stack_deep, record.stack_bytes, static_cast<std::int64_t>(flight_stack_bytes())});
  }
}

void Flight::check_calendar() {
  TimeNs time = 0;
  Status updates;
  if (!calendar_.caught_up(utc_now(), mission_, clock().now(), time, updates)) return;
  real_clock_.set(time);
  source_->follow_clock();
  report(updates);
}

bool Flight::done() {
  if (!options_.virtual_time || !software_->processed()) return false;
  return !shared_ || shared_->done(software_->executive());
}

void Flight::check_lock() {
  if (store_.disk() == nullptr) return;
  const Status updates = lock_watch_.look(*store_.disk(), lock_lease_s_);
  if (updates.ok()) return;
  print_status(store_label(options_), updates);
  if (software_ != nullptr) {
    report(updates);
  } else {
    early_update_ = updates;
  }
}

/// Between two minor frames, no transaction is open.
void Flight::leave_memory() {
  static_cast<void>(software_->executive().end());
  static_cast<void>(software_->boot().end());  // The next start finds in the copy that this boot has ended in order.
  const Status left = store_.leave_memory(options_.store, &wait_);
  left_memory_ = left.ok();
  if (left_memory_) return software_->configuration().end_in_order(clock().now());
  software_->boot().record().end_ns = 0;
  report(software_->boot().go_on());
  report({StatusCode::store_not_moved, static_cast<std::int64_t>(left.code), left.a});
  look_.probe_again();
}

void Flight::run() {
  TimeNs next = clock().now();
  std::int64_t frames = 0;
  if (store_.disk() != nullptr && !options_.virtual_time)
    sqlite::wait_for_writers(store_.disk()->session(), longest_lock_wait_ms);
  while (stop_requested == 0 && !restart_wanted()) {
    if (shared_ && !shared_->connected(software_->executive())) {
      // The board is well: no reset would bring the server back.
      static_cast<void>(watchdog_.kick());
      static_cast<void>(manager_.kick(clock().now()));
      continue;
    }
    check_lock();
    if (options_.virtual_time && is_locked(store_.disk()) && wait_for_lock(store_.disk())) {
      // Mission time stands still.
      static_cast<void>(watchdog_.kick());
      static_cast<void>(manager_.kick(clock().now()));
      continue;
    }
    if (done()) break;
    software_->executive().run_minor_frame(next);
    report(watchdog_.kick());
    report(manager_.kick(clock().now()));
    report(software_->compute().compute().take_updates());
    report(store_.take_updates());
    if (++frames % frames_between_entries == 0 && !options_.virtual_time) {
      write_boot();
      report(software_->boot().go_on());
      check_calendar();
    }
    if (look_.found()) leave_memory();
    if (shared_) report(shared_->keep_alive(software_->executive()));
    // Others have to finish first, and mission time stands still.
    if (shared_ && shared_->waited(software_->executive())) continue;
    next = next_frame_begin(next, clock().now());
    clock().sleep_until(next);
  }
}

/// Without it no pose is final, so nothing of the ground has been made.
void Flight::report_unknown_camera() {
  CameraRecord camera;
  std::int64_t keyframes = 0;
  if (!get_camera(store_.store(), camera_id, camera).ok() || camera.frozen) return;
  if (!store_.store().count(record_info(RecordType::keyframe), keyframes).ok() || keyframes == 0) return;
  std::fprintf(stderr,
               "ilp-onboard: the camera is not known yet after %" PRId64
               " keyframes, so there are no heights, no poses and no products: start again with the same --store to "
               "take more images (16 keyframes at least, over relief, from a camera that tilts), or begin a flight "
               "with --camera\n",
               keyframes);
}

int Flight::finish() {
  manager_.stop();
  if (store_.disk() != nullptr) sqlite::wait_for_writers(store_.disk()->session(), longest_lock_wait_at_end_ms);
  if (left_memory_) {
    std::fprintf(stderr, "ilp-onboard: the disk is back, and has all records of the flight in memory: start again\n");
    return exit_restart;
  }
  if (store_.damaged()) {
    std::fprintf(stderr, "ilp-onboard: %s is damaged: start again\n", options_.store);
    return exit_restart;
  }
  if (software_->damaged()) {
    std::fprintf(stderr, "ilp-onboard: memory was damaged, or the worker is stuck: start again\n");
    return exit_restart;
  }
  while (options_.virtual_time && stop_requested == 0 && wait_for_lock(store_.disk())) check_lock();
  // On a full disk the end is not recorded, but it is in order otherwise.
  if (stop_requested != 0 && !software_->restart_wanted()) software_->configuration().end_in_order(clock().now());
  bool well = good("housekeeping", software_->executive().end());
  write_boot();
  well = good("record of the end", software_->boot().end()) && well;
  watchdog_.stop();
  worker_.end();
  print_memory_use(store_.file());
  print_timing(software_->executive());
  std::int64_t frames = 0;
  well = good("counting frames", store_.store().count(record_info(RecordType::frame), frames)) && well;
  if (!restart_wanted()) report_unknown_camera();
  if (shared_) well = good("synchronising the store", store_.sharing().flush_or_later()) && well;
  store_.close();
  if (frames == 0) std::fprintf(stderr, "ilp-onboard: the source gave no usable frame; the events say why\n");
  if (software_->restart_wanted()) {
    std::fprintf(stderr, "ilp-onboard: parameters or memory need a start: start again\n");
    return exit_restart;
  }
  return well && frames > 0 ? 0 : 1;
}

int Flight::fly() {
  if (!prepare() || !start()) return store_.damaged() ? exit_restart : 1;
  seal_heap(options_.trap_heap ? HeapTrapMode::strict : HeapTrapMode::report);
  run();
  return finish();
}

struct Order {
  const Options& options;
  StageMask stages;
};

void print_fault(const CommandLineFault& fault) {
  const bool near = fault.nearest != nullptr;
  std::fprintf(stderr, "ilp-onboard: %s %s%s%s; ilp-onboard --help lists all options\n", fault.word, fault.reason,
               near ? ", the nearest is " : "", near ? fault.nearest : "");
}

int fly(void* argument) {
  const Order& order = *static_cast<const Order*>(argument);
  sqlite_arena.init(store_region, limits::sqlite_arena_bytes);
  const Status configured = configure_sqlite_memory(sqlite_arena);
  if (!configured.ok()) return fail("SQLite's memory", configured);
  static ChosenStore store(sqlite_arena, store_region);
  if (!is_primary(order.stages)) {
    return run_node(order.options, order.stages, {store, flight_region}, stop_requested);
  }
  static Flight flight(order.options, order.stages, store);
  return flight.fly();
}

}  // namespace

int main(int argc, char** argv) {
  setvbuf(stdout, output_buffer, _IOFBF, sizeof(output_buffer));
  Options options;
  CommandLineFault fault;
  const bool understood = parse(argc, argv, options, fault);
  StageMask stages = all_stages;
  StageNames culprit;
  if (options.stages != nullptr && !parse_stages(options.stages, stages, culprit)) {
    std::fprintf(
        stderr,
        "ilp-onboard: --stages: \"%s\" is no stage that can run by itself; they are head, %s (docs/schedule.md)\n",
        culprit.c_str(), stage_names(all_stages & ~primary_stages).c_str());
    return 2;
  }
  if (!understood) {
    print_fault(fault);
    return 2;
  }
  if (options.help) {
    print_usage();
    return 0;
  }
  if (names_password(options)) {
    std::fputs(
        "ilp-onboard: --store: a password on the command line can be seen by others: put it into a file that "
        "PGPASSFILE names\n",
        stderr);
    return 2;
  }
  if (options.version) {
    std::printf("ilp-onboard %s, commit %s, profile %s\n", software_version, build_commit(), limits::profile);
    return 0;
  }
  if (options.memory_map) {
    print_memory_map();
    return 0;
  }
  use_instructions_of_processor();
  std::signal(SIGTERM, request_stop);
  std::signal(SIGINT, request_stop);
  // A terminal that closes, or an order to read settings again, is no reason to end a flight.
  std::signal(SIGHUP, SIG_IGN);
  Order order{options, stages};
  int result = 1;
  const int error = call_on_flight_stack(fly, &order, result);
  if (error != 0)
    std::fprintf(stderr, "ilp-onboard: the flight's thread cannot be started: %s\n", std::strerror(error));
  return result;
}
