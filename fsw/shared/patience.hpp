// Counts the attempts on an input that a component cannot read or process, until the input gets a verdict.
#pragma once

#include <cstdint>

#include "fsw/executive/component.hpp"

namespace ilp {

/// A component works on one input at a time, in ascending order of ids from 1. When a step fails, the component's
/// memory may be ahead of the store: the component is restored from its checkpoint and starts the input again after the
/// executive's pause. If the store does not answer at all the restore fails too; such attempts are not counted. The
/// counts do not survive a restart.
class Patience {
 public:
  /// Notes that a step has met `fault` in reading or processing input `id`, and returns the result of the step. After a
  /// transient fault, a failed assertion or damaged memory the input is tried most_read_attempts times. After that, or
  /// at once for any other fault, abandoned(id) is true, and the component must write a verdict.
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
  /// The result of a step whose records could not be written. The fault says nothing about the input, so that attempts
  /// are not limited.
  [[nodiscard]] static StepResult not_written(const Status& fault) { return {fault, true, Then::restore}; }

  /// A transient fault between these two calls counts as a fault of writing.
  void begin_writing() { writing_ = true; }
  void end_writing() { writing_ = false; }

  /// The component must not try this input again.
  [[nodiscard]] bool abandoned(std::int64_t id) const { return id != 0 && id == abandoned_id_; }

 private:
  std::int64_t tried_id_ = 0;
  std::int64_t abandoned_id_ = 0;
  std::uint32_t attempts_ = 0;  ///< failed attempts on tried_id_
  bool writing_ = false;
};

}  // namespace ilp
