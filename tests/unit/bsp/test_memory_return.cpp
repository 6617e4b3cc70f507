// A start that waits for its disk, and a flight in memory that goes back to it: nothing is lost, whenever power fails.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "bsp/flight/disk_probe.hpp"
#include "bsp/flight/flight_software.hpp"
#include "bsp/flight/flight_store.hpp"
#include "fsw/shared/camera_on_record.hpp"
#include "hal/store/checksums.hpp"
#include "hal/store/record_bytes.hpp"
#include "tests/support/failing_calls.hpp"
#include "tests/support/store_records.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

using Bytes = std::vector<std::uint8_t>;
using Key = std::pair<RecordType, std::int64_t>;
/// Every record with its blobs: checksum of the fields, then the bytes.
using Content = std::map<Key, Bytes>;

constexpr std::int64_t memory_base = 100'000'000;

Content content_of(Store& store) {
  Content content;
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    const RecordInfo& info = record_info(static_cast<RecordType>(t));
    alignas(8) std::uint8_t record[limits::max_record_bytes] = {};
    std::int64_t after = std::numeric_limits<std::int64_t>::min();
    while (store.next(info, after, record).ok()) {
      after = id_of(record);
      Bytes& bytes = content[{info.type, after}];
      bytes.resize(4);
      store_little_endian(record_checksum(info, record), bytes.data());
      for_each_blob(info, [&](const FieldInfo& field, std::size_t) {
        Bytes blob(blob_bytes(record, field));
        if (!blob.empty()) {
          EXPECT_OK(store.read_blob(info, field.name, after, 0, blob));
        }
        bytes.insert(bytes.end(), blob.begin(), blob.end());
      });
    }
  }
  return content;
}

template <typename Record>
std::vector<std::int64_t> ids_of(Store& store) {
  std::vector<std::int64_t> ids;
  for (const Record& record : test::records_of<Record>(store)) ids.push_back(record.id);
  return ids;
}

/// Counts, and repairs the disk before an attempt.
class CountedWait final : public DiskWait {
 public:
  void until_next_attempt(int attempts, const Status& fault) override {
    attempts_ = attempts;
    faults_.insert(fault.code);
    if (repair) repair(attempts);
  }
  void at_work() override { ++kicks_; }

  std::function<void(int)> repair;
  int attempts_ = 0;
  int kicks_ = 0;
  std::set<StatusCode> faults_;
};

