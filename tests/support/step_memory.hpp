// The memory that a stage under test uses within a step.
#pragma once

#include "fsw/shared/step_memory.hpp"

namespace ilp::test {

/// One region for all objects of a kind, because they step one after another.
template <typename Stage>
StepMemory<Stage>& step_memory() {
  static StepMemory<Stage> memory;
  return memory;
}

}  // namespace ilp::test
