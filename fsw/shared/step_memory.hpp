// Memory that a stage needs within one step and carries to no other. All stages share one region of it, because the
// executive runs one step at a time.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <new>
#include <type_traits>

namespace ilp {

inline constexpr std::size_t step_memory_alignment = 64;

/// The region, large enough for the scratch of each of these stages (their member type `Scratch`).
template <typename... Stages>
struct StepMemory {
  static constexpr std::size_t size = std::max({Stages::Scratch::bytes...});
  alignas(step_memory_alignment) std::array<std::byte, size> bytes;
};

/// A stage's view of the region: it holds one of these types at a time. A type is plain memory. It begins with what the
/// stages before have left there, so its user writes all that it reads; `StageReplay` puts rubbish there between steps.
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

  /// What an earlier call in this step returned must not be used any more.
  template <typename T>
  [[nodiscard]] T& as() const {
    static_assert((std::is_same_v<T, Types> || ...), "the stage's Scratch does not name this type");
    return *std::launder(reinterpret_cast<T*>(memory_));
  }

 private:
  std::byte* memory_;
};

}  // namespace ilp
