// What becomes of an input that cannot be worked on: first it is tried again, then there is a verdict on it.
#pragma once

#include <cstdint>

#include "fsw/executive/component.hpp"

namespace ilp {

/// A component works on one input at a time, in the order of ids from 1. When a step fails, its memory may be ahead of
/// the store: it goes back to its checkpoint, and the input is started over after the executive's pause. A store that
/// answers nothing answers the restore neither, so that only tries are counted in which other records could be read.
/// Of one life only.
class Patience {
 public:
  /// A step on input `id` has met `fault`, reading it or working on it. Tried again as often as is allowed where the
  /// fault may pass, or is our own bug; then, and at once for any other fault, given_up(id) holds: a verdict is due.
  [[nodiscard]] StepResult failed(std::int64_t id, const Status& fault) {
    const bool bug = fault.is(StatusCode::assertion_failed);
    if (!bug && !is_transient(fault)) {
      given_up_id_ = id;
      return {fault, true, Then::restore};
    }
    if (id != tried_id_) attempts_ = 0;
    tried_id_ = id;
    if (++attempts_ < most_read_attempts) return {fault, true, Then::restore};
    given_up_id_ = id;
    return {{StatusCode::input_given_up, id, static_cast<std::int64_t>(fault.code)}, true, Then::restore};
  }
  /// What was found could not be written: that is no word on the input, and is tried for ever.
  [[nodiscard]] static StepResult not_written(const Status& fault) { return {fault, true, Then::restore}; }

  [[nodiscard]] bool given_up(std::int64_t id) const { return id != 0 && id == given_up_id_; }

 private:
  std::int64_t tried_id_ = 0;
  std::int64_t given_up_id_ = 0;
  std::uint32_t attempts_ = 0;  ///< of tried_id_, in vain
};

}  // namespace ilp
