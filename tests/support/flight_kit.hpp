// A flight for tests, in memory that begins as zeros, as the static memory of a process does.
#pragma once

#include <cstdlib>
#include <memory>
#include <new>

#include "bsp/flight/flight_software.hpp"
#include "hal/nonvolatile/ram_nonvolatile.hpp"

namespace ilp::test {

/// What the test connects to the flight; see FlightDevices. The nonvolatile memory is empty and belongs to the kit.
struct KitDevices {
  Store& store;
  Camera& camera;
  Link& link;
  Clock& clock;
  PacketLink* packets = nullptr;
  PacketLink* files = nullptr;
  bool real_time = false;
};

class FlightKit {
 public:
  FlightKit(const KitDevices& devices, MissionParameters& mission)
      : memory_(std::calloc(1, sizeof(FlightSoftware)), &std::free),
        flight_(new (memory_.get()) FlightSoftware({.store = devices.store,
                                                    .camera = devices.camera,
                                                    .link = devices.link,
                                                    .clock = devices.clock,
                                                    .nonvolatile_memory = nonvolatile_memory_,
                                                    .packets = devices.packets,
                                                    .files = devices.files,
                                                    .real_time = devices.real_time},
                                                   mission)) {}

  /// Starts the flight in virtual time.
  Status start(const CameraModel& camera) {
    ILP_TRY(flight_->prepare({}));
    return flight_->start(camera);
  }

  FlightSoftware& operator*() { return *flight_; }
  FlightSoftware* operator->() { return flight_; }

 private:
  RamNonvolatile nonvolatile_memory_;
  std::unique_ptr<void, decltype(&std::free)> memory_;
  FlightSoftware* flight_;
};

}  // namespace ilp::test
