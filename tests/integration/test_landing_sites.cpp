// Landing sites that a flight finds, against the true ground of its world: rocks and slopes that the simulator planted.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/host/alignment.hpp"
#include "sim/host/geo_raster.hpp"
#include "sim/host/reference_cameras.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

#ifdef ILP_FIFTEEN_FLIGHTS
constexpr int first_seed = 401, flights = 15;
#else
constexpr int first_seed = 301, flights = 1;
#endif
constexpr double footprint_m = 6, slope_deg = 8, step_m = 1.4;

std::vector<std::string> sil_words(int seed, const fs::path& out) {
  // Few and many rocks, gentle and rugged ground.
  const std::array<const char*, 3> rocks = {"0.2", "0.5", "0.8"}, ruggedness = {"0.6", "1", "1.6"};
  const auto kind = static_cast<std::size_t>(seed);
  return {ILP_SIL,
          "--scenario",
          "mars-plains",
          "--frames",
          "30",
          "--seed",
          std::to_string(seed),
          "--out",
          out,
          "--set",
          "navigation.altimeter=true",
          "--set",
          "navigation.attitude=true",
          "--set",
          "navigation.position=true",
          "--set",
          std::string("world.rock_density=") + rocks[kind % 3],
          "--set",
          std::string("world.ruggedness=") + ruggedness[kind / 3 % 3],
          "--set",
          std::string("world.largest_rock_radius_m=") + (kind % 2 == 0 ? "1.4" : "2.2")};
}

/// Truth from the axes of the strip, by the cameras.
host::Similarity3 truth_from_strip(const fs::path& flight, const fs::path& ground) {
  const auto cameras = host::read_reference_cameras(flight / "flight/truth/poses.txt");
  std::map<std::string, const host::ReferenceCamera*> by_name;
  for (const auto& camera : cameras) by_name[fs::path(camera.name).stem()] = &camera;
  std::vector<Vec3> reported, truth;
  std::vector<Mat3> given_attitude, true_attitude;
  std::ifstream images(ground / "colmap/images.txt");
  for (std::string line; std::getline(images, line);) {
    if (line.starts_with("#")) continue;
    std::istringstream words(line);
    std::int64_t id = 0;
    int camera = 0;
    std::array<double, 4> q{};
    Vec3 t;
    std::string name;
    words >> id >> q[0] >> q[1] >> q[2] >> q[3] >> t[0] >> t[1] >> t[2] >> camera >> name;
    std::getline(images, line);  // of its points
    const auto found = by_name.find(fs::path(name).stem());
    if (found == by_name.end()) continue;
    const Mat3 turn = rotation_from_quaternion(q.data());
    reported.emplace_back(-(turn.transpose() * t));
    given_attitude.push_back(turn);
    truth.push_back(found->second->centre);
    true_attitude.push_back(found->second->cam_from_world);
  }
  const auto fit = host::align_cameras(reported, given_attitude, truth, true_attitude, 100);
  EXPECT_TRUE(fit);
  return fit.value_or(host::Similarity3());
}

struct TrueHazard {
  bool known = false;
  double slope_deg = 0, step_m = 0;
  [[nodiscard]] bool safe() const { return slope_deg <= ::ilp::slope_deg && step_m <= ::ilp::step_m; }
};

/// By all true heights in the circle.
TrueHazard hazard_at(const host::GeoRaster& truth, double x, double y) {
  const host::RasterPlace& place = *truth.place;
  const double radius = footprint_m / 2;
  const auto column = [&](double at) {
    return static_cast<std::int32_t>(std::lround((at - place.x) / place.spacing_x));
  };
  const auto row = [&](double at) { return static_cast<std::int32_t>(std::lround((place.y - at) / place.spacing_y)); };
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  std::vector<Vec3> heights;
  for (std::int32_t j = row(y + radius) - 1; j <= row(y - radius) + 1; ++j) {
    for (std::int32_t i = column(x - radius) - 1; i <= column(x + radius) + 1; ++i) {
      const Vec3 at(place.x + i * place.spacing_x - x, place.y - j * place.spacing_y - y, 1);
      if (at.x() * at.x() + at.y() * at.y() > radius * radius) continue;
      if (!truth.values.contains(i, j) || !std::isfinite(truth.values.at(i, j))) return {};
      const double z = truth.values.at(i, j);
      normal += at * at.transpose();
      right += z * at;
      heights.emplace_back(at.x(), at.y(), z);
    }
  }
  const Vec3 plane = normal.inverse() * right;
  double low = 1e9, high = -1e9;
  for (const Vec3& h : heights) {
    const double off = h.z() - plane.x() * h.x() - plane.y() * h.y() - plane.z();
    low = std::min(low, off);
    high = std::max(high, off);
  }
  const double gradient = std::sqrt(plane.x() * plane.x() + plane.y() * plane.y());
  return {true, std::atan(gradient) * 57.29577951308232, high - low};
}

