// What the ground makes of a flight over a known plane: heights, surface, COLMAP model, errors, report.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/ground/ground_run.hpp"
#include "sim/host/files.hpp"
#include "sim/host/image_io.hpp"
#include "tests/support/page_text.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::ground {
namespace {
namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
  const auto bytes = host::read_file(path);
  return {bytes.begin(), bytes.end()};
}

// One run for all tests that only look at its results.
class PlaneFlight : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<test::TemporaryFolder>();
    flight_ = test::make_flight(false);
    GroundOptions options;
    options.outbox = folder_->path() / "outbox";
    options.out = folder_->path() / "result";
    options.truth = folder_->path() / "truth";
    options.title = "Plane <of> \"test\"";
    test::write_outbox(flight_, options.outbox);
    test::write_truth(flight_, options.truth, 7.5, rotation_from_vector(Vec3(0.4, -0.9, 2.1)), Vec3(100, -50, 3));
    std::ostringstream messages;
    report_ = std::make_unique<report::Report>(run_ground(options, messages));
    // On a slow machine progress may be printed, and nothing else.
    for (const char* word : {"skipped", "missing", "quarantined"})
      EXPECT_EQ(messages.str().find(word), std::string::npos);
  }
  static void TearDownTestSuite() {
    report_.reset();
    folder_.reset();
  }
  static fs::path out() { return folder_->path() / "result"; }

  static inline std::unique_ptr<test::TemporaryFolder> folder_;
  static inline test::SyntheticFlight flight_;
  static inline std::unique_ptr<report::Report> report_;
};

struct Ply {
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<std::uint8_t, 3>> colours;
  std::vector<std::array<std::int32_t, 3>> faces;
};

// Reads exactly the layout that the header announces.
Ply read_ply(const fs::path& path) {
  const std::string file = text_of(path);
  const std::size_t body = file.find("end_header\n") + 11;
  std::istringstream header(file.substr(0, body));
  Ply ply;
  std::string word;
  std::size_t vertices = 0, faces = 0;
  while (header >> word) {
    if (word == "vertex") header >> vertices;
    if (word == "face") header >> faces;
  }
  EXPECT_EQ(file.size(), body + vertices * 15 + faces * 13);
  const char* at = file.data() + body;
  for (std::size_t i = 0; i < vertices; ++i, at += 15) {
    std::memcpy(ply.vertices.emplace_back().data(), at, 12);
    std::memcpy(ply.colours.emplace_back().data(), at + 12, 3);
  }
  for (std::size_t i = 0; i < faces; ++i, at += 13) {
    EXPECT_EQ(*at, 3);
    std::memcpy(ply.faces.emplace_back().data(), at + 1, 12);
  }
  return ply;
}

TEST_F(PlaneFlight, GridHeightsLieOnThePlaneAndCarryTheImage) {
  const report::StripResult& strip = report_->strips.at(0);
  ASSERT_TRUE(strip.grid);
  const map::GroundGrid& grid = *strip.grid;
  const host::Raster<float> height = host::read_pfm(out() / "height.pfm");
  const host::Raster<std::uint8_t> ortho = host::read_gray(out() / "ortho.png");
  ASSERT_EQ(height.width, grid.height.width);
  ASSERT_EQ(ortho.width, height.width);
  std::ifstream png(out() / "ortho.png", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(png), {}};
  EXPECT_EQ(bytes.substr(33, 10), std::string("\0\0\0\2tRNS\0\0", 10)) << "behind IHDR, grey 0";
  std::ifstream world(out() / "ortho.pgw");
  double cell = 0, skew = 0, minus_cell = 0, x0 = 0, y0 = 0;
  world >> cell >> skew >> skew >> minus_cell >> x0 >> y0;
  int covered = 0;
  double worst_height = 0, worst_grey = 0;
  for (int j = 0; j < height.height; ++j) {
    for (int i = 0; i < height.width; ++i) {
      if (!std::isfinite(height.at(i, j))) {
        ASSERT_EQ(ortho.at(i, j), 0) << "which is transparent";
        continue;
      }
      ASSERT_GT(ortho.at(i, j), 0);
      ++covered;
      const double x = x0 + i * cell, y = y0 + j * minus_cell;
      worst_height = std::max(worst_height, std::fabs(height.at(i, j) - test::plane_height(x, y)));
      worst_grey = std::max(worst_grey, std::fabs(ortho.at(i, j) - test::plane_grey(x, y)));
    }
  }
  // One step of the depth code is 2e-5 of inverse depth: 0.003 at a depth of 12.
  EXPECT_LT(worst_height, 0.02);
  // Half a cell (0.05) times the steepest grey (78 per unit) and rounding.
  EXPECT_LT(worst_grey, 6);
  EXPECT_GT(covered, 0.6 * height.width * height.height);
  // The plane's tilt, recovered.
  EXPECT_NEAR(strip.plane.a, 0.06, 1e-3);
  EXPECT_NEAR(strip.plane.b, -0.04, 1e-3);
}

