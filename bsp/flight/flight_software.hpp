// All components of the package, connected to one store, camera, link and clock. The same object flies on every board,
// in a process with some of the stages, in the simulator and in tests. It is static, and its size is the memory of the
// flight.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "bsp/flight/boot.hpp"
#include "bsp/flight/flight_components.hpp"
#include "bsp/flight/flight_compute.hpp"
#include "bsp/flight/mission_epoch.hpp"
#include "bsp/flight/stage_set.hpp"
#include "cfg/mission.hpp"
#include "fsw/commanding/configuration.hpp"
#include "fsw/downlink/delivery_queue.hpp"
#include "fsw/executive/executive.hpp"
#include "fsw/packets/packet_router.hpp"
#include "fsw/packets/telemetry_writer.hpp"
#include "fsw/shared/image_cache.hpp"

namespace ilp {

/// What a start finds outside of its store.
struct StartFacts {
  Status nonvolatile_memory = {};        ///< of opening it
  Status store = {};                     ///< why the store replaces another one; ok: it does not
  std::optional<std::int64_t> utc = {};  ///< the calendar, nanoseconds since 1958; none in virtual time
  EpochChoice epoch = EpochChoice::first_start;
};

/// What a flight is connected to. All of it outlives the flight.
struct FlightDevices {
  Store& store;
  Camera& camera;
  Link& link;  ///< carries whole files, where there are no packets
  Clock& clock;
  Nonvolatile& nonvolatile_memory;         ///< what outlives the store (docs/getting-back-in.md)
  PacketLink* packets = nullptr;           ///< carries packets, and files too if they travel by CFDP
  PacketLink* files = nullptr;             ///< carries the PDUs of CFDP alone
  NavigationSource* navigation = nullptr;  ///< the vehicle's measurements, if there are any
  MapFolder* map = nullptr;                ///< the files of an orbiter's map, if there is one
  /// Does what cannot be cut into steps (docs/worker.md); without it that is done in a step. It is for this flight
  /// alone.
  Worker* worker = nullptr;
  ImageRegions image = {};  ///< code and constants of the program, which never change; may be unknown
  bool real_time = false;   ///< time passes while components work (ExecutiveSetup)
};

class FlightSoftware {
 public:
  /// `mission` has the values of the mission file; telecommands change it. Only the components of `stages` run; if
  /// these are not all, other processes run the rest over the same store. It uses no device before prepare().
  FlightSoftware(const FlightDevices& devices, MissionParameters& mission, StageMask stages = all_stages);

  // A start, in this order: prepare(), the clock is set to time().now, start(), record_boot(). A process that joins
  // calls join() only.

  /// Takes up the settings (Configuration::begin) and finds mission time: begin_mission_time, or in virtual time the
  /// latest that is known.
  Status prepare(const StartFacts& facts);
  [[nodiscard]] const MissionTimeBegin& time() const { return time_; }
  /// Writes the camera's intrinsics into a fresh store (nominal ones if the mission says that the camera is not known),
  /// or compares them with those of an existing store: `camera_changed` when the flight began with another camera, or
  /// with one that was known and now is not. Then restores every component. If that fails with tentative parameters, it
  /// continues with the last good ones.
  Status start(const CameraModel& camera);
  /// All three for a process that is not the primary: takes up the stored settings, and restores its components. The
  /// primary has written the camera and begun the boot (find_flight).
  Status join();
  /// Begins the record of this boot, and reports the start, its mission time and `updates` of the store that are not
  /// ok.
  Status record_boot(const BoardState& board, std::span<const Status> updates);
  Executive& executive() { return executive_; }
  Configuration& configuration() { return configuration_; }
  Boot& boot() { return boot_; }
  PacketRouter& router() { return router_; }

  /// What does the jobs of components that have some.
  FlightCompute& compute() { return compute_; }
  /// A device does jobs from now on, if it does them rightly. Call it before start(): no stage uses the memory of the
  /// step yet.
  Status accept(ComputeDevice& device) {
    return compute_.accept(device, StepScratch<WideJob>(step_memory_).as<WideJob>());
  }

  /// Memory was damaged, or the worker is stuck, so that only a new process goes on.
  [[nodiscard]] bool damaged() const {
    return stages_.get<Scrubber>().image_damaged() || executive_.restart_wanted() ||
           stages_.get<Compressor>().worker_stuck();
  }
  /// ... or parameters need a new start.
  [[nodiscard]] bool restart_wanted() const { return damaged() || configuration_.restart_wanted(); }

  /// The source of images has ended and everything has been processed.
  [[nodiscard]] bool processed() const;
  /// Files that the ground holds, of those that went by CFDP.
  [[nodiscard]] std::uint64_t files_delivered() const { return delivery_.counts.delivered; }
  /// ... and everything has been sent and confirmed.
  [[nodiscard]] bool drained() const { return processed() && stages_.get<Downlink>().drained(); }

 private:
  /// Writes the camera and its copy. A camera that is not frozen is also the nominal one.
  Status write_camera(const CameraRecord& camera);
  Status check_camera(const CameraModel& camera);
  Status start_once(const CameraModel& camera);

  Store& store_;
  StepStore steps_;
  ImageCache images_;  ///< in front of it, for all components that use frames
  MissionParameters& mission_;
  FlightMemory memory_;
  Configuration configuration_;
  MissionTimeBegin time_;
  Boot boot_;
  const bool commanded_;  ///< the ground has a link for telecommands
  PacketRouter router_;
  TelemetryWriter telemetry_writer_;
  FlightComponents::SharedMemory step_memory_;
  FlightCompute compute_;
  DeliveryFigures delivery_;
  DeliveryQueue delivery_queue_;
  std::array<Component*, stage_count> components_{};
  std::array<Stage, stage_count> rows_here_;  ///< of a part of the stages, as are the components; the rest is unused
  std::array<Component*, stage_count> components_here_{};
  Executive executive_;
  FlightComponents::Set stages_;
};

/// The forms of all checkpoints that the flight needs. A store with other forms does not fit this build
/// (check_checkpoints).
std::span<const CheckpointForm* const> checkpoint_forms();

/// Every static region of the flight: the components, then the arenas of SQLite and OpenJPEG.
[[nodiscard]] std::span<const MemoryRegion> memory_map();

}  // namespace ilp