struct Bin {
  double count = 0, reported = 0, safe = 0;
};

/// Sites, and cells of the map two metres apart.
void measure(const fs::path& flight, const fs::path& ground, std::array<Bin, 10>& bins, int& sites, int& unsafe) {
  const nlohmann::json report = nlohmann::json::parse(std::ifstream(ground / "report.json"));
  const auto& landing = report.at("landing").at(0);
  ASSERT_EQ(landing.at("fault"), "");
  const host::Similarity3 to_truth = truth_from_strip(flight, ground);
  const host::GeoRaster truth = host::read_raster(flight / "flight/truth/height.tif");
  ASSERT_TRUE(truth.place);
  double ground_z = 0;
  for (const auto& site : landing.at("sites")) {
    const auto& at = site.at("place");
    const Vec3 place = to_truth * Vec3(at[0], at[1], at[2]);
    ground_z = at[2];
    const TrueHazard hazard = hazard_at(truth, place.x(), place.y());
    if (!hazard.known) continue;
    ++sites;
    if (hazard.safe()) continue;
    ++unsafe;
    std::printf("unsafe site in %s: told %s, true slope %.1f degrees, step %.2f m\n", flight.c_str(),
                site.dump().c_str(), hazard.slope_deg, hazard.step_m);
  }
  const host::GeoRaster safe = host::read_raster(ground / "landing-safe.tif");
  ASSERT_TRUE(safe.place);
  for (std::int32_t row = 0; row < safe.values.height; row += 10) {
    for (std::int32_t column = 0; column < safe.values.width; column += 10) {
      const float reported = safe.values.at(column, row);
      if (!std::isfinite(reported)) continue;
      const Vec3 place = to_truth * Vec3(safe.place->x + column * safe.place->spacing_x,
                                         safe.place->y - row * safe.place->spacing_y, ground_z);
      const TrueHazard hazard = hazard_at(truth, place.x(), place.y());
      if (!hazard.known) continue;
      Bin& bin = bins[static_cast<std::size_t>(std::clamp(static_cast<int>(10 * reported), 0, 9))];
      bin.count += 1;
      bin.reported += reported;
      bin.safe += hazard.safe() ? 1 : 0;
    }
  }
}

TEST(LandingSites, AreSafeAndAsProbableAsToldOnTheTrueGround) {
  const test::TemporaryFolder scratch;
  std::array<Bin, 10> bins{};
  int sites = 0, unsafe = 0;
  for (int seed = first_seed; seed < first_seed + flights; ++seed) {
    const fs::path flight = scratch.path() / std::to_string(seed), ground = flight / "ground";
    test::run_well(sil_words(seed, flight));
    const test::ProgramResult mapped =
        test::run_well({ILP_GROUND, flight / "outbox", "--out", ground, "--landing-sites", "6,8,1.4"});
    EXPECT_NE(mapped.output.find("Landing sites of strip 1: "), std::string::npos) << mapped.output;
    EXPECT_TRUE(fs::exists(ground / "landing-sites.geojson"));
    measure(flight, ground, bins, sites, unsafe);
    fs::remove_all(flight);
  }
  std::printf("%d sites, %d of them unsafe\n", sites, unsafe);
  EXPECT_GE(sites, 8 * flights) << "of the ten best of each flight";
  EXPECT_EQ(unsafe, 0);
  for (const Bin& bin : bins) {
    if (bin.count == 0) continue;
    const double reported = bin.reported / bin.count, safe = bin.safe / bin.count;
    std::printf("told %.3f, true %.3f of %.0f\n", reported, safe, bin.count);
    // Of one flight all cells have its ground in common.
    if (bin.count < 100) continue;
    EXPECT_NEAR(reported, safe, flights > 1 ? 0.1 : 0.25);
  }
}

TEST(LandingSites, AreRefusedWhereTheFlightDoesNotKnowWhatIsUp) {
  const test::TemporaryFolder scratch;
  const fs::path flight = test::prepared_flights() / "uninterrupted";
  const test::ProgramResult mapped =
      test::run_well({ILP_GROUND, flight / "outbox", "--out", scratch.path() / "ground", "--landing-sites", "6,8,1.4"});
  EXPECT_NE(mapped.output.find("none can be found: strip 1 does not know what is up"), std::string::npos)
      << mapped.output;
  EXPECT_FALSE(fs::exists(scratch.path() / "ground/landing-safe.tif"));
  const test::ProgramResult wrong = test::run_program(
      {ILP_GROUND, flight / "outbox", "--out", scratch.path() / "other", "--landing-sites", "6,95,1.4"});
  EXPECT_NE(wrong.exit_status, 0);
  EXPECT_NE(wrong.output.find("from 0.100 to 60.0 degrees"), std::string::npos) << wrong.output;
}

}  // namespace
}  // namespace ilp
