#include "sim/tools/lab/stage_range.hpp"

#include <algorithm>
#include <cstring>
#include <new>
#include <stdexcept>
#include <type_traits>

namespace ilp::lab {

StageObject::StageObject(ComponentId stage, const StageWorld& world, RangeMemory& memory) {
  const bool takes_images = stage == ComponentId::capture_clock || stage == ComponentId::acquisition;
  if (takes_images && world.camera == nullptr) throw std::invalid_argument("a stage that takes images has no camera");
  if (stage == ComponentId::downlink && world.link == nullptr) throw std::invalid_argument("the downlink has no link");
  const FlightComponents::Parts parts{.stored = world.store,
                                      .at_hand = world.store,
                                      .clock = world.clock,
                                      .mission = world.mission,
                                      .step_memory = memory.step,
                                      .router = memory.router,
                                      .writer = memory.writer,
                                      .camera = world.camera,
                                      .link = world.link,
                                      .navigation = world.navigation,
                                      .compute = &memory.compute.compute()};
  FlightComponents::for_each([&]<typename C>() {
    if (C::component_id != stage) return;
    void* const place = ::operator new (sizeof(C), std::align_val_t{alignof(C)});
    std::memset(place, 0, sizeof(C));
    C* const made = new (place) C(FlightComponents::made_of<C>(parts));
    component_ = made;
    memory_ = std::shared_ptr<void>(place, [made](void* zeroed) {
      made->~C();
      ::operator delete (zeroed, std::align_val_t{alignof(C)});
    });
  });
}

StageRange::StageRange(const std::vector<std::string>& names, const StageWorld& world)
    : memory_(std::make_unique<RangeMemory>(world.clock, world.mission)) {
  for (const Stage& stage : schedule) {
    if (std::find(names.begin(), names.end(), stage.name) == names.end()) continue;
    stages_.push_back(stage);
    objects_.emplace_back(stage.component, world, *memory_);
    components_.push_back(&objects_.back().component());
  }
  if (stages_.size() != names.size()) throw std::invalid_argument("the name of a stage is unknown, or given twice");
  executive_ = std::make_unique<Executive>(stages_, components_, world.store, world.clock);
}

bool StageRange::camera_ended() const {
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    if (stages_[i].component == ComponentId::acquisition) return static_cast<Acquisition*>(components_[i])->ended();
  }
  return false;
}

}  // namespace ilp::lab
