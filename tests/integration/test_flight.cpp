#include <gtest/gtest.h>

#include <fstream>
#include <memory>

#include "fsw/vision/codec/jpeg2000.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/report/accuracy.hpp"
#include "sim/ground/report/report.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

const fs::path plain = test::prepared_flights() / "plain";
const fs::path uninterrupted = test::prepared_flights() / "uninterrupted";

intake::Flight received(const fs::path& out) {
  intake::Outbox outbox = intake::read_outbox(out / "outbox");
  intake::Flight flight = intake::build_flight(outbox);
  for (const intake::ReceivedFile& file : outbox.files) EXPECT_EQ(file.fault, "") << file.name;
  return flight;
}

/// Every keyframe of the one strip has a final pose, and all but the last have depth.
void expect_complete(const intake::Flight& flight, std::size_t least_keyframes) {
  EXPECT_EQ(flight.strips.size(), 1U);
  ASSERT_GE(flight.keyframes.size(), least_keyframes);
  for (const auto& [id, keyframe] : flight.keyframes) {
    EXPECT_TRUE(keyframe.posed()) << "keyframe " << id;
    ASSERT_TRUE(keyframe.depth) << "keyframe " << id;
    const bool is_last = id == flight.keyframes.rbegin()->first;
    EXPECT_EQ(keyframe.depth->verdict, is_last ? DepthVerdict::no_partner : DepthVerdict::ok) << "keyframe " << id;
    EXPECT_EQ(keyframe.inverse_depth.empty(), is_last) << "keyframe " << id;
    EXPECT_FALSE(keyframe.image.empty()) << "keyframe " << id;
  }
}

/// Bounds of the first issue's acceptance: positions within 0.5 % of the way flown, depth within 1 % of the height.
void expect_accurate(const intake::Flight& flight, const fs::path& truth) {
  const report::ReferenceFiles reference(truth / "poses.txt", truth / "depth");
  ASSERT_FALSE(flight.strips.empty());
  const auto accuracy = report::measure_accuracy(flight, flight.strips.begin()->second, reference);
  ASSERT_TRUE(accuracy);
  EXPECT_EQ(accuracy->poses, flight.keyframes.size());
  EXPECT_LT(accuracy->percent_of_length(accuracy->position.max), 0.5);
  EXPECT_LT(accuracy->percent_of_length(accuracy->position_with_attitude.max), 0.5);
  EXPECT_LT(accuracy->rotation_rad.max, 0.01);
  ASSERT_TRUE(accuracy->depth_percent);
  EXPECT_LT(accuracy->depth_percent->max, 1.0);
  EXPECT_EQ(accuracy->depth_percent->count, flight.keyframes.size() - 1);
}

TEST(FlightTest, EveryPoseIsFinalAndAllButTheLastKeyframeHaveDepth) {
  expect_complete(received(uninterrupted), 8);
}

TEST(FlightTest, PositionsAndDepthAgreeWithTheTruth) {
  expect_accurate(received(uninterrupted), plain / "truth");
}

TEST(FlightTest, EachPixelOfTheGroundIsSentAboutOnce) {
  // A keyframe's mask leaves out what its predecessors have shown: the masks of all are not much more than the ground.
  const intake::Flight flight = received(uninterrupted);
  std::size_t first_pixels = 0;
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (keyframe.mask.empty() || id == flight.keyframes.rbegin()->first) continue;
    const auto set = static_cast<std::size_t>(
        std::count_if(keyframe.mask.samples.begin(), keyframe.mask.samples.end(), [](auto v) { return v != 0; }));
    const std::size_t all = keyframe.mask.samples.size();
    if (id == 1) {
      first_pixels = set;
      EXPECT_GT(set, all / 2);
    } else {
      // The step between keyframes of this flight is 10 to 25 % of the image.
      EXPECT_GT(set, all / 20) << "keyframe " << id;
      EXPECT_LT(set, all * 2 / 5) << "keyframe " << id;
    }
  }
  EXPECT_GT(first_pixels, 0U);
}

TEST(FlightTest, NoProductExceedsItsGrant) {
  std::size_t products = 0;
  for (const auto& [id, keyframe] : received(uninterrupted).keyframes) {
    for (const auto& product : keyframe.products) {
      if (!product) continue;
      ++products;
      ASSERT_GT(product->grant_bytes, 0U);
      EXPECT_LE(product->bytes, product->grant_bytes) << product->file;
    }
  }
  EXPECT_GE(products, 15U);
}

TEST(FlightTest, AnotherDecoderReadsEveryProductAndSeesTheSame) {
  const fs::path program = "/usr/bin/opj_decompress";
  if (!fs::exists(program)) GTEST_SKIP() << "opj_decompress (libopenjp2-tools) is not installed";
  const test::TemporaryFolder folder;
  for (const auto& [name, bytes] : test::files_of(uninterrupted / "outbox", {"product-"})) {
    const fs::path picture = folder / "picture.pgm";
    fs::remove(picture);
    const test::ProgramResult result =
        test::run_program({program, "-i", (uninterrupted / "outbox" / name).string(), "-o", picture.string()});
    ASSERT_EQ(result.exit_status, 0) << name << ": " << result.output;
    ASSERT_TRUE(fs::exists(picture)) << name;
    if (name.find("image") == std::string::npos) continue;
    const host::Raster<std::uint8_t> theirs = host::read_gray(picture);
    const intake::Product ours = intake::decode_product(bytes);
    ASSERT_EQ(theirs.samples.size(), ours.samples.samples.size());
    for (std::size_t i = 0; i < theirs.samples.size(); ++i)
      ASSERT_EQ(theirs.samples[i], ours.samples.samples[i]) << name;
  }
}

