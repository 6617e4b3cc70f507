// Each stage alone, on the inputs of a recorded flight: it writes what it wrote in the flight, byte for byte, its
// checkpoints included. It writes the same wherever its process ends in between.

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <optional>

#include "hal/store/ram/ram_store.hpp"
#include "sim/tools/lab/stage_range.hpp"
#include "tests/stages/recorded_flight.hpp"

namespace ilp::test {
namespace {

enum class Stop : std::uint8_t {
  never,
  before_writes,  ///< each transaction is cut off before its commit
  after_writes    ///< the process ends after each step that has written
};

/// A stage, a store with what the others had written at the time, and the world as it was.
class Replay {
 public:
  Replay(ComponentId stage, CameraKnown known, Stop stop)
      : stage_(stage), flight_(recorded_flight(known)), stop_(stop), mission_(flight_.mission) {
    store_.before_commit = [this] { return cutting_ ? Status{StatusCode::io_error} : Status{}; };
    store_.committed = [this](const Writes& writes) {
      written_.push_back(writes);
      camera_mark_ = camera_.given();
    };
  }

  /// Everything that the stage wrote in the flight has been written again.
  void run() {
    make();
    for (std::size_t i = 0; i < flight_.events.size(); ++i) {
      const Event& event = flight_.events[i];
      const bool own = event.stage == place_of(stage_);
      if (event.kind == Event::Kind::commit) {
        if (own) continue;
        ASSERT_TRUE(apply_writes(ram_, event.writes).ok());
      } else if (own) {
        clock_.sleep_until(event.time);
        const std::size_t before = expected_.size();
        for (std::size_t k = i + 1; k < flight_.events.size() && is_own_commit(flight_.events[k]); ++k) {
          expected_.push_back(&flight_.events[k].writes);
        }
        call(event.kind, expected_.size() > before);
        ASSERT_NO_FATAL_FAILURE(compare());
      }
    }
    const bool may_write_more = stage_ == ComponentId::scrubber && stop_ != Stop::never;
    EXPECT_TRUE(written_.size() == expected_.size() || may_write_more);
  }
  [[nodiscard]] std::size_t transactions() const { return written_.size(); }

 private:
  [[nodiscard]] bool is_own_commit(const Event& event) const {
    return event.kind == Event::Kind::commit && event.stage == place_of(stage_);
  }

  void call(Event::Kind kind, bool writes) {
    if (kind == Event::Kind::restore) {
      EXPECT_TRUE(restored(component().restore()));
      return;
    }
    if (stop_ == Stop::before_writes && writes) {
      cutting_ = true;
      for (int steps = 0; cutting_ && steps < most_steps; ++steps) cutting_ = step().status.ok();
      cutting_ = false;
      make();
      EXPECT_TRUE(restored(component().restore()));
    }
    step();
    // Another start does again what several steps had done.
    for (int steps = 0; stop_ != Stop::never && written_.size() < expected_.size() && steps < most_steps; ++steps) {
      if (stage_ == ComponentId::scrubber) take_time();
      step();
    }
    if (stop_ == Stop::after_writes && writes) {
      make();
      EXPECT_TRUE(restored(component().restore()));
    }
  }

  /// Other stages have used the memory that they share since the stage's previous step, unless that one keeps it. The
  /// scrubber, which steps many times, has none.
  StepResult step() {
    rubbish_ = rubbish_ * 5 + 1;
    if (stage_ != ComponentId::scrubber && !keeps_)
      std::memset(&shared_->step.bytes, static_cast<int>(rubbish_ >> 24U), shared_->step.bytes.size());
    const LastingMemory before = component().lasting();
    const std::uint64_t state = before.is_at_rest() ? before.state_checksum() : 0;
    const StepResult result = component().step();
    if (before.is_at_rest()) {
      EXPECT_EQ(component().lasting().state_checksum(), state) << "it said that it would not change it";
    }
    keeps_ = result.then == Then::keep;
    return result;
  }

  /// The scrubber reads what belongs to the time since its previous step.
  void take_time() {
    constexpr TimeNs time = stage_of(ComponentId::scrubber).period * minor_frame_ns;
    clock_.set(clock_.now() - time);
    step();
    clock_.sleep_until(clock_.now() + time);
  }

