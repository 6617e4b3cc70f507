// Sets of stages: which stages of the schedule a process runs if several processes share the flight
// (docs/several-machines.md).
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "cfg/schedule.hpp"
#include "fsw/base/text.hpp"
#include "hal/store/store_sharing.hpp"

namespace ilp {

[[nodiscard]] constexpr StageMask stage_bit(ComponentId component) {
  return component == ComponentId::none ? 0 : StageMask{1} << (static_cast<unsigned>(component) - 1);
}
[[nodiscard]] constexpr bool has_stage(StageMask stages, ComponentId component) {
  return (stages & stage_bit(component)) != 0;
}

static_assert(component_numbers <= 32);
inline constexpr StageMask all_stages = [] {
  StageMask all = 0;
  for (const Stage& stage : schedule) all |= stage_bit(stage.component);
  return all;
}();

/// The stages that run in one process, the primary, because they need the camera, a link or its memory.
inline constexpr StageMask primary_stages = [] {
  StageMask head = 0;
  for (const Stage& stage : schedule) {
    if (stage.runs_on == RunsOn::primary) head |= stage_bit(stage.component);
  }
  return head;
}();
static_assert(has_stage(primary_stages, ComponentId::telecommander), "the head's number is 1");

[[nodiscard]] constexpr bool is_primary(StageMask stages) {
  return (stages & primary_stages) == primary_stages;
}
/// Id of the record of a process with these stages (NodeRecord): the lowest component number. 0: there is no stage.
[[nodiscard]] constexpr std::int64_t node_number(StageMask stages) {
  return stages == 0 ? 0 : std::countr_zero(stages) + 1;
}

using StageNames = FixedText<512>;
/// Names of the stages, separated by commas; `head` stands for all stages of the primary.
[[nodiscard]] StageNames stage_names(StageMask stages);
/// Parses such a list. Returns false for an unknown name, and for the name of a single stage of the primary; `culprit`
/// becomes that name.
[[nodiscard]] bool parse_stages(const char* text, StageMask& stages, StageNames& culprit);

}  // namespace ilp
