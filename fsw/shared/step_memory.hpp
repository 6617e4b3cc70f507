// Scratch memory that a stage needs only while it works on one input. All stages share one region, which the executive
// lets one stage use at a time. Work that is too long for one step takes several steps: all but the last one return
// Then::keep (fsw/executive/component.hpp), which keeps the region for the stage.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <new>
#include <type_traits>

#include "cfg/schedule.hpp"

namespace ilp {

inline constexpr std::size_t step_memory_alignment = 64;

/// Bytes of the region that a stage needs: the size of its member type `Scratch`, or 0 without this type. The stage's
/// row must say that it uses the region. A class without a row is a part of a stage.
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

/// The region, which is large enough for each of these stages.
template <typename... Stages>
struct StepMemory {
  static constexpr std::size_t size = std::max({scratch_bytes<Stages>()...});
  alignas(step_memory_alignment) std::array<std::byte, size> bytes;
};

/// A stage's view of the region, which holds an object of one of these types at a time. The object is not initialised:
/// it has the bytes that earlier stages have left, so that its user must write all that it reads. (`StageReplay` fills
/// the region with arbitrary bytes between steps, except after Then::keep.)
template <typename... Types>
class StepScratch {
  static_assert((std::is_trivially_destructible_v<Types> && ...), "nothing is destroyed when a step ends");
  static_assert(((alignof(Types) <= step_memory_alignment) && ...));

 public:
  static constexpr std::size_t bytes = std::max({sizeof(Types)...});

  /// A region that is too small does not compile.
  template <typename... Stages>
  StepScratch(StepMemory<Stages...>& memory) : memory_(memory.bytes.data()) {
    static_assert(StepMemory<Stages...>::size >= bytes, "the region is too small for this stage");
  }

  /// The region as an object of type T. An object of another type from an earlier call must not be used any more.
  template <typename T>
  [[nodiscard]] T& as() const {
    static_assert((std::is_same_v<T, Types> || ...), "the stage's Scratch does not name this type");
    return *std::launder(reinterpret_cast<T*>(memory_));
  }

 private:
  std::byte* memory_;
};

}  // namespace ilp