TEST_F(PlaneFlight, CellIsTheGroundSampling) {
  // Depth about 10 to 15, focal length 120 px.
  EXPECT_NEAR(report_->strips.at(0).grid->cell, 12.0 / 120, 0.02);
}

TEST_F(PlaneFlight, SurfaceHasOneVertexPerCellOnThePlaneAndNoSeams) {
  const Ply ply = read_ply(out() / "model.ply");
  const std::vector<float>& heights = report_->strips.at(0).grid->height.samples;
  const auto expected =
      static_cast<std::size_t>(std::count_if(heights.begin(), heights.end(), [](float z) { return std::isfinite(z); }));
  EXPECT_EQ(ply.vertices.size(), expected);
  for (std::size_t i = 0; i < ply.vertices.size(); ++i) {
    const auto& [x, y, z] = ply.vertices[i];
    ASSERT_NEAR(z, test::plane_height(x, y), 0.02);
    ASSERT_NEAR(ply.colours[i][1], test::plane_grey(x, y), 6);
  }
  EXPECT_GT(ply.faces.size(), 1.8 * static_cast<double>(expected));
  for (const auto& f : ply.faces) {
    const auto& a = ply.vertices[static_cast<std::size_t>(f[0])];
    const auto& b = ply.vertices[static_cast<std::size_t>(f[1])];
    const auto& c = ply.vertices[static_cast<std::size_t>(f[2])];
    // Counter-clockwise from above.
    ASSERT_GT((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]), 0);
  }
}

TEST_F(PlaneFlight, AlignmentFindsTheSimilarityAndLeavesNoError) {
  ASSERT_TRUE(report_->strips.at(0).accuracy);
  const report::StripAccuracy& a = *report_->strips.at(0).accuracy;
  EXPECT_EQ(a.poses, 5U);
  EXPECT_NEAR(a.reference_from_strip.scale, 7.5, 1e-9);
  EXPECT_LT(a.position.max, 1e-9);
  EXPECT_LT(a.position_with_attitude.max, 1e-6);
  EXPECT_LT(a.rotation_rad.max, 1e-7);
  double length = 0;
  for (std::size_t i = 1; i < 5; ++i) length += 7.5 * (flight_.views[i].centre - flight_.views[i - 1].centre).norm();
  EXPECT_NEAR(a.length, length, 1e-9);
  EXPECT_NEAR(a.extent, 7.5 * (flight_.views[4].centre - flight_.views[0].centre).norm(), 1e-9);
  ASSERT_TRUE(a.depth_percent);
  EXPECT_EQ(a.depth_percent->count, 5U);
  EXPECT_LT(a.depth_percent->max, 0.02);
}

TEST_F(PlaneFlight, ReportJsonSaysTheSame) {
  const auto json = nlohmann::json::parse(text_of(out() / "report.json"));
  EXPECT_EQ(json["title"], "Plane <of> \"test\"");
  EXPECT_EQ(json["totals"]["final_poses"], 5);
  EXPECT_EQ(json["totals"]["products"], 10);
  EXPECT_EQ(json["totals"]["products_over_grant"], 0);
  EXPECT_EQ(json["keyframes"].size(), 5U);
  EXPECT_EQ(json["keyframes"][0]["name"], "frame-000000.png");
  EXPECT_EQ(json["keyframes"][0]["verdict"], "ok");
  EXPECT_EQ(json["keyframes"][0]["image_product"]["bytes"],
            fs::file_size(folder_->path() / "outbox" / "product-000001-image.jp2"));
  EXPECT_NEAR(json["strips"][0]["accuracy"]["scale_reference_from_strip"].get<double>(), 7.5, 1e-6);
  EXPECT_EQ(json["events"][0]["text"], "3 frames missing before frame 17");
  EXPECT_EQ(json["events"][0]["advice"], status_advice(StatusCode::frame_gap));
}

