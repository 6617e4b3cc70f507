// A flight whose disk fails with a reset and comes back: three store epochs with images, and one history.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "sim/world/flight.hpp"
#include "sim/world/renderer.hpp"
#include "sim/world/scenario.hpp"
#include "sim/world/terrain.hpp"
#include "tests/integration/flight_board.hpp"
#include "tests/support/store_records.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
namespace {

namespace fs = std::filesystem;

constexpr TimeNs interval_ns = 3 * ns_per_s;

/// Gives the images of a simulated flight one after the other, whatever the time.
class PassingCamera final : public Camera {
 public:
  PassingCamera() {
    model.width = 160, model.height = 120;
    model.fx = model.fy = 137;
    model.cx = 79.5, model.cy = 59.5;
    scenario_.effects.read_noise_grey = 1;
    scenario_.flight.camera = model;
    scenario_.flight.frames = 60;
    scenario_.flight.interval_s = 1e-9 * static_cast<double>(interval_ns);
    exposures_ = world::Trajectory(scenario_.flight).exposures();
  }
  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override {
    // Mission time of another store epoch may begin again.
    next_ = std::min(next_, now + interval_ns);
    if (given == wanted || now < next_) return StatusCode::not_ready;
    const world::Terrain terrain(scenario_.world);
    const world::Trajectory trajectory(scenario_.flight);
    const world::Renderer renderer(terrain, model, scenario_.effects, scenario_.flight.seed);
    world::RenderedFrame picture;
    renderer.render(trajectory.motion(exposures_[given]), static_cast<std::int64_t>(given), picture);
    ILP_TRY(image.resize(picture.grey.width, picture.grey.height));
    std::copy(picture.grey.samples.begin(), picture.grey.samples.end(), image.view().data);
    frame = {};
    frame.time_ns = now;
    frame.sequence = static_cast<std::int64_t>(++given);
    copy_text(frame.name, std::to_string(given).c_str());
    next_ = now + interval_ns;
    return {};
  }
  [[nodiscard]] bool restarts_counter() const override { return true; }

  CameraModel model;
  std::size_t given = 0, wanted = 1000;
  TimeNs next_ = 0;

 private:
  world::Scenario scenario_;
  std::vector<std::int64_t> exposures_;
};

class BackToDisk : public testing::Test {
 protected:
  BackToDisk() {
    board_.eye = &camera_;
    board_.model = camera_.model;
    board_.mission_file.confirmation_timeout_s = 100;
    board_.mission_file.link_bytes_per_s = 20000;
  }
  void unmount() { fs::rename(board_.folder.path(), away()); }
  void mount() { fs::rename(away(), board_.folder.path()); }
  fs::path away() const { return board_.folder.path().string() + ".away"; }
  /// Without images from the camera.
  void fly_without_camera(double seconds) {
    const std::size_t before = camera_.wanted;
    camera_.wanted = camera_.given;
    board_.fly(seconds);
    camera_.wanted = before;
  }
  template <typename Record>
  std::vector<Record> all() {
    return test::records_of<Record>(board_.store->store());
  }