Bytes image_of(std::int64_t id) {
  Bytes image(20'000);
  for (std::size_t i = 0; i < image.size(); ++i) image[i] = static_cast<std::uint8_t>(id + static_cast<int>(i / 100));
  return image;
}

void put_frame(Store& store, std::int64_t id, bool image) {
  FrameRecord frame{.id = id, .time_ns = 1000 * id, .capture_id = id};
  frame.image.bytes = image ? 20'000 : 0;
  ASSERT_OK(put(store, frame));
  if (image) {
    ASSERT_OK(write_blob<FrameRecord>(store, "image", id, 0, image_of(id)));
  }
}

void put_keyframe(Store& store, std::int64_t id, std::int64_t frame_id, std::int64_t strip_id, bool coded) {
  KeyframeRecord keyframe{.id = id, .frame_id = frame_id, .strip_id = strip_id};
  ASSERT_OK(put(store, keyframe));
  PlaceRecord place{.id = id, .slot = static_cast<std::int32_t>(id % 1000)};
  ASSERT_OK(put(store, place));
  if (!coded) return;
  ProductRecord product{.id = product_id(id, ProductKind::image), .keyframe_id = id, .kind = ProductKind::image};
  product.data.bytes = 9000;
  ASSERT_OK(put(store, product));
  Bytes data(9000, static_cast<std::uint8_t>(id));
  ASSERT_OK(write_blob<ProductRecord>(store, "data", product.id, 0, data));
}

void put_event(Store& store, std::int64_t id) {
  EventRecord event{.id = id, .time_ns = id};
  ASSERT_OK(put(store, event));
}

/// A checkpoint of each component that has to have one of its form, with a byte that tells the store epochs apart.
void put_checkpoints(Store& store, std::int64_t cursor, std::uint8_t byte) {
  for (const CheckpointForm* form : checkpoint_forms()) {
    // The camera's search and its checks have one place.
    const Bytes state(form->bytes, byte);
    ASSERT_OK(save_checkpoint(store, *form, {cursor, 0}, std::span<const std::uint8_t>(state)));
  }
}

void put_store_epoch(Store& store, std::int64_t store_epoch, std::int64_t base, TimeNs now) {
  IdentityRecord identity{.life = store_epoch, .keyframe_base = base, .record_base = base};
  ASSERT_OK(put(store, identity));
  StartRecord start{.id = base + 1, .time_ns = now, .alive_ns = now};
  ASSERT_OK(put(store, start));
  StorageRecord storage{.frames_released = static_cast<std::uint32_t>(store_epoch)};
  ASSERT_OK(put(store, storage));
}

/// The store epoch on the disk: six frames, three of them keyframes, of which the first is coded; a file that the
/// ground has and one that it has not confirmed; 150 events, of which a file had the first ones.
void live_on_disk(Store& store) {
  Transaction transaction(store);
  ASSERT_OK(transaction.begin());
  put_store_epoch(store, 1, 0, 5);
  put_checkpoints(store, 6, 1);
  for (std::int64_t id = 1; id <= 6; ++id) put_frame(store, id, id >= 3);
  put_keyframe(store, 1, 2, 1, true);
  put_keyframe(store, 2, 4, 1, true);
  put_keyframe(store, 3, 5, 1, false);
  StripRecord strip{.id = 1, .first_keyframe_id = 1, .last_keyframe_id = 3};
  ASSERT_OK(put(store, strip));
  for (std::int64_t id = 1; id <= 150; ++id) put_event(store, id);
  DownlinkRecord file;
  file.id = 1;
  file.kind = DownlinkKind::records;
  file.subject_id = 1;
  file.records_through = 1;
  file.bytes = 3000;
  file.acknowledged_ns = 77;
  copy_text(file.name, "records-000001.ilp");
  ASSERT_OK(put(store, file));
  file.id = 2;
  file.kind = DownlinkKind::product;
  file.subject_id = product_id(1, ProductKind::image);
  file.acknowledged_ns = 0;
  copy_text(file.name, "product-000001-image.jp2");
  ASSERT_OK(put(store, file));
  file.id = 3;
  file.kind = DownlinkKind::records;
  file.subject_id = -1;
  copy_text(file.name, "events-000001.ilp");
  ASSERT_OK(put(store, file));
  SettingRecord setting{.id = 3, .value = 0.25};
  ASSERT_OK(put(store, setting));
  ASSERT_OK(transaction.commit());
}

/// A store epoch in memory, with `frames` images.
void live_in_memory(Store& store, std::int64_t frames, std::int64_t store_epoch = 2, std::int64_t base = memory_base) {
  Transaction transaction(store);
  ASSERT_OK(transaction.begin());
  put_store_epoch(store, store_epoch, base, 9000);
  put_checkpoints(store, base + frames, static_cast<std::uint8_t>(store_epoch));
  for (std::int64_t id = base + 1; id <= base + frames; ++id) {
    put_frame(store, id, id % 2 == 0);
    put_event(store, id);
  }
  put_keyframe(store, base + 1, base + 2, base + 1, true);
  StripRecord strip{.id = base + 1, .first_keyframe_id = base + 1, .last_keyframe_id = base + 1};
  ASSERT_OK(put(store, strip));
  SettingRecord setting{.id = 4, .value = 0.5};
  ASSERT_OK(put(store, setting));
  ASSERT_OK(transaction.commit());
}

class MemoryReturn : public testing::Test {
 protected:
  static constexpr std::int64_t capacity = 1 << 20;

  void SetUp() override { fs::create_directory(disk_); }

  std::unique_ptr<FlightStore> make() { return std::make_unique<FlightStore>(sqlite_, memory_); }
  std::unique_ptr<FlightStore> start() {
    auto store = make();
    MissionParameters mission;
    EXPECT_OK(store->open(path_.c_str(), StoreTrouble::fly_on, mission));
    return store;
  }
  void unmount() const { fs::rename(disk_, disk_ + ".away"); }
  void mount() const { fs::rename(disk_ + ".away", disk_); }
  /// What lies on the disk is written back to this folder with restore().
  void remember() const { fs::copy(disk_, disk_ + ".before", fs::copy_options::recursive); }
  void restore() const {
    fs::remove_all(disk_);
    fs::copy(disk_ + ".before", disk_, fs::copy_options::recursive);
  }

  /// A store epoch on the disk, then one in memory, whose records lie beside the database. Their contents are those
  /// before.
  void fly_both(std::int64_t frames, bool earlier = true) {
    if (earlier) {
      const auto store = start();
      live_on_disk(store->store());
      on_disk_ = content_of(store->store());
    }
    unmount();
    const auto store = start();
    ASSERT_EQ((store->updates()).code, StatusCode::store_in_memory);
    live_in_memory(store->store(), frames);
    in_memory_ = content_of(store->store());
    mount();
    ASSERT_OK(try_disk(path_.c_str(), capacity));
    ASSERT_OK(store->leave_memory(path_.c_str(), &wait_));
  }
  /// Records of the store epoch in memory that are in the database as they were. The storage manager counts again.
  void expect_memory_in(const Content& content) const {
    const std::int64_t manager = static_cast<std::int64_t>(ComponentId::storage_manager);
    for (const auto& [key, bytes] : in_memory_) {
      const auto found = content.find(key);
      if (key.first == RecordType::checkpoint && key.second % 100 == manager) {
        EXPECT_EQ(found, content.end());
        continue;
      }
      ASSERT_NE(found, content.end()) << record_info(key.first).name << ' ' << key.second;
      EXPECT_EQ(found->second, bytes) << record_info(key.first).name << ' ' << key.second;
    }
  }

  test::TemporaryFolder folder_;
  std::string disk_ = folder_ / "disk";
  std::string path_ = disk_ + "/flight.db";
  CountedWait wait_;
  Content on_disk_, in_memory_;
  Arena sqlite_;  // of a host: SQLite has the system's heap
  alignas(Arena::alignment) static inline std::byte memory_[limits::ram_store_bytes];
};

TEST_F(MemoryReturn, AStartWaitsForADiskThatComesSoon) {
  unmount();
  wait_.repair = [&](int attempts) {
    if (attempts == 3) mount();
  };
  const auto store = make();
  MissionParameters mission;
  ASSERT_OK(store->open(path_.c_str(), StoreTrouble::fly_on, mission, &wait_));
  EXPECT_OK(store->updates());
  EXPECT_EQ((store->start().opened_late).code, StatusCode::store_opened_late);
  EXPECT_EQ(store->start().opened_late.a, 3);
  EXPECT_EQ(wait_.faults_, (std::set<StatusCode>{StatusCode::store_error}));
  live_on_disk(store->store());
  EXPECT_TRUE(fs::exists(path_ + "-wal")) << "it flies on the disk";
}

TEST_F(MemoryReturn, ADiskThatStaysAwayIsTriedForALimitedTime) {
  unmount();
  const auto store = make();
  MissionParameters mission;
  ASSERT_OK(store->open(path_.c_str(), StoreTrouble::fly_on, mission, &wait_));
  EXPECT_EQ(wait_.attempts_, start_attempts - 1);
  EXPECT_STATUS(store->updates(), store_in_memory);
  EXPECT_OK(store->start().opened_late);
}

TEST_F(MemoryReturn, AVerdictOnTheContentIsNotWaitedFor) {
  std::ofstream(path_) << std::string(10'000, 'x');
  const auto store = make();
  MissionParameters mission;
  ASSERT_OK(store->open(path_.c_str(), StoreTrouble::fly_on, mission, &wait_));
  EXPECT_EQ(wait_.attempts_, 0);
  EXPECT_STATUS(store->updates(), store_set_aside);
}

TEST_F(MemoryReturn, WithoutAnEarlierStoreEpochTheDatabaseIsWhatWasInMemory) {
  fly_both(20, false);
  const auto store = start();
  EXPECT_EQ((store->start().moved).code, StatusCode::store_back_on_disk);
  EXPECT_EQ(store->start().moved.b, 0);
  const Content content = content_of(store->store());
  expect_memory_in(content);
  EXPECT_EQ(store->start().moved.a, static_cast<std::int64_t>(content.size()));
  EXPECT_EQ(count_memory_copies(path_.c_str()), 0);
  // What comes now is on the disk.
  test::in_transaction(store->store(), [&] { put_event(store->store(), memory_base + 1000); });
  store->close();
  const auto again = start();
  EXPECT_OK(again->start().moved);
  EventRecord event;
  EXPECT_OK(get(again->store(), memory_base + 1000, event));
}

TEST_F(MemoryReturn, BothStoreEpochsAreInTheDatabaseAndTheLaterOneGoesOn) {
  fly_both(20);
  const auto store = start();
  Store& database = store->store();
  EXPECT_EQ((store->start().moved).code, StatusCode::store_back_on_disk);
  const Content content = content_of(database);
  expect_memory_in(content);
  // Nothing of the earlier store epoch has changed but what is stated here.
  const std::set<RecordType> of_one_store_epoch = {RecordType::identity, RecordType::checkpoint, RecordType::storage,
                                                   RecordType::setting};
  for (const auto& [key, bytes] : on_disk_) {
    if (of_one_store_epoch.count(key.first) != 0 || key.first == RecordType::downlink || key.first == RecordType::place)
      continue;
    const auto found = content.find(key);
    ASSERT_NE(found, content.end()) << record_info(key.first).name << ' ' << key.second;
    const bool handed_in = key.first == RecordType::frame && key.second >= 3;
    const bool ended = key.first == RecordType::strip;
    if (handed_in || ended) continue;
    EXPECT_EQ(found->second, bytes) << record_info(key.first).name << ' ' << key.second;
  }
  StripRecord strip;
  ASSERT_OK(get(database, 1, strip));
  EXPECT_EQ(strip.end, StripEnd::overlap_lost);
  PlaceRecord place;
  EXPECT_STATUS(get(database, 1, place), not_found) << "its slot belongs to another place";

  // Images without a product follow as new frames: of 3, 5 and 6; that of 4 is coded.
  std::vector<std::int64_t> later;
  for (const std::int64_t id : ids_of<FrameRecord>(database)) {
    if (id > memory_base + 20) later.push_back(id);
  }
  ASSERT_EQ(later, (std::vector<std::int64_t>{memory_base + 21, memory_base + 22, memory_base + 23}));
  const std::int64_t images[] = {3, 5, 6};
  for (std::size_t i = 0; i < 3; ++i) {
    FrameRecord frame;
    ASSERT_OK(get(database, later[i], frame));
    EXPECT_EQ(frame.time_ns, 1000 * images[i]);
    Bytes image(frame.image.bytes);
    ASSERT_OK(read_blob<FrameRecord>(database, "image", frame.id, 0, image));
    EXPECT_EQ(image, image_of(images[i]));
    ASSERT_OK(get(database, images[i], frame));
    EXPECT_EQ(frame.image.bytes, 0U);
  }

  // Files keep what is known of them. What had not been sent is noted as not confirmed.
  std::vector<DownlinkRecord> files;
  for (const std::int64_t id : ids_of<DownlinkRecord>(database)) {
    DownlinkRecord file;
    ASSERT_OK(get(database, id, file));
    files.push_back(file);
  }
  ASSERT_EQ(files.size(), 7U);
  EXPECT_GT(files.front().id, memory_base);
  EXPECT_EQ(files[0].acknowledged_ns, 77);
  EXPECT_EQ(files[1].subject_id, product_id(1, ProductKind::image));
  EXPECT_EQ(files[1].acknowledged_ns, 0);
  EXPECT_EQ(files[3].subject_id, 2) << "records of the keyframe that was coded and not sent";
  const std::int64_t events[] = {-1, -65, -129};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(files[4 + i].subject_id, events[i]);

  // Without the nonvolatile memory a store epoch in memory has only its own settings, here none by telecommand.
  SettingRecord setting;
  EXPECT_OK(get(database, 4, setting));
}

TEST_F(MemoryReturn, SettingsOfTheDiskStayWhereTheFlightInMemoryDidNotKnowThem) {
  {
    const auto store = start();
    live_on_disk(store->store());
    IdentityRecord identity;
    ASSERT_OK(get(store->store(), 1, identity));
    identity.configuration = 5;
    test::write_records(store->store(), identity);
  }
  fly_both(4, false);
  const auto store = start();
  SettingRecord setting;
  EXPECT_OK(get(store->store(), 3, setting));
  EXPECT_OK(get(store->store(), 4, setting));
  IdentityRecord identity;
  ASSERT_OK(get(store->store(), 1, identity));
  EXPECT_EQ(identity.life, 2);
  EXPECT_GE(identity.configuration, 5) << "or the nonvolatile memory would revert what was set in memory";
}

TEST_F(MemoryReturn, APowerCutWhileTheDatabaseTakesTheRecordsInLosesNothing) {
  fly_both(300);
  remember();
  Content whole;
  {
    const auto store = start();
    whole = content_of(store->store());
  }
  std::set<std::int64_t> seen;
  bool finished = false;
  int call = 1;
  for (int round = 0; round < 60 && !finished; ++round, call += 1 + call / 4) {
    restore();
    finished = !test::cut_in_call(disk_, call, [&] {
      MissionParameters mission;
      (void)make()->open(path_.c_str(), StoreTrouble::fly_on, mission);
    });
    {
      SqliteStore half;
      std::int64_t records = 0;
      if (half.open(path_.c_str()).ok()) {
        EXPECT_OK(half.count(record_info(RecordType::frame), records));
      }
      seen.insert(records);
    }
    const auto store = start();
    EXPECT_OK(store->updates());
    EXPECT_EQ(content_of(store->store()), whole) << "round " << round;
    EXPECT_EQ(count_memory_copies(path_.c_str()), 0);
  }
  EXPECT_TRUE(finished);
  EXPECT_GT(seen.size(), 2U) << "always cut at the same place";
}

TEST_F(MemoryReturn, APowerCutWhileTheRecordsLeaveMemoryLeavesTheDiskAsItWasOrHasThemAll) {
  {
    const auto store = start();
    live_on_disk(store->store());
    on_disk_ = content_of(store->store());
  }
  remember();
  std::set<bool> seen;
  bool finished = false;
  int call = 1;
  for (int round = 0; round < 60 && !finished; ++round, call += 1 + call / 4) {
    restore();
    finished = !test::cut_in_call(disk_, call, [&] {
      MissionParameters mission;
      const auto store = make();
      if (!store->begin_in_memory(mission).ok()) return;
      live_in_memory(store->store(), 300);
      if (try_disk(path_.c_str(), capacity).ok()) (void)store->leave_memory(path_.c_str(), nullptr);
    });
    const auto store = start();
    const bool all = store->start().moved.is(StatusCode::store_back_on_disk);
    seen.insert(all);
    EXPECT_TRUE(all || store->start().moved.ok()) << "a part of a copy has the name of a whole one";
    EventRecord event;
    EXPECT_EQ(get(store->store(), memory_base + 300, event).ok(), all);
    if (!all) {
      EXPECT_EQ(content_of(store->store()), on_disk_) << "round " << round;
    }
  }
  EXPECT_TRUE(finished);
  EXPECT_EQ(seen.size(), 2U);
}

TEST_F(MemoryReturn, ADiskThatFailsAgainLeavesTheFlightInMemory) {
  unmount();
  const auto store = start();
  live_in_memory(store->store(), 40);
  const Content before = content_of(store->store());
  EXPECT_STATUS(try_disk(path_.c_str(), capacity), io_error);
  EXPECT_STATUS(store->leave_memory(path_.c_str(), &wait_), io_error);
  mount();
  // A disk that becomes full at any place of the file.
  signal(SIGXFSZ, SIG_IGN);
  rlimit before_limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before_limit), 0);
  for (const rlim_t most : {rlim_t{0}, rlim_t{1}, rlim_t{5000}, rlim_t{100'000}, rlim_t{400'000}}) {
    const rlimit limit{most, before_limit.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
    const Status tried = try_disk(path_.c_str(), capacity);
    const Status left = store->leave_memory(path_.c_str(), &wait_);
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before_limit), 0);
    EXPECT_STATUS(tried, io_error) << most;
    EXPECT_STATUS(left, io_error) << most;
    EXPECT_TRUE(fs::is_empty(disk_)) << "the room is given back";
    EXPECT_EQ(content_of(store->store()), before);
  }
  in_memory_ = before;
  ASSERT_OK(store->leave_memory(path_.c_str(), &wait_));
  EXPECT_GT(wait_.kicks_, 0);
  const auto back = start();
  EXPECT_EQ((back->start().moved).code, StatusCode::store_back_on_disk);
  expect_memory_in(content_of(back->store()));
}

