#include "tests/integration/endless_flight.hpp"

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "fsw/base/crc.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/vision/overlap/overlap.hpp"
#include "tests/support/fake_clock.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/support/store_records.hpp"
#include "tests/unit/products/coded_product.hpp"

namespace ilp::test {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t side = 64;
constexpr std::int64_t frames_per_keyframe = 4;
constexpr std::int64_t keyframes_per_strip = 40;
constexpr std::int64_t window = 5;
constexpr int variants = 24;
constexpr TimeNs keyframe_period_ns = 2 * ns_per_s;

double chance(std::uint64_t seed, std::uint64_t stream) {
  return Rng(seed, stream).uniform();
}

std::int64_t product_of_name(const std::string& name) {
  if (name.rfind("product-", 0) != 0) return 0;
  const std::int64_t keyframe = std::stoll(name.substr(8, 6));
  return product_id(keyframe, name.find("depth") == std::string::npos ? ProductKind::image : ProductKind::depth);
}

std::int64_t resident_kib() {
  std::ifstream in("/proc/self/statm");
  std::int64_t all = 0, resident = 0;
  in >> all >> resident;
  return resident * (sysconf(_SC_PAGESIZE) / 1024);
}

std::int64_t size_of(const std::string& path) {
  std::error_code error;
  const auto size = fs::file_size(path, error);
  return error ? 0 : static_cast<std::int64_t>(size);
}

}  // namespace

Status LossyGround::begin_file(const char* name) {
  if (!contact) return StatusCode::not_ready;
  name_ = name;
  open_ = {};
  return {};
}

Status LossyGround::write(std::span<const std::uint8_t> bytes) {
  if (!contact) return StatusCode::not_ready;
  open_.crc32 = crc32(bytes, open_.crc32);
  open_.bytes += static_cast<std::uint32_t>(bytes.size());
  return {};
}

Status LossyGround::end_file() {
  if (!contact) return StatusCode::not_ready;
  ++files_;
  bytes_ += open_.bytes;
  const double fate = chance(static_cast<std::uint64_t>(files_), 1);
  if (fate < lost_share_) return {};
  if (fate < lost_share_ + damaged_share_) open_.crc32 ^= 1;
  const double delay_s = 1 + 30 * chance(static_cast<std::uint64_t>(files_), 2);
  open_.reports_ns = clock_.now() + static_cast<TimeNs>(delay_s * 1e9);
  held_[name_] = open_;
  return {};
}

Status LossyGround::acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc) {
  const auto found = held_.find(name);
  if (!contact || found == held_.end() || clock_.now() < found->second.reports_ns) return StatusCode::not_ready;
  bytes = found->second.bytes;
  crc = found->second.crc32;
  const std::int64_t product = product_of_name(name);
  if (product != 0) confirmed_.insert(product);
  return {};
}

StubStages::StubStages(Store& store, Clock& clock, std::int64_t keyframes)
    : store_(store), clock_(clock), keyframes_(keyframes) {
  for (int i = 0; i < variants; ++i) {
    Coded coded;
    const auto kind = i % 2 == 0 ? ProductKind::depth : ProductKind::image;
    coded.record = coded_product(0, kind, i, coded.file);
    coded_.push_back(coded);
  }
}

constexpr CheckpointForm StubStages::form = checkpoint_form<State>(ComponentId::acquisition, 1);

Status StubStages::restore() {
  Cursor cursor;
  return restore_checkpoint(store_, form, cursor, state_);
}

Status StubStages::take_frames(State& after) {
  std::vector<std::uint8_t> pixels(side * side, static_cast<std::uint8_t>(after.keyframe));
  for (std::int64_t i = 0; i < frames_per_keyframe; ++i) {
    FrameRecord frame;
    frame.id = ++after.frame;
    frame.time_ns = clock_.now();
    frame.sequence = frame.id;
    frame.width = frame.height = side;
    frame.capture_id = frame.id;
    frame.image.bytes = side * side;
    ILP_TRY(put(store_, frame));
    ILP_TRY(write_blob<FrameRecord>(store_, "image", frame.id, 0, pixels));
    CaptureRecord capture{.id = frame.id, .state = CaptureState::exposed, .frame_id = frame.id};
    ILP_TRY(put(store_, capture));
    OverlapRecord overlap{
        .id = frame.id, .keyframe_id = after.keyframe, .overlap = 0.98 - 0.04 * static_cast<double>(i)};
    const bool chosen = i + 1 == frames_per_keyframe;
    overlap.decision = chosen ? OverlapDecision::selected : OverlapDecision::skipped;
    ILP_TRY(put(store_, overlap));
  }
  return {};
}

