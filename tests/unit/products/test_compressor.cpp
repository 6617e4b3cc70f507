// Products as they are stored: what their records and metadata say holds for the file.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "fsw/base/crc.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/products/compressor.hpp"
#include "fsw/shared/calibration_wait.hpp"
#include "fsw/vision/codec/jpeg2000_decode.hpp"
#include "fsw/vision/codec/layer_errors.hpp"
#include "fsw/vision/codec/metadata.hpp"
#include "fsw/vision/terrain/depth_coding.hpp"
#include "fsw/vision/terrain/mask_coding.hpp"
#include "tests/support/failing_store.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/support/strip.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp {
namespace {

constexpr std::int32_t width = 256, height = 192;
constexpr std::size_t pixels = std::size_t{width} * height;
constexpr double disparity_per_inverse_depth_px = 450;

class CompressorTest : public test::ComponentTest {
 protected:
  double hollow_px = 0;  ///< of the disc of new ground, the radius of what is not new

  /// One keyframe with everything that the compressor wants of it; a disc of the image is new.
  void write_keyframe(std::int64_t id, double richness, double share, TimeNs time = 1'000'000'000) {
    CameraRecord camera;
    camera.id = camera_id_of(PoseRecord{});
    camera.width = width;
    camera.height = height;
    camera.fx = camera.fy = 220;
    camera.cx = width / 2.0;
    camera.cy = height / 2.0;
    write(camera);
    FrameRecord frame;
    frame.id = 10 * id;
    frame.time_ns = time;
    frame.width = width;
    frame.height = height;
    frame.image.bytes = pixels;
    std::strcpy(frame.name, "0007.pgm");
    image = test::render_texture(width, height, {2, 0.1, 0, 0}, 1, 0, 1, 4);
    write(frame, "image", image.pixels);
    KeyframeRecord keyframe;
    keyframe.id = id;
    keyframe.frame_id = frame.id;
    keyframe.strip_id = 3;
    keyframe.time_ns = time;
    write(keyframe);
    PoseRecord pose;
    pose.id = id;
    pose.strip_id = 3;
    pose.state = PoseState::final;
    pose.q_cam_from_world[0] = 1;
    pose.centre[1] = 2.5;
    pose.sigma[2] = 0.125;
    // Variances of the attitude about y and of the centre along y, correlated by -0.8.
    pose.covariance[2] = 0.003 * 0.003;
    pose.covariance[14] = 0.125 * 0.125;
    pose.covariance[11] = -0.8 * 0.003 * 0.125;
    write(pose);
    write_depth(id, share);
    RichnessRecord index;
    index.id = id;
    index.strip_id = 3;
    index.richness = richness;
    index.relief = 0.25;
    write(index);
  }