TEST_F(PlaneFlight, PageIsSelfContainedAndEscaped) {
  const std::string html = text_of(out() / "report.html");
  EXPECT_NE(html.find("Plane &lt;of&gt; &quot;test&quot;"), std::string::npos);
  EXPECT_EQ(html.find("Plane <of>"), std::string::npos);
  // With the colon: the letters alone may occur in an embedded picture.
  for (const char* foreign : {"http:", "https:", "url(//", "@import"}) {
    EXPECT_EQ(html.find(foreign), std::string::npos) << foreign;
  }
  EXPECT_EQ(html.find("<script src"), std::string::npos);
  EXPECT_EQ(html.find("<link"), std::string::npos);
  EXPECT_NE(html.find("<noscript><p>This page is drawn with JavaScript"), std::string::npos);
  const std::string open = "<script type=\"application/json\" id=\"report\">";
  const std::size_t begin = html.find(open) + open.size();
  EXPECT_EQ(nlohmann::ordered_json::parse(html.substr(begin, html.find("</script>", begin) - begin)),
            nlohmann::ordered_json::parse(text_of(out() / "report.json")));
}

TEST_F(PlaneFlight, TheTextOfThePageNamesNothingFromOutside) {
  ILP_NEED_TOOL("node");
  const std::string html = test::page_text(out() / "report.html");
  EXPECT_NE(html.find("Plane &lt;of&gt; &quot;test&quot;"), std::string::npos);
  for (const std::string attribute : {"src=\"", "href=\""}) {
    std::size_t found = 0;
    for (std::size_t at = html.find(attribute); at != std::string::npos; at = html.find(attribute, at + 1), ++found) {
      const std::size_t begin = at + attribute.size();
      const std::string to = html.substr(begin, html.find('"', begin) - begin);
      // A picture, or a file that lies beside the page.
      EXPECT_TRUE(to.starts_with("data:image/png;") || fs::is_regular_file(out() / to)) << to.substr(0, 40);
    }
    EXPECT_GT(found, 2U);
  }
  EXPECT_NE(html.find("3 frames missing before frame 17"), std::string::npos);
  EXPECT_NE(html.find(status_advice(StatusCode::frame_gap)), std::string::npos);
  for (const char* number :
       {">nan", ">-nan", ">inf", "\"nan", " nan", ">NaN", "\"NaN", " NaN", "undefined", "null", "[object"})
    EXPECT_EQ(html.find(number), std::string::npos) << number;
}

TEST_F(PlaneFlight, KeyframeFilesAreWrittenAndRight) {
  for (const char* name : {"000001-image.png", "000001-mask.png", "000001-depth.png", "000005-depth.pfm"}) {
    EXPECT_TRUE(fs::exists(out() / "keyframes" / name)) << name;
  }
  const host::Raster<float> depth = host::read_pfm(out() / "keyframes" / "000002-depth.pfm");
  const host::Raster<std::uint8_t> mask = host::read_gray(out() / "keyframes" / "000002-mask.png");
  for (int y = 0; y < depth.height; ++y) {
    for (int x = 0; x < depth.width; ++x) {
      const bool inside = test::newly_seen(flight_, 1, x, y);
      ASSERT_EQ(mask.at(x, y), inside ? 255 : 0);
      ASSERT_EQ(std::isfinite(depth.at(x, y)), inside);
      if (!inside) continue;
      ASSERT_NEAR(depth.at(x, y), test::plane_depth(flight_, flight_.views[1], x, y), 0.01);
    }
  }
}

struct ColmapImage {
  Mat3 rotation;
  Vec3 translation;
  std::string name;
  std::vector<std::array<double, 3>> points2d;
};

