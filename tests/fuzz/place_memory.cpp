// A store whose places, ties and poses hold anything, and a flight that comes back to their ground. In a flight,
// checksums notice what flipped bits have changed.
#include "fsw/places/place_memory.hpp"

#include <cmath>
#include <cstring>
#include <memory>

#include "hal/store/newest_id.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "tests/fuzz/special_values.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/unit/places/place_flight.hpp"

namespace ilp::fuzz {
namespace {

constexpr std::size_t region_bytes = std::size_t{12} << 20U;
constexpr std::int64_t known_keyframes = 3, all_keyframes = 5;
constexpr int most_steps = 2000;

void must(const Status& status) {
  require(status.ok(), "the store of the trial fails");
}

/// The stage with what it shares with others; one of each, because they are large.
struct Stage {
  MissionParameters mission;
  alignas(PlaceMemory) std::byte place[sizeof(PlaceMemory)];

  PlaceMemory& begin(Store& store) {
    std::memset(place, 0, sizeof(place));
    return *new (place) PlaceMemory(store, mission, test::step_memory<PlaceMemory>());
  }
};

void run(PlaceMemory& memory) {
  static_cast<void>(memory.restore());
  for (int i = 0; i < most_steps; ++i) {
    const StepResult result = memory.step();
    require(!result.status.is(StatusCode::assertion_failed), "an assertion fails");
    if (result.then == Then::restore) static_cast<void>(memory.restore());
    if (!result.pending) return;
  }
  require(false, "the stage never comes to rest");
}

void show(test::PlaceFlight& flight, std::int64_t id) {
  const bool out = id <= known_keyframes;
  const double x = test::PlaceFlight::step * static_cast<double>(out ? id : 2 * known_keyframes - id);
  flight.see(id, out ? 1 : 2, static_cast<std::int32_t>(out ? id - 1 : id - known_keyframes - 1),
             test::looking_down(Vec3(x, out ? 0 : 5, test::PlaceFlight::height), Vec3(0, 0, out ? 0 : 0.3)),
             out ? Similarity{} : flight.second_, static_cast<std::uint64_t>(id));
}

template <typename Record>
void damage_record(Choices& choices, Store& store, std::int64_t id) {
  Record record;
  if (!get(store, id, record).ok()) return;
  auto* const bytes = reinterpret_cast<std::uint8_t*>(&record);
  for (unsigned i = choices.byte() & 7U; i > 0; --i) {
    const std::size_t at = choices.byte() % sizeof(Record);
    // From whole fields on most often.
    const std::size_t field = at / 8 * 8 + 8 <= sizeof(Record) ? at / 8 * 8 : at;
    const std::uint64_t value = (choices.byte() & 1U) != 0 ? special_value(choices.byte()) : choices.number(8);
    std::memcpy(bytes + field, &value, std::min(sizeof(value), sizeof(Record) - field));
  }
  // A store has no larger blobs than the flight has memory for, and no ids below 1.
  if constexpr (std::is_same_v<Record, PlaceRecord>) {
    for (Blob* blob : {&record.features, &record.cells, &record.patches}) blob->bytes %= 200'000;
  }
  if (record.id < 1) record.id = id;
  if (record.id != id && (choices.byte() & 1U) != 0) must(store.erase(record_info<Record>(), id));
  must(put(store, record));
}

void damage_blob(Choices& choices, Store& store, const char* field, std::uint32_t bytes, std::int64_t id) {
  if (bytes == 0) return;
  std::uint8_t change[8];
  const std::uint64_t value = (choices.byte() & 1U) != 0 ? special_value(choices.byte()) : choices.number(8);
  std::memcpy(change, &value, sizeof(value));
  const std::size_t at = choices.number(3) % bytes / 4 * 4;
  const std::size_t length = std::min<std::size_t>(bytes - at, sizeof(change));
  static_cast<void>(write_blob<PlaceRecord>(store, field, id, at, {change, length}));
}

void damage(Choices& choices, Store& store) {
  Transaction transaction(store);
  must(transaction.begin());
  for (int i = 0; i < 12 && !choices.empty(); ++i) {
    const std::uint8_t what = choices.byte();
    const std::int64_t id = 1 + what / 8 % known_keyframes;
    PlaceRecord place;
    const bool placed = get(store, id, place).ok();
    switch (what % 8) {
      case 0:
      case 1:
        damage_record<PlaceRecord>(choices, store, id);
        break;
      case 2:
        damage_record<PoseRecord>(choices, store, id);
        break;
      case 3:
        static_cast<void>(store.erase(record_info<PoseRecord>(), id));
        break;
      case 4: {
        TieRecord tie{.id = 1 + choices.byte() % 3, .to_strip_id = choices.byte() % 4};
        must(put(store, tie));
        damage_record<TieRecord>(choices, store, tie.id);
        break;
      }
      case 5:
        if (placed) damage_blob(choices, store, "features", place.features.bytes, id);
        break;
      case 6:
        if (placed) damage_blob(choices, store, "patches", place.patches.bytes, id);
        break;
      default:
        if (placed) damage_blob(choices, store, "cells", place.cells.bytes, id);
        break;
    }
  }
  must(transaction.commit());
}

void judge(Store& store) {
  LinkRecord link;
  for (std::int64_t id = 0; next(store, id, link).ok(); id = link.id) {
    require(link.keyframe_id <= all_keyframes && link.place_id < link.keyframe_id, "a link to what was not there");
    require(std::isfinite(link.scale) && std::isfinite(link.rms_px), "a link without numbers");
    for (const double h : link.keyframe_from_place_px) require(std::isfinite(h), "a link without a homography");
    for (const double t : link.translation) require(std::isfinite(t), "a link without a translation");
    require(link.points.bytes <= limits::max_link_points * sizeof(LinkPoint), "too many points");
  }
  std::int64_t newest = 0;
  must(newest_id<PlaceRecord>(store, newest));
  require(newest >= all_keyframes, "a keyframe without a place");
  std::int64_t places = 0;
  must(store.count(record_info<PlaceRecord>(), places));
  require(places <= all_keyframes + 1, "places that lead nowhere");
  MaskRecord record;
  for (std::int64_t id = 0; next(store, id, record).ok(); id = record.id) {
    // The places of the first keyframes were put there, and behind a place of a later id the stage has nothing to do.
    const bool visited = record.id > known_keyframes && newest == all_keyframes;
    require(!visited || record.scope == MaskScope::flight, "a mask that is not final");
    std::vector<std::uint8_t> coded(record.code.bytes);
    must(read_blob<MaskRecord>(store, "code", record.id, 0, coded));
    std::vector<std::uint8_t> mask(static_cast<std::size_t>(record.width * record.height));
    must(decode_mask(coded.data(), coded.size(), {mask.data(), record.width, record.height}));
  }
}

/// The places of the first keyframes, which are found once.
struct KnownPlace {
  PlaceRecord record;
  std::vector<std::uint8_t> features, cells, patches;
};

template <typename Use>
void each_blob(KnownPlace& place, Use use) {
  use("features", place.record.features, place.features);
  use("cells", place.record.cells, place.cells);
  use("patches", place.record.patches, place.patches);
}

test::PlaceFlight begin_flight(Store& store) {
  test::PlaceFlight flight(store, test::distorting_camera(240, 180));
  flight.write_camera();
  for (std::int64_t id = 1; id <= known_keyframes; ++id) show(flight, id);
  return flight;
}

std::vector<KnownPlace> find_places(std::span<std::byte> region, Stage& stage) {
  RamStore store(region);
  begin_flight(store);
  run(stage.begin(store));
  std::vector<KnownPlace> places(known_keyframes);
  for (std::int64_t id = 1; id <= known_keyframes; ++id) {
    KnownPlace& place = places[static_cast<std::size_t>(id - 1)];
    must(get(store, id, place.record));
    each_blob(place, [&](const char* field, const Blob& blob, std::vector<std::uint8_t>& bytes) {
      bytes.resize(blob.bytes);
      must(read_blob<PlaceRecord>(store, field, id, 0, bytes));
    });
  }
  return places;
}

void write_places(Store& store, std::vector<KnownPlace>& places) {
  Transaction transaction(store);
  must(transaction.begin());
  for (KnownPlace& place : places) {
    must(put(store, place.record));
    each_blob(place, [&](const char* field, const Blob&, std::vector<std::uint8_t>& bytes) {
      must(write_blob<PlaceRecord>(store, field, place.record.id, 0, bytes));
    });
  }
  must(transaction.commit());
}

}  // namespace

void place_memory(Octets input) {
  static const auto stage = std::make_unique<Stage>();
  static std::vector<std::byte> region(region_bytes);
  static std::vector<KnownPlace> places = find_places(region, *stage);
  Choices choices(input);
  RamStore store(region);
  test::PlaceFlight flight = begin_flight(store);
  write_places(store, places);
  damage(choices, store);
  for (std::int64_t id = known_keyframes + 1; id <= all_keyframes; ++id) show(flight, id);
  run(stage->begin(store));
  judge(store);
}

}  // namespace ilp::fuzz