  void write_depth(std::int64_t id, double share) {
    mask.assign(pixels, 0);
    inverse_depth.assign(pixels, 0.0F);
    std::vector<float> sigma(pixels, 0.0F);
    DepthRecord depth;
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = 0; x < width; ++x) {
        const auto i = static_cast<std::size_t>(y * width + x);
        const double dx = x - 150, dy = y - 90;
        const double squared = dx * dx + dy * dy;
        const double outer = share * static_cast<double>(pixels) / 3.14159 + hollow_px * hollow_px;
        if (squared > outer || squared < hollow_px * hollow_px) continue;
        mask[i] = 255;
        ++depth.newly_seen;
        sigma[i] = 1;
        inverse_depth[i] = static_cast<float>(0.05 + 0.01 * std::sin(x * 0.05) * std::cos(y * 0.04) +
                                              0.0003 * std::sin(x * 0.9 + y * 0.7));
      }
    }
    DepthCoding coding;
    const ImageView<const float> rho(inverse_depth.data(), width, height), error(sigma.data(), width, height);
    const MaskView inside(mask.data(), width, height);
    ASSERT_TRUE(choose_depth_coding(rho, error, inside, disparity_per_inverse_depth_px, 1, 16, coding).ok());
    std::vector<std::uint16_t> codes(pixels);
    ASSERT_TRUE(encode_depth(rho, error, inside, coding, ImageView<std::uint16_t>(codes.data(), width, height)).ok());
    std::vector<std::uint8_t> coded(max_mask_bytes(pixels));
    std::size_t mask_bytes = 0;
    ASSERT_TRUE(encode_mask(inside, coded.data(), coded.size(), mask_bytes).ok());
    depth.id = id;
    depth.width = width;
    depth.height = height;
    depth.offset = coding.offset;
    depth.step = coding.step;
    depth.disparity_per_inverse_depth_px = disparity_per_inverse_depth_px;
    depth.values.bytes = 2 * pixels;
    depth.sigma.bytes = pixels;
    depth.mask.bytes = static_cast<std::uint32_t>(mask_bytes);
    const std::vector<std::uint8_t> sigma_codes(pixels, 9);
    Transaction transaction(store);
    ASSERT_TRUE(transaction.begin().ok());
    ASSERT_TRUE(put(store, depth).ok());
    const auto* values = reinterpret_cast<const std::uint8_t*>(codes.data());
    ASSERT_TRUE(write_blob<DepthRecord>(store, "values", id, 0, {values, 2 * pixels}).ok());
    ASSERT_TRUE(write_blob<DepthRecord>(store, "sigma", id, 0, sigma_codes).ok());
    ASSERT_TRUE(write_blob<DepthRecord>(store, "mask", id, 0, {coded.data(), mask_bytes}).ok());
    ASSERT_TRUE(transaction.commit().ok());
  }

  void compress() {
    const auto compressor = std::make_unique<Compressor>(store, mission, test::step_memory<Compressor>());
    ASSERT_TRUE(compressor->restore().ok());
    for (const Status& fault : run(*compressor)) ADD_FAILURE() << status_name(fault.code) << " " << fault.a;
  }

  /// The product cut after `layers`, and what decoding it gives.
  std::vector<std::int32_t> decode(const ProductRecord& product, int layers) {
    file.resize(product.bytes);
    EXPECT_TRUE(read_blob<ProductRecord>(store, "data", product.id, 0, file).ok());
    EXPECT_EQ(crc32(file), product.crc32);
    std::size_t bytes = 0;
    EXPECT_TRUE(truncate_to_layers(file, layers, bytes).ok());
    EXPECT_EQ(bytes, product.layer_bytes[layers - 1]);
    file.resize(bytes);
    std::vector<std::int32_t> samples(pixels);
    EXPECT_TRUE(decode_jpeg2000(file, false, {samples.data(), width, height}).ok());
    return samples;
  }

  test::Image image;
  std::vector<std::uint8_t> mask;
  std::vector<float> inverse_depth;
  std::vector<std::uint8_t> file;
};

// A thin ring, as what is left of a mask beside known ground.
TEST_F(CompressorTest, ALittleNewGroundIsCodedAloneAndExactly) {
  std::int64_t id = 5;
  for (const double hollow : {0.0, 6.0, 9.0, 12.0, 15.0, 20.0}) {
    hollow_px = hollow;
    write_keyframe(id++, 0.4, 0.006);
  }
  compress();
  const auto grant_of_a_thumbnail = static_cast<std::uint32_t>(1536 + 0.06 * pixels / 8);
  for (std::int64_t made = 5; made < id; ++made) {
    const ProductRecord product = read<ProductRecord>(product_id(made, ProductKind::image));
    ASSERT_GT(product.layers, 0);
    EXPECT_EQ(product.layer_quality[product.layers - 1], 120) << made;
    for (int i = 1; i < product.layers; ++i) {
      EXPECT_GE(product.layer_quality[i], product.layer_quality[i - 1]) << made;
    }
    EXPECT_LE(product.bytes, grant_of_a_thumbnail) << made;
  }
}

TEST_F(CompressorTest, OfAKeyframeWithNothingNewNoProductIsMadeAndTheNextOneIs) {
  write_keyframe(5, 0.4, -1);
  write_keyframe(6, 0.4, 0.2);
  compress();
  ProductRecord none;
  EXPECT_TRUE(get(store, product_id(5, ProductKind::depth), none).is(StatusCode::not_found));
  const ProductRecord image_of_old = read<ProductRecord>(product_id(5, ProductKind::image));
  EXPECT_EQ(image_of_old.state, ProductState::dropped);
  EXPECT_EQ(image_of_old.data.bytes, 0U);
  EXPECT_GT(read<ProductRecord>(product_id(6, ProductKind::depth)).data.bytes, 0U);
  EXPECT_GT(read<ProductRecord>(product_id(6, ProductKind::image)).data.bytes, 0U);
}

