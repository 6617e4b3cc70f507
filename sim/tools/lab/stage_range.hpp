// Some stages of the flight, chosen by their names, on a store of the caller's.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cfg/mission.hpp"
#include "fsw/downlink/downlink.hpp"
#include "fsw/executive/executive.hpp"
#include "fsw/imaging/overlap_checker.hpp"
#include "fsw/motion/camera_calibrator.hpp"
#include "fsw/motion/structure_and_motion.hpp"
#include "fsw/places/place_memory.hpp"
#include "fsw/products/compressor.hpp"
#include "fsw/products/richness_scorer.hpp"
#include "fsw/storage/storage_manager.hpp"
#include "hal/camera/camera.hpp"
#include "hal/clock/clock.hpp"
#include "hal/link/link.hpp"
#include "hal/navigation/navigation.hpp"

namespace ilp::lab {

/// What stages work with. `camera`, `link` and `navigation` may be null where no stage needs them.
struct StageWorld {
  Store& store;
  Clock& clock;
  const MissionParameters& mission;
  Camera* camera = nullptr;
  Link* link = nullptr;
  NavigationSource* navigation = nullptr;
};

/// What the stages share within a step, as in a flight.
using RangeMemory = StepMemory<OverlapChecker, CameraCalibrator, StructureAndMotion, RichnessScorer, Compressor,
                               StorageManager, Downlink, PlaceMemory>;

/// A component of the flight in memory that was zero, as the static memory of a process is.
class StageObject {
 public:
  /// Stages of the imaging chain, from the capture clock to the downlink, the scrubber and the navigator;
  /// std::invalid_argument for another one.
  StageObject(ComponentId stage, const StageWorld& world, RangeMemory& memory);

  [[nodiscard]] Component& component() const { return *component_; }

 private:
  template <typename C, typename... Arguments>
  void make(Arguments&&... arguments);

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
  std::unique_ptr<RangeMemory> step_memory_;
  std::vector<Stage> stages_;
  std::vector<StageObject> objects_;
  std::vector<Component*> components_;
  std::unique_ptr<Executive> executive_;
};

}  // namespace ilp::lab