  /// After a restart it reads a little twice, so that it saves other places, and at other times: one after the other.
  void compare_saves() const {
    EXPECT_GE(written_.size(), expected_.size());
    for (std::size_t i = 0; i < written_.size(); ++i) {
      CheckpointRecord saved;
      ASSERT_EQ(written_[i].size(), 2U);
      ASSERT_EQ(written_[i][0].type, RecordType::checkpoint);
      std::memcpy(&saved, written_[i][0].record.data(), sizeof(saved));
      EXPECT_EQ(saved.cursor, static_cast<std::int64_t>(i) + 1);
    }
  }

  void compare() {
    if (stage_ == ComponentId::scrubber && stop_ != Stop::never) return compare_saves();
    ASSERT_LE(written_.size(), expected_.size()) << "it writes what it did not write in the flight";
    ASSERT_TRUE(stop_ != Stop::never || written_.size() == expected_.size());
    for (; compared_ < written_.size(); ++compared_) {
      const Writes& is = written_[compared_];
      const Writes& was = *expected_[compared_];
      ASSERT_EQ(is.size(), was.size()) << "writes of transaction " << compared_;
      for (std::size_t i = 0; i < is.size(); ++i) {
        const StateBytes states = stop_ == Stop::never ? StateBytes::compared : StateBytes::passed_over;
        ASSERT_TRUE(is[i].same(was[i], states))
            << was[i].name() << " in transaction " << compared_ << ", now " << is[i].name();
      }
    }
  }

  void make() {
    camera_.go_to(camera_mark_);
    object_.reset();
    object_.emplace(stage_, lab::StageWorld{store_, clock_, mission_, &camera_, &link_}, *shared_);
    keeps_ = false;
  }
  [[nodiscard]] Component& component() { return object_->component(); }

  static constexpr int most_steps = 5000;

  ComponentId stage_;
  const Recording& flight_;
  Stop stop_;
  MissionParameters mission_;
  std::vector<std::byte> region_ = std::vector<std::byte>(std::size_t{48} << 20U);
  RamStore ram_{region_};
  RecordingStore store_{ram_};
  StillClock clock_;
  RecordedCamera camera_;
  std::size_t camera_mark_ = 0;
  ConfirmingLink link_;
  std::unique_ptr<lab::RangeMemory> shared_ = std::make_unique<lab::RangeMemory>(clock_, mission_);
  std::optional<lab::StageObject> object_;
  std::uint32_t rubbish_ = 1;
  bool cutting_ = false, keeps_ = false;
  std::vector<Writes> written_;
  std::vector<const Writes*> expected_;
  std::size_t compared_ = 0;
};

class StageReplay : public testing::TestWithParam<ComponentId> {
 protected:
  void replay(Stop stop) const {
    Replay replay(GetParam(), CameraKnown::yes, stop);
    replay.run();
    EXPECT_GT(replay.transactions(), 0U) << "the flight gives it nothing to do";
    // A camera that is looked for is more work for the calibrator, and lets the next stages wait.
    if (GetParam() == ComponentId::camera_calibrator || GetParam() == ComponentId::structure_and_motion) {
      Replay(GetParam(), CameraKnown::no, stop).run();
    }
  }
};

TEST_P(StageReplay, AloneItWritesTheSameBytes) {
  replay(Stop::never);
}

TEST_P(StageReplay, AStopBeforeEachWriteChangesNoByte) {
  replay(Stop::before_writes);
}

TEST_P(StageReplay, AStopAfterEachWriteChangesNoByte) {
  replay(Stop::after_writes);
}

INSTANTIATE_TEST_SUITE_P(Stages, StageReplay,
                         testing::Values(ComponentId::capture_clock, ComponentId::acquisition,
                                         ComponentId::overlap_checker, ComponentId::camera_calibrator,
                                         ComponentId::structure_and_motion, ComponentId::dense_matcher,
                                         ComponentId::richness_scorer, ComponentId::compressor,
                                         ComponentId::storage_manager, ComponentId::downlink, ComponentId::scrubber),
                         [](const auto& about) { return std::string(stage_of(about.param).name); });

}  // namespace
}  // namespace ilp::test