TEST(FlightTest, InsideTheMaskAnImageIsBetterThanWithTheSameBytesSpreadOverAll) {
  static Jpeg2000Workspace workspace;
  const intake::Flight flight = received(uninterrupted);
  double gain_sum = 0;
  int images = 0;
  for (const auto& [id, keyframe] : flight.keyframes) {
    const auto& account = keyframe.product(ProductKind::image);
    ASSERT_TRUE(account) << "keyframe " << id;
    if (account->scheme == ProductScheme::thumbnail) continue;
    const host::Raster<std::uint8_t> original = host::read_gray(plain / "images" / keyframe.name);
    // Without the metadata: every byte for the picture.
    Jpeg2000Params params{.max_bytes = account->bytes, .region = RegionCoding::none};
    test::Bytes file(account->bytes);
    Jpeg2000Product coded;
    ASSERT_TRUE(encode_jpeg2000(original.view(), MaskView{}, params, {}, workspace, file, coded).ok());
    file.resize(coded.bytes);
    const intake::Product spread = intake::decode_product(file);
    host::Raster<std::uint8_t> pixels(spread.samples.width, spread.samples.height);
    for (std::size_t i = 0; i < pixels.samples.size(); ++i) {
      pixels.samples[i] = static_cast<std::uint8_t>(spread.samples.samples[i]);
    }
    const double ours = report::psnr_db(keyframe.image.view(), original.view(), keyframe.mask, true);
    const double theirs = report::psnr_db(pixels.view(), original.view(), keyframe.mask, true);
    // The first keyframe's mask is nearly the whole image: there is little to gain.
    if (id == 1) {
      EXPECT_GT(ours, theirs - 1);
      continue;
    }
    EXPECT_GT(ours, theirs) << "keyframe " << id;
    gain_sum += ours - theirs;
    ++images;
  }
  ASSERT_GE(images, 5);
  EXPECT_GT(gain_sum / images, 2.0) << "dB on average";
}

TEST(FlightTest, AcknowledgedProductsLeaveTheStore) {
  const auto products = test::records_of<ProductRecord>(uninterrupted);
  for (const ProductRecord& product : products) EXPECT_EQ(product.data.bytes, 0U) << product.id;
  const auto storage = test::records_of<StorageRecord>(uninterrupted);
  ASSERT_EQ(storage.size(), 1U);
  EXPECT_GE(storage[0].products_acknowledged, 15U);
  EXPECT_EQ(storage[0].products_dropped, 0U);
}

TEST(FlightTest, NoComponentFailedOnTheWay) {
  for (const auto& component : test::records_of<ComponentRecord>(uninterrupted)) {
    EXPECT_GT(component.steps, 0U) << component.name;
    EXPECT_EQ(component.restarts, 0U) << component.name;
    EXPECT_EQ(component.faults, 0U) << component.name;
  }
}

TEST(FlightTest, TwoFlightsOverTheSameImagesLeaveTheSameBytes) {
  const test::TemporaryFolder folder;
  const fs::path out = folder / "out";
  test::run_well(test::sil_command(plain, out));
  test::expect_same_files(test::results_of(uninterrupted), test::results_of(out));
  EXPECT_GE(test::results_of(out).size(), 24U);
}

TEST(FlightTest, ThroughADistortingLensItIsAsGood) {
  const fs::path distorted = test::prepared_flights() / "distorted";
  const test::TemporaryFolder folder;
  const fs::path out = folder / "out";
  test::run_well(test::sil_command(distorted, out));
  const intake::Flight flight = received(out);
  ASSERT_TRUE(flight.camera);
  EXPECT_EQ(flight.camera->k1, -0.1);
  expect_complete(flight, 4);
  expect_accurate(flight, distorted / "truth");
}

TEST(FlightTest, TheSameFramesAsAVideoGiveTheSameKeyframes) {
  const test::TemporaryFolder folder;
  const fs::path video = folder / "flight.y4m";
  {
    std::ofstream out(video, std::ios::binary);
    out << "YUV4MPEG2 W320 H240 F1:4 Ip A1:1 Cmono\n";
    for (int number = 1; number <= 20; ++number) {
      char name[32];
      std::snprintf(name, sizeof(name), "%04d.pgm", number);
      const host::Raster<std::uint8_t> image = host::read_gray(plain / "images" / name);
      out << "FRAME\n";
      out.write(reinterpret_cast<const char*>(image.samples.data()),
                static_cast<std::streamsize>(image.samples.size()));
    }
  }
  const fs::path out = folder / "out";
  test::run_well({ILP_SIL, "--y4m", "-", "--camera", (plain / "cameras.txt").string(), "--out", out.string()}, video);
  const auto expected = test::records_of<KeyframeRecord>(uninterrupted);
  const auto keyframes = test::records_of<KeyframeRecord>(out);
  ASSERT_EQ(keyframes.size(), expected.size());
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    EXPECT_EQ(keyframes[i].frame_id, expected[i].frame_id);
    EXPECT_EQ(keyframes[i].time_ns, expected[i].time_ns);
  }
}

}  // namespace
}  // namespace ilp
