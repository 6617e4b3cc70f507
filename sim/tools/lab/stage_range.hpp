// Runs chosen stages of the flight on the caller's store.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bsp/flight/flight_components.hpp"
#include "bsp/flight/flight_compute.hpp"
#include "fsw/executive/executive.hpp"
#include "hal/navigation/navigation.hpp"

namespace ilp::lab {

/// Environment of the stages. `camera`, `link` and `navigation` may be null if no stage needs them.
struct StageWorld {
  Store& store;
  Clock& clock;
  MissionParameters& mission;
  Camera* camera = nullptr;
  Link* link = nullptr;
  NavigationSource* navigation = nullptr;
};

/// Objects that the stages share, as in a flight without a packet link.
struct RangeMemory {
  RangeMemory(Clock& clock, const MissionParameters& mission)
      : router(nullptr, nullptr, clock, mission), writer(router, clock, mission) {}

  FlightCompute compute;
  FlightComponents::SharedMemory step;
  PacketRouter router;
  TelemetryWriter writer;
};

/// A component of the flight, constructed in zeroed memory like the static memory of a process.
class StageObject {
 public:
  /// Throws std::invalid_argument for a stage that takes images without a camera, or sends files without a link.
  StageObject(ComponentId stage, const StageWorld& world, RangeMemory& memory);

  [[nodiscard]] Component& component() const { return *component_; }

 private:
  std::shared_ptr<void> memory_;
  Component* component_ = nullptr;
};

/// An executive with the chosen stages in the order of the schedule. The records that the other stages would have
/// written must be in the store already, unless the chosen stages do not need them.
class StageRange {
 public:
  /// Throws std::invalid_argument for an unknown or repeated name.
  StageRange(const std::vector<std::string>& names, const StageWorld& world);

  [[nodiscard]] Executive& executive() { return *executive_; }
  /// Whether the camera has no more images, as the stage `acquisition` knows; false without this stage.
  [[nodiscard]] bool camera_ended() const;

 private:
  std::unique_ptr<RangeMemory> memory_;
  std::vector<Stage> stages_;
  std::vector<StageObject> objects_;
  std::vector<Component*> components_;
  std::unique_ptr<Executive> executive_;
};

}  // namespace ilp::lab
