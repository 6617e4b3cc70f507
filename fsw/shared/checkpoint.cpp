#include "fsw/shared/checkpoint.hpp"

#include <utility>

#include "fsw/base/checksum.hpp"

namespace ilp {
namespace {

constexpr std::int64_t other_place = 100;
static_assert(component_numbers < other_place);

std::int64_t number_of(ComponentId component) {
  return static_cast<std::int64_t>(component);
}

bool has_form(const CheckpointRecord& record, const CheckpointForm& form) {
  return record.layout == form.layout && record.state.bytes == form.bytes;
}

Status of_another_build(const CheckpointRecord& record) {
  return {StatusCode::store_build, record.id % other_place, record.state.bytes};
}

std::int64_t checksum_of(const CheckpointRecord& record, std::span<const std::uint8_t> state) {
  const std::int64_t head[] = {record.id,         record.cursor, record.cursor_second,
                               record.generation, record.layout, record.state.bytes};
  return static_cast<std::int64_t>(checksum64(std::as_bytes(state), checksum64(memory_of(head))));
}

/// One of the two places of a component.
struct Place {
  CheckpointRecord record;
  bool there = false;    ///< a record exists and its fields can be read
  bool damaged = false;  ///< it exists, and its checksum is wrong
};

Status look(Reader<CheckpointRecord> store, std::int64_t id, Place& place) {
  const Status found = get(store, id, place.record);
  place.there = found.ok();
  place.damaged = found.is(StatusCode::record_damaged);
  if (!place.there) place.record = {};
  place.record.id = id;
  return place.there || place.damaged || found.is(StatusCode::not_found) ? Status{} : found;
}

Status read_state(Reader<CheckpointRecord> store, Place& place, std::span<std::uint8_t> state) {
  if (!state.empty()) {
    const Status read = read_blob<CheckpointRecord>(store, "state", place.record.id, 0, state);
    if (!read.ok() && !read.is(StatusCode::record_damaged) && !read.is(StatusCode::not_found)) return read;
    place.damaged = !read.ok();
  }
  if (!place.damaged) place.damaged = place.record.checksum != checksum_of(place.record, state);
  return {};
}

/// A damaged one must not be taken for the newer one again, because the next save would be a step back.
Status erase_damaged(CheckpointStore store, std::span<const Place> places) {
  Transaction transaction(store);
  ILP_TRY(transaction.begin());
  for (const Place& place : places) {
    if (place.damaged) ILP_TRY(erase<CheckpointRecord>(store, place.record.id));
  }
  return transaction.commit();
}

}  // namespace

Status save_checkpoint(CheckpointStore store, const CheckpointForm& form, const Cursor& cursor,
                       std::span<const std::uint8_t> state) {
  ILP_ASSERT(state.size() == form.bytes, state.size());
  const std::int64_t number = number_of(form.component);
  Place newest, older;
  ILP_TRY(look(store, number, newest));
  ILP_TRY(look(store, number + other_place, older));
  if (older.record.generation > newest.record.generation) std::swap(newest, older);
  // Cursors of another form may count something else.
  const bool same = newest.there && has_form(newest.record, form);
  if (same && cursor.first < newest.record.cursor) return {StatusCode::cursor_back, number, cursor.first};
  if (same && cursor.second < newest.record.cursor_second) return {StatusCode::cursor_back, number, cursor.second};
  CheckpointRecord record;
  record.id = newest.there ? older.record.id : newest.record.id;
  record.cursor = cursor.first;
  record.cursor_second = cursor.second;
  record.generation = newest.record.generation + 1;
  record.layout = form.layout;
  record.state.bytes = form.bytes;
  record.checksum = checksum_of(record, state);
  ILP_TRY(put(store, record));
  if (state.empty()) return {};
  return write_blob<CheckpointRecord>(store, "state", record.id, 0, state);
}

Status load_checkpoint(CheckpointStore store, const CheckpointForm& form, Cursor& cursor,
                       std::span<std::uint8_t> state) {
  ILP_ASSERT(state.size() == form.bytes, state.size());
  const std::int64_t number = number_of(form.component);
  Place places[2];
  ILP_TRY(look(store, number, places[0]));
  ILP_TRY(look(store, number + other_place, places[1]));
  if (places[1].record.generation > places[0].record.generation) std::swap(places[0], places[1]);
  bool loaded = false;
  bool damage = places[0].damaged || places[1].damaged;
  std::int64_t generation = 0;
  for (Place& place : places) {
    if (loaded || !place.there) continue;
    // After a damaged one of the requested form, the older one may still be of an earlier form, and is of no use.
    place.damaged = !has_form(place.record, form) && damage;
    if (place.damaged) continue;
    if (!has_form(place.record, form)) return of_another_build(place.record);
    ILP_TRY(read_state(store, place, state));
    loaded = !place.damaged;
    damage = damage || place.damaged;
    generation = place.record.generation;
    if (loaded) cursor = {place.record.cursor, place.record.cursor_second};
  }
  if (damage) ILP_TRY(erase_damaged(store, places));
  if (damage) return {loaded ? StatusCode::checkpoint_older : StatusCode::checkpoint_lost, number, generation};
  return loaded ? Status{} : Status{StatusCode::not_found, number};
}

Status check_checkpoints(Reader<CheckpointRecord> store, std::span<const CheckpointForm* const> forms) {
  for (const CheckpointForm* asked : forms) {
    for (const std::int64_t place : {std::int64_t{0}, other_place}) {
      Place found;
      ILP_TRY(look(store, number_of(asked->component) + place, found));
      bool fits = !found.there;
      for (const CheckpointForm* form : forms) {
        fits = fits || (form->component == asked->component && has_form(found.record, *form));
      }
      if (!fits) return of_another_build(found.record);
    }
  }
  return {};
}

Status saved_cursor(Reader<CheckpointRecord> store, ComponentId component, Cursor& cursor) {
  Place newest, older;
  ILP_TRY(look(store, number_of(component), newest));
  ILP_TRY(look(store, number_of(component) + other_place, older));
  if (older.record.generation > newest.record.generation) std::swap(newest, older);
  cursor = {newest.record.cursor, newest.record.cursor_second};
  return {};
}

}  // namespace ilp