  PassingCamera camera_;
  test::FlightBoard board_;
};

TEST_F(BackToDisk, EveryImageOfThreeStoreEpochsIsExaminedAndCodedAndEveryFileIsSent) {
  ASSERT_OK(board_.start());
  ASSERT_EQ(board_.set("motion", "corners", 500), "1.1 1.3 1.7");
  board_.fly(80);
  const auto earlier_keyframes = all<KeyframeRecord>();
  const auto earlier_products = all<ProductRecord>();
  std::set<std::int64_t> coded;
  for (const ProductRecord& product : earlier_products) coded.insert(product.keyframe_id);
  ASSERT_GT(coded.size(), 0U);
  ASSERT_LT(coded.size(), earlier_keyframes.size()) << "nothing was left to do";
  board_.stop();

  unmount();
  ASSERT_OK(board_.start());
  ASSERT_EQ(board_.store->updates().code, StatusCode::store_in_memory);
  EXPECT_TRUE(board_.ping());
  board_.fly(40);
  EXPECT_EQ(board_.store->leave_memory(board_.database().c_str(), nullptr).code, StatusCode::io_error);
  board_.fly(5);
  IdentityRecord in_memory;
  ASSERT_OK(get(board_.store->store(), 1, in_memory));
  EXPECT_GT(in_memory.keyframe_base, 0);
  StorageRecord held;
  ASSERT_OK(get(board_.store->store(), 1, held));
  EXPECT_GT(held.frames_released, 0U);
  const auto memory_keyframes = all<KeyframeRecord>();
  ASSERT_GT(memory_keyframes.size(), 2U);

  mount();
  ASSERT_OK(board_.store->leave_memory(board_.database().c_str(), nullptr));
  ASSERT_OK(board_.restart());
  EXPECT_EQ(board_.store->start().moved.code, StatusCode::store_back_on_disk);
  EXPECT_OK(board_.store->updates());
  EXPECT_TRUE(board_.ping());
  StorageRecord storage;
  ASSERT_OK(get(board_.store->store(), 1, storage));
  EXPECT_GE(storage.frames_released, held.frames_released) << "its totals go on";
  EXPECT_EQ(board_.in_force("motion", "corners"), 500) << "as it was set before the disk failed";
  IdentityRecord identity;
  ASSERT_OK(get(board_.store->store(), 1, identity));
  EXPECT_EQ(identity.keyframe_base, in_memory.keyframe_base);
  board_.fly(30);
  fly_without_camera(300);
  ASSERT_OK(board_.restart()) << "as any other flight";
  EXPECT_OK(board_.store->start().moved);
  fly_without_camera(30);

  // The storage manager has counted what is held.
  ASSERT_OK(get(board_.store->store(), 1, storage));
  std::uint32_t with_image = 0;
  for (const FrameRecord& frame : all<FrameRecord>()) with_image += frame.image.bytes != 0 ? 1U : 0U;
  EXPECT_EQ(storage.frames_held, with_image);
  EXPECT_EQ(storage.products_held, all<ProductRecord>().size());
  // Each image that the camera gave was examined.
  std::set<std::string> examined;
  std::map<std::int64_t, std::string> names;
  for (const FrameRecord& frame : all<FrameRecord>()) {
    names[frame.id] = frame.name;
    OverlapRecord seen;
    if (get(board_.store->store(), frame.id, seen).ok()) examined.insert(frame.name);
  }
  EXPECT_EQ(examined.size(), camera_.given);
  // Each image that became a keyframe is coded, if not as this keyframe then as a later one; the newest of a strip
  // waits.
  std::set<std::string> sent;
  for (const ProductRecord& product : all<ProductRecord>()) {
    KeyframeRecord keyframe;
    ASSERT_OK(get(board_.store->store(), product.keyframe_id, keyframe));
    if (product.kind == ProductKind::image) sent.insert(names[keyframe.frame_id]);
  }
  StripRecord open;
  ASSERT_OK(last(board_.store->store(), open));
  std::size_t missing = 0;
  for (const KeyframeRecord& keyframe : all<KeyframeRecord>()) {
    if (keyframe.strip_id != open.id && sent.count(names[keyframe.frame_id]) == 0) ++missing;
  }
  EXPECT_EQ(missing, 0U);
  // The records of each keyframe whose image is coded were sent, and nothing stays noted as unsent. The ground confirms
  // nothing here, so that the link is still busy with the latest files.
  std::set<std::string> files;
  std::int64_t records_through = 0;
  for (const TransferRecord& transfer : all<TransferRecord>()) files.insert(transfer.name);
  for (const DownlinkRecord& file : all<DownlinkRecord>()) {
    EXPECT_GT(file.bytes, 0U) << file.name;
    records_through = std::max(records_through, file.records_through);
  }
  EXPECT_GT(records_through, memory_keyframes.back().id);
  for (const ProductRecord& product : all<ProductRecord>()) {
    if (product.keyframe_id > records_through) continue;
    FixedText<32> name;
    name.add("records-").add(product.keyframe_id, 6).add(".ilp");
    EXPECT_EQ(files.count(name.c_str()), 1U) << name.c_str();
  }
  for (const EventRecord& event : all<EventRecord>()) {
    EXPECT_NE(event.code, static_cast<std::uint16_t>(StatusCode::assertion_failed));
    EXPECT_NE(event.code, static_cast<std::uint16_t>(StatusCode::cursor_back));
  }
}

TEST_F(BackToDisk, StoreEpochsInMemoryFollowEachOtherIntoOneDatabase) {
  camera_.wanted = 0;
  ASSERT_OK(board_.start());
  board_.fly(1);
  board_.stop();
  unmount();
  ASSERT_OK(board_.start());
  board_.fly(1);
  mount();
  ASSERT_OK(board_.store->leave_memory(board_.database().c_str(), nullptr));
  ASSERT_OK(board_.restart());
  IdentityRecord first, second;
  ASSERT_OK(get(board_.store->store(), 1, first));
  EXPECT_EQ(board_.memory().content().keyframe_base, first.keyframe_base);
  board_.fly(1);
  const std::size_t events = all<EventRecord>().size();
  board_.stop();

  // The nonvolatile memory can be read this time.
  fs::rename(board_.database(), board_.database() + ".away");
  fs::create_directory(board_.database());
  ASSERT_OK(board_.start());
  ASSERT_EQ(board_.store->updates().code, StatusCode::store_in_memory);
  ASSERT_OK(get(board_.store->store(), 1, second));
  EXPECT_GT(second.keyframe_base, first.keyframe_base) << "or the two store epochs would not fit into one database";
  EXPECT_GT(second.record_base, first.record_base);
  board_.fly(1);
  fs::remove(board_.database());
  fs::rename(board_.database() + ".away", board_.database());
  ASSERT_OK(board_.store->leave_memory(board_.database().c_str(), nullptr));
  ASSERT_OK(board_.restart());
  EXPECT_OK(board_.store->updates());
  EXPECT_EQ(board_.store->start().moved.code, StatusCode::store_back_on_disk);
  EXPECT_GT(all<EventRecord>().size(), events);
  EXPECT_TRUE(board_.ping());
}

}  // namespace
}  // namespace ilp
