// Saving and loading where a component stands. Saved in the same transaction as what was derived from the input, so
// that after a power failure the flight goes on as if nothing had happened (architecture, "Atomicity").
//
// Kept in two generations, each with a checksum of its own: a save replaces the older one, a load takes the newer one
// that is sound. What was derived since the older one is on record then: a component that loads it has to find the same
// again or to go on behind what is on record, and so has one that finds none (docs/design.md, "Going on").
#pragma once

#include <type_traits>

#include "cfg/schedule.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

struct Cursor {
  std::int64_t first = 0;   ///< last input consumed
  std::int64_t second = 0;  ///< last input consumed of a second kind
};

using CheckpointStore = StorePart<Writes<CheckpointRecord>, Erases<CheckpointRecord>>;

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
/// With the layout that the component's row has.
template <typename State>
constexpr CheckpointForm checkpoint_form(ComponentId component) {
  return checkpoint_form<State>(component, stage_of(component).state.number);
}

/// Inside the transaction of what goes with it. `cursor_back`, with nothing written, when a cursor would be smaller
/// than in the newest checkpoint of this form.
Status save_checkpoint(CheckpointStore store, const CheckpointForm& form, const Cursor& cursor,
                       std::span<const std::uint8_t> state);
/// Outside of transactions. `not_found` when there is none: start afresh. `store_build` when there is one of another
/// form: to start afresh would overwrite what was derived from the input up to there. Damaged ones are erased:
/// `checkpoint_older` when the other one was loaded, `checkpoint_lost` when there is no other one; then cursor and
/// state may be anything.
Status load_checkpoint(CheckpointStore store, const CheckpointForm& form, Cursor& cursor,
                       std::span<std::uint8_t> state);
/// Nothing is read into memory or written: `store_build` when a component of `forms` has a checkpoint of none of them.
/// Damaged ones are passed over.
Status check_checkpoints(Reader<CheckpointRecord> store, std::span<const CheckpointForm* const> forms);
/// How far a component has come; zeros where it has no checkpoint that can be read.
Status saved_cursor(Reader<CheckpointRecord> store, ComponentId component, Cursor& cursor);

template <typename State>
Status save_checkpoint(CheckpointStore store, const CheckpointForm& form, const Cursor& cursor, const State& state) {
  static_assert(std::is_trivially_copyable_v<State>);
  return save_checkpoint(store, form, cursor,
                         std::span<const std::uint8_t>(reinterpret_cast<const std::uint8_t*>(&state), sizeof(State)));
}
template <typename State>
Status load_checkpoint(CheckpointStore store, const CheckpointForm& form, Cursor& cursor, State& state) {
  static_assert(std::is_trivially_copyable_v<State>);
  return load_checkpoint(store, form, cursor,
                         std::span<std::uint8_t>(reinterpret_cast<std::uint8_t*>(&state), sizeof(State)));
}

/// Cursor and state as they were saved, or new ones where there is no checkpoint. Ok, news (restored() of
/// component.hpp), or a fault.
template <typename State>
Status restore_checkpoint(CheckpointStore store, const CheckpointForm& form, Cursor& cursor, State& state) {
  cursor = {};
  state = {};
  const Status status = load_checkpoint(store, form, cursor, state);
  if (status.is(StatusCode::not_found)) return {};
  if (status.is(StatusCode::checkpoint_lost)) {
    cursor = {};
    state = {};
  }
  return status;
}

}  // namespace ilp
