// The compiler keeps what the rows of the schedule say about tables.

#include <gtest/gtest.h>

#include "fsw/executive/stage_component.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

template <ComponentId id, typename Record>
concept CanRead = requires(StageStore<id> store, Record record) {
  get(store, 1, record);
  next(store, 0, record);
  last(store, record);
};
template <ComponentId id, typename Record>
concept CanPut = requires(StageStore<id> store, Record record) {
  put(store, record);
};
template <ComponentId id, typename Record>
concept CanAmend = requires(StageStore<id> store, Record record) {
  amend(store, record);
};
template <ComponentId id, typename Record>
concept CanErase = requires(StageStore<id> store) {
  erase<Record>(store, 1);
};
template <ComponentId id, typename Record>
concept CanFindNewest = requires(StageStore<id> store, std::int64_t number) {
  newest_id<Record>(store, number);
};

constexpr bool has(RecordMask mask, RecordType type) {
  return (mask & mask_of(type)) != 0;
}

/// Whether the component may do what its row says with the table of `Record`, and nothing else.
template <ComponentId id, typename Record>
constexpr bool as_in_its_row() {
  constexpr Stage row = stage_of(id);
  constexpr RecordType type = record_type<Record>;
  constexpr bool own = type == RecordType::checkpoint;
  constexpr bool makes = has(row.writes, type) || own;
  constexpr bool erases = has(row.erases, type) || own;
  constexpr bool changes = makes || has(row.changes, type);
  constexpr bool reads = has(row.reads, type) || changes || erases;
  return CanRead<id, Record> == reads && CanFindNewest<id, Record> == reads && CanPut<id, Record> == makes &&
         CanAmend<id, Record> == changes && CanErase<id, Record> == erases;
}

template <std::size_t... numbers>
constexpr bool all_as_in_their_rows(std::index_sequence<numbers...>) {
  bool all = true;
#define RECORD(number, record, name, ...) all = all && (as_in_its_row<schedule[numbers].component, record>() && ...);
#include "fsw/records/records.inc"
  return all;
}

TEST(Permissions, AComponentTouchesTheTablesOfItsRowOnly) {
  static_assert(all_as_in_their_rows(std::make_index_sequence<stage_count>{}));
  // By name, so that the check above cannot be true of nothing.
  static_assert(CanPut<ComponentId::dense_matcher, DepthRecord>);
  static_assert(!CanPut<ComponentId::dense_matcher, KeyframeRecord>);
  static_assert(!CanRead<ComponentId::dense_matcher, ProductRecord>);
  static_assert(CanAmend<ComponentId::storage_manager, ProductRecord>);
  static_assert(!CanPut<ComponentId::storage_manager, ProductRecord>);
}

TEST(Permissions, APartOfTheStoreGivesNoMoreThanItHas) {
  using Narrow = Reader<PoseRecord>;
  using Wide = StorePart<Reads<PoseRecord, FrameRecord>, Writes<DepthRecord>>;
  static_assert(std::is_convertible_v<Wide, Narrow>);
  static_assert(std::is_convertible_v<Wide, Reader<DepthRecord>>, "what may be written may be read");
  static_assert(!std::is_convertible_v<Narrow, Wide>);
  static_assert(!std::is_convertible_v<Wide, StorePart<Erases<DepthRecord>>>);
  static_assert(!std::is_convertible_v<StorePart<Changes<DepthRecord>>, StorePart<Writes<DepthRecord>>>);
  static_assert(std::is_convertible_v<StorePart<Writes<DepthRecord>>, StorePart<Changes<DepthRecord>>>);
  static_assert(!std::is_convertible_v<Wide, Store&>);
}

/// How many components make the records of a table.
int makers_of(RecordType type) {
  int makers = 0;
  for (const Stage& stage : schedule) makers += has(stage.writes, type) ? 1 : 0;
  return makers;
}

TEST(Permissions, ATableHasOneComponentThatMakesItsRecords) {
  // A command's number is one more than the newest one's, read in the transaction that writes it, by one process.
  constexpr RecordMask several = mask_of(RecordType::command);
  // Tables that the executive, the start of a flight, the process itself, or every component writes.
  constexpr RecordMask of_others =
      mask_of(RecordType::event, RecordType::component, RecordType::timing, RecordType::start, RecordType::identity,
              RecordType::checkpoint, RecordType::node);
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    const auto type = static_cast<RecordType>(t);
    if (has(several, type)) {
      EXPECT_EQ(makers_of(type), 3) << record_info(type).name;
    } else {
      EXPECT_EQ(makers_of(type), has(of_others, type) ? 0 : 1) << record_info(type).name;
    }
  }
}

TEST(Permissions, WhatIsChangedOrReadIsMadeBySomebodyAndNobodyChangesItsOwn) {
  RecordMask made = mask_of(RecordType::event, RecordType::component, RecordType::timing, RecordType::start,
                            RecordType::identity, RecordType::checkpoint, RecordType::node);
  for (const Stage& stage : schedule) made |= stage.writes;
  for (const Stage& stage : schedule) {
    EXPECT_EQ((stage.wakes | stage.reads | stage.changes | stage.erases) & ~made, 0U) << stage.name;
    EXPECT_EQ(stage.writes & stage.changes, 0U) << stage.name;
    EXPECT_EQ(stage.reads & (stage.writes | stage.changes | stage.erases) &
                  ~(stage.component == ComponentId::scrubber ? ~RecordMask{0} : 0U),
              0U)
        << stage.name << " may read what it writes: the row need not say so";
  }
}

/// The tables of an image's life that lead back: what is known of later images, or of strips as a whole, wakes these.
constexpr RecordMask leads_back_to(ComponentId stage) {
  using enum RecordType;
  switch (stage) {
    case ComponentId::capture_clock:
      return mask_of(frame, overlap, keyframe, pose, navigation, fix);
    case ComponentId::navigator:
      return mask_of(pose, fix);
    case ComponentId::camera_calibrator:
      return mask_of(pose);
    case ComponentId::storage_manager:
      return mask_of(downlink);
    default:
      return 0;
  }
}

TEST(Schedule, RowsStandInTheOrderInWhichDataFlow) {
  constexpr RecordMask of_many = mask_of(RecordType::command, RecordType::setting);
  RecordMask made = mask_of(RecordType::event, RecordType::component);
  for (const Stage& stage : schedule) {
    EXPECT_EQ(stage.wakes & ~made & ~of_many & ~leads_back_to(stage.component), 0U)
        << stage.name << " is woken by what a later row makes";
    made |= stage.writes;
  }
}

TEST(Schedule, ANumberFindsItsRowWhereverItStands) {
  EXPECT_LT(place_of(ComponentId::place_memory), place_of(ComponentId::richness_scorer));
  EXPECT_STREQ(component_name(17), "place_memory");
  EXPECT_STREQ(component_name(8), "richness_scorer");
  EXPECT_STREQ(component_name(0), "package");
  EXPECT_EQ(find_stage(component_numbers + 1), nullptr);
}

}  // namespace
}  // namespace ilp