TEST_F(MemoryReturn, ADiskIsLookedForUntilItServesAndAgainWhenAsked) {
  static DiskProbe look;
  static const std::string path = path_;
  unmount();
  const auto store = start();
  ASSERT_EQ(store->look_stack().size(), disk_probe_stack_bytes);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(store->look_stack().data()) % stack_page_bytes, 0U);
  EXPECT_LE(store->store().usage().limit_bytes,
            static_cast<std::int64_t>(limits::ram_store_bytes - disk_probe_stack_bytes));
  alignas(stack_page_bytes) static std::byte stack[disk_probe_stack_bytes];
  ASSERT_EQ(look.begin(path.c_str(), capacity, stack, ns_per_ms), 0);
  const timespec nap{0, 5'000'000};
  for (int i = 0; i < 10; ++i) nanosleep(&nap, nullptr);
  EXPECT_FALSE(look.found());
  mount();
  const auto comes = [&] {
    for (int i = 0; i < 2000 && !look.found(); ++i) nanosleep(&nap, nullptr);
    return look.found();
  };
  EXPECT_TRUE(comes());
  EXPECT_EQ(fs::file_size(path_ + ".memory-part"), static_cast<std::uintmax_t>(capacity)) << "the room for the records";
  look.probe_again();
  EXPECT_TRUE(comes());
}

