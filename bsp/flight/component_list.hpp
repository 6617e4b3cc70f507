// Follows from the rows of the schedule for an assembled flight: the order of its components, the checkpoints that a
// store must have, and the memory of each component.
#pragma once

#include <array>
#include <cstddef>

#include "fsw/executive/component.hpp"
#include "fsw/shared/checkpoint.hpp"

namespace ilp {

struct MemoryRegion {
  const char* name;
  std::size_t bytes;
};

/// One type for each row of the schedule, in any order.
template <typename... Components>
struct ComponentList {
  static constexpr bool has_each_row_once() {
    std::array<int, stage_count> components{};
    (++components[place_of(Components::component_id)], ...);
    for (const int count : components) {
      if (count != 1) return false;
    }
    return true;
  }
  static_assert(has_each_row_once(), "a row of the schedule has no component, or has two");

  /// The components in the order in which the executive calls them.
  static std::array<Component*, stage_count> in_order(Components&... components) {
    std::array<Component*, stage_count> table{};
    ((table[place_of(Components::component_id)] = &components), ...);
    return table;
  }

  static constexpr std::array<MemoryRegion, stage_count> memory() {
    std::array<MemoryRegion, stage_count> table{};
    ((table[place_of(Components::component_id)] = {stage_of(Components::component_id).name, sizeof(Components)}), ...);
    return table;
  }

  /// The forms of the checkpoints that a store must have in this form or not at all: those of components whose row
  /// refuses a state of another build.
  static std::span<const CheckpointForm* const> checkpoint_forms() {
    static constexpr auto forms = [] {
      std::array<const CheckpointForm*, 2 * stage_count> table{};
      std::size_t count = 0;
      (add_forms<Components>(table, count), ...);
      return std::pair(table, count);
    }();
    return std::span(forms.first).first(forms.second);
  }

 private:
  template <typename C>
  static constexpr void add_forms(std::array<const CheckpointForm*, 2 * stage_count>& table, std::size_t& count) {
    constexpr const StateLayout& state = stage_of(C::component_id).state;
    if constexpr (state.old == OldState::dropped) {
      return;
    } else {
      table[count++] = &C::checkpoint;
      if constexpr (state.second != 0) table[count++] = &C::second_checkpoint;
    }
  }
};

}  // namespace ilp
