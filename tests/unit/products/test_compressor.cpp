// Products as they are stored: what their records and metadata say holds for the file.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <set>
#include <vector>

#include "fsw/base/heap_gate.hpp"
#include "fsw/products/compressor.hpp"
#include "fsw/vision/codec/jpeg2000_decode.hpp"
#include "fsw/vision/codec/layer_errors.hpp"
#include "fsw/vision/codec/metadata.hpp"
#include "tests/support/failing_store.hpp"
#include "tests/unit/products/compressor_fixture.hpp"

namespace ilp {
namespace {

using test::CompressorTest;

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

TEST_F(CompressorTest, OnlyAMaskOfTheSameCodeIsTakenInsteadOfDecodingIt) {
  write_keyframe(5, 0.4, 0.3);
  write_keyframe(6, 0.4, 0.1);
  const auto large = read<MaskRecord>(5), small = read<MaskRecord>(6);
  const auto maps = std::make_unique<MapBuffers>();
  const auto loaded = [&](const MaskRecord& record, const DecodedMask& earlier) {
    EXPECT_TRUE(load_mask(store, record, *maps, earlier).ok());
    const MaskView decoded = maps->mask.view();
    return std::vector<std::uint8_t>(decoded.data, decoded.data + decoded.area());
  };
  const std::vector<std::uint8_t> of_large = loaded(large, {}), at_hand(of_large.size(), 1);
  DecodedMask earlier{{at_hand.data(), large.width, large.height}, checksum_of_mask(large, *maps)};
  const std::vector<std::uint8_t> of_small = loaded(small, {});
  EXPECT_EQ(loaded(large, earlier), at_hand);
  EXPECT_EQ(loaded(small, earlier), of_small);
  earlier.checksum = 0;
  EXPECT_EQ(loaded(large, earlier), of_large);
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

// The library cannot code the picture by which it is known. Later it can: what it makes then is right.
TEST_F(CompressorTest, WithALibraryThatWorksOtherwiseProductsAreRightAndHaveNoRegion) {
  write_keyframe(1, 0.7, 0.05);
  static int calls;
  calls = 0;
  install_heap_gate({nullptr, nullptr, [](HeapRegion) { return ++calls == 1; }});
  compress();
  install_heap_gate({});
  ASSERT_GT(calls, 1);
  const auto psnr = [&](const std::vector<std::int32_t>& samples, bool inside) {
    double squares = 0, count = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
      if ((mask[i] != 0) != inside) continue;
      squares += (samples[i] - image.pixels[i]) * (samples[i] - image.pixels[i]);
      ++count;
    }
    return psnr_of(squares / count);
  };
  const auto product = read<ProductRecord>(product_id(1, ProductKind::image));
  EXPECT_LE(product.bytes, product.grant_bytes);
  std::vector<std::int32_t> samples;
  for (int layers = 1; layers <= product.layers; ++layers) {
    samples = decode(product, layers);
    EXPECT_NEAR(psnr(samples, true), static_cast<double>(product.layer_quality[layers - 1]), 1e-3);
  }
  EXPECT_LT(psnr(samples, true), psnr(samples, false) + 3) << "a region would be better by far";
  const auto of_depth = read<ProductRecord>(product_id(1, ProductKind::depth));
  const auto depth = read<DepthRecord>(1);
  samples = decode(of_depth, of_depth.layers);
  for (std::size_t i = 0; i < pixels; ++i) {
    if (mask[i] == 0) continue;
    const double error_px = (depth.offset + depth.step * samples[i] - static_cast<double>(inverse_depth[i])) *
                            disparity_per_inverse_depth_px;
    ASSERT_LE(std::abs(error_px), static_cast<double>(of_depth.layer_quality[of_depth.layers - 1]));
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
                                     {"mask_pixels", read<MaskRecord>(5).newly_seen}}) {
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
  test::erase_records<ProductRecord, CheckpointRecord>(store);
  for (bool pending = true; pending;) {
    const auto compressor = std::make_unique<Compressor>(store, mission, test::step_memory<Compressor>());
    ASSERT_TRUE(compressor->restore().ok());
    StepResult result = compressor->step();
    while (result.then == Then::keep) result = compressor->step();
    pending = result.pending;
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
  test::erase_records<ProductRecord, CheckpointRecord>(store);

  test::FailingStore failing(store);
  std::set<std::pair<RecordType, test::StoreCall>> failed;
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool read = call.kind == test::StoreCall::get || call.kind == test::StoreCall::read_blob;
    const bool hit = read && call.type != RecordType::checkpoint && failed.emplace(call.type, call.kind).second;
    return hit ? Status{StatusCode::store_error, 10} : Status{};
  });
  const auto compressor = std::make_unique<Compressor>(failing, mission, test::step_memory<Compressor>());
  ASSERT_TRUE(compressor->restore().ok());
  const std::vector<Status> reported = run(*compressor);
  EXPECT_EQ(reported.size(), failed.size()) << "each is told";
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
    const bool hit = call.kind == test::StoreCall::read_blob && call.type == RecordType::mask;
    return hit ? Status{StatusCode::record_damaged, call.id, static_cast<std::int64_t>(call.type)} : Status{};
  });
  const auto compressor = std::make_unique<Compressor>(failing, mission, test::step_memory<Compressor>());
  ASSERT_TRUE(compressor->restore().ok());
  const std::vector<Status> reported = run(*compressor);
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_EQ(reported[0].code, StatusCode::record_damaged);
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