TEST_F(MemoryReturn, TwoStoreEpochsInMemoryFollowEachOther) {
  fly_both(10);
  {
    const auto store = make();
    MissionParameters mission;
    ASSERT_OK(store->begin_in_memory(mission));
    live_in_memory(store->store(), 12, 3, 2 * memory_base);
    ASSERT_OK(store->leave_memory(path_.c_str(), &wait_));
  }
  EXPECT_EQ(count_memory_copies(path_.c_str()), 2);
  const auto store = start();
  EXPECT_EQ((store->start().moved).code, StatusCode::store_back_on_disk);
  EXPECT_EQ(count_memory_copies(path_.c_str()), 0);
  IdentityRecord identity;
  ASSERT_OK(get(store->store(), 1, identity));
  EXPECT_EQ(identity.life, 3);
  EventRecord event;
  for (const std::int64_t id : {std::int64_t{150}, memory_base + 10, 2 * memory_base + 12}) {
    EXPECT_OK(get(store->store(), id, event));
  }
}

TEST_F(MemoryReturn, AnEarlierCopyThatStillWaitsIsTakenInFirst) {
  fly_both(10);
  // The one before it has been taken in.
  fs::rename(memory_copy_path(path_.c_str(), 1).c_str(), memory_copy_path(path_.c_str(), 2).c_str());
  {
    const auto store = make();
    MissionParameters mission;
    ASSERT_OK(store->begin_in_memory(mission));
    live_in_memory(store->store(), 12, 3, 2 * memory_base);
    ASSERT_OK(store->leave_memory(path_.c_str(), &wait_));
  }
  const auto store = start();
  EXPECT_TRUE(store->updates().ok()) << "nothing is quarantined";
  EventRecord event;
  for (const std::int64_t id : {std::int64_t{150}, memory_base + 10, 2 * memory_base + 12}) {
    EXPECT_OK(get(store->store(), id, event));
  }
}

