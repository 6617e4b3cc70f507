// Saving and loading where a component stands. Saved in the same transaction as what was derived from the input, so
// that after a power failure the flight goes on as if nothing had happened (architecture, "Atomicity").
#pragma once

#include <type_traits>

#include "cfg/schedule.hpp"
#include "hal/store/store.hpp"

namespace ilp {

struct Cursor {
  std::int64_t first = 0;   ///< last input consumed
  std::int64_t second = 0;  ///< last input consumed of a second kind
};

/// `layout` tells versions of a state apart; its size does so by itself.
Status save_checkpoint(Store& store, ComponentId component, const Cursor& cursor, std::uint32_t layout,
                       std::span<const std::uint8_t> state);
/// `not_found` when there is none, or one with another layout: start afresh.
Status load_checkpoint(Store& store, ComponentId component, Cursor& cursor, std::uint32_t layout,
                       std::span<std::uint8_t> state);

template <typename State>
Status save_checkpoint(Store& store, ComponentId component, const Cursor& cursor, std::uint32_t layout,
                       const State& state) {
  static_assert(std::is_trivially_copyable_v<State>);
  return save_checkpoint(store, component, cursor, layout,
                         std::span<const std::uint8_t>(reinterpret_cast<const std::uint8_t*>(&state), sizeof(State)));
}
template <typename State>
Status load_checkpoint(Store& store, ComponentId component, Cursor& cursor, std::uint32_t layout, State& state) {
  static_assert(std::is_trivially_copyable_v<State>);
  return load_checkpoint(store, component, cursor, layout,
                         std::span<std::uint8_t>(reinterpret_cast<std::uint8_t*>(&state), sizeof(State)));
}

/// Cursor and state as they were saved, or new ones where there is no checkpoint.
template <typename State>
Status restore_checkpoint(Store& store, ComponentId component, Cursor& cursor, std::uint32_t layout, State& state) {
  cursor = {};
  state = {};
  const Status status = load_checkpoint(store, component, cursor, layout, state);
  return status.is(StatusCode::not_found) ? Status{} : status;
}

}  // namespace ilp