// Parsed by the format's description alone, and projected with COLMAP's own conventions.
void expect_consistent_colmap(const test::SyntheticFlight& flight, const fs::path& folder) {
  std::istringstream cameras(text_of(folder / "cameras.txt"));
  std::string line;
  while (std::getline(cameras, line) && line[0] == '#') {
  }
  std::istringstream camera_line(line);
  int id = 0;
  std::string model;
  CameraModel camera;
  camera_line >> id >> model >> camera.width >> camera.height >> camera.fx >> camera.fy >> camera.cx >> camera.cy;
  EXPECT_EQ(model, flight.camera.has_distortion() ? "OPENCV" : "PINHOLE");
  if (model == "OPENCV") camera_line >> camera.k1 >> camera.k2 >> camera.p1 >> camera.p2;
  ASSERT_TRUE(camera_line);
  // colmap_pixel adds the half pixel that this file already has.
  camera.cx -= 0.5;
  camera.cy -= 0.5;

  std::map<int, ColmapImage> images;
  std::istringstream image_file(text_of(folder / "images.txt"));
  while (std::getline(image_file, line)) {
    if (line[0] == '#') continue;
    std::istringstream in(line);
    int camera_id = 0;
    double q[4];
    ColmapImage image;
    in >> id >> q[0] >> q[1] >> q[2] >> q[3] >> image.translation[0] >> image.translation[1] >> image.translation[2] >>
        camera_id >> image.name;
    ASSERT_TRUE(in);
    EXPECT_EQ(camera_id, 1);
    image.rotation = rotation_from_quaternion(q);
    std::getline(image_file, line);
    std::istringstream points(line);
    for (std::array<double, 3> p; points >> p[0] >> p[1] >> p[2];) image.points2d.push_back(p);
    images[id] = image;
  }
  ASSERT_EQ(images.size(), flight.views.size());
  for (const auto& view : flight.views) {
    const ColmapImage& image = images.at(static_cast<int>(view.keyframe_id));
    EXPECT_EQ(image.name, view.name);
    EXPECT_LT((-(image.rotation.transpose() * image.translation) - view.centre).norm(), 1e-9);
  }

  std::size_t observations = 0, points = 0, listed = 0;
  std::istringstream point_file(text_of(folder / "points3D.txt"));
  while (std::getline(point_file, line)) {
    if (line[0] == '#') continue;
    std::istringstream in(line);
    double point_id = 0, r = 0, g = 0, b = 0, error = 0;
    Vec3 world;
    in >> point_id >> world[0] >> world[1] >> world[2] >> r >> g >> b >> error;
    EXPECT_NEAR(world.z(), test::plane_height(world.x(), world.y()), 1e-12);
    ++points;
    int track = 0;
    for (std::size_t image_id = 0, index = 0; in >> image_id >> index; ++track) {
      const ColmapImage& image = images.at(static_cast<int>(image_id));
      const auto& seen = image.points2d.at(index);
      EXPECT_EQ(seen[2], point_id);
      const Vec2 projected = test::colmap_pixel(camera, image.rotation, image.translation, world);
      EXPECT_NEAR(seen[0], projected.x(), 1e-4);
      EXPECT_NEAR(seen[1], projected.y(), 1e-4);
      ++observations;
    }
    EXPECT_GE(track, 2);
  }
  for (const auto& [image_id, image] : images) listed += image.points2d.size();
  EXPECT_EQ(listed, observations);
  EXPECT_GT(points, 40U);
}

TEST_F(PlaneFlight, ColmapModelReprojects) {
  expect_consistent_colmap(flight_, out() / "colmap");
}

TEST(Colmap, DistortedCameraReprojectsToo) {
  const test::TemporaryFolder folder;
  const test::SyntheticFlight flight = test::make_flight(true);
  test::write_outbox(flight, folder.path() / "outbox");
  // Without products no frame name came down; the database or the truth would have it.
  GroundOptions options{.outbox = folder.path() / "outbox", .out = folder.path() / "result"};
  std::ostringstream messages;
  (void)run_ground(options, messages);
  test::SyntheticFlight unnamed = flight;
  for (auto& view : unnamed.views) view.name = "keyframe-" + host::six_digits(view.keyframe_id);
  expect_consistent_colmap(unnamed, options.out / "colmap");
}

