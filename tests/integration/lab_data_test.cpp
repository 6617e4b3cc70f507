// ilp-lab on the shared data, against their ground truth.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "sim/host/image_io.hpp"
#include "tests/integration/lab_program.hpp"
#include "tests/support/alignment.hpp"
#include "tests/support/strip.hpp"

namespace ilp::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double degrees = 180 / 3.14159265358979323846;

class LabData : public LabTest {
 protected:
  /// Matches of a data file (their last column is the truth about inliers, which the lab must not see) as a list for
  /// the lab.
  [[nodiscard]] std::string match_list(const std::vector<std::vector<double>>& lines, std::size_t first) const {
    std::ostringstream text;
    text.precision(12);
    for (std::size_t i = first; i < lines.size(); ++i) {
      text << lines[i][0] << " " << lines[i][1] << " " << lines[i][2] << " " << lines[i][3] << "\n";
    }
    return write("m.txt", text.str());
  }
  struct PoseError {
    double rotation_deg = 180, direction_deg = 180;
  };
  static PoseError error_of(const LabRun& run, const std::vector<double>& r, const Vector3d& direction) {
    if (run.status != 0 || run.json["rotation_b_from_a"].is_null()) return {};
    const auto q = run.json["rotation_b_from_a"].get<std::vector<double>>();
    const auto t = run.json["direction_b"].get<std::vector<double>>();
    Matrix3d truth;
    truth << r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8];
    const double cosine = std::clamp(Vector3d(t[0], t[1], t[2]).dot(direction.normalized()), -1.0, 1.0);
    return {degrees * Quaterniond(q[0], q[1], q[2], q[3]).angularDistance(Quaterniond(truth)),
            degrees * std::acos(cosine)};
  }
};

TEST_F(LabData, RelativePoseOfRealMatches) {
  if (shared("relative_pose_strecha").empty()) GTEST_SKIP() << "no ../shared/data/relative_pose_strecha";
  for (const char* pair : {"fountain_0000_0001", "fountain_0004_0005", "fountain_0005_0007", "fountain_0009_0010",
                           "entry_0000_0001", "entry_0004_0005", "entry_0007_0008"}) {
    const auto lines = read_numbers(shared(std::string("relative_pose_strecha/") + pair + ".txt"));
    ASSERT_GT(lines.size(), 100U);
    const auto& k = lines[0];
    std::ostringstream camera;
    camera.precision(12);
    camera << "1 PINHOLE 768 512 " << k[0] << " " << k[1] << " " << k[2] + 0.5 << " " << k[3] + 0.5 << "\n";
    const LabRun run = lab("relpose " + match_list(lines, 6) + " --camera " + write("c.txt", camera.str()));
    const PoseError error = error_of(run, lines[2], Vector3d(lines[3][0], lines[3][1], lines[3][2]));
    EXPECT_LT(error.rotation_deg, 0.3) << pair;
    EXPECT_LT(error.direction_deg, 1.0) << pair;
  }
}

TEST_F(LabData, RelativePoseOverPlanesLinesAndRelief) {
  if (shared("relative_pose_synthetic").empty()) GTEST_SKIP() << "no ../shared/data/relative_pose_synthetic";
  const std::string camera = write("c.txt", pinhole_text(640, 480, 700, 319.5, 239.5));
  for (int scene = 0; scene < 6; ++scene) {
    std::vector<double> rotation, direction;
    for (int trial = 0; trial < 4; ++trial) {
      const std::string name = std::to_string(scene) + "_o30_n05_00" + std::to_string(trial) + ".txt";
      const auto lines = read_numbers(shared("relative_pose_synthetic/" + name));
      ASSERT_GT(lines.size(), 100U) << name;
      const auto& truth = lines[0];
      const LabRun run = lab("relpose " + match_list(lines, 1) + " --camera " + camera);
      const PoseError error = error_of(run, truth, Vector3d(truth[9], truth[10], truth[11]));
      rotation.push_back(error.rotation_deg);
      direction.push_back(error.direction_deg);
    }
    EXPECT_LT(*std::max_element(rotation.begin(), rotation.end()), 2) << "scene " << scene;
    EXPECT_LT(*std::max_element(direction.begin(), direction.end()), 10) << "scene " << scene;
  }
}

/// Share of the pixels with known disparity (and visible in both images, where that is known) that are off by more than
/// 2 px; those without an answer count.
double bad_share(const std::string& folder, const host::Raster<float>& disparity) {
  const Image16 truth = read_image16(folder + "/disp_left_x256.png");
  const Image visible = read_image(folder + "/nonocc_left.png");
  std::size_t known = 0, bad = 0;
  for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
    if (truth.pixels[i] == 0 || (!visible.empty() && visible.pixels[i] == 0)) continue;
    ++known;
    const double error = std::fabs(static_cast<double>(disparity.samples[i]) - truth.pixels[i] / 256.0);
    bad += error <= 2 ? 0 : 1;
  }
  return static_cast<double>(bad) / static_cast<double>(known);
}

TEST_F(LabData, StereoOfMiddlebury) {
  const struct {
    const char* name;
    const char* range;
    double bad;
  } pairs[] = {{"tsukuba", " --min-disparity 0 --max-disparity 15", 0.12},
               {"cones", " --min-disparity 0 --max-disparity 63", 0.18},
               {"motorcycle", " --min-disparity 0 --max-disparity 63", 0.2}};
  for (const auto& pair : pairs) {
    const std::string folder = shared(std::string("stereo_middlebury/") + pair.name);
    if (folder.empty()) GTEST_SKIP() << "no ../shared/data/stereo_middlebury";
    lab_done("stereo " + folder + "/left.png " + folder + "/right.png" + pair.range + " --out " + path("d.pfm"));
    const double bad = bad_share(folder, host::read_pfm(path("d.pfm")));
    EXPECT_LT(bad, pair.bad) << pair.name;
    EXPECT_GT(bad, 0) << pair.name;
    RecordProperty(pair.name, std::to_string(bad));
  }
}

