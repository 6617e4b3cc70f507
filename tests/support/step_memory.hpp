// Gives a stage under test the memory that it uses within a step.
#pragma once

#include "fsw/shared/step_memory.hpp"

namespace ilp::test {

/// Returns the memory of all objects of a stage. They share it, because they step one after another.
template <typename Stage>
StepMemory<Stage>& step_memory() {
  static StepMemory<Stage> memory;
  return memory;
}

}  // namespace ilp::test