TEST(Strips, EachHasFilesOfItsOwnAndTheFirstPosedOneThePlainNames) {
  const test::TemporaryFolder folder;
  test::SyntheticFlight flight = test::make_flight(false);
  flight.views[3].strip_id = flight.views[4].strip_id = 2;
  test::write_outbox(flight, folder.path() / "outbox");
  GroundOptions options{.outbox = folder.path() / "outbox", .out = folder.path() / "result", .max_vertices = 2000};
  std::ostringstream messages;
  const report::Report report = run_ground(options, messages);
  ASSERT_EQ(report.strips.size(), 2U);
  for (const char* name :
       {"model.ply", "model-strip-2.ply", "colmap/images.txt", "colmap-strip-2/images.txt", "height-strip-2.pfm"}) {
    EXPECT_TRUE(fs::exists(options.out / name)) << name;
  }
  EXPECT_LE(report.strips[0].vertices, 2000U);
  EXPECT_GT(report.strips[0].stride, 1);
  for (const auto& [x, y, z] : read_ply(options.out / "model.ply").vertices) {
    ASSERT_NEAR(z, test::plane_height(x, y), 0.02);
  }
  EXPECT_EQ(report.strips[1].colmap.images, 2U);
}

TEST(GroundRun, LeavesNothingOfAnEarlierRunButForeignFiles) {
  const test::TemporaryFolder folder;
  const test::SyntheticFlight flight = test::make_flight(false);
  test::write_outbox(flight, folder.path() / "outbox");
  GroundOptions options{.outbox = folder.path() / "outbox", .out = folder.path() / "result"};
  fs::create_directories(options.out / "colmap-strip-2");
  fs::create_directories(options.out / "keyframes");
  for (const char* name : {"model-strip-2.ply", "colmap-strip-2/images.txt", "keyframes/000099-image.png", "notes.txt",
                           "keyframes/holiday.png", "sigma-matching-strip-2.tif", "landing-sites-strip-2.geojson"}) {
    host::write_file(options.out / name, std::string_view("old"));
  }
  std::ostringstream messages;
  (void)run_ground(options, messages);
  EXPECT_FALSE(fs::exists(options.out / "model-strip-2.ply"));
  EXPECT_FALSE(fs::exists(options.out / "sigma-matching-strip-2.tif"));
  EXPECT_FALSE(fs::exists(options.out / "landing-sites-strip-2.geojson"));
  EXPECT_FALSE(fs::exists(options.out / "colmap-strip-2"));
  EXPECT_FALSE(fs::exists(options.out / "keyframes" / "000099-image.png"));
  EXPECT_TRUE(fs::exists(options.out / "notes.txt"));
  EXPECT_TRUE(fs::exists(options.out / "keyframes" / "holiday.png"));
}

TEST(Surface, IsCutAtDepthJumps) {
  intake::Keyframe keyframe;
  keyframe.camera = {16, 16, 100, 100, 8, 8, 0, 0, 0, 0};
  keyframe.pose = PoseRecord{};
  keyframe.pose->state = PoseState::final;
  keyframe.inverse_depth = host::Raster<float>(16, 16, 1.0F / 10);
  for (int y = 0; y < 16; ++y) {
    for (int x = 8; x < 16; ++x) keyframe.inverse_depth.at(x, y) = 1.0F / 11;  // ten pixel footprints deeper
  }
  map::PixelRays rays;
  const map::SurfaceMesh mesh = map::keyframe_surface(keyframe, keyframe, {}, rays);
  EXPECT_EQ(mesh.vertices.size(), 256U);
  EXPECT_EQ(mesh.faces.size(), 2U * 15 * 14);  // one column of cells is missing
  for (const auto& f : mesh.faces) {
    EXPECT_NEAR(mesh.vertices[f[0]].z, mesh.vertices[f[1]].z, 1e-4);
    EXPECT_NEAR(mesh.vertices[f[0]].z, mesh.vertices[f[2]].z, 1e-4);
  }
}

TEST(GroundGrid, APieceOfTwoPixelsIsAPieceLikeAnyOther) {
  intake::Flight flight;
  intake::Strip strip;
  for (const std::int64_t id : {1, 2}) {
    intake::Keyframe& keyframe = flight.keyframes[id];
    keyframe.camera = {16, 16, 100, 100, 8, 8, 0, 0, 0, 0};
    keyframe.pose = PoseRecord{};
    keyframe.pose->state = PoseState::final;
    keyframe.inverse_depth = host::Raster<float>(16, 16, id == 1 ? 1.0F / 10 : 0.0F);
    strip.keyframes.push_back(id);
  }
  flight.keyframes[2].inverse_depth.at(14, 3) = flight.keyframes[2].inverse_depth.at(13, 3) = 1.0F / 10;
  const std::optional<map::GroundGrid> grid = map::build_grid(flight, strip, {});
  ASSERT_TRUE(grid);
  EXPECT_NEAR(grid->cell, 0.1, 1e-6);
}

