#include "bsp/flight/flight_software.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <type_traits>

#include "fsw/base/argument.hpp"
#include "fsw/commanding/settings.hpp"
#include "fsw/shared/camera_on_record.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

/// Those of a table with one element for each stage that belong to `stages`, in the same order.
template <typename T>
std::array<std::remove_const_t<T>, stage_count> chosen(std::span<T, stage_count> all, StageMask stages) {
  std::array<std::remove_const_t<T>, stage_count> some{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < stage_count; ++i) {
    if (has_stage(stages, schedule[i].component)) some[count++] = all[i];
  }
  return some;
}

std::size_t count_of(StageMask stages) {
  return static_cast<std::size_t>(std::popcount(stages));
}

}  // namespace

FlightSoftware::FlightSoftware(const FlightDevices& devices, MissionParameters& mission, StageMask stages)
    : store_(devices.store),
      steps_(devices.store),
      images_(steps_),
      mission_(mission),
      memory_(devices.nonvolatile_memory),
      configuration_(memory_, mission),
      boot_(devices.store, devices.clock),
      commanded_(devices.packets != nullptr),
      router_(devices.packets, devices.files, devices.clock, mission),
      telemetry_writer_(router_, devices.clock, mission),
      delivery_queue_(steps_, devices.clock, mission, step_memory_, &delivery_.backlog),
      rows_here_(chosen(std::span(schedule), stages)),
      // The whole table is a constant of the program, which the scrubber watches.
      executive_(stages == all_stages ? std::span<const Stage>(schedule)
                                      : std::span<const Stage>(rows_here_).first(count_of(stages)),
                 stages == all_stages ? std::span<Component* const>(components_)
                                      : std::span<Component* const>(components_here_).first(count_of(stages)),
                 devices.store, devices.clock,
                 {.parameters = &mission,
                  .real_time = devices.real_time,
                  .shares_flight = stages != all_stages,
                  .steps = &steps_,
                  .constants = delivery_queue_.constants()}),
      stages_({.stored = steps_,
               .at_hand = images_,
               .clock = devices.clock,
               .mission = mission,
               .step_memory = step_memory_,
               .router = router_,
               .writer = telemetry_writer_,
               .camera = &devices.camera,
               .link = router_.present() ? &delivery_queue_ : &devices.link,
               .delivery = &delivery_,
               .health = &executive_,
               .navigation = devices.navigation,
               .map = devices.map,
               .worker = devices.worker,
               .compute = &compute_.compute(),
               .configuration = &configuration_,
               .memory = &memory_,
               .image = devices.image}) {
  components_ = stages_.in_order();
  components_here_ = chosen(std::span(components_), stages);
}

Status FlightSoftware::prepare(const StartFacts& facts) {
  const Status loaded = memory_.load();
  ILP_TRY(configuration_.begin(store_, {.loaded = facts.nonvolatile_memory.ok() ? loaded : facts.nonvolatile_memory,
                                        .utc_s = facts.utc.value_or(0) / ns_per_s,
                                        .commanded = commanded_,
                                        .store = facts.store}));
  time_ = {};
  if (!facts.utc) {
    ILP_TRY(latest_known_time(store_, time_.now));
    // A new store knows nothing of the previous store epoch.
    if (!facts.store.ok()) time_.now = std::max(time_.now, memory_.content().latest_ns);
    return {};
  }
  ILP_TRY(begin_mission_time(store_, memory_, facts.epoch, *facts.utc, mission_, time_));
  configuration_.epoch_is(mission_.mission_epoch_s);
  return {};
}

Status FlightSoftware::write_camera(const CameraRecord& camera) {
  Transaction transaction(store_);
  ILP_TRY(transaction.begin());
  ILP_TRY(put_camera(store_, camera));
  if (!camera.frozen) {
    CameraRecord nominal = camera;
    nominal.id = nominal_camera_id;
    ILP_TRY(put(store_, nominal));
  }
  return transaction.commit();
}

