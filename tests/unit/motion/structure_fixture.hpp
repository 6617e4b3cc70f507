// Keyframes over terrain given by a formula, for structure and motion under the real executive.
#pragma once

#include <memory>
#include <vector>

#include "fsw/motion/structure_and_motion.hpp"
#include "tests/support/level_plane.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/unit/shared/executed_component.hpp"
#include "tests/unit/vision/stereo/analytic_scene.hpp"

namespace ilp::test {

inline constexpr std::int64_t keyframes = 9;
inline constexpr double height = 100;
inline constexpr double step_m = 12;

inline double rugged(double x, double y) {
  return 9 * std::sin(x / 15) * std::cos(y / 12) + 4 * std::sin((x + y) / 7);
}

/// As rendered once for all tests.
inline const std::vector<View>& views() {
  static const std::vector<View> rendered = [] {
    std::vector<View> made;
    for (std::int64_t i = 0; i < keyframes; ++i) {
      const Vec3 centre(step_m * static_cast<double>(i), 0.5 * static_cast<double>(i % 3), height);
      made.push_back(
          render_view(distorting_camera(), looking_down(centre), rugged, 2, 1, static_cast<std::uint64_t>(i + 1)));
    }
    return made;
  }();
  return rendered;
}

class StructureFixture : public ComponentTest {
 protected:
  explicit StructureFixture(const std::vector<View>& seen = views()) : seen_(seen) {
    mission.window_keyframes = 4;
    write(camera_record(seen_[0].camera));
    for (std::int64_t id = 1; id <= keyframes; ++id) add(id);
    end_strip(StripEnd::end_of_flight);
  }

  void add(std::int64_t id) {
    const View& view = seen_[static_cast<std::size_t>(id - 1)];
    write_frame(id, view.image);
    KeyframeRecord keyframe{
        .id = id, .frame_id = id, .strip_id = 1, .index = static_cast<std::int32_t>(id - 1), .altitude = height};
    if (id > 1) put_level_plane(seen_[static_cast<std::size_t>(id - 2)], view, keyframe);
    write(keyframe);
  }
  void end_strip(StripEnd end) {
    StripRecord strip{.id = 1, .first_keyframe_id = 1, .last_keyframe_id = keyframes, .end = end};
    write(strip);
  }
  void release_image(std::int64_t id) {
    auto frame = read<FrameRecord>(id);
    frame.image.bytes = 0;
    write(frame);
  }
  void command_restart() {
    CommandRecord command{.id = number_of<CommandRecord>() + 1, .kind = CommandKind::restart, .subject_id = 1};
    write(command);
  }
  [[nodiscard]] std::int64_t strip_ends_commanded() {
    std::int64_t count = 0;
    for (const CommandRecord& command : records_of<CommandRecord>(store))
      count += command.kind == CommandKind::end_strip ? 1 : 0;
    return count;
  }
  [[nodiscard]] PoseState state(std::int64_t id) {
    PoseRecord pose;
    return get(store, id, pose).ok() ? pose.state : PoseState::count;
  }
  [[nodiscard]] std::int64_t finals() {
    std::int64_t count = 0;
    for (std::int64_t id = 1; id <= keyframes; ++id) count += state(id) == PoseState::final ? 1 : 0;
    return count;
  }
  /// Poses and points of an undisturbed flight; the store is as it was before.
  struct Result {
    std::vector<std::vector<std::uint8_t>> poses, structures;
    bool operator==(const Result&) const = default;
  };
  [[nodiscard]] Result result() { return {all_of<PoseRecord>(store), all_of<StructureRecord>(store)}; }
  /// From a start until nothing is left to do.
  void run_to_the_end() {
    ExecutedComponent run(*component, store);
    ASSERT_TRUE(run.start().ok());
    ASSERT_TRUE(run.run());
  }
  Result undisturbed() {
    run_to_the_end();
    Result found = result();
    EXPECT_EQ(found.poses.size(), static_cast<std::size_t>(keyframes));
    EXPECT_EQ(finals(), keyframes);
    forget();
    return found;
  }
  /// More steps in every boot, so that each of them is the last one of some boot.
  void fly_in_short_boots() {
    for (int boot = 0; boot < 200 && finals() < keyframes; ++boot) {
      component = std::make_unique<StructureAndMotion>(failing, mission, test::step_memory<StructureAndMotion>());
      ASSERT_TRUE(component->restore().ok());
      for (int step = 0; step < 3 + 2 * boot; ++step) ASSERT_TRUE(component->step().status.ok());
    }
  }
  void forget() {
    const auto erase = [&](RecordType type) {
      std::vector<std::int64_t> ids;
      alignas(8) std::uint8_t record[limits::max_record_bytes];
      std::int64_t id = 0;
      while (store.next(record_info(type), id, record).ok()) ids.push_back(id = id_of(record));
      Transaction transaction(store);
      ASSERT_TRUE(transaction.begin().ok());
      for (const std::int64_t one : ids) ASSERT_TRUE(store.erase(record_info(type), one).ok());
      ASSERT_TRUE(transaction.commit().ok());
    };
    for (const RecordType type :
         {RecordType::pose, RecordType::structure, RecordType::checkpoint, RecordType::command, RecordType::event}) {
      erase(type);
    }
  }
  /// Until `posed` keyframes have a pose.
  static void run_until(ExecutedComponent& run, Store& store, std::int64_t posed) {
    std::int64_t count = 0;
    while (store.count(record_info<PoseRecord>(), count).ok() && count < posed) run.frame();
  }
  std::vector<CheckpointRecord> checkpoints() { return records_of<CheckpointRecord>(store); }
  void flip_a_bit_of(const CheckpointRecord& record) {
    std::uint8_t byte = 0;
    in_transaction(store, [&] {
      ASSERT_TRUE(read_blob<CheckpointRecord>(store, "state", record.id, 5000, {&byte, 1}).ok());
      byte ^= 4U;
      ASSERT_TRUE(write_blob<CheckpointRecord>(store, "state", record.id, 5000, {&byte, 1}).ok());
    });
  }

  const std::vector<View>& seen_;
  FailingStore failing{store};
  std::unique_ptr<StructureAndMotion> component =
      std::make_unique<StructureAndMotion>(failing, mission, test::step_memory<StructureAndMotion>());
};

}  // namespace ilp::test
