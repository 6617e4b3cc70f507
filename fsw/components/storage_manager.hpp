// Keeps the store within its budget and never loses what it should keep (paper 2; decisions.md, 12).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/components/checkpoint.hpp"
#include "fsw/executive/component.hpp"

namespace ilp {

/// In this order: raw frames that no product needs any more are released; depth maps are released once their records
/// are with the link; acknowledged products are deleted; and when the budget is exceeded all the same, the unsent
/// product of the least priority is dropped. Nothing else is ever deleted, and capture never stops.
class StorageManager final : public Component {
 public:
  StorageManager(Store& store, const MissionParameters& mission);

  [[nodiscard]] const char* name() const override { return "storage_manager"; }
  Status restore() override;
  StepResult step(TimeNs deadline) override;

 private:
  struct State {
    std::int64_t released_frame_id = 0;  ///< every frame up to it has been released
    std::int64_t counted_frame_id = 0;
    std::int64_t keyframe_id = 0;  ///< the keyframes up to it have released frames
    std::int64_t released_depth_id = 0;
    std::int64_t counted_depth_id = 0;
    std::int64_t counted_product_id = 0;
    std::int64_t checked_downlink_id = 0;  ///< every downlink up to it is acknowledged and accounted for
    StorageRecord account;
  };

  Status count_new(State& after, bool& changed);
  Status release_frame(State& after, bool& changed);
  Status release_depth(State& after, bool& changed);
  Status delete_acknowledged(State& after, bool& changed);
  Status drop_least(State& after, bool& changed, Status& event);
  Status save(const State& after);

  Store& store_;
  const MissionParameters& mission_;
  Cursor cursor_;
  State state_;
};

}  // namespace ilp
