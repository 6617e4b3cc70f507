// Products that go down in layers, from the downlink to what the ground puts together.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <string>

#include "fsw/downlink/downlink.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"
#include "fsw/vision/codec/jpeg2000_decode.hpp"
#include "sim/ground/intake/outbox_reader.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/unit/downlink/fake_link.hpp"
#include "tests/unit/hal/temporary_folder.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp {
namespace {

using test::Bytes;
using test::FakeLink;

/// A JP2 file of noise on a slope, and its layers.
struct Coded {
  Bytes file;
  Jpeg2000Product product;
};

Coded coded_image(std::uint32_t seed, std::size_t bytes) {
  static const auto workspace = std::make_unique<Jpeg2000Workspace>();
  constexpr std::int32_t width = 160, height = 120;
  std::vector<std::uint8_t> grey(static_cast<std::size_t>(width) * height);
  std::uint32_t state = seed;
  for (std::size_t i = 0; i < grey.size(); ++i) {
    state = state * 1664525U + 1013904223U;
    grey[i] = static_cast<std::uint8_t>(40 + (i % width) / 2 + (state >> 26U));
  }
  Coded coded;
  coded.file.resize(bytes);
  Jpeg2000Params params{.max_bytes = bytes, .region = RegionCoding::none, .layers = 4};
  const Bytes metadata{'k', '=', '1', '\n'};
  const Status status = encode_jpeg2000(GrayView(grey.data(), width, height), MaskView{}, params, metadata, *workspace,
                                        coded.file, coded.product);
  EXPECT_TRUE(status.ok());
  coded.file.resize(coded.product.bytes);
  return coded;
}

class DownlinkLayersTest : public test::ComponentTest {
 protected:
  DownlinkLayersTest() {
    mission.link_bytes_per_s = 1000;
    mission.pass_period_s = 60;
    mission.pass_length_s = 10;
    mission.pass_start_s = 30;
    EXPECT_TRUE(downlink->restore().ok());
  }
  void add(std::int64_t keyframe_id, double richness, double newly_seen, std::size_t bytes = 6000) {
    KeyframeRecord keyframe{.id = keyframe_id, .frame_id = keyframe_id, .strip_id = 1};
    write(keyframe);
    RichnessRecord index{.id = keyframe_id, .richness = richness, .mask_fraction = newly_seen};
    write(index);
    const Coded coded = coded_image(static_cast<std::uint32_t>(keyframe_id), bytes);
    ProductRecord product;
    product.id = product_id(keyframe_id, ProductKind::image);
    product.keyframe_id = keyframe_id;
    product.priority = richness;
    product.bytes = static_cast<std::uint32_t>(coded.file.size());
    product.crc32 = crc32(coded.file);
    product.layers = static_cast<std::uint8_t>(coded.product.layers);
    for (std::size_t k = 0; k < coded.product.layer_bytes.size(); ++k) {
      product.layer_bytes[k] = static_cast<std::uint32_t>(coded.product.layer_bytes[k]);
    }
    for (std::size_t k = 0; k < product.layers; ++k) product.layer_quality[k] = 26.0F + 3.0F * static_cast<float>(k);
    product.data.bytes = product.bytes;
    write(product, "data", coded.file);
    originals[product.id] = coded.file;
  }
  void request(std::int64_t keyframe_id) {
    CommandRecord command{
        .id = number_of<CommandRecord>() + 1, .kind = CommandKind::refine, .keyframe_id = keyframe_id};
    write(command);
  }
  void reboot() {
    downlink = std::make_unique<Downlink>(store, link, clock, mission, test::step_memory<Downlink>());
    ASSERT_TRUE(downlink->restore().ok());
  }
  /// In steps of half a second; the ground confirms all that it gets when `confirming`.
  void fly(int from_s, int to_s) {
    for (int half = 2 * from_s; half < 2 * to_s; ++half) {
      clock.set(half * ns_per_s / 2);
      const std::size_t before = link.order.size();
      for (const Status& status : run(*downlink)) ADD_FAILURE() << status_name(status.code);
      if (link.order.size() != before) {
        const int second = half / 2;
        EXPECT_TRUE(second >= 30 && (second - 30) % 60 < 10) << "sent without contact at " << second << " s";
      }
      if (!confirming) continue;
      for (std::size_t i = before; i < link.order.size(); ++i) link.confirm(link.order[i]);
      if (link.order.size() != before) check_states();
    }
  }
  /// What the ground could not put together must not be taken for acknowledged.
  void check_states() {
    for (const auto& [id, original] : originals) {
      const auto product = read<ProductRecord>(id);
      if (product.state != ProductState::acknowledged) continue;
      EXPECT_EQ(on_the_ground(id), original);
    }
  }
  /// The product as all confirmed files give it.
  Bytes on_the_ground(std::int64_t id) {
    std::set<std::string> names;
    for (const auto& file : link.confirmed) names.insert(file.first);
    return received(names)[id];
  }
  std::map<std::int64_t, Bytes> received(const std::set<std::string>& names) {
    const test::TemporaryFolder folder;
    for (const std::string& name : names) {
      std::ofstream(folder / name, std::ios::binary)
          .write(reinterpret_cast<const char*>(link.files[name].data()),
                 static_cast<std::streamsize>(link.files[name].size()));
    }
    const intake::Outbox outbox = intake::read_outbox(folder / "");
    waiting = outbox.waiting.size();
    for (const auto& file : outbox.files) EXPECT_EQ(file.fault, "") << file.name;
    std::map<std::int64_t, Bytes> products;
    for (const auto& product : outbox.products) {
      products[product_id(product.keyframe_id, product.kind)] = product.bytes.bytes();
    }
    return products;
  }
  std::set<std::string> all_names() { return {link.order.begin(), link.order.end()}; }
  std::vector<std::string> names_with(const std::string& prefix) {
    std::vector<std::string> names;
    for (const std::string& name : link.order) {
      if (name.starts_with(prefix)) names.push_back(name);
    }
    return names;
  }

