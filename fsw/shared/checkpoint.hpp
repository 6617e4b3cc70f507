// Saves and loads checkpoints: the state of a component and its position in its input. A checkpoint is saved in the
// same transaction as the records that were derived from the input, so that after a power failure the flight goes on as
// if nothing had happened (architecture, "Atomicity").
//
// Two generations are kept, each with its own checksum: a save replaces the older one, and a load takes the newest
// valid one. If that is the older one, or there is none, records that were derived later are already in the store: the
// component either derives the same records again or continues after them (docs/design.md, "Going on").
#pragma once

#include <new>
#include <type_traits>

#include "cfg/schedule.hpp"
#include "fsw/base/fields.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// The position of a component in its input, as record ids; 0: nothing was consumed.
struct Cursor {
  std::int64_t first = 0;   ///< id of the last input that was consumed
  std::int64_t second = 0;  ///< the same for a second kind of input
};

using CheckpointStore = StorePart<Writes<CheckpointRecord>, Erases<CheckpointRecord>>;

/// Identifies the form of a component's state: only a state of the same form can be loaded.
struct CheckpointForm {
  ComponentId component;
  /// The upper octet is the number of Stage::state, which is raised when the meaning of the state changes. The lower
  /// octets change with names, types and order of its fields (layout_digest).
  std::uint32_t layout;
  std::uint32_t bytes;  ///< size of the state, which also depends on the capacities of the profile
};
template <typename State>
constexpr CheckpointForm checkpoint_form(ComponentId component, std::uint32_t layout) {
  static_assert(!has_pointers<State>(), "an address means nothing to another process");
  constexpr std::uint64_t digest = layout_digest<State>();
  return {component, layout << 24U | static_cast<std::uint32_t>(digest >> 40U), sizeof(State)};
}
/// The form with the number that the component's row has (Stage::state).
template <typename State>
constexpr CheckpointForm checkpoint_form(ComponentId component) {
  return checkpoint_form<State>(component, stage_of(component).state.number);
}

/// Saves a checkpoint. Call it inside the transaction of the derived records. Returns `cursor_back` and writes nothing
/// if `cursor` is behind that of the newest checkpoint and this has the same form.
Status save_checkpoint(CheckpointStore store, const CheckpointForm& form, const Cursor& cursor,
                       std::span<const std::uint8_t> state);
/// Loads the newest valid checkpoint and erases damaged ones. Call it outside of transactions. Returns
/// - `not_found` if there is no checkpoint: the component starts from the beginning;
/// - `store_build` if the newest one has another form: a start from the beginning would overwrite the records that were
///   derived up to it;
/// - `checkpoint_older` if one is damaged and the other one was loaded;
/// - `checkpoint_lost` if one is damaged and no other one is valid; cursor and state are then undefined.
Status load_checkpoint(CheckpointStore store, const CheckpointForm& form, Cursor& cursor,
                       std::span<std::uint8_t> state);
/// Returns `store_build` if a component of `forms` has a checkpoint whose form is not in `forms`. Damaged checkpoints
/// are ignored.
Status check_checkpoints(Reader<CheckpointRecord> store, std::span<const CheckpointForm* const> forms);
/// Reads the cursor of a component's newest checkpoint; zeros if no checkpoint can be read.
Status saved_cursor(Reader<CheckpointRecord> store, ComponentId component, Cursor& cursor);

/// As save_checkpoint above. Clears the padding of `state` first, so that equal states have equal bytes.
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

/// Resets `state` to State{} in place, because a state may be larger than the stack.
template <typename State>
void renew(State& state) {
  static_assert(std::is_trivially_destructible_v<State>);
  new (static_cast<void*>(&state)) State{};
}

/// Loads cursor and state, or resets them if there is no checkpoint or it is lost. Returns ok, a report (restored() of
/// component.hpp), or a fault.
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
