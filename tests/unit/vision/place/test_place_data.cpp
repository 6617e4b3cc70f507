// Recorded surveys beside the project. The truth are their reference cameras.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/unit/vision/place/place_images.hpp"

namespace ilp {
namespace {

struct Survey {
  std::string folder;
  std::vector<test::StripImage> images;
  std::vector<PlaceFeatures> features;
};

const Survey& survey(std::string_view folder) {
  static std::map<std::string, Survey> read;
  Survey& s = read[std::string(folder)];
  if (!s.folder.empty()) return s;
  s.folder = folder;
  s.images = test::read_strip(s.folder);
  for (const test::StripImage& image : s.images) {
    s.features.push_back(test::features_of(test::read_strip_image(s.folder, image.name)));
  }
  return s;
}

/// Median distance of the matched features from the epipolar lines of the reference cameras, px.
double median_epipolar_px(const Survey& s, std::size_t a, std::size_t b, const PlaceMatch& match) {
  std::vector<double> distances;
  for (const PlacePair& pair : match.pairs) {
    const PlaceFeature &p = s.features[a][pair.older], &q = s.features[b][pair.newer];
    distances.push_back(test::epipolar_distance(s.images[a], s.images[b], p.x, p.y, q.x, q.y));
  }
  std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2),
                   distances.end());
  return distances[distances.size() / 2];
}

struct Expected {
  const char* folder;
  int images, least_links;
  std::size_t least_in_one_patch;
};

class PlaceSurvey : public testing::TestWithParam<Expected> {};

TEST_P(PlaceSurvey, EveryLinkIsTrueAndLinksHoldItTogether) {
  const Survey& s = survey(GetParam().folder);
  if (s.images.empty()) GTEST_SKIP() << "no recorded data: " << GetParam().folder;
  ASSERT_EQ(s.images.size(), static_cast<std::size_t>(GetParam().images));
  std::vector<std::size_t> patch(s.images.size());
  for (std::size_t k = 0; k < patch.size(); ++k) patch[k] = k;
  int links = 0;
  for (std::size_t b = 0; b < s.images.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const PlaceMatch match = test::verify(s.features[a], s.features[b]);
      if (match.verdict != PlaceVerdict::verified) continue;
      ++links;
      EXPECT_LT(median_epipolar_px(s, a, b, match), 5) << s.images[a].name << " " << s.images[b].name;
      const std::size_t from = patch[b];
      std::replace(patch.begin(), patch.end(), from, patch[a]);
    }
  }
  EXPECT_GE(links, GetParam().least_links);
  std::map<std::size_t, std::size_t> sizes;
  for (const std::size_t k : patch) ++sizes[k];
  std::size_t largest = 0;
  for (const auto& [root, size] : sizes) largest = std::max(largest, size);
  EXPECT_GE(largest, GetParam().least_in_one_patch);
}
INSTANTIATE_TEST_SUITE_P(Recorded, PlaceSurvey,
                         testing::Values(Expected{"revisit_boruszyn_kite", 28, 150, 28},
                                         Expected{"revisit_seneca_farm", 39, 45, 25},
                                         Expected{"aerial_coal_oil_point", 21, 55, 21},
                                         Expected{"strecha_fountain_p11", 11, 10, 9}));

// Images of one survey against those of another one.
TEST(PlaceSurveys, AreNeverLinkedWithEachOther) {
  const char* const folders[] = {"revisit_boruszyn_kite", "revisit_seneca_farm", "aerial_coal_oil_point",
                                 "aerial_caliterra_a", "strecha_fountain_p11"};
  int checks = 0;
  for (std::size_t i = 0; i < std::size(folders); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const Survey &p = survey(folders[i]), &q = survey(folders[k]);
      for (std::size_t a = 0; a < p.features.size(); ++a) {
        for (std::size_t b = a % 2; b < q.features.size(); b += 2, ++checks) {
          const PlaceMatch match = test::verify(p.features[a], q.features[b]);
          EXPECT_NE(match.verdict, PlaceVerdict::verified)
              << p.images[a].name << " " << q.images[b].name << " evidence " << match.evidence;
        }
      }
    }
  }
  if (checks == 0) GTEST_SKIP() << "no recorded data";
  EXPECT_GT(checks, 1500);
}

}  // namespace
}  // namespace ilp
