// Quality per byte of image products that differ from their originals by known amounts.

#include "sim/tools/score/quality_score.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/host/image_io.hpp"
#include "tests/unit/host/scratch_folder.hpp"

namespace ilp::score {
namespace {

/// 40 x 30 pixels; columns left of `masked` are inside the mask and off by `inside` grey levels, the others by 50.
void add_product(intake::Flight& flight, std::int64_t id, const test::ScratchFolder& folder, int masked, int inside) {
  intake::Keyframe& k = flight.keyframes[id];
  k.id = id;
  k.name = "image" + std::to_string(id) + ".pgm";
  k.image = host::Raster<std::uint8_t>(40, 30, 100);
  k.mask = host::Raster<std::uint8_t>(40, 30);
  host::Raster<std::uint8_t> original(40, 30, 150);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < masked; ++x) {
      k.mask.at(x, y) = 255;
      original.at(x, y) = static_cast<std::uint8_t>(100 + (y % 2 == 0 ? inside : -inside));
    }
  }
  host::write_pgm(folder / k.name, original.view());
  k.products[static_cast<std::size_t>(ProductKind::image)] = intake::ProductAccount{"", 600};
  k.products[static_cast<std::size_t>(ProductKind::depth)] = intake::ProductAccount{"", 250};
}

TEST(QualityScore, IsThatInsideTheMaskForTheBytesOfTheWholeProduct) {
  const test::ScratchFolder folder;
  intake::Flight flight;
  add_product(flight, 1, folder, 10, 2);
  add_product(flight, 2, folder, 30, 4);
  std::vector<std::string> remarks;
  const auto scores = score_quality(flight, folder.path(), remarks);
  EXPECT_TRUE(remarks.empty());
  EXPECT_NEAR(scores.at(1).psnr_db(), 20 * std::log10(255.0 / 2), 1e-9);
  EXPECT_NEAR(scores.at(1).image_bytes_per_masked_pixel(), 600.0 / 300, 1e-12);
  EXPECT_EQ(scores.at(1).depth_bytes, 250U);
  QualityScore sum = scores.at(1);
  sum.add(scores.at(2));
  // 300 pixels with 4, 900 with 16: a mean square of 13.
  EXPECT_NEAR(sum.psnr_db(), 10 * std::log10(255.0 * 255.0 / 13), 1e-9);
  EXPECT_NEAR(sum.image_bytes_per_masked_pixel(), 1200.0 / 1200, 1e-12);
}

TEST(QualityScore, ExactImagesAreInfinitelyGoodAndMissingOnesUnknown) {
  const test::ScratchFolder folder;
  intake::Flight flight;
  add_product(flight, 1, folder, 10, 0);
  add_product(flight, 2, folder, 10, 3);
  add_product(flight, 3, folder, 10, 3);
  add_product(flight, 4, folder, 10, 3);
  std::filesystem::remove(folder / "image2.pgm");
  folder.write("image3.pgm", "P5 40");
  host::write_pgm(folder / "image4.pgm", host::Raster<std::uint8_t>(20, 30, 9).view());
  flight.keyframes[5].id = 5;  // came without products
  std::vector<std::string> remarks;
  const auto scores = score_quality(flight, folder.path(), remarks);
  EXPECT_EQ(scores.size(), 4U);
  EXPECT_TRUE(std::isinf(scores.at(1).psnr_db()));
  for (const std::int64_t id : {2, 3, 4}) EXPECT_TRUE(std::isnan(scores.at(id).psnr_db())) << id;
  EXPECT_NEAR(scores.at(2).image_bytes_per_masked_pixel(), 2, 1e-12);
  ASSERT_EQ(remarks.size(), 2U);
  EXPECT_TRUE(test::says(remarks[0], "image3.pgm"));
  EXPECT_TRUE(test::says(remarks[1], "20 x 30 pixels; the product has 40 x 30"));
}

}  // namespace
}  // namespace ilp::score