Status StubStages::begin_keyframe(State& after) {
  KeyframeRecord keyframe;
  keyframe.id = ++after.keyframe;
  keyframe.frame_id = after.frame;
  keyframe.strip_id = (keyframe.id - 1) / keyframes_per_strip + 1;
  keyframe.time_ns = clock_.now();
  StripRecord strip{.id = keyframe.strip_id};
  strip.first_keyframe_id = (strip.id - 1) * keyframes_per_strip + 1;
  strip.last_keyframe_id = keyframe.id;
  if (keyframe.id % keyframes_per_strip == 0) strip.end = StripEnd::overlap_lost;
  PoseRecord pose{.id = keyframe.id, .strip_id = strip.id};
  ILP_TRY(put(store_, strip));
  ILP_TRY(put(store_, keyframe));
  return put(store_, pose);
}

Status StubStages::make_product(std::int64_t keyframe_id, ProductKind kind) {
  const std::int64_t id = product_id(keyframe_id, kind);
  const Coded& coded = coded_[static_cast<std::size_t>((2 * keyframe_id + (kind == ProductKind::image)) % variants)];
  ProductRecord product = coded.record;
  product.id = id;
  product.keyframe_id = keyframe_id;
  product.strip_id = (keyframe_id - 1) / keyframes_per_strip + 1;
  product.kind = kind;
  product.priority = chance(static_cast<std::uint64_t>(id), 3);
  ILP_TRY(put(store_, product));
  return write_blob<ProductRecord>(store_, "data", id, 0, coded.file);
}

Status StubStages::finish_keyframe(std::int64_t id) {
  PoseRecord pose;
  ILP_TRY(get(store_, id, pose));
  pose.state = PoseState::final;
  ILP_TRY(put(store_, pose));
  StructureRecord structure{.id = id, .strip_id = pose.strip_id};
  structure.points.bytes = 40 * (10 + static_cast<std::uint32_t>(id % 30));
  ILP_TRY(put(store_, structure));
  DepthRecord depth{.id = id, .strip_id = pose.strip_id, .width = side, .height = side};
  depth.values.bytes = 2 * side * side;
  depth.sigma.bytes = side * side;
  ILP_TRY(put(store_, depth));
  MaskRecord mask{.id = id, .scope = MaskScope::flight, .width = side, .height = side, .newly_seen = side * side / 4};
  mask.code.bytes = 100 + static_cast<std::uint32_t>(id % 50);
  ILP_TRY(put(store_, mask));
  PlaceRecord place{.id = id, .strip_id = pose.strip_id};
  ILP_TRY(put(store_, place));
  if (id > 1 && get(store_, id - 1, place).ok()) ILP_TRY(store_.erase(record_info<PlaceRecord>(), id - 1));
  RichnessRecord richness{.id = id, .strip_id = pose.strip_id, .richness = chance(static_cast<std::uint64_t>(id), 4)};
  ILP_TRY(put(store_, richness));
  ILP_TRY(make_product(id, ProductKind::depth));
  return make_product(id, ProductKind::image);
}

StepResult StubStages::step() {
  const TimeNs now = clock_.now();
  // A clock that has gone back does not stop the camera.
  const bool due = now >= state_.next_ns || state_.next_ns - now > keyframe_period_ns;
  if (state_.keyframe >= keyframes_ || !due) return {};
  State after = state_;
  after.next_ns = now + keyframe_period_ns;
  Transaction transaction(store_);
  Status status = transaction.begin();
  if (status.ok()) status = take_frames(after);
  if (status.ok()) status = begin_keyframe(after);
  const std::int64_t finished = after.keyframe - window;
  if (status.ok() && finished >= 1) status = finish_keyframe(finished);
  if (status.ok()) status = save_checkpoint(store_, form, Cursor{}, after);
  if (status.ok()) status = transaction.commit();
  if (!status.ok()) return {status, false};
  state_ = after;
  return {{}, false};
}

