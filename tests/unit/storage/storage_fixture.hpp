// The storage manager on a store in memory, with records as the other stages write them.
#pragma once

#include <memory>
#include <vector>

#include "fsw/storage/storage_manager.hpp"
#include "fsw/vision/overlap/overlap.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/unit/products/coded_product.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp::test {

inline constexpr std::uint32_t frame_bytes = 4096;
inline constexpr std::uint32_t map_bytes = 1000;

/// Writes what the stages before and after the storage manager would.
class StorageManagerTest : public ComponentTest {
 protected:
  using Ids = std::vector<std::int64_t>;

  StorageManagerTest() { EXPECT_TRUE(manager->restore().ok()); }

  void add_frames(std::int64_t count) {
    for (std::int64_t i = 0; i < count; ++i) {
      FrameRecord frame;
      frame.id = ++frames;
      frame.image.bytes = frame_bytes;
      write(frame);
    }
  }
  void add_keyframe(std::int64_t id, std::int64_t frame_id) {
    KeyframeRecord keyframe{.id = id, .frame_id = frame_id};
    write(keyframe);
  }
  void add_depth(std::int64_t id) {
    DepthRecord depth{.id = id};
    depth.values.bytes = 2 * map_bytes;
    depth.sigma.bytes = map_bytes;
    write(depth);
    MaskRecord mask{.id = id, .scope = MaskScope::flight};
    mask.code.bytes = 100;
    write(mask);
  }
  void add_product(std::int64_t keyframe_id, ProductKind kind, double priority = 0.5, std::uint32_t bytes = 5000,
                   ProductState state = ProductState::stored) {
    ProductRecord product;
    product.id = product_id(keyframe_id, kind);
    product.keyframe_id = keyframe_id;
    product.kind = kind;
    product.priority = priority;
    product.state = state;
    product.bytes = bytes;
    product.data.bytes = bytes;
    write(product);
  }
  void add_downlink(std::int64_t id, DownlinkKind kind, std::int64_t subject, std::int64_t records_through,
                    TimeNs acknowledged = 0) {
    DownlinkRecord sent;
    sent.id = id;
    sent.kind = kind;
    sent.subject_id = subject;
    sent.records_through = sent.points_through = records_through;
    sent.acknowledged_ns = acknowledged;
    write(sent);
    ProductRecord product;
    if (acknowledged == 0 || kind != DownlinkKind::product || !get(store, subject, product).ok()) return;
    product.state = ProductState::acknowledged;
    write(product);
  }
  void add_overlap(std::int64_t frame_id, OverlapDecision decision, double overlap = 0.9,
                   OverlapVerdict verdict = OverlapVerdict::ok) {
    OverlapRecord seen{.id = frame_id, .verdict = verdict, .decision = decision, .overlap = overlap};
    write(seen);
  }
  /// A product as the compressor makes it, in four layers.
  ProductRecord add_coded_product(std::int64_t keyframe_id, double priority, int layers_sent = 0, int seed = 0) {
    std::vector<std::uint8_t> file(20'000);
    ProductRecord product = coded_product(keyframe_id, ProductKind::image, seed, file);
    product.priority = priority;
    product.layers_sent = static_cast<std::uint8_t>(layers_sent);
    if (layers_sent == product.layers) product.state = ProductState::sent;
    write(product, "data", file);
    return product;
  }
  std::vector<std::uint8_t> data_of(const ProductRecord& product) {
    std::vector<std::uint8_t> bytes(product.data.bytes);
    EXPECT_TRUE(read_blob<ProductRecord>(store, "data", product.id, 0, bytes).ok());
    return bytes;
  }
  Ids frames_held() {
    return ids_of<FrameRecord>([](const FrameRecord& frame) { return frame.image.bytes != 0; });
  }
  Ids products_held() {
    return ids_of<ProductRecord>([](const ProductRecord& product) { return product.data.bytes != 0; });
  }
  /// Compares what really lies in the store with what the account says.
  void expect_account_is_right() {
    std::int64_t frames_sum = 0, depth_sum = 0, product_sum = 0;
    for (const FrameRecord& frame : records_of<FrameRecord>(store)) frames_sum += frame.image.bytes;
    for (const DepthRecord& depth : records_of<DepthRecord>(store)) {
      depth_sum += std::int64_t{depth.values.bytes} + depth.sigma.bytes;
    }
    for (const MaskRecord& mask : records_of<MaskRecord>(store)) depth_sum += mask.code.bytes;
    for (const ProductRecord& product : records_of<ProductRecord>(store)) product_sum += product.data.bytes;
    const auto account = read<StorageRecord>(1);
    EXPECT_EQ(account.frame_bytes, frames_sum);
    EXPECT_EQ(account.depth_bytes, depth_sum);
    EXPECT_EQ(account.product_bytes, product_sum);
    EXPECT_EQ(account.frames_held, frames_held().size());
    EXPECT_EQ(account.products_held, products_held().size());
  }

  template <typename Record, typename Wanted>
  Ids ids_of(Wanted wanted) {
    Ids ids;
    for (const Record& record : records_of<Record>(store)) {
      if (wanted(record)) ids.push_back(record.id);
    }
    return ids;
  }

  std::int64_t frames = 0;
  std::unique_ptr<StorageManager> manager =
      std::make_unique<StorageManager>(store, mission, test::step_memory<StorageManager>());
};

}  // namespace ilp::test
