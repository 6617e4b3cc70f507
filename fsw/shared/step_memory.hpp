// Memory that a stage needs for one piece of work and carries to no other. All stages share one region of it, because
// the executive lets one of them work in it at a time. Work that is too long for a step takes several: all but the last
// one return Then::keep (fsw/executive/component.hpp).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <new>
#include <type_traits>

#include "cfg/schedule.hpp"

namespace ilp {

inline constexpr std::size_t step_memory_alignment = 64;

/// What a stage needs of this memory, its member type `Scratch`. Its row says that it uses the memory; a class without
/// a row is a part of a stage.
template <typename User>
[[nodiscard]] constexpr std::size_t scratch_bytes() {
  constexpr bool used = requires {
    typename User::Scratch;
  };
  if constexpr (requires { User::component_id; }) {
    static_assert(used == stage_of(User::component_id).step_memory, "the executive must know it: Stage::step_memory");
  }
  if constexpr (used) return User::Scratch::bytes;
  return 0;
}

/// The region, large enough for each of these stages.
template <typename... Stages>
struct StepMemory {
  static constexpr std::size_t size = std::max({scratch_bytes<Stages>()...});
  alignas(step_memory_alignment) std::array<std::byte, size> bytes;
};

/// A stage's view of the region: it holds one of these types at a time. A type is plain memory. It begins with what the
/// stages before have left there, so its user writes all that it reads; `StageReplay` puts rubbish there between steps,
/// except after Then::keep.
template <typename... Types>
class StepScratch {
  static_assert((std::is_trivially_destructible_v<Types> && ...), "nothing is destroyed when a step ends");
  static_assert(((alignof(Types) <= step_memory_alignment) && ...));

 public:
  static constexpr std::size_t bytes = std::max({sizeof(Types)...});

  /// The compiler refuses a region that is too small.
  template <typename... Stages>
  StepScratch(StepMemory<Stages...>& memory) : memory_(memory.bytes.data()) {
    static_assert(StepMemory<Stages...>::size >= bytes, "the region is too small for this stage");
  }

  /// What an earlier call for another type returned must not be used any more.
  template <typename T>
  [[nodiscard]] T& as() const {
    static_assert((std::is_same_v<T, Types> || ...), "the stage's Scratch does not name this type");
    return *std::launder(reinterpret_cast<T*>(memory_));
  }

 private:
  std::byte* memory_;
};

}  // namespace ilp
