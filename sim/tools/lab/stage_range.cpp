#include "sim/tools/lab/stage_range.hpp"

#include <algorithm>
#include <cstring>
#include <new>
#include <stdexcept>
#include <utility>

#include "fsw/imaging/acquisition.hpp"
#include "fsw/imaging/capture_clock.hpp"
#include "fsw/navigation/navigator.hpp"
#include "fsw/storage/scrubber.hpp"
#include "fsw/terrain/dense_matcher.hpp"

namespace ilp::lab {

template <typename C, typename... Arguments>
void StageObject::make(Arguments&&... arguments) {
  void* const place = ::operator new (sizeof(C), std::align_val_t{alignof(C)});
  std::memset(place, 0, sizeof(C));
  C* const made = new (place) C(std::forward<Arguments>(arguments)...);
  component_ = made;
  memory_ = std::shared_ptr<void>(place, [made](void* memory) {
    made->~C();
    ::operator delete (memory, std::align_val_t{alignof(C)});
  });
}

StageObject::StageObject(ComponentId stage, const StageWorld& world, RangeMemory& memory) {
  const bool takes_images = stage == ComponentId::capture_clock || stage == ComponentId::acquisition;
  if (takes_images && world.camera == nullptr) throw std::invalid_argument("a stage that takes images has no camera");
  if (stage == ComponentId::downlink && world.link == nullptr) throw std::invalid_argument("the downlink has no link");
  switch (stage) {
    case ComponentId::capture_clock:
      make<CaptureClock>(world.store, *world.camera, world.clock, world.mission);
      break;
    case ComponentId::acquisition:
      make<Acquisition>(world.store, *world.camera, world.clock, world.mission);
      break;
    case ComponentId::overlap_checker:
      make<OverlapChecker>(world.store, world.mission, memory);
      break;
    case ComponentId::camera_calibrator:
      make<CameraCalibrator>(world.store, world.mission, memory);
      break;
    case ComponentId::structure_and_motion:
      make<StructureAndMotion>(world.store, world.mission, memory);
      break;
    case ComponentId::dense_matcher:
      make<DenseMatcher>(world.store, world.mission);
      break;
    case ComponentId::richness_scorer:
      make<RichnessScorer>(world.store, world.mission, memory);
      break;
    case ComponentId::compressor:
      make<Compressor>(world.store, world.mission, memory);
      break;
    case ComponentId::storage_manager:
      make<StorageManager>(world.store, world.mission, memory);
      break;
    case ComponentId::downlink:
      make<Downlink>(world.store, *world.link, world.clock, world.mission, memory);
      break;
    case ComponentId::scrubber:
      make<Scrubber>(world.store, world.clock, world.mission);
      break;
    case ComponentId::navigator:
      make<Navigator>(world.store, world.clock, world.mission);
      if (world.navigation != nullptr) static_cast<Navigator*>(component_)->navigate_by(*world.navigation);
      break;
    case ComponentId::place_memory:
      make<PlaceMemory>(world.store, world.mission, memory);
      break;
    default:
      throw std::invalid_argument(std::string(stage_of(stage).name) + " does not work alone");
  }
}

StageRange::StageRange(const std::vector<std::string>& names, const StageWorld& world)
    : step_memory_(std::make_unique<RangeMemory>()) {
  for (const Stage& stage : schedule) {
    if (std::find(names.begin(), names.end(), stage.name) == names.end()) continue;
    stages_.push_back(stage);
    objects_.emplace_back(stage.component, world, *step_memory_);
    components_.push_back(&objects_.back().component());
  }
  if (stages_.size() != names.size()) throw std::invalid_argument("a name is of no stage, or stands there twice");
  executive_ = std::make_unique<Executive>(stages_, components_, world.store, world.clock);
}

bool StageRange::camera_ended() const {
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    if (stages_[i].component == ComponentId::acquisition) return static_cast<Acquisition*>(components_[i])->ended();
  }
  return false;
}

}  // namespace ilp::lab