TEST(Alignment, LeavesWhatNoSimilarityCanExplain) {
  // Corners of a square lifted by turns: orthogonal to every translation, rotation and scaling, so all of it remains.
  const std::vector<Vec3> square{{1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}};
  std::vector<Vec3> bent = square;
  for (std::size_t i = 0; i < 4; ++i) bent[i].z() = i % 2 == 0 ? 0.01 : -0.01;
  const auto s = host::align_positions(bent, square);
  ASSERT_TRUE(s);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(((*s) * bent[i] - square[i]).norm(), 0.01, 1e-5);
}

TEST(Alignment, NeverMirrors) {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  std::vector<Vec3> mirrored = points;
  for (Vec3& p : mirrored) p.x() = -p.x();
  const auto s = host::align_positions(points, mirrored);
  ASSERT_TRUE(s);
  EXPECT_NEAR(s->rotation.determinant(), 1, 1e-9);
}

TEST(Alignment, CoincidentPositionsHaveNone) {
  const std::vector<Vec3> same(3, Vec3(1, 2, 3));
  EXPECT_FALSE(host::align_positions(same, same));
  EXPECT_FALSE(host::align_positions({Vec3(0, 0, 0)}, {Vec3(0, 0, 0)}));
}

class ScaledTruth final : public report::Reference {
 public:
  explicit ScaledTruth(const test::SyntheticFlight& flight, double depth_factor)
      : flight_(flight), depth_factor_(depth_factor) {
    for (const auto& view : flight.views) poses_[view.name] = {view.cam_from_world, view.centre};
  }
  const report::ReferencePose* pose(const std::string& name) const override {
    const auto found = poses_.find(name);
    return found == poses_.end() ? nullptr : &found->second;
  }
  host::Raster<float> depth(const std::string& name) const override {
    host::Raster<float> z(flight_.camera.width, flight_.camera.height);
    for (const auto& view : flight_.views) {
      if (view.name != name) continue;
      for (int y = 0; y < z.height; ++y) {
        for (int x = 0; x < z.width; ++x)
          z.at(x, y) = static_cast<float>(depth_factor_ * test::plane_depth(flight_, view, x, y));
      }
    }
    return z;
  }

 private:
  const test::SyntheticFlight& flight_;
  double depth_factor_;
  std::map<std::string, report::ReferencePose> poses_;
};

TEST(Accuracy, DepthsThatContradictThePositionsScaleAreAnError) {
  const test::TemporaryFolder folder;
  const test::SyntheticFlight flight = test::make_flight(false);
  test::write_outbox(flight, folder.path());
  intake::Outbox outbox = intake::read_outbox(folder.path());
  const intake::Flight decoded = intake::build_flight(outbox);
  const auto accuracy = report::measure_accuracy(decoded, decoded.strips.at(1), ScaledTruth(flight, 1.02));
  ASSERT_TRUE(accuracy && accuracy->depth_percent);
  const report::DepthAccuracy& depth = *accuracy->keyframes.at(1).depth;
  // Our depths are z where 1.02 z is true: 1.96 per cent of the flying height too low, nearly everywhere; the shape is
  // right.
  EXPECT_NEAR(depth.median_abs_percent, 100 * 0.02 / 1.02, 0.1);
  EXPECT_NEAR(depth.bias_percent, -100 * 0.02 / 1.02, 0.1);
  EXPECT_LT(depth.own_scale_percent, 0.02);
}

TEST(Names, AreMadeSafe) {
  EXPECT_EQ(host::safe_name("../../etc/passwd"), "passwd");
  EXPECT_EQ(host::safe_name("a b<c>.png"), "a_b_c_.png");
  EXPECT_EQ(host::safe_name(".."), "");
  EXPECT_EQ(host::stem("IMG_1.png"), "IMG_1");
  EXPECT_EQ(host::six_digits(42), "000042");
}

}  // namespace
}  // namespace ilp::ground
