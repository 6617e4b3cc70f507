// A component takes its name and its part of the store from its row of the schedule.
#pragma once

#include "fsw/executive/component.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// The tables of a component's row. Every component may read and write its checkpoint too.
[[nodiscard]] constexpr StoreAccess stage_access(ComponentId component) {
  constexpr RecordMask checkpoint = mask_of(RecordType::checkpoint);
  const Stage& stage = stage_of(component);
  return {stage.reads, stage.writes | checkpoint, stage.changes, stage.erases | checkpoint};
}
template <ComponentId id>
using StageStore = StoreView<stage_access(id)>;

/// A component of the flight.
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