TEST_F(CompressorTest, NoDisparityIsFartherOffThanItsLayerStates) {
  for (const double asked : {0.0, 0.25}) {
    mission.depth_error_px = asked;
    const std::int64_t id = asked > 0 ? 2 : 1;
    write_keyframe(id, 0.7, 0.3);
    compress();
    const auto product = read<ProductRecord>(product_id(id, ProductKind::depth));
    const auto depth = read<DepthRecord>(id);
    ASSERT_GE(product.layers, 2);
    for (int layers = 1; layers <= product.layers; ++layers) {
      const std::vector<std::int32_t> samples = decode(product, layers);
      double worst = 0;
      for (std::size_t i = 0; i < pixels; ++i) {
        if (mask[i] == 0) continue;
        const auto back = static_cast<float>(depth.offset + depth.step * samples[i]);
        worst = std::max(worst, std::abs(static_cast<double>(back) - static_cast<double>(inverse_depth[i])) *
                                    disparity_per_inverse_depth_px);
      }
      const auto stated = static_cast<double>(product.layer_quality[layers - 1]);
      EXPECT_LE(worst, stated) << "layer " << layers;
      EXPECT_GE(worst, stated - 0.04) << "half a step is lost to rounding, hardly more";
    }
    const auto last = static_cast<double>(product.layer_quality[product.layers - 1]);
    EXPECT_LE(last, 0.25);
    if (asked > 0) {
      EXPECT_GT(last, 0.04) << "what is finer than asked for is left off";
      EXPECT_GT(static_cast<double>(product.layer_quality[product.layers - 2]), asked);
    } else {
      EXPECT_LT(last, 0.04) << "the codes themselves";
    }
  }
}

TEST_F(CompressorTest, LayersOfAnImageAreAsGoodAsStated) {
  write_keyframe(1, 0.7, 0.3);
  compress();
  const auto product = read<ProductRecord>(product_id(1, ProductKind::image));
  ASSERT_EQ(product.layers, 4);
  EXPECT_LE(product.bytes, product.grant_bytes);
  EXPECT_EQ(product.layer_bytes[3], product.bytes);
  EXPECT_EQ(product.layer_bytes[4], 0U);
  EXPECT_EQ(product.layer_quality[4], 0.0F);
  for (int layers = 1; layers <= 4; ++layers) {
    const std::vector<std::int32_t> samples = decode(product, layers);
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
      if (mask[i] == 0) continue;
      sum += (samples[i] - image.pixels[i]) * (samples[i] - image.pixels[i]);
      ++count;
    }
    EXPECT_NEAR(10 * std::log10(255 * 255 * count / sum), static_cast<double>(product.layer_quality[layers - 1]), 1e-3);
  }
}