TEST_F(LabData, OverlapAndMatchesOfAnAerialPair) {
  const std::string images = shared("aerial_caliterra_a/images");
  if (images.empty()) GTEST_SKIP() << "no ../shared/data/aerial_caliterra_a";
  const std::string pair = images + "/IMG_9363.png " + images + "/IMG_9364.png";
  const LabRun overlap = lab_done("overlap " + pair);
  EXPECT_EQ(overlap.verdict(), "ok");
  lab_done("match " + pair + " --out " + path("m.txt"));
  const std::vector<StripImage> strip = read_strip("aerial_caliterra_a");
  const auto matches = read_numbers(path("m.txt"));
  ASSERT_GT(matches.size(), 300U);
  std::size_t near = 0;
  for (const auto& m : matches) near += epipolar_distance(strip[0], strip[1], m[0], m[1], m[2], m[3]) < 1.5 ? 1 : 0;
  EXPECT_GT(static_cast<double>(near), 0.95 * static_cast<double>(matches.size()));
}

struct PosedImage {
  std::string name;
  Vector3d centre;
};

std::vector<PosedImage> read_model_centres(const std::string& file) {
  std::ifstream in(file);
  std::vector<PosedImage> images;
  bool pose_line = true;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty() && line[0] == '#') continue;
    if (pose_line) {
      std::istringstream words(line);
      double id = 0, w = 0, x = 0, y = 0, z = 0, camera = 0;
      Vector3d t;
      PosedImage image;
      words >> id >> w >> x >> y >> z >> t.x() >> t.y() >> t.z() >> camera >> image.name;
      image.centre = -(Quaterniond(w, x, y, z).inverse() * t);
      images.push_back(image);
    }
    pose_line = !pose_line;
  }
  return images;
}

TEST_F(LabData, PosesOfAnAerialStripAndARectifiedPairOfThem) {
  const std::string folder = shared("aerial_caliterra_a");
  if (folder.empty()) GTEST_SKIP() << "no ../shared/data/aerial_caliterra_a";
  const std::string model = path("model");
  const LabRun run = lab_done("pose-strip " + folder + " --camera " + folder +
                              "/colmap/cameras.txt --target-overlap 0.98" + " --out " + model);
  // Poses of several images take longer than a millisecond on any processor.
  EXPECT_GT(run.number("motion_ms"), 1);
  EXPECT_GE(run.number("kernel_ms"), run.number("motion_ms"));
  EXPECT_EQ(run.verdict(), "ok");
  const std::vector<PosedImage> posed = read_model_centres(model + "/images.txt");
  ASSERT_GE(posed.size(), 6U);
  ASSERT_EQ(posed.size(), run.json["images"].get<std::size_t>());
  std::vector<Vector3d> estimates, references;
  for (const StripImage& truth : read_strip("aerial_caliterra_a")) {
    for (const PosedImage& image : posed) {
      if (image.name != truth.name) continue;
      estimates.push_back(image.centre);
      references.emplace_back(truth.centre[0], truth.centre[1], truth.centre[2]);
    }
  }
  ASSERT_EQ(estimates.size(), posed.size());
  const double length = (references.back() - references.front()).norm();
  EXPECT_LT(alignment_errors(estimates, references).mean, 0.003 * length);

  const LabRun apart = lab_done("pose-strip " + folder + " --camera " + folder +
                                "/colmap/cameras.txt --target-overlap 0.98" + " --apart --out " + path("apart"));
  // Nothing of one strip joins it.
  EXPECT_EQ(apart.json["strips"][0]["observations"], run.json["strips"][0]["observations"]);

  const LabRun rectified = lab_done("rectify " + folder + "/images/" + posed[0].name + " " + folder + "/images/" +
                                    posed[1].name + " --model " + model + " --out " + path("rect"));
  EXPECT_EQ(rectified.verdict(), "ok");
  EXPECT_LT(rectified.number("max_vertical_error_px"), 1e-6);
  EXPECT_LT(rectified.number("median_observed_vertical_error_px"), 0.5);
  EXPECT_GT(rectified.number("observed_points"), 100);
}

TEST_F(LabData, StripsOfABrokenSurveyAreJoinedAsTheGroundJoinsThem) {
  const std::string folder = shared("revisit_seneca_farm");
  if (folder.empty()) GTEST_SKIP() << "no ../shared/data/revisit_seneca_farm";
  const LabRun run =
      lab_done("pose-strip " + folder + " --camera " + folder + "/colmap/cameras.txt --out " + path("model"));
  ASSERT_EQ(run.json["joined"].size(), 1U) << run.out;
  EXPECT_GE(run.json["joined"][0]["strips"].size(), 10U);
  const std::vector<PosedImage> posed = read_model_centres(path("model/images.txt"));
  ASSERT_GE(posed.size(), 30U);
  std::vector<Vector3d> estimates, references;
  double extent = 0;
  for (const StripImage& truth : read_strip("revisit_seneca_farm")) {
    for (const PosedImage& image : posed) {
      if (image.name != truth.name) continue;
      estimates.push_back(image.centre);
      references.emplace_back(truth.centre[0], truth.centre[1], truth.centre[2]);
    }
  }
  ASSERT_EQ(estimates.size(), posed.size());
  for (std::size_t i = 0; i < references.size(); ++i) extent = std::max(extent, (references[i] - references[0]).norm());
  EXPECT_LT(alignment_errors(estimates, references).mean, 0.01 * extent);
}

}  // namespace
}  // namespace ilp::test
