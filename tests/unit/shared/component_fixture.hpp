// A store in memory, a clock that the test moves, and the few moves that every component test makes.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "cfg/mission.hpp"
#include "fsw/executive/component.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "tests/support/fake_clock.hpp"
#include "tests/support/store_records.hpp"

namespace ilp::test {

class ComponentTest : public testing::Test {
 protected:
  template <typename Record>
  void write(const Record& record, const char* field = nullptr, std::span<const std::uint8_t> bytes = {}) {
    in_transaction(store, [&] {
      ASSERT_TRUE(put(store, record).ok());
      if (field == nullptr) return;
      ASSERT_TRUE(write_blob<Record>(store, field, record.id, 0, bytes).ok());
    });
  }
  /// A frame with its image, which has width, height and pixels.
  template <typename Image>
  void write_frame(std::int64_t id, const Image& image, TimeNs time_ns = 0) {
    FrameRecord frame{.id = id, .time_ns = time_ns, .width = image.width, .height = image.height};
    frame.image.bytes = static_cast<std::uint32_t>(image.pixels.size());
    write(frame, "image", image.pixels);
  }
  template <typename Record>
  Record read(std::int64_t id) {
    Record record;
    const Status status = get(store, id, record);
    EXPECT_TRUE(status.ok()) << record_info<Record>().name << " " << id << ": " << status_name(status.code);
    return record;
  }
  template <typename Record>
  [[nodiscard]] std::int64_t number_of() {
    std::int64_t count = -1;
    EXPECT_TRUE(store.count(record_info<Record>(), count).ok());
    return count;
  }
  /// Steps until nothing is pending; the statuses that were not ok.
  std::vector<Status> run(Component& component, int most_steps = 1000) {
    std::vector<Status> faults;
    for (int i = 0; i < most_steps; ++i) {
      const StepResult result = component.step();
      if (!result.status.ok()) faults.push_back(result.status);
      if (result.then == Then::restore) {
        EXPECT_TRUE(restored(component.restore())) << component.name();
      }
      if (!result.pending) return faults;
    }
    ADD_FAILURE() << component.name() << " never ends";
    return faults;
  }

  /// Makes both generations of every checkpoint unreadable, as flipped bits would.
  void damage_checkpoints(bool newer_only = false) {
    const std::vector<CheckpointRecord> all = records_of<CheckpointRecord>(store);
    for (const CheckpointRecord& one : all) {
      bool newer = true;
      for (const CheckpointRecord& other : all) {
        newer = newer && (other.id % 100 != one.id % 100 || other.generation <= one.generation);
      }
      if (newer_only && !newer) continue;
      CheckpointRecord damaged = one;
      damaged.checksum ^= 1;
      write(damaged);
    }
  }

  std::vector<std::byte> region = std::vector<std::byte>(std::size_t{24} << 20U);
  RamStore store{region};
  FakeClock clock;
  MissionParameters mission;
};

}  // namespace ilp::test
