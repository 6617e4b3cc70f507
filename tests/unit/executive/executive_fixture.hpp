// Three components that do what a test sets, under an executive on a store in memory.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fsw/executive/executive.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "tests/support/failing_store.hpp"
#include "tests/support/fake_clock.hpp"
#include "tests/support/store_records.hpp"

namespace ilp::test {

/// Does what the test sets, and writes its letter into the common diary.
class FakeComponent final : public Component {
 public:
  FakeComponent(const char* name, std::string& diary) : name_(name), diary_(diary) {}
  [[nodiscard]] const char* name() const override { return name_; }
  Status restore() override {
    ++restores;
    return on_restore ? on_restore() : Status{};
  }
  StepResult step() override {
    ++steps;
    diary_ += name_;
    return on_step ? on_step() : StepResult{};
  }

  [[nodiscard]] LastingMemory lasting() const override {
    return keeps != nullptr ? LastingMemory().keeping(*keeps) : LastingMemory();
  }

  int steps = 0;
  int restores = 0;
  const std::int64_t* keeps = nullptr;  ///< what lasts in its memory
  std::function<StepResult()> on_step;
  std::function<Status()> on_restore;

 private:
  const char* name_;
  std::string& diary_;
};

/// Three components: `a` runs in every frame, `b` is woken by frames, `c` by overlaps and in every third frame.
class ExecutiveTest : public testing::Test {
 protected:
  static constexpr TimeNs budget = 20 * ns_per_ms;

  void start() {
    ASSERT_TRUE(executive.start().ok());
    // Every component is woken once at the start; the tests begin after that.
    executive.run_minor_frame();
    next_frame();
    diary.clear();
  }
  /// Another executive, from now on.
  void assemble(const ExecutiveSetup& setup) {
    std::destroy_at(&executive);
    std::construct_at(&executive, stages, components, lockable, clock, setup);
    begin_ns = clock.now();
  }
  void next_frame() { clock.sleep_until(begin_ns + executive.frames_run() * minor_frame_ns); }
  void run_frames(int count) {
    for (int i = 0; i < count; ++i) {
      executive.run_minor_frame();
      next_frame();
    }
  }
  template <typename Record>
  void write(std::int64_t id) {
    Record record;
    record.id = id;
    test::write_records(store, record);
  }
  std::vector<EventRecord> events(StatusCode code) { return test::events_of(store, code); }
  const ComponentStats& stats(std::size_t i) const { return executive.stats(static_cast<ComponentId>(i + 1)); }

  std::vector<std::byte> region = std::vector<std::byte>(std::size_t{8} << 20U);
  RamStore store{region};
  FailingStore lockable{store};  ///< as executive and components see the store
  FakeClock clock;
  std::string diary;
  FakeComponent a{"a", diary}, b{"b", diary}, c{"c", diary};
  std::array<Component*, 3> components{&a, &b, &c};
  std::array<Stage, 3> stages{
      Stage{.component = ComponentId{1}, .name = "a", .period = 1, .budget_ns = budget},
      Stage{.component = ComponentId{2}, .name = "b", .wakes = mask_of(RecordType::frame), .budget_ns = budget},
      Stage{.component = ComponentId{3},
            .name = "c",
            .wakes = mask_of(RecordType::overlap),
            .period = 3,
            .budget_ns = budget},
  };
  MissionParameters mission;
  TimeNs begin_ns = 0;
  Executive executive{stages, components, lockable, clock};
};

}  // namespace ilp::test
