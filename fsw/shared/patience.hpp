// The handling of an input that a component cannot process: it is tried again, then gets a verdict.
#pragma once

#include <cstdint>

#include "fsw/executive/component.hpp"

namespace ilp {

/// A component works on one input at a time, in the order of ids from 1. When a step fails, its memory may be ahead of
/// the store: the component is restored from its checkpoint and starts the input again after the executive's pause. A
/// store that answers nothing cannot serve the restore either, so only attempts in which other records could be read
/// are counted. The counts are of one boot only.
class Patience {
 public:
  /// A step has met `fault` in reading or processing input `id`. If the fault may pass, is a bug of our own, or says
  /// that memory was damaged, the input is tried as often as allowed. After that, and at once for any other fault,
  /// abandoned(id) holds: a verdict is due.
  [[nodiscard]] StepResult failed(std::int64_t id, const Status& fault) {
    const bool of_writing = (writing_ && is_transient(fault)) || fault.is(StatusCode::store_locked);
    writing_ = false;
    if (of_writing) return not_written(fault);
    const bool of_input = !fault.is(StatusCode::assertion_failed) && !fault.is(StatusCode::memory_damaged);
    if (of_input && !is_transient(fault)) {
      abandoned_id_ = id;
      return {fault, true, Then::restore};
    }
    if (id != tried_id_) attempts_ = 0;
    tried_id_ = id;
    if (++attempts_ < most_read_attempts) return {fault, true, Then::restore};
    abandoned_id_ = id;
    return {{StatusCode::input_given_up, id, static_cast<std::int64_t>(fault.code)}, true, Then::restore};
  }
  /// The result could not be written. That is no statement about the input, so there is no limit of attempts.
  [[nodiscard]] static StepResult not_written(const Status& fault) { return {fault, true, Then::restore}; }

  /// A fault that passes between these two calls is one of writing.
  void begin_writing() { writing_ = true; }
  void end_writing() { writing_ = false; }

  [[nodiscard]] bool abandoned(std::int64_t id) const { return id != 0 && id == abandoned_id_; }

 private:
  std::int64_t tried_id_ = 0;
  std::int64_t abandoned_id_ = 0;
  std::uint32_t attempts_ = 0;  ///< failed attempts on tried_id_
  bool writing_ = false;
};

}  // namespace ilp