TEST_F(MemoryReturn, AtMostFourCopiesWait) {
  const auto store = make();
  MissionParameters mission;
  ASSERT_OK(store->begin_in_memory(mission));
  live_in_memory(store->store(), 2);
  for (std::int64_t n = 0; n < max_memory_copies; ++n) ASSERT_OK(store->leave_memory(path_.c_str(), nullptr));
  EXPECT_STATUS(store->leave_memory(path_.c_str(), nullptr), capacity_exceeded);
  EXPECT_EQ(count_memory_copies(path_.c_str()), max_memory_copies);
}

TEST_F(MemoryReturn, ACopyThatIsNotWholeIsKeptAndNotUsed) {
  fly_both(10);
  const std::string copy = memory_copy_path(path_.c_str(), 1).c_str();
  {
    std::fstream file(copy, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(1000);
    file.put('\x55');
  }
  const auto store = start();
  EXPECT_OK(store->start().moved);
  EXPECT_STATUS(store->start().not_moved, store_not_moved);
  EXPECT_EQ(store->start().not_moved.a, static_cast<std::int64_t>(StatusCode::record_damaged));
  EXPECT_EQ(content_of(store->store()), on_disk_);
  EXPECT_TRUE(fs::exists(copy + ".refused"));
}

TEST_F(MemoryReturn, ACopyThatTheDiskDoesNotReadDoesNotKeepTheOthersFromTheDatabase) {
  fly_both(10);
  const std::string second = memory_copy_path(path_.c_str(), 2).c_str();
  fs::rename(memory_copy_path(path_.c_str(), 1).c_str(), second);
  const std::string first = memory_copy_path(path_.c_str(), 1).c_str();
  for (int round = 0; round < 2; ++round) {
    // A folder can be opened, and not read.
    fs::create_directory(first);
    const auto store = make();
    MissionParameters mission;
    ASSERT_OK(store->open(path_.c_str(), StoreTrouble::fly_on, mission, &wait_));
    EXPECT_OK(store->updates()) << "it flies on the disk";
    EXPECT_EQ(wait_.attempts_, start_attempts - 1);
    EXPECT_STATUS(store->start().not_moved, store_not_moved);
    EXPECT_EQ(store->start().not_moved.a, static_cast<std::int64_t>(StatusCode::io_error));
    EXPECT_EQ(store->start().moved.is(StatusCode::store_back_on_disk), round == 0);
    expect_memory_in(content_of(store->store()));
  }
  EXPECT_TRUE(fs::exists(first + ".refused"));
  EXPECT_TRUE(fs::exists(first + ".refused-2"));
  EXPECT_FALSE(fs::exists(second));
}

TEST_F(MemoryReturn, ThePrimaryOfSeveralProcessesTakesCopiesInToo) {
  fly_both(10, false);
  const auto store = make();
  MissionParameters mission;
  ASSERT_OK(store->open_as_primary(path_.c_str(), StoreTrouble::fly_on, Synchronise::behind_commit, mission));
  EXPECT_STATUS(store->start().moved, store_back_on_disk);
  expect_memory_in(content_of(store->store()));
}

TEST_F(MemoryReturn, AStartRemovesWhatAPowerCutHasLeftUnfinished) {
  std::ofstream(path_ + ".memory-part") << std::string(10'000, 'x');
  const auto store = start();
  EXPECT_OK(store->updates());
  EXPECT_FALSE(fs::exists(path_ + ".memory-part"));
}

TEST_F(MemoryReturn, ADiskWithoutTheRoomIsNotWritten) {
  EXPECT_STATUS(try_disk(path_.c_str(), std::int64_t{1} << 60), io_error);
  EXPECT_TRUE(fs::is_empty(disk_));
}

TEST_F(MemoryReturn, WhereNumbersWouldMeetTheEarlierDatabaseIsSetAside) {
  {
    const auto store = start();
    live_in_memory(store->store(), 5, 7, 3 * memory_base);
  }
  fly_both(10, false);
  const auto store = start();
  EXPECT_STATUS(store->updates(), store_set_aside);
  EXPECT_EQ((store->start().moved).code, StatusCode::store_back_on_disk);
  expect_memory_in(content_of(store->store()));
  EXPECT_TRUE(fs::exists(path_ + ".aside-1"));
}

}  // namespace
}  // namespace ilp