  FakeLink link;
  std::unique_ptr<Downlink> downlink =
      std::make_unique<Downlink>(store, link, clock, mission, test::step_memory<Downlink>());
  std::map<std::int64_t, Bytes> originals;
  std::size_t waiting = 0;
  bool confirming = true;
};

TEST_F(DownlinkLayersTest, FirstLayersGoFirstAndTheGroundPutsTheExactFilesTogether) {
  for (std::int64_t id = 1; id <= 8; ++id) add(id, 0.1 * static_cast<double>(id), 0.2);
  fly(0, 60);
  std::map<std::int64_t, Bytes> products = received(all_names());
  EXPECT_GE(products.size(), 4U) << "one whole product would have filled most of a pass of 10 kB";
  EXPECT_LE(link.total_bytes, 10'000U);
  fly(60, 900);
  EXPECT_FALSE(names_with("refine-").empty());
  products = received(all_names());
  ASSERT_EQ(products.size(), originals.size());
  for (const auto& [id, original] : originals) {
    EXPECT_EQ(products[id], original) << id;
    EXPECT_EQ(read<ProductRecord>(id).state, ProductState::acknowledged);
  }
  EXPECT_EQ(all_names().size(), link.order.size()) << "no file comes twice";
  EXPECT_LT(link.total_bytes, 8 * 6000U * 11 / 10 + 8 * 1200U) << "what is down is not sent again";
}

TEST_F(DownlinkLayersTest, LateAndMissingFilesLeaveAPictureOfWhatIsThere) {
  for (std::int64_t id = 1; id <= 6; ++id) add(id, 0.5, 0.2);
  fly(0, 900);
  for (const std::string& missing : names_with("refine-")) {
    std::set<std::string> names = all_names();
    names.erase(missing);
    const std::map<std::int64_t, Bytes> products = received(names);
    EXPECT_EQ(products.size(), originals.size());
    std::size_t shorter = 0;
    for (const auto& [id, bytes] : products) {
      Jpeg2000Info info;
      ASSERT_TRUE(read_jpeg2000_header(bytes, info).ok());
      std::vector<std::int32_t> samples(160 * 120);
      EXPECT_TRUE(decode_jpeg2000(bytes, false, {samples.data(), 160, 120}).ok());
      shorter += bytes != originals[id];
    }
    EXPECT_EQ(shorter, 1U) << missing;
  }
  std::set<std::string> names = all_names();
  names.erase("product-000003-image.jp2");
  EXPECT_EQ(received(names).count(product_id(3, ProductKind::image)), 0U);
  EXPECT_GT(waiting, 0U) << "its refinements are kept and told of";
}

TEST_F(DownlinkLayersTest, OneUnconfirmedLayerKeepsAProductOnBoard) {
  for (std::int64_t id = 1; id <= 4; ++id) add(id, 0.5, 0.2);
  confirming = false;
  fly(0, 600);
  const std::vector<std::string> refinements = names_with("refine-");
  ASSERT_FALSE(refinements.empty());
  for (const std::string& name : link.order) {
    if (name != refinements.back()) link.confirm(name);
  }
  fly(600, 700);
  std::size_t held = 0;
  for (const auto& [id, original] : originals) held += read<ProductRecord>(id).state != ProductState::acknowledged;
  EXPECT_EQ(held, 1U);
  link.confirm(refinements.back());
  fly(700, 701);
  for (const auto& [id, original] : originals) EXPECT_EQ(read<ProductRecord>(id).state, ProductState::acknowledged);
}

TEST_F(DownlinkLayersTest, ARequestGoesBeforeAllOthers) {
  for (std::int64_t id = 1; id <= 8; ++id) add(id, id == 5 ? 0.05 : 0.9, 0.3);
  fly(0, 60);
  ASSERT_LT(read<ProductRecord>(product_id(5, ProductKind::image)).layers_sent, 4);
  request(5);
  const std::size_t before = link.order.size();
  fly(60, 120);
  ASSERT_GT(link.order.size(), before);
  EXPECT_NE(link.order[before].find("000005-image"), std::string::npos) << link.order[before];
  EXPECT_EQ(on_the_ground(product_id(5, ProductKind::image)), originals[product_id(5, ProductKind::image)]);
}

TEST_F(DownlinkLayersTest, DullProductsGoWithinTheStatedPassesHoweverRichTheOthers) {
  mission.overdue_passes = 3;
  constexpr std::int64_t dull = 6;
  for (std::int64_t id = 1; id <= dull; ++id) add(id, 0.0, 0.0, 2500);
  std::int64_t next_id = dull + 1;
  // More than a pass brings arrives before each, all of it worth far more.
  for (int pass = 0; pass < 14; ++pass) {
    for (int i = 0; i < 4; ++i) add(next_id++, 1.0, 1.0, 6000);
    fly(60 * pass, 60 * (pass + 1));
    for (std::int64_t id = 1; id <= dull; ++id) {
      // All were there when the first pass began: n - 1 older products and n records of keyframes before it.
      if (pass + 1 < 3 + 1 + 2 * id) continue;
      EXPECT_GT(read<ProductRecord>(product_id(id, ProductKind::image)).layers_sent, 0) << id << " after " << pass;
    }
  }
}

TEST_F(DownlinkLayersTest, RebootedBeforeEveryStepTheGroundHasTheSame) {
  for (std::int64_t id = 1; id <= 5; ++id) add(id, 0.2 * static_cast<double>(id), 0.2);
  for (int half = 0; half < 1200; ++half) {
    clock.set(half * ns_per_s / 2);
    reboot();
    const std::size_t before = link.order.size();
    ASSERT_TRUE(downlink->step().status.ok());
    for (std::size_t i = before; i < link.order.size(); ++i) link.confirm(link.order[i]);
  }
  EXPECT_EQ(all_names().size(), link.order.size()) << "no file comes twice";
  const std::map<std::int64_t, Bytes> products = received(all_names());
  for (const auto& [id, original] : originals) EXPECT_EQ(products.at(id), original);
}

TEST_F(DownlinkLayersTest, InOrderOfOriginProductsGoWhole) {
  mission.downlink_order = DownlinkOrder::origin;
  for (std::int64_t id = 1; id <= 6; ++id) add(id, 0.1 * static_cast<double>(7 - id), 0.2, 4000);
  fly(0, 900);
  EXPECT_TRUE(names_with("refine-").empty());
  const std::vector<std::string> sent = names_with("product-");
  EXPECT_TRUE(std::is_sorted(sent.begin(), sent.end()));
  EXPECT_EQ(sent.size(), 6U);
}

}  // namespace
}  // namespace ilp
