// Some stages of the flight, chosen by their names, on a store of the caller's.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bsp/flight/flight_components.hpp"
#include "bsp/flight/flight_compute.hpp"
#include "fsw/executive/executive.hpp"
#include "hal/navigation/navigation.hpp"

namespace ilp::lab {

/// What stages work with. `camera`, `link` and `navigation` may be null where no stage needs them.
struct StageWorld {
  Store& store;
  Clock& clock;
  MissionParameters& mission;
  Camera* camera = nullptr;
  Link* link = nullptr;
  NavigationSource* navigation = nullptr;
};

/// What the stages share, as in a flight without a link for packets.
struct RangeMemory {
  RangeMemory(Clock& clock, const MissionParameters& mission)
      : router(nullptr, nullptr, clock, mission), writer(router, clock, mission) {}

  FlightCompute compute;
  FlightComponents::SharedMemory step;
  PacketRouter router;
  TelemetryWriter writer;
};

/// A component of the flight in memory that was zero, as the static memory of a process is.
class StageObject {
 public:
  /// std::invalid_argument for a stage that takes images, or sends files, in a world without a camera or link.
  StageObject(ComponentId stage, const StageWorld& world, RangeMemory& memory);

  [[nodiscard]] Component& component() const { return *component_; }

 private:
  std::shared_ptr<void> memory_;
  Component* component_ = nullptr;
};

/// Stages under an executive of their own, in the order of the schedule. Stages that are left out do nothing: what they
/// would have written is in the store already, or is not needed.
class StageRange {
 public:
  /// std::invalid_argument for an unknown name.
  StageRange(const std::vector<std::string>& names, const StageWorld& world);

  [[nodiscard]] Executive& executive() { return *executive_; }
  /// The camera has no more images. The range has an acquisition.
  [[nodiscard]] bool camera_ended() const;

 private:
  std::unique_ptr<RangeMemory> memory_;
  std::vector<Stage> stages_;
  std::vector<StageObject> objects_;
  std::vector<Component*> components_;
  std::unique_ptr<Executive> executive_;
};

}  // namespace ilp::lab