TEST_F(CompressorTest, TheFileSaysWhatItIs) {
  write_keyframe(5, 0.6, 0.2, 77'000'000'000);
  compress();
  for (const ProductKind kind : {ProductKind::depth, ProductKind::image}) {
    const auto product = read<ProductRecord>(product_id(5, kind));
    decode(product, 1);
    Jpeg2000Info info;
    ASSERT_TRUE(read_jpeg2000_header(file, info).ok());
    const MetadataReader reader(info.metadata);
    std::int64_t integer = 0;
    for (const auto& [key, value] : {std::pair<const char*, std::int64_t>{"keyframe", 5},
                                     {"strip", 3},
                                     {"time_ns", 77'000'000'000},
                                     {"width", width},
                                     {"parameters", parameters_fingerprint(mission)},
                                     {"grant_bytes", product.grant_bytes},
                                     {"mask_pixels", read<DepthRecord>(5).newly_seen}}) {
      EXPECT_TRUE(reader.integer(key, integer).ok()) << key;
      EXPECT_EQ(integer, value) << key;
    }
    std::vector<double> numbers(8);
    ASSERT_TRUE(reader.reals("camera", numbers).ok());
    EXPECT_EQ(numbers[0], 220);
    numbers.resize(3);
    ASSERT_TRUE(reader.reals("centre", numbers).ok());
    EXPECT_EQ(numbers[1], 2.5);
    ASSERT_TRUE(reader.reals("sigma", numbers).ok());
    EXPECT_EQ(numbers[2], 0.125);
    ASSERT_TRUE(reader.reals("sigma_attitude_rad", numbers).ok());
    EXPECT_NEAR(numbers[1], 0.003, 0.003 / 256);
    numbers.resize(15);
    ASSERT_TRUE(reader.reals("pose_correlation_percent", numbers).ok());
    EXPECT_EQ(numbers[7], -80) << "of the fifth and the second";
    EXPECT_EQ(numbers[0], 0);
    numbers.resize(12);
    ASSERT_TRUE(reader.reals("richness_terms", numbers).ok());
    EXPECT_EQ(numbers[4], 0.25) << "relief";
    numbers.resize(4);
    ASSERT_TRUE(reader.reals("layer_quality", numbers).ok());
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(numbers[i], static_cast<double>(product.layer_quality[i]), 1.1e-4);
    if (kind == ProductKind::depth) {
      EXPECT_GE(numbers[0], static_cast<double>(product.layer_quality[0])) << "a bound is rounded up";
    }
  }
}

TEST_F(CompressorTest, AnotherParameterIsAnotherFingerprint) {
  const std::uint32_t before = parameters_fingerprint(mission);
  mission.depth_step_px = 0.0626;
  EXPECT_NE(parameters_fingerprint(mission), before);
}

TEST_F(CompressorTest, ByTheirRankDullAndRichGetAThumbnailAndTheExactRegion) {
  mission.lossless_share = 0.2;
  mission.thumbnail_share = 0.2;
  mission.link_bytes_per_s = 1000;
  // Indices lie close together. Only before the last two images enough others are known.
  std::int64_t id = 0;
  for (const double richness : {0.36, 0.35, 0.39, 0.41, 0.38, 0.40, 0.42, 0.37, 0.43, 0.395}) {
    ++id;
    write_keyframe(id, richness, 0.2, id * ns_per_s);
  }
  // In a second the link brings little. The last one comes after a pause, in which it brings enough.
  write_keyframe(11, 0.355, 0.2, 11 * ns_per_s);
  write_keyframe(12, 0.44, 0.2, 100 * ns_per_s);
  compress();
  for (id = 1; id <= 10; ++id) {
    EXPECT_EQ(read<ProductRecord>(product_id(id, ProductKind::image)).scheme, ProductScheme::lossy_region)
        << "too few images to rank image " << id;
  }
  const auto dull = read<ProductRecord>(product_id(11, ProductKind::image));
  EXPECT_EQ(dull.scheme, ProductScheme::thumbnail);
  EXPECT_LT(dull.bytes, 2500U);
  const auto rich = read<ProductRecord>(product_id(12, ProductKind::image));
  EXPECT_EQ(rich.scheme, ProductScheme::lossless_region);
  EXPECT_EQ(static_cast<double>(rich.layer_quality[rich.layers - 1]), exact_psnr_db);
  const std::vector<std::int32_t> samples = decode(rich, rich.layers);
  for (std::size_t i = 0; i < pixels; ++i) {
    if (mask[i] != 0) {
      ASSERT_EQ(samples[i], image.pixels[i]);
    }
  }
}

TEST_F(CompressorTest, ARestartAfterEveryProductChangesNoScheme) {
  mission.lossless_share = 0.3;
  mission.thumbnail_share = 0.3;
  mission.link_bytes_per_s = 1000;
  constexpr std::int64_t keyframes = 24;
  for (std::int64_t id = 1; id <= keyframes; ++id) {
    write_keyframe(id, 0.35 + 0.01 * static_cast<double>(5 * id % 11), 0.1, (id % 5 == 0 ? 100 * id : id) * ns_per_s);
  }
  compress();
  std::vector<ProductRecord> wanted;
  std::set<ProductScheme> schemes;
  for (std::int64_t id = 1; id <= keyframes; ++id) {
    wanted.push_back(read<ProductRecord>(product_id(id, ProductKind::image)));
    schemes.insert(wanted.back().scheme);
  }
  EXPECT_EQ(schemes.size(), 3U);
  Transaction transaction(store);
  ASSERT_TRUE(transaction.begin().ok());
  for (std::int64_t id = 1; id <= keyframes; ++id) {
    for (const ProductKind kind : {ProductKind::depth, ProductKind::image}) {
      ASSERT_TRUE(store.erase(record_info<ProductRecord>(), product_id(id, kind)).ok());
    }
  }
  CheckpointRecord saved;
  while (next(store, saved.id, saved).ok()) ASSERT_TRUE(store.erase(record_info<CheckpointRecord>(), saved.id).ok());
  ASSERT_TRUE(transaction.commit().ok());
  for (bool pending = true; pending;) {
    const auto compressor = std::make_unique<Compressor>(store, mission, test::step_memory<Compressor>());
    ASSERT_TRUE(compressor->restore().ok());
    pending = compressor->step().pending;
  }
  for (const ProductRecord& product : wanted) {
    const auto again = read<ProductRecord>(product.id);
    EXPECT_EQ(again.scheme, product.scheme) << product.id;
    EXPECT_EQ(again.crc32, product.crc32) << product.id;
  }
}

// A slow link: keyframes four seconds apart are granted about what it brings in four seconds, and no product more.
TEST_F(CompressorTest, ASlowLinkTakesBytesFromEveryProduct) {
  write_keyframe(1, 0.8, 0.3, 0);
  write_keyframe(2, 0.8, 0.3, 4'000'000'000);
  compress();
  const auto ample = read<ProductRecord>(product_id(2, ProductKind::image));
  mission.link_bytes_per_s = 500;
  write_keyframe(3, 0.8, 0.3, 8'000'000'000);
  compress();
  const auto scarce = read<ProductRecord>(product_id(3, ProductKind::image));
  EXPECT_LT(scarce.grant_bytes, ample.grant_bytes);
  EXPECT_LE(scarce.bytes, scarce.grant_bytes);
}

TEST_F(CompressorTest, AReadThatFailsOnceCostsNoProduct) {
  write_keyframe(1, 0.6, 0.4);
  compress();
  std::vector<ProductRecord> wanted;
  for (const ProductKind kind : {ProductKind::depth, ProductKind::image}) {
    wanted.push_back(read<ProductRecord>(product_id(1, kind)));
  }
  Transaction transaction(store);
  ASSERT_TRUE(transaction.begin().ok());
  for (const ProductRecord& product : wanted) {
    ASSERT_TRUE(store.erase(record_info<ProductRecord>(), product.id).ok());
  }
  CheckpointRecord checkpoint;
  while (next(store, 0, checkpoint).ok()) {
    ASSERT_TRUE(store.erase(record_info<CheckpointRecord>(), checkpoint.id).ok());
  }
  ASSERT_TRUE(transaction.commit().ok());

  test::FailingStore failing(store);
  std::set<std::pair<RecordType, test::StoreCall>> failed;
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool read = call.kind == test::StoreCall::get || call.kind == test::StoreCall::read_blob;
    const bool hit = read && call.type != RecordType::checkpoint && failed.emplace(call.type, call.kind).second;
    return hit ? Status{StatusCode::store_error, 10} : Status{};
  });
  const auto compressor = std::make_unique<Compressor>(failing, mission, test::step_memory<Compressor>());
  ASSERT_TRUE(compressor->restore().ok());
  const std::vector<Status> told = run(*compressor);
  EXPECT_EQ(told.size(), failed.size()) << "each is told";
  EXPECT_GE(failed.size(), 6U);
  for (const ProductRecord& product : wanted) {
    const auto made = read<ProductRecord>(product.id);
    EXPECT_EQ(made.state, ProductState::stored);
    EXPECT_EQ(made.crc32, product.crc32);
    EXPECT_EQ(made.bytes, product.bytes);
  }
}

TEST_F(CompressorTest, WhereTheMapsAreDamagedTheImageGoesWhole) {
  write_keyframe(1, 0.6, 0.1);
  test::FailingStore failing(store);
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool hit = call.kind == test::StoreCall::read_blob && call.type == RecordType::depth;
    return hit ? Status{StatusCode::record_damaged, call.id, static_cast<std::int64_t>(call.type)} : Status{};
  });
  const auto compressor = std::make_unique<Compressor>(failing, mission, test::step_memory<Compressor>());
  ASSERT_TRUE(compressor->restore().ok());
  const std::vector<Status> told = run(*compressor);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].code, StatusCode::record_damaged);
  EXPECT_EQ(read<ProductRecord>(product_id(1, ProductKind::depth)).state, ProductState::dropped);
  const auto product = read<ProductRecord>(product_id(1, ProductKind::image));
  EXPECT_EQ(product.state, ProductState::stored);
  // Outside of what would have been new, too.
  const std::vector<std::int32_t> samples = decode(product, product.layers);
  double squares = 0;
  for (std::size_t i = 0; i < pixels; ++i) squares += std::pow(samples[i] - image.pixels[i], 2);
  EXPECT_GT(psnr_of(squares / static_cast<double>(pixels)), 25);
}

TEST_F(CompressorTest, WhereTheImageIsDamagedTheDepthMapGoes) {
  write_keyframe(1, 0.6, 0.4);
  test::FailingStore failing(store);
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool hit = call.kind == test::StoreCall::read_blob && call.type == RecordType::frame;
    return hit ? Status{StatusCode::record_damaged, call.id, static_cast<std::int64_t>(call.type)} : Status{};
  });
  const auto compressor = std::make_unique<Compressor>(failing, mission, test::step_memory<Compressor>());
  ASSERT_TRUE(compressor->restore().ok());
  EXPECT_EQ(run(*compressor).size(), 1U);
  EXPECT_EQ(read<ProductRecord>(product_id(1, ProductKind::depth)).state, ProductState::stored);
  EXPECT_EQ(read<ProductRecord>(product_id(1, ProductKind::image)).state, ProductState::dropped);
}

}  // namespace
}  // namespace ilp