Status FlightSoftware::check_camera(const CameraModel& camera) {
  const bool camera_known = mission_.camera_known && mission_.lens_known && !(mission_.readout_sigma_s > 0);
  CameraRecord wanted = camera_known ? camera_record(camera) : nominal_camera_record(camera);
  wanted.sigma_readout_s = mission_.readout_sigma_s;
  CameraRecord known;
  Status found = get_camera(store_, camera_id, known);
  // The camera and its copy are damaged. A known camera is written again, and a calibrated one is calibrated again, so
  // that the flight can continue.
  if (is_gone(found)) return write_camera(wanted);
  ILP_TRY(found);
  CameraRecord there;
  if (!get(store_, camera_id, there).ok() || !get(store_, camera_copy_id, there).ok()) ILP_TRY(write_camera(known));
  found = get(store_, nominal_camera_id, known);
  if (!found.ok() && !found.is(StatusCode::not_found)) return found;
  const bool same = camera_model(known) == camera_model(wanted) && known.frozen == wanted.frozen;
  return same ? Status{} : StatusCode::camera_changed;
}

Status FlightSoftware::start_once(const CameraModel& camera) {
  telemetry_writer_.configure();
  ILP_TRY(check_camera(camera));
  return executive_.start();
}

Status FlightSoftware::start(const CameraModel& camera) {
  ILP_TRY(validate(camera));
  if (std::fabs(camera.readout_s) > mission_.capture_min_interval_s)
    return out_of_range(Argument::readout, camera.readout_s);
  const Status status = start_once(camera);
  if (status.ok()) return {};
  ILP_TRY(configuration_.step_down(status));
  return start_once(camera);
}

Status FlightSoftware::join() {
  // The primary tells the ground of settings that do not count.
  const Status set = load_settings(store_, mission_);
  if (!set.ok() && !set.is(StatusCode::setting_ignored)) return set;
  return executive_.start();
}

Status FlightSoftware::record_boot(const BoardState& board, std::span<const Status> updates) {
  ILP_TRY(boot_.begin(board));
  StartRecord& record = boot_.record();
  record.unconfirmed = configuration_.unconfirmed();
  record.configuration = configuration_.stage();
  const auto report = [&](const Status& status) {
    if (!status.ok()) executive_.events().report(record.time_ns, "board", status);
  };
  report({StatusCode::started, record.id, static_cast<std::int64_t>(record.reason)});
  report(time_.updates);
  for (const Status& status : updates) report(status);
  return {};
}

bool FlightSoftware::processed() const {
  return stages_.get<Acquisition>().ended() && executive_.idle();
}

std::span<const CheckpointForm* const> checkpoint_forms() {
  return FlightComponents::checkpoint_forms();
}

namespace {

constexpr auto regions = [] {
  constexpr MemoryRegion others[] = {
      {"images at hand", sizeof(ImageCache)},
      {"telemetry writer", sizeof(TelemetryWriter)},
      {"memory of one step", sizeof(FlightComponents::SharedMemory)},
      {"compute jobs", sizeof(FlightCompute)},
      {"delivery_queue", sizeof(DeliveryQueue)},
      {"executive", sizeof(Executive)},
      {"packet router", sizeof(PacketRouter)},
      {"SQLite, or the records where there is no disk", limits::ram_store_bytes},
      {"OpenJPEG arena", limits::openjpeg_arena_bytes},
  };
  constexpr auto components = FlightComponents::memory();
  std::array<MemoryRegion, components.size() + std::size(others)> all{};
  std::copy(std::begin(others), std::end(others), std::copy(components.begin(), components.end(), all.begin()));
  return all;
}();

constexpr std::size_t total_bytes() {
  std::size_t total = 0;
  for (const MemoryRegion& region : regions) total += region.bytes;
  return total;
}
static_assert(total_bytes() + limits::early_heap_bytes + limits::flight_stack_bytes + limits::worker_stack_bytes <=
                  limits::max_static_bytes,
              "the flight does not fit its board");

}  // namespace

std::span<const MemoryRegion> memory_map() {
  return regions;
}

}  // namespace ilp
