// Saves and loads the position of a component in its input. It is saved in the same transaction as what was derived
// from the input, so that after a power failure the flight goes on as if nothing had happened (architecture,
// "Atomicity").
//
// Two generations are kept, each with a checksum of its own: a save replaces the older one, a load takes the newer one
// that is valid. What was derived after the older one is then already on record. A component that loads the older one,
// or finds none, either derives the same again or continues after what is on record (docs/design.md, "Going on").
#pragma once

#include <new>
#include <type_traits>

#include "cfg/schedule.hpp"
#include "fsw/base/fields.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

struct Cursor {
  std::int64_t first = 0;   ///< last input consumed
  std::int64_t second = 0;  ///< last input consumed of a second kind
};

using CheckpointStore = StorePart<Writes<CheckpointRecord>, Erases<CheckpointRecord>>;

/// What distinguishes the state of a component from that of another build. The upper octet of `layout` is the number of
/// the component's row, which is raised with a change of meaning; the rest changes with the fields' names, types and
/// order (layout_digest). The size also changes with the capacities of the profile.
struct CheckpointForm {
  ComponentId component;
  std::uint32_t layout;
  std::uint32_t bytes;
};
template <typename State>
constexpr CheckpointForm checkpoint_form(ComponentId component, std::uint32_t layout) {
  static_assert(!has_pointers<State>(), "an address means nothing to another process");
  constexpr std::uint64_t digest = layout_digest<State>();
  return {component, layout << 24U | static_cast<std::uint32_t>(digest >> 40U), sizeof(State)};
}
/// The form with the layout that the component's row has.
template <typename State>
constexpr CheckpointForm checkpoint_form(ComponentId component) {
  return checkpoint_form<State>(component, stage_of(component).state.number);
}

/// Call it inside the transaction of the derived records. Returns `cursor_back`, with nothing written, when a cursor
/// would be smaller than in the newest checkpoint of this form.
Status save_checkpoint(CheckpointStore store, const CheckpointForm& form, const Cursor& cursor,
                       std::span<const std::uint8_t> state);
/// Call it outside of transactions. `not_found` when there is none: the component starts from the beginning.
/// `store_build` when there is one of another form: a new beginning would overwrite what was derived from the input up
/// to there. Damaged ones are erased: `checkpoint_older` when the other one was loaded, `checkpoint_lost` when there is
/// no other one; cursor and state are then undefined.
Status load_checkpoint(CheckpointStore store, const CheckpointForm& form, Cursor& cursor,
                       std::span<std::uint8_t> state);
/// Only checks: `store_build` when a component of `forms` has a checkpoint of none of them. Damaged checkpoints are
/// passed over.
Status check_checkpoints(Reader<CheckpointRecord> store, std::span<const CheckpointForm* const> forms);
/// The position of a component in its input; zeros if it has no readable checkpoint.
Status saved_cursor(Reader<CheckpointRecord> store, ComponentId component, Cursor& cursor);

/// Clears the padding of `state`, so that equal states are equal bytes.
template <typename State>
Status save_checkpoint(CheckpointStore store, const CheckpointForm& form, const Cursor& cursor, State& state) {
  static_assert(std::is_trivially_copyable_v<State>);
  clear_padding(state);
  return save_checkpoint(store, form, cursor,
                         std::span<const std::uint8_t>(reinterpret_cast<const std::uint8_t*>(&state), sizeof(State)));
}
template <typename State>
Status load_checkpoint(CheckpointStore store, const CheckpointForm& form, Cursor& cursor, State& state) {
  static_assert(std::is_trivially_copyable_v<State>);
  return load_checkpoint(store, form, cursor,
                         std::span<std::uint8_t>(reinterpret_cast<std::uint8_t*>(&state), sizeof(State)));
}

/// Makes it as it begins, in its place: a state may be larger than a stack.
template <typename State>
void renew(State& state) {
  static_assert(std::is_trivially_destructible_v<State>);
  new (static_cast<void*>(&state)) State{};
}

/// Loads cursor and state, or new ones if there is no checkpoint. Returns ok, a report (restored() of component.hpp),
/// or a fault.
template <typename State>
Status restore_checkpoint(CheckpointStore store, const CheckpointForm& form, Cursor& cursor, State& state) {
  cursor = {};
  renew(state);
  const Status status = load_checkpoint(store, form, cursor, state);
  if (status.is(StatusCode::not_found)) return {};
  if (status.is(StatusCode::checkpoint_lost)) {
    cursor = {};
    renew(state);
  }
  return status;
}

}  // namespace ilp