namespace {

constexpr Stage stages[] = {
    {.component = ComponentId::capture_clock, .name = "stub_stages", .period = 1, .budget_ns = 100 * ns_per_ms},
    stage_of(ComponentId::storage_manager),
    stage_of(ComponentId::downlink),
};

/// One boot of the program, from start to restart.
struct Boot {
  Boot(Store& store, Link& link, Clock& clock, const MissionParameters& mission, std::int64_t keyframes)
      : stub(store, clock, keyframes),
        manager(std::make_unique<StorageManager>(store, mission, test::step_memory<StorageManager>())),
        downlink(std::make_unique<Downlink>(store, link, clock, mission, test::step_memory<Downlink>())),
        components{&stub, manager.get(), downlink.get()},
        executive(stages, components, store, clock) {}

  StubStages stub;
  std::unique_ptr<StorageManager> manager;
  std::unique_ptr<Downlink> downlink;
  Component* components[3];
  Executive executive;
};

/// What was seen of the store before, and what must hold of it now.
class Watch {
 public:
  Watch(Store& store, const LossyGround& ground) : store_(store), ground_(ground) {}

  void look(bool account_too) {
    look_at_products();
    look_at_frames();
    if (account_too) look_at_account();
  }
  [[nodiscard]] std::int64_t rows() {
    std::int64_t all = 0;
    for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
      std::int64_t count = 0;
      EXPECT_TRUE(store_.count(record_info(static_cast<RecordType>(t)), count).ok());
      all += count;
    }
    return all;
  }

 private:
  struct Seen {
    ProductState state = ProductState::stored;
    std::uint32_t bytes = 0;
    std::uint8_t layers = 0, layers_sent = 0;
  };

  void look_at_products() {
    std::map<std::int64_t, Seen> now;
    ProductRecord product;
    product_bytes_ = 0;
    products_held_ = 0;
    for (std::int64_t id = 0; next(store_, id, product).ok(); id = product.id) {
      const Seen seen{product.state, product.data.bytes, product.layers, product.layers_sent};
      product_bytes_ += product.data.bytes;
      products_held_ += product.data.bytes != 0 ? 1 : 0;
      const auto before = seen_.find(product.id);
      now[product.id] = seen;
      if (before == seen_.end()) continue;
      const bool was_with_link = before->second.state == ProductState::sent || before->second.layers_sent > 0;
      if (was_with_link && product.state == ProductState::dropped && before->second.state != ProductState::dropped) {
        ADD_FAILURE() << "product " << product.id << " was dropped though it was with the link";
      }
      if (product.layers < before->second.layers_sent) {
        ADD_FAILURE() << "product " << product.id << " lost layers that were with the link";
      }
      if (before->second.state == ProductState::sent && product.data.bytes != before->second.bytes &&
          product.state != ProductState::acknowledged) {
        ADD_FAILURE() << "product " << product.id << " was changed though it was with the link";
      }
    }
    for (const auto& [id, seen] : seen_) {
      if (now.contains(id) || seen.state == ProductState::dropped) continue;
      if (!ground_.confirmed(id)) ADD_FAILURE() << "product " << id << " is gone, but the ground does not hold it";
    }
    seen_ = std::move(now);
  }

  /// A keyframe whose image is not coded has its image; so has the newest.
  void look_at_frames() {
    KeyframeRecord keyframe;
    if (!last(store_, keyframe).ok()) return;
    for (std::int64_t id = keyframe.id; id >= 1 && id > keyframe.id - 3 * window; --id) {
      KeyframeRecord older;
      FrameRecord frame;
      ProductRecord product;
      ASSERT_TRUE(get(store_, id, older).ok()) << id;
      ASSERT_TRUE(get(store_, older.frame_id, frame).ok()) << id;
      const bool coded = id <= keyframe.id - window;
      if (!coded || id == keyframe.id) {
        EXPECT_EQ(frame.image.bytes, side * side) << "keyframe " << id;
      }
    }
  }

