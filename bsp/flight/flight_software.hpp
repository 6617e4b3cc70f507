// The flight software: all components, connected to one store, camera, link and clock. The same class runs on every
// board, in a process with some of the stages, in the simulator and in tests. The object is static, and its size is the
// memory of the flight.
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

/// What is known at a start besides the content of the store.
struct StartFacts {
  Status nonvolatile_memory = {};        ///< result of opening the nonvolatile memory
  Status store = {};                     ///< why the store replaces another one; ok: it does not
  std::optional<std::int64_t> utc = {};  ///< calendar time, ns since 1958; none in virtual time
  EpochChoice epoch = EpochChoice::first_start;
};

/// What a flight is connected to. All referenced objects outlive the flight.
struct FlightDevices {
  Store& store;
  Camera& camera;
  Link& link;  ///< carries complete files if there is no packet link
  Clock& clock;
  Nonvolatile& nonvolatile_memory;         ///< keeps data that must outlive the store (docs/getting-back-in.md)
  PacketLink* packets = nullptr;           ///< carries packets, and files too if they travel by CFDP
  PacketLink* files = nullptr;             ///< carries only the PDUs of CFDP
  NavigationSource* navigation = nullptr;  ///< the vehicle's measurements; null: none
  MapFolder* map = nullptr;                ///< the files of an orbiter's map; null: none
  /// Runs jobs that cannot be cut into steps (docs/worker.md); null: they run in a step. Two flights cannot share a
  /// worker.
  Worker* worker = nullptr;
  ImageRegions image = {};  ///< code and constants of the program, which never change; empty: not known
  bool real_time = false;   ///< time passes while components work (ExecutiveSetup)
};

class FlightSoftware {
 public:
  /// `mission` has the values of the mission file; telecommands change it. Only the components of `stages` run. If
  /// these are not all stages, other processes run the rest with the same store. No device is used before prepare().
  FlightSoftware(const FlightDevices& devices, MissionParameters& mission, StageMask stages = all_stages);

  // A start takes these steps: prepare(), setting the clock to time().now, start(), record_boot(). A process that joins
  // a flight calls join() instead.

  /// Loads the settings (Configuration::begin) and finds mission time. In real time this is that of
  /// begin_mission_time(), in virtual time the latest time in the store.
  Status prepare(const StartFacts& facts);
  [[nodiscard]] const MissionTimeBegin& time() const { return time_; }
  /// Writes the camera's intrinsics into a new store, or compares them with those of an existing store. They are
  /// nominal if the mission states that the camera is not known. Then restores every component. If a component fails
  /// while parameters are tentative, it starts again with the last good parameters. Returns `camera_changed` if the
  /// flight began with other intrinsics, or with a known camera that is not known now.
  Status start(const CameraModel& camera);
  /// For a process that is not the primary: loads the stored settings and restores its components. The primary has
  /// written the camera and begun the boot (find_flight).
  Status join();
  /// Begins the record of this boot, and reports the start, the result of finding mission time and those of `updates`
  /// that are not ok.
  Status record_boot(const BoardState& board, std::span<const Status> updates);
  Executive& executive() { return executive_; }
  Configuration& configuration() { return configuration_; }
  Boot& boot() { return boot_; }
  PacketRouter& router() { return router_; }

  /// Computes the components' jobs.
  FlightCompute& compute() { return compute_; }
  /// Uses a device for jobs from now on if its results are correct (GuardedCompute::accept). Call it before start(),
  /// because it uses the stages' shared memory as scratch.
  Status accept(ComputeDevice& device) {
    return compute_.accept(device, StepScratch<WideJob>(step_memory_).as<WideJob>());
  }

  /// Whether memory was damaged or the worker is stuck. Only a new process can then continue the flight.
  [[nodiscard]] bool damaged() const {
    return stages_.get<Scrubber>().image_damaged() || executive_.restart_wanted() ||
           stages_.get<Compressor>().worker_stuck();
  }
  /// Whether damaged() is true or new parameters need a restart of the software.
  [[nodiscard]] bool restart_wanted() const { return damaged() || configuration_.restart_wanted(); }

  /// Whether the source of images has ended and all images have been processed.
  [[nodiscard]] bool processed() const;
  /// Number of files sent by CFDP that the ground has confirmed.
  [[nodiscard]] std::uint64_t files_delivered() const { return delivery_.counts.delivered; }
  /// Whether processed() is true and all products have been sent and confirmed.
  [[nodiscard]] bool drained() const { return processed() && stages_.get<Downlink>().drained(); }

 private:
  /// Writes the camera and its copy. A camera that is not frozen becomes the nominal camera too.
  Status write_camera(const CameraRecord& camera);
  /// Writes the camera, or compares it with the stored one (start()).
  Status check_camera(const CameraModel& camera);
  Status start_once(const CameraModel& camera);

  Store& store_;
  StepStore steps_;
  ImageCache images_;  ///< cache in front of `steps_`, for all components that use frames
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
  /// Rows and components of the stages that run in this process. The rest of both arrays is unused.
  std::array<Stage, stage_count> rows_here_;
  std::array<Component*, stage_count> components_here_{};
  Executive executive_;
  FlightComponents::Set stages_;
};

/// The forms of all checkpoints that the flight needs. A store with other forms does not fit this build
/// (check_checkpoints).
std::span<const CheckpointForm* const> checkpoint_forms();

/// Name and size of every static region of the flight: first the components, then the rest.
[[nodiscard]] std::span<const MemoryRegion> memory_map();

}  // namespace ilp
