// Pieces of a map that a camera exposed differently get one brightness and one contrast.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "sim/ground/map/balance.hpp"

namespace ilp::map {
namespace {

constexpr std::int32_t patch_columns = 150, rows = 500;

/// A strip of pieces side by side, 150 columns each. `ground` is the true grey of a cell, `shown` what the camera makes
/// of it for a piece.
GroundGrid strip_of(std::int32_t patches, const std::function<double(std::int32_t x, std::int32_t y)>& ground,
                    const std::function<double(std::int32_t patch, std::int32_t x, double grey)>& shown) {
  GroundGrid grid(0, 0, 1, patches * patch_columns, rows);
  for (std::int32_t y = 0; y < rows; ++y) {
    for (std::int32_t x = 0; x < grid.ortho.width; ++x) {
      const std::int32_t patch = x / patch_columns;
      const double grey = shown(patch, x % patch_columns, ground(x, y));
      grid.ortho.at(x, y) = static_cast<std::uint8_t>(std::lround(std::clamp(grey, 0.0, 255.0)));
      grid.source.at(x, y) = static_cast<std::uint16_t>(patch + 1);
      grid.count.at(x, y) = 1;
    }
  }
  return grid;
}

std::map<std::int64_t, Balance> balance_of(const GroundGrid& grid, const std::vector<std::int64_t>& keyframes) {
  Seams seams;
  add_seams(grid, keyframes, 0, seams);
  std::vector<ShownPatch> shown(keyframes.size());
  add_shown(grid, 0, shown);
  std::map<std::int64_t, ShownPatch> patches;
  for (std::size_t i = 0; i < keyframes.size(); ++i) patches[keyframes[i]] = shown[i];
  return balance_patches(seam_levels_of(seams), patches);
}

std::vector<std::int64_t> ids_of(std::int32_t patches) {
  std::vector<std::int64_t> ids;
  for (std::int64_t i = 0; i < patches; ++i) ids.push_back(10 + 3 * i);
  return ids;
}

/// Smoothed noise about 120 with a standard deviation of 25: every piece has the same statistics.
double texture(std::int32_t x, std::int32_t y) {
  constexpr std::int32_t columns = 24 * patch_columns, reach = 2;
  static const std::vector<double> field = [] {
    std::mt19937 random(5);
    std::vector<double> now(static_cast<std::size_t>(columns) * rows), next(now.size());
    for (double& value : now) value = static_cast<double>(random() % 1000) - 499.5;
    for (const std::int32_t step : {1, columns, 1, columns}) {
      for (std::size_t i = 0; i < now.size(); ++i) {
        next[i] = 0;
        for (std::int32_t k = -reach; k <= reach; ++k)
          next[i] += now[(i + now.size() + static_cast<std::size_t>(k * step + columns * rows)) % now.size()];
      }
      std::swap(now, next);
    }
    double squares = 0;
    for (const double value : now) squares += value * value;
    const double scale = 25 / std::sqrt(squares / static_cast<double>(now.size()));
    for (double& value : now) value = 120 + scale * value;
    return now;
  }();
  return field[static_cast<std::size_t>(y) * columns + static_cast<std::size_t>(x)];
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

TEST(Balance, KnownGainsAndOffsetsOfOneTextureAreFoundToTwoPerCent) {
  const std::vector<Balance> camera = {{1, 0},      {0.62, 30}, {1.3, -40}, {0.8, 70},
                                       {1.15, -10}, {0.7, -20}, {0.95, 15}, {1.25, -60}};
  const auto patches = static_cast<std::int32_t>(camera.size());
  // Every piece shows the same ground, every other one mirrored, so that both sides of a seam are alike.
  const auto ground = [](std::int32_t x, std::int32_t y) {
    const std::int32_t at = x % patch_columns;
    return texture(x / patch_columns % 2 == 0 ? at : patch_columns - 1 - at, y);
  };
  const GroundGrid grid = strip_of(patches, ground, [&](std::int32_t patch, std::int32_t, double grey) {
    return camera[static_cast<std::size_t>(patch)].of(grey);
  });
  const auto balance = balance_of(grid, ids_of(patches));
  // What a grey of the ground becomes by camera and balance together: the same line for all pieces.
  std::vector<double> contrasts, darks, brights;
  for (std::size_t i = 0; i < camera.size(); ++i) {
    const Balance& one = balance.at(10 + 3 * static_cast<std::int64_t>(i));
    contrasts.push_back(one.gain * camera[i].gain);
    darks.push_back(one.of(camera[i].of(90)));
    brights.push_back(one.of(camera[i].of(150)));
  }
  for (std::size_t i = 0; i < camera.size(); ++i) {
    EXPECT_NEAR(contrasts[i] / mean_of(contrasts), 1, 0.02) << i;
    EXPECT_NEAR(darks[i], mean_of(darks), 0.02 * 120) << i;
    EXPECT_NEAR(brights[i], mean_of(brights), 0.02 * 120) << i;
  }
  // No piece is taken for the right one.
  double gains = 0;
  for (const auto& [id, one] : balance) gains += std::log(one.gain);
  EXPECT_NEAR(gains / patches, 0, 0.01);
}

TEST(Balance, ContrastIsEvenOverTheEighthsOfAStripWhoseExposureFalls) {
  constexpr std::int32_t patches = 16;
  const GroundGrid grid = strip_of(patches, texture, [](std::int32_t patch, std::int32_t, double grey) {
    return std::exp(-std::log(2.7) * patch / (patches - 1)) * grey;
  });
  const auto ids = ids_of(patches);
  const auto balance = balance_of(grid, ids);
  std::vector<double> contrasts;
  for (std::int32_t eighth = 0; eighth < 8; ++eighth) {
    double sum = 0, squares = 0, cells = 0;
    for (std::int32_t y = 0; y < rows; ++y) {
      for (std::int32_t x = eighth * 2 * patch_columns; x < (eighth + 1) * 2 * patch_columns; ++x) {
        const double grey = balance.at(ids[grid.source.at(x, y) - 1U]).of(grid.ortho.at(x, y));
        sum += grey;
        squares += grey * grey;
        ++cells;
      }
    }
    contrasts.push_back(std::sqrt(squares / cells - sum * sum / (cells * cells)));
  }
  const auto [low, high] = std::minmax_element(contrasts.begin(), contrasts.end());
  EXPECT_LT(*high / *low, 1.25) << "2.5 as the camera shows it";
}

TEST(Balance, TheOrderOfIdsAndOfPiecesMakesNoDifference) {
  const GroundGrid grid = strip_of(3, texture, [](std::int32_t patch, std::int32_t, double grey) {
    return Balance{1.0 - 0.2 * patch, 10.0 * patch}.of(grey);
  });
  const auto rising = balance_of(grid, {1, 2, 3}), falling = balance_of(grid, {9, 7, 4});
  EXPECT_NEAR(rising.at(1).gain, falling.at(9).gain, 1e-9);
  EXPECT_NEAR(rising.at(3).offset, falling.at(4).offset, 1e-9);
}

TEST(Balance, BrightnessDoesNotDriftAlongAStripWhoseImagesAreDarkerAtOneEdge) {
  constexpr std::int32_t patches = 24;
  const GroundGrid grid = strip_of(patches, texture, [](std::int32_t patch, std::int32_t x, double grey) {
    return (1 + 0.3 * std::sin(0.4 * patch)) * (1 - 0.06 * x / (patch_columns - 1)) * grey;
  });
  const auto ids = ids_of(patches);
  const auto balance = balance_of(grid, ids);
  std::vector<ShownPatch> shown(ids.size());
  add_shown(grid, 0, shown);
  std::vector<double> means;
  for (std::size_t i = 0; i < ids.size(); ++i)
    means.push_back(balance.at(ids[i]).of(static_cast<double>(shown[i].grey) / static_cast<double>(shown[i].cells)));
  // The errors of 23 seams add up to a factor of 4.
  const auto [darkest, brightest] = std::minmax_element(means.begin(), means.end());
  EXPECT_LT(*brightest / *darkest, 1.45);
  const auto [dark, bright] = std::minmax_element(means.begin() + 8, means.end() - 8);
  EXPECT_LT(*bright / *dark, 1.05) << "far from the ends nothing is left";
}

TEST(Balance, BrightGroundBesideDarkGroundStaysBright) {
  constexpr std::int32_t patches = 12, change = patch_columns * 13 / 2;
  const auto fields = [](std::int32_t x, std::int32_t y) { return texture(x, y) * (x < change ? 0.7 : 1.2); };
  const GroundGrid grid = strip_of(patches, fields, [](std::int32_t, std::int32_t, double grey) { return grey; });
  const auto ids = ids_of(patches);
  const auto balance = balance_of(grid, ids);
  const double dark = balance.at(ids[5]).of(0.7 * 120), bright = balance.at(ids[7]).of(1.2 * 120);
  EXPECT_GT(bright - dark, 0.5 * 0.5 * 120);
}

TEST(Balance, AKeyframeAtTheEndOfALongStripDoesNotChangeItsBeginning) {
  const auto balance_with = [](std::int64_t keyframes) {
    Seams seams;
    std::map<std::int64_t, ShownPatch> patches;
    for (std::int64_t id = 1; id <= keyframes; ++id) {
      const auto grey = static_cast<std::uint64_t>(93 + 13 * (id % 5));
      patches[id] = {.cells = 1000,
                     .grey = 1000 * grey,
                     .pairs = 1000,
                     .differences = static_cast<std::uint64_t>(9000 + 2000 * (id % 3))};
      if (id == 1) continue;
      SeamGreys& greys = seams[{id - 1, id}];
      for (std::int64_t k = 0; k < 40; ++k) {
        greys.first.add(static_cast<std::uint8_t>(70 + 13 * ((id - 1) % 5) + k), 10);
        greys.second.add(static_cast<std::uint8_t>(70 + 13 * (id % 5) + id % 3 + k), 10);
      }
    }
    return balance_patches(seam_levels_of(seams), patches);
  };
  for (const std::int64_t keyframes : {200, 500}) {
    const auto before = balance_with(keyframes), after = balance_with(keyframes + 1);
    for (std::int64_t id = 1; id <= keyframes - 100; ++id) {
      ASSERT_NEAR(before.at(id).gain, after.at(id).gain, 1e-6) << id;
      ASSERT_NEAR(before.at(id).offset, after.at(id).offset, 1e-4) << id;
    }
    EXPECT_GT(std::fabs(before.at(keyframes).offset - after.at(keyframes).offset), 1e-2);
  }
}

TEST(Balance, SmoothGroundIsNotMadeIntoNoise) {
  // A lake in the middle: no contrast but the noise of its pixels.
  const auto ground = [](std::int32_t x, std::int32_t y) {
    const bool lake = x >= 3 * patch_columns && x < 5 * patch_columns;
    return lake ? 100.0 + (x * 7 + y * 13) % 3 - 1 : texture(x, y);
  };
  const GroundGrid grid = strip_of(8, ground, [](std::int32_t, std::int32_t, double grey) { return grey; });
  const auto ids = ids_of(8);
  const auto balance = balance_of(grid, ids);
  EXPECT_LT(balance.at(ids[3]).gain, 1.6);
  EXPECT_LT(balance.at(ids[4]).gain, 1.6);
  for (const auto& [id, one] :
       balance_of(strip_of(
                      2, [](std::int32_t, std::int32_t) { return 80.0; },
                      [](std::int32_t patch, std::int32_t, double grey) { return grey + 40 * patch; }),
                  {1, 2})) {
    EXPECT_NEAR(one.gain, 1, 1e-6);
    EXPECT_NEAR(one.of(id == 1 ? 80 : 120), 100, 1) << "without any contrast there is still one brightness";
  }
}

TEST(Balance, ACloudOverHalfOfOneSeamDoesNotTakeTheOthersAlong) {
  // Over half of the rows of piece 4, a cloud that nobody else sees.
  constexpr std::int32_t patches = 9;
  GroundGrid grid = strip_of(patches, texture, [](std::int32_t, std::int32_t, double grey) { return grey; });
  for (std::int32_t y = 0; y < rows / 2; ++y) {
    for (std::int32_t x = 4 * patch_columns; x < 5 * patch_columns; ++x) grid.ortho.at(x, y) = 245;
  }
  const auto ids = ids_of(patches);
  const auto balance = balance_of(grid, ids);
  for (const std::size_t i : {0U, 1U, 2U, 6U, 7U, 8U}) {
    EXPECT_NEAR(balance.at(ids[i]).gain / balance.at(ids[0]).gain, 1, 0.1) << i;
    EXPECT_NEAR(balance.at(ids[i]).of(120), balance.at(ids[0]).of(120), 12) << i;
  }
}

TEST(Balance, ASeamWithACloudOnOneSideDoesNotChangeTheContrastOfTheOthers) {
  constexpr std::int32_t patches = 9;
  GroundGrid grid = strip_of(patches, texture, [](std::int32_t, std::int32_t, double grey) { return grey; });
  for (std::int32_t y = 0; y < rows / 2; ++y) {
    for (std::int32_t x = 4 * patch_columns; x < 4 * patch_columns + patch_columns / 2; ++x) grid.ortho.at(x, y) = 245;
  }
  const auto ids = ids_of(patches);
  const auto balance = balance_of(grid, ids);
  for (const std::size_t i : {0U, 1U, 2U, 6U, 7U, 8U})
    EXPECT_NEAR(balance.at(ids[i]).gain / balance.at(ids[0]).gain, 1, 0.1) << i;
}

TEST(Balance, ALongBorderDoesNotOverruleShortOnes) {
  // Around three pieces of one grey, the differences of grey do not add up to zero.
  const auto seam_of = [](std::uint32_t cells, int difference) {
    SeamGreys greys;
    for (int k = 0; k < 20; ++k) {
      greys.first.add(static_cast<std::uint8_t>(100 + k), cells / 20);
      greys.second.add(static_cast<std::uint8_t>(100 + k + difference), cells / 20);
    }
    return greys;
  };
  const ShownPatch patch{.cells = 30000, .grey = 3300000, .pairs = 1000, .differences = 9000};
  const auto balance = balance_patches(
      seam_levels_of({{{1, 2}, seam_of(40000, 0)}, {{2, 3}, seam_of(2000, 12)}, {{1, 3}, seam_of(2000, 0)}}),
      {{1, patch}, {2, patch}, {3, patch}});
  EXPECT_GT(balance.at(2).of(110) - balance.at(1).of(110), 2) << "the long border takes part of what is missing";
}

TEST(Balance, AKeyframeThatIsBrighterFromOneSideMeetsItsNeighbourAllAlongTheirBorder) {
  // Two pieces of 500 rows share a column; the second one shows 15 more above and 15 less below.
  const auto meeting = [](double row, double brighter) {
    return SeamLevels{.first = 1,
                      .second = 2,
                      .column = 100,
                      .row = row,
                      .cells = 500,
                      .first_level = {120, 20},
                      .second_level = {120 + brighter, 20}};
  };
  const auto patch = [](std::int64_t column) {
    return ShownPatch{
        .cells = 1000, .grey = 120000, .columns = 1000 * column, .rows = 250000, .pairs = 1000, .differences = 9000};
  };
  const auto balance =
      balance_patches({meeting(50, 15), meeting(450, -15), meeting(250, 0)}, {{1, patch(50)}, {2, patch(150)}});
  for (const auto& [row, brighter] : {std::pair{50, 15.0}, {250, 0.0}, {450, -15.0}})
    EXPECT_NEAR(balance.at(1).of(120, 100, row), balance.at(2).of(120 + brighter, 100, row), 2) << row;
  EXPECT_NEAR(balance.at(1).ramp[1], -balance.at(2).ramp[1], 0.1) << "neither is taken for the right one";
}

TEST(Balance, BlackAndWhiteCellsAndShortSeamsSayNothing) {
  GroundGrid grid = strip_of(
      2, texture, [](std::int32_t patch, std::int32_t, double grey) { return patch == 0 ? grey : 0.5 * grey; });
  Seams all, none;
  add_seams(grid, {1, 2}, 0, all);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all.begin()->second.first.count(), all.begin()->second.second.count());
  std::fill(grid.ortho.samples.begin(), grid.ortho.samples.end(), std::uint8_t{255});
  add_seams(grid, {1, 2}, 0, none);
  EXPECT_TRUE(none.empty());
  // 19 cells are too few.
  const auto offset_of = [](std::uint32_t cells) {
    SeamGreys greys;
    greys.first.add(100, cells);
    greys.second.add(140, cells);
    const ShownPatch patch{.cells = 1000, .grey = 120000};
    return balance_patches(seam_levels_of({{{1, 2}, greys}}), {{1, patch}, {2, patch}}).at(1).offset;
  };
  EXPECT_NEAR(offset_of(19), 0, 1e-9);
  EXPECT_GT(offset_of(20), 5);
}

}  // namespace
}  // namespace ilp::map