  void look_at_account() {
    StorageRecord account;
    if (!get(store_, 1, account).ok()) return;
    EXPECT_EQ(account.product_bytes, product_bytes_);
    EXPECT_EQ(account.products_held, products_held_);
    std::int64_t depth_bytes = 0, frame_bytes = 0;
    for (const DepthRecord& depth : records_of<DepthRecord>(store_)) {
      depth_bytes += std::int64_t{depth.values.bytes} + depth.sigma.bytes;
    }
    for (const MaskRecord& mask : records_of<MaskRecord>(store_)) depth_bytes += mask.code.bytes;
    for (const FrameRecord& frame : records_of<FrameRecord>(store_)) frame_bytes += frame.image.bytes;
    EXPECT_EQ(account.depth_bytes, depth_bytes);
    EXPECT_EQ(account.frame_bytes, frame_bytes);
  }

  Store& store_;
  const LossyGround& ground_;
  std::map<std::int64_t, Seen> seen_;
  std::int64_t product_bytes_ = 0;
  std::uint32_t products_held_ = 0;
};

}  // namespace

MissionParameters endless_mission() {
  MissionParameters mission;
  // 100 keyframes of two products of 4 kB.
  mission.storage_budget_mib = 1;
  mission.link_bytes_per_s = 10'000;
  mission.history_keyframes = 100;
  mission.history_frames = 300;
  mission.confirmation_timeout_s = 1500;
  return mission;
}

EndlessResult fly_endlessly(const std::string& database, const MissionParameters& mission,
                            const EndlessOptions& options) {
  EndlessResult result;
  SqliteStore store;
  StillClock clock;
  LossyGround ground(clock, options.lost_share, options.damaged_share);
  EXPECT_TRUE(store.open(database.c_str()).ok());
  EXPECT_TRUE(store.limit(database_limit_bytes(mission)).ok());
  auto boot = std::make_unique<Boot>(store, ground, clock, mission, options.keyframes);
  EXPECT_TRUE(boot->executive.start().ok());
  Watch watch(store, ground);
  std::int64_t keyframes = 0;
  std::int64_t latest_keyframe_frame = 0;
  for (std::int64_t frame = 0; boot->stub.keyframes() < options.keyframes; ++frame) {
    ground.contact = frame % options.pass_period_frames < options.pass_frames;
    if (options.happen) options.happen(store, frame);
    boot->executive.run_minor_frame();
    const bool captured = boot->stub.keyframes() != keyframes;
    if (captured || ground.contact) watch.look(frame < options.behind_from || frame >= options.behind_to);
    if (captured) latest_keyframe_frame = frame;
    keyframes = boot->stub.keyframes();
    const bool stopped = (frame - latest_keyframe_frame) * minor_frame_ns > options.longest_pause_ns;
    if (stopped || testing::Test::HasFailure()) {
      ADD_FAILURE() << "stopped after " << keyframes << " keyframes, minor frame " << frame;
      break;
    }
    if (captured) {
      result.most_database_bytes = std::max(result.most_database_bytes, store.usage().bytes);
      result.most_log_bytes = std::max(result.most_log_bytes, size_of(database + "-wal"));
      StorageRecord account;
      if (get(store, 1, account).ok()) {
        result.most_held_bytes = std::max(result.most_held_bytes, account.frame_bytes + account.depth_bytes +
                                                                      account.structure_bytes + account.product_bytes);
      }
      if (keyframes % 50 == 0) result.most_rows = std::max(result.most_rows, watch.rows());
      if (keyframes == options.keyframes / 4) {
        result.database_bytes_at_quarter = store.usage().bytes;
        result.resident_kib_at_quarter = resident_kib();
      }
    }
    if (options.restart_every_frames > 0 && (frame + 1) % options.restart_every_frames == 0) {
      store.close();
      EXPECT_TRUE(store.open(database.c_str()).ok());
      EXPECT_TRUE(store.limit(database_limit_bytes(mission)).ok());
      clock.set(clock.now() - options.clock_back_ns);
      boot = std::make_unique<Boot>(store, ground, clock, mission, options.keyframes);
      EXPECT_TRUE(boot->executive.start().ok());
    }
    clock.sleep_until(clock.now() + minor_frame_ns);
    result.minor_frames = frame + 1;
  }
  result.keyframes = keyframes;
  result.resident_kib_at_end = resident_kib();
  EXPECT_TRUE(get(store, 1, result.account).ok());
  for (const EventRecord& event : records_of<EventRecord>(store)) {
    ++result.events[static_cast<StatusCode>(event.code)];
  }
  result.files = ground.files();
  result.bytes = ground.bytes();
  return result;
}

}  // namespace ilp::test
