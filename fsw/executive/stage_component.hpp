// The base class of the flight's components, with name and access to the store from the schedule.
#pragma once

#include "fsw/executive/component.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// The access to tables that a component's row gives. In addition every component may write and erase its checkpoint.
[[nodiscard]] constexpr StoreAccess stage_access(ComponentId component) {
  constexpr RecordMask checkpoint = mask_of(RecordType::checkpoint);
  const Stage& stage = stage_of(component);
  return {stage.reads, stage.writes | checkpoint, stage.changes, stage.erases | checkpoint};
}
template <ComponentId id>
using StageStore = StoreView<stage_access(id)>;

/// Base class of the component with this id.
template <ComponentId id>
class StageComponent : public Component {
 public:
  static constexpr ComponentId component_id = id;
  using Tables = StageStore<id>;

  [[nodiscard]] const char* name() const final { return stage_of(id).name; }

 protected:
  ~StageComponent() = default;
};

}  // namespace ilp
