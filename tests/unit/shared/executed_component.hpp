// One component under the real executive, in front of a store whose calls fail when a test wants them to.
#pragma once

#include <array>

#include "fsw/executive/executive.hpp"
#include "fsw/records/serial.hpp"
#include "hal/store/record_bytes.hpp"
#include "tests/support/failing_store.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp::test {

/// Every step takes 60 ms, so that a minor frame holds two of them.
class TickingClock final : public Clock {
 public:
  TimeNs now() override { return now_; }
  void sleep_until(TimeNs time) override {
    if (time > now_) now_ = time;
  }
  TimeNs processor_time() override { return now_ += 30 * ns_per_ms; }

 private:
  TimeNs now_ = 0;
};

/// The executive takes the component for the first of its table: a command to restart names number 1.
class ExecutedComponent {
 public:
  ExecutedComponent(Component& component, Store& store)
      : components_{&component},
        stages_{Stage{.component = ComponentId{1},
                      .name = "alone",
                      .wakes = ~RecordMask{0} & ~mask_of(RecordType::event),
                      .budget_ns = 100 * ns_per_ms}},
        executive_(stages_, components_, store, clock_) {}

  [[nodiscard]] Status start() { return executive_.start(); }
  void frame() {
    executive_.run_minor_frame();
    clock_.sleep_until(executive_.frames_run() * minor_frame_ns);
  }
  /// Until nothing is left to do; false after too many minor frames.
  [[nodiscard]] bool run(int most_frames = 20'000) {
    for (int i = 0; i < most_frames; ++i) {
      frame();
      if (executive_.idle()) return true;
    }
    return false;
  }
  [[nodiscard]] TimeNs now() { return clock_.now(); }

 private:
  std::array<Component*, 1> components_;
  std::array<Stage, 1> stages_;
  TickingClock clock_;
  Executive executive_;
};

/// All records of a kind, each with the bytes of its blobs.
template <typename Record>
std::vector<std::vector<std::uint8_t>> all_of(Store& store) {
  std::vector<std::vector<std::uint8_t>> records;
  const RecordInfo& info = record_info<Record>();
  for (const Record& record : records_of<Record>(store)) {
    std::vector<std::uint8_t> bytes(serial_bytes(info));
    EXPECT_TRUE(serialize(info, &record, bytes).ok());
    for_each_blob(info, [&](const FieldInfo& field, std::size_t) {
      std::vector<std::uint8_t> data(blob_bytes(&record, field));
      EXPECT_TRUE(data.empty() || store.read_blob(info, field.name, record.id, 0, data).ok());
      bytes.insert(bytes.end(), data.begin(), data.end());
    });
    records.push_back(std::move(bytes));
  }
  return records;
}

}  // namespace ilp::test
