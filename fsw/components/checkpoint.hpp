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

/// What tells the state of a component from that of another build. `layout` is raised with a change of meaning; the
/// size also changes with the capacities of the profile.
struct CheckpointForm {
  ComponentId component;
  std::uint32_t layout;
  std::uint32_t bytes;
};
template <typename State>
constexpr CheckpointForm checkpoint_form(ComponentId component, std::uint32_t layout) {
  return {component, layout, sizeof(State)};
}

Status save_checkpoint(Store& store, const CheckpointForm& form, const Cursor& cursor,
                       std::span<const std::uint8_t> state);
/// `not_found` when there is none: start afresh. `store_build` when there is one of another form: to start afresh would
/// overwrite what was derived from the input up to there.
Status load_checkpoint(Store& store, const CheckpointForm& form, Cursor& cursor, std::span<std::uint8_t> state);
/// Nothing is read into memory or written: `store_build` when a component of `forms` has a checkpoint of none of them.
Status check_checkpoints(Store& store, std::span<const CheckpointForm* const> forms);

template <typename State>
Status save_checkpoint(Store& store, const CheckpointForm& form, const Cursor& cursor, const State& state) {
  static_assert(std::is_trivially_copyable_v<State>);
  return save_checkpoint(store, form, cursor,
                         std::span<const std::uint8_t>(reinterpret_cast<const std::uint8_t*>(&state), sizeof(State)));
}
template <typename State>
Status load_checkpoint(Store& store, const CheckpointForm& form, Cursor& cursor, State& state) {
  static_assert(std::is_trivially_copyable_v<State>);
  return load_checkpoint(store, form, cursor,
                         std::span<std::uint8_t>(reinterpret_cast<std::uint8_t*>(&state), sizeof(State)));
}

/// Cursor and state as they were saved, or new ones where there is no checkpoint.
template <typename State>
Status restore_checkpoint(Store& store, const CheckpointForm& form, Cursor& cursor, State& state) {
  cursor = {};
  state = {};
  const Status status = load_checkpoint(store, form, cursor, state);
  return status.is(StatusCode::not_found) ? Status{} : status;
}

}  // namespace ilp
