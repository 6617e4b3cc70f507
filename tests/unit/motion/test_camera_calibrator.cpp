// Keyframes over terrain given by a formula, posed as they are in flight: the camera is found, freezes once, is
// contradicted, and the search goes on after restarts and failing reads.
#include "fsw/motion/camera_calibrator.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <set>

#include "fsw/motion/structure_and_motion.hpp"
#include "fsw/shared/body_figure.hpp"
#include "fsw/shared/camera_on_record.hpp"
#include "tests/support/level_plane.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/unit/shared/executed_component.hpp"
#include "tests/unit/vision/stereo/analytic_scene.hpp"

namespace ilp {
namespace {

constexpr double height = 100;
constexpr std::int64_t keyframes = 12;

double rugged(double x, double y) {
  return 16 * std::sin(x / 19) * std::cos(y / 15) + 7 * std::sin((x + y) / 9);
}
double flat(double, double) {
  return 0;
}

CameraModel true_camera() {
  CameraModel camera = test::distorting_camera();
  camera.k1 = -0.05;
  camera.k2 = camera.p1 = camera.p2 = 0;
  camera.fy = camera.fx;
  camera.cx = 0.5 * (camera.width - 1);
  camera.cy = 0.5 * (camera.height - 1);
  return camera;
}

/// Swinging about both axes, as below a balloon; 0: it looks straight down.
RigidTransform pose_at(std::int64_t i, double swing = 1) {
  const auto t = static_cast<double>(i);
  const Vec3 turn = swing * Vec3(0.11 * std::sin(1.9 * t), 0.10 * std::cos(1.3 * t), 0.12 * std::sin(0.7 * t));
  return test::looking_down(Vec3(11 * t, 3 * std::sin(t), height + 2 * std::cos(0.8 * t)), turn);
}

const std::vector<test::View>& views(const test::Terrain& terrain, std::vector<test::View>& rendered,
                                     double swing = 1) {
  for (std::int64_t i = 0; rendered.size() < static_cast<std::size_t>(keyframes); ++i) {
    rendered.push_back(
        test::render_view(true_camera(), pose_at(i, swing), terrain, 2, 1, static_cast<std::uint64_t>(i + 1)));
  }
  return rendered;
}
const std::vector<test::View>& rugged_views() {
  static std::vector<test::View> rendered;
  return views(rugged, rendered);
}
const std::vector<test::View>& flat_views() {
  static std::vector<test::View> rendered;
  return views(flat, rendered);
}

const std::vector<test::View>& level_views() {
  static std::vector<test::View> rendered;
  return views(flat, rendered, 0);
}

class CameraCalibratorTest : public test::ComponentTest {
 protected:
  CameraCalibratorTest() { mission.camera_known = 0; }

  /// The camera's focal length as the flight takes it to be, and whether that is frozen.
  void fly(const std::vector<test::View>& seen, double focal_factor, bool frozen) {
    CameraModel taken = true_camera();
    taken.fx *= focal_factor;
    taken.fy *= focal_factor;
    if (!frozen) taken.k1 = 0;
    write(frozen ? camera_record(taken) : nominal_camera_record(taken));
    for (std::int64_t id = 1; id <= keyframes; ++id) {
      const test::View& view = seen[static_cast<std::size_t>(id - 1)];
      write_frame(id, view.image);
      KeyframeRecord keyframe;
      keyframe.id = keyframe.frame_id = id;
      keyframe.strip_id = 1;
      keyframe.index = static_cast<std::int32_t>(id - 1);
      keyframe.time_ns = id * 60 * ns_per_s;
      if (id > 1) test::put_level_plane(seen[static_cast<std::size_t>(id - 2)], view, keyframe);
      write(keyframe);
    }
    StripRecord strip{.id = 1, .first_keyframe_id = 1, .last_keyframe_id = keyframes, .end = StripEnd::end_of_flight};
    write(strip);
  }
  static void expect_true_within_errors(const CameraRecord& camera) {
    EXPECT_NEAR(camera.fx, true_camera().fx, 3 * camera.sigma_focal_px);
    EXPECT_NEAR(camera.k1, true_camera().k1, 3 * std::sqrt(camera.covariance[9]));
  }
  /// Both stages in turn, until neither has anything to do; with `restarts`, new ones take over after so many steps.
  std::vector<std::vector<std::uint8_t>> run_undisturbed(int restarts = 0) {
    begin_stages();
    int steps = 0;
    for (bool more = true; more && steps < 400'000;) {
      more = false;
      for (Component* stage : {static_cast<Component*>(motion.get()), static_cast<Component*>(component.get())}) {
        const StepResult result = stage->step();
        if (!result.status.ok()) said.push_back(result.status);
        if (result.then == Then::restore) {
          EXPECT_TRUE(restored(stage->restore()));
        }
        more = more || result.pending;
      }
      if (restarts > 0 && ++steps % restarts == 0) begin_stages();
      if (restarts == 0) ++steps;
    }
    return found();
  }
  void begin_stages() {
    motion = std::make_unique<StructureAndMotion>(failing, mission, test::step_memory<StructureAndMotion>());
    component = std::make_unique<CameraCalibrator>(failing, mission);
    EXPECT_TRUE(restored(motion->restore()));
    EXPECT_TRUE(restored(component->restore()));
  }
  /// The camera, everything that was said of it, and the poses.
  std::vector<std::vector<std::uint8_t>> found() {
    std::vector<std::vector<std::uint8_t>> all = test::all_of<CameraRecord>(store);
    for (auto& record : test::all_of<CalibrationRecord>(store)) all.push_back(std::move(record));
    for (auto& record : test::all_of<PoseRecord>(store)) all.push_back(std::move(record));
    return all;
  }
  void renew_store() {
    store.~RamStore();
    new (&store) RamStore(region);
    said.clear();
  }
  std::int64_t events(StatusCode code) {
    return std::count_if(said.begin(), said.end(), [&](const Status& status) { return status.is(code); });
  }
  void expect_all_posed() {
    for (std::int64_t id = 1; id <= keyframes; ++id) {
      EXPECT_EQ(read<PoseRecord>(id).state, PoseState::final) << "keyframe " << id;
    }
  }

  test::FailingStore failing{store};
  std::unique_ptr<CameraCalibrator> component;
  std::unique_ptr<StructureAndMotion> motion;
  std::vector<Status> said;
};

TEST_F(CameraCalibratorTest, OverReliefTheCameraIsFoundAndFrozenOnce) {
  fly(rugged_views(), 1.12, false);
  run_undisturbed();
  const auto camera = read<CameraRecord>(camera_id);
  EXPECT_EQ(camera.frozen, 1);
  EXPECT_EQ(camera.source, CameraSource::calibrated);
  EXPECT_NEAR(camera.fx / true_camera().fx, 1, 0.01);
  EXPECT_NEAR(camera.fx, true_camera().fx, 3 * camera.sigma_focal_px);
  const double sigma_k1 = std::sqrt(camera.covariance[9]);
  EXPECT_NEAR(camera.k1, true_camera().k1, 3 * sigma_k1);
  EXPECT_LT(sigma_k1, 0.02);
  EXPECT_EQ(events(StatusCode::camera_calibrated), 1);
  EXPECT_EQ(number_of<CalibrationRecord>(), 2) << "passes: of six poses, and of what the flight brought";
  CalibrationRecord newest;
  ASSERT_TRUE(last(store, newest).ok());
  EXPECT_EQ(newest.verdict, CalibrationVerdict::ok);
  EXPECT_EQ(newest.revision, camera.revision);
  expect_all_posed();
  for (std::int64_t id = 1; id <= keyframes; ++id) EXPECT_EQ(read<PoseRecord>(id).camera_revision, camera.revision);
}

TEST_F(CameraCalibratorTest, OverAPlaneTheLensIsFoundAndEveryKeyframeIsPosed) {
  fly(flat_views(), 1.05, false);
  run_undisturbed();
  const auto camera = read<CameraRecord>(camera_id);
  EXPECT_EQ(camera.frozen, 1);
  expect_true_within_errors(camera);
  EXPECT_EQ(events(StatusCode::camera_calibrated) + events(StatusCode::camera_nominal), 1);
  expect_all_posed();
}

TEST_F(CameraCalibratorTest, WithoutTiltsOverAPlaneAttitudesOfTheVehicleDetermineTheLens) {
  std::vector<CameraRecord> found;
  for (const double error_of_sensor_rad : {0.0, 0.003, 0.3}) {
    SCOPED_TRACE(error_of_sensor_rad);
    fly(level_views(), 1.05, false);
    mission.use_navigation = error_of_sensor_rad > 0;
    std::mt19937 random(5);
    std::normal_distribution<double> error(0, std::max(error_of_sensor_rad, 1e-9));
    for (std::int64_t id = 1; id <= keyframes && mission.use_navigation; ++id) {
      NavigationRecord measured{.id = id, .tilt_sigma_rad = 0.003, .heading_sigma_rad = 0.003};
      const Mat3 seen = rotation_from_vector(Vec3(error(random), error(random), error(random))) *
                        level_views()[static_cast<std::size_t>(id - 1)].cam_from_world.rotation;
      const Pose pose = pose_from({seen, Vec3::Zero()});
      std::copy_n(pose.q_cam_from_world, 4, measured.q_cam_from_level);
      write(measured);
    }
    run_undisturbed();
    found.push_back(read<CameraRecord>(camera_id));
    EXPECT_EQ(found.back().frozen, 1);
    expect_true_within_errors(found.back());
    renew_store();
  }
  const auto sigma_k1 = [&](int of) { return std::sqrt(found[static_cast<std::size_t>(of)].covariance[9]); };
  EXPECT_LT(sigma_k1(1), 0.7 * sigma_k1(0)) << "the images leave a bow";
  EXPECT_GT(sigma_k1(2), sigma_k1(1)) << "a sensor that is wrong is not believed";
}

TEST_F(CameraCalibratorTest, WithoutTiltsOverAPlanePlacesOfTheVehicleDetermineTheLens) {
  enum Measured { nothing, places, wrong_places };
  std::vector<CameraRecord> found;
  for (const Measured what : {nothing, places, wrong_places}) {
    SCOPED_TRACE(what);
    fly(level_views(), 1.05, false);
    mission.use_navigation = what != nothing;
    mission.body = Body::mars;
    std::mt19937 random(6);
    std::normal_distribution<double> normal(0, 1);
    for (std::int64_t id = 1; id <= keyframes && what != nothing; ++id) {
      NavigationRecord measured{.id = id, .time_ns = id * 60 * ns_per_s};
      const Vec3 centre = test::centre_of(level_views()[static_cast<std::size_t>(id - 1)].cam_from_world);
      measured.horizontal_sigma_m = measured.vertical_sigma_m = 0.03;
      double at[3];
      const double error_m = what == wrong_places ? 30 : 0.03;
      for (int k = 0; k < 3; ++k) at[k] = centre[k] + error_m * normal(random);
      const BodyPlace place = place_at(Body::mars, {137, -4.5, -4000}, at);
      measured.longitude_deg = place.longitude_deg;
      measured.latitude_deg = place.latitude_deg;
      measured.elevation_m = place.elevation_m;
      write(measured);
    }
    run_undisturbed();
    found.push_back(read<CameraRecord>(camera_id));
    EXPECT_EQ(found.back().frozen, 1);
    expect_true_within_errors(found.back());
    renew_store();
  }
  const auto sigma_k1 = [&](Measured what) { return std::sqrt(found[what].covariance[9]); };
  EXPECT_LT(sigma_k1(places), 0.7 * sigma_k1(nothing)) << "the images leave a bow";
  EXPECT_GT(sigma_k1(wrong_places), sigma_k1(places)) << "what no lens explains is not believed";
}

TEST_F(CameraCalibratorTest, HeightsBesidePlacesDetermineTheFocalLengthOverAPlane) {
  constexpr double place_sigma_m = 0.3, height_sigma_m = 0.5, tilt_sigma_rad = 0.02;
  enum Measured { places, and_heights, heights_without_attitude };
  std::vector<CameraRecord> found;
  for (const Measured what : {places, and_heights, heights_without_attitude}) {
    SCOPED_TRACE(what);
    fly(level_views(), 1.05, false);
    mission.use_navigation = true;
    mission.body = Body::mars;
    std::mt19937 random(8);
    std::normal_distribution<double> normal(0, 1);
    for (std::int64_t id = 1; id <= keyframes; ++id) {
      const RigidTransform& truth = level_views()[static_cast<std::size_t>(id - 1)].cam_from_world;
      const Vec3 centre = test::centre_of(truth);
      NavigationRecord measured;
      measured.id = id;
      measured.time_ns = id * 60 * ns_per_s;
      measured.horizontal_sigma_m = measured.vertical_sigma_m = place_sigma_m;
      double at[3];
      for (int k = 0; k < 3; ++k) at[k] = centre[k] + place_sigma_m * normal(random);
      const BodyPlace place = place_at(Body::mars, {137, -4.5, -4000}, at);
      measured.longitude_deg = place.longitude_deg;
      measured.latitude_deg = place.latitude_deg;
      measured.elevation_m = place.elevation_m;
      const Vec3 wrong = tilt_sigma_rad * Vec3(normal(random), normal(random), normal(random));
      const double height_m = centre.z() + height_sigma_m * normal(random);
      if (what != heights_without_attitude) {
        const Pose pose = pose_from({rotation_from_vector(wrong) * truth.rotation, Vec3::Zero()});
        std::copy_n(pose.q_cam_from_world, 4, measured.q_cam_from_level);
        measured.tilt_sigma_rad = tilt_sigma_rad;
      }
      if (what != places) measured.height_m = height_m, measured.height_sigma_m = height_sigma_m;
      write(measured);
    }
    run_undisturbed();
    found.push_back(read<CameraRecord>(camera_id));
    expect_true_within_errors(found.back());
    renew_store();
  }
  EXPECT_LT(found[and_heights].sigma_focal_px, 0.5 * found[places].sigma_focal_px);
  EXPECT_GT(found[heights_without_attitude].sigma_focal_px, 0.8 * found[places].sigma_focal_px)
      << "nothing says along which line the height was measured";
}

TEST_F(CameraCalibratorTest, AGivenFocalLengthStaysWithinItsError) {
  mission.camera_known = 1;
  mission.lens_known = 0;
  fly(rugged_views(), 1, false);
  run_undisturbed();
  const auto camera = read<CameraRecord>(camera_id);
  EXPECT_EQ(camera.frozen, 1);
  EXPECT_NEAR(camera.fx / true_camera().fx, 1, 0.005);
  EXPECT_NEAR(camera.k1, true_camera().k1, 3 * std::sqrt(camera.covariance[9]));
}

TEST_F(CameraCalibratorTest, WhenThePatienceEndsTheCameraIsTakenAsItIs) {
  mission.calibration_patience_keyframes = 6;
  fly(rugged_views(), 1.12, false);
  run_undisturbed();
  EXPECT_EQ(read<CameraRecord>(camera_id).frozen, 1);
  CalibrationRecord newest;
  ASSERT_TRUE(last(store, newest).ok());
  EXPECT_EQ(newest.id, 7) << "keyframe 7 is the first that finds keyframe 1 waiting for six";
  expect_all_posed();
}

TEST_F(CameraCalibratorTest, WithoutPosesTheCameraStaysAsItWasGiven) {
  std::vector<test::View> unrelated = rugged_views();
  for (test::View& view : unrelated) std::fill(view.image.pixels.begin(), view.image.pixels.end(), std::uint8_t{100});
  fly(unrelated, 1.12, false);
  const auto nominal = read<CameraRecord>(camera_id);
  run_undisturbed();
  const auto camera = read<CameraRecord>(camera_id);
  EXPECT_EQ(camera.frozen, 1);
  EXPECT_EQ(camera.source, CameraSource::nominal);
  EXPECT_EQ(camera.fx, nominal.fx);
  EXPECT_EQ(events(StatusCode::camera_nominal), 1);
  EXPECT_EQ(read<CalibrationRecord>(keyframes).verdict, CalibrationVerdict::nothing_seen);
}

TEST_F(CameraCalibratorTest, RestartedAgainAndAgainItFindsTheSameCamera) {
  fly(rugged_views(), 1.12, false);
  const auto wanted = run_undisturbed();
  for (const int steps : {397, 1009}) {
    renew_store();
    fly(rugged_views(), 1.12, false);
    EXPECT_EQ(run_undisturbed(steps), wanted) << steps;
  }
}

TEST_F(CameraCalibratorTest, EveryReadOfPointsMayFailOnce) {
  fly(rugged_views(), 1.12, false);
  const auto wanted = run_undisturbed();
  renew_store();
  fly(rugged_views(), 1.12, false);
  std::set<std::int64_t> failed;
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool points = call.type == RecordType::structure && call.kind == test::StoreCall::read_blob;
    return points && failed.insert(call.id).second ? Status{StatusCode::store_error, 10} : Status{};
  });
  EXPECT_EQ(run_undisturbed(), wanted);
  EXPECT_GE(failed.size(), 3U);
}

TEST_F(CameraCalibratorTest, BehindADamagedCheckpointAFrozenCameraStaysAsItIs) {
  fly(rugged_views(), 1.12, false);
  const auto wanted = run_undisturbed();
  for (const bool newer_only : {true, false}) {
    damage_checkpoints(newer_only);
    EXPECT_EQ(run_undisturbed(), wanted);
    EXPECT_EQ(events(StatusCode::camera_calibrated), 1);
  }
}

TEST_F(CameraCalibratorTest, WhereTheFrozenCameraIsDamagedItsCopyIsRead) {
  fly(rugged_views(), 1.12, false);
  run_undisturbed();
  const auto frozen = read<CameraRecord>(camera_id);
  ASSERT_EQ(frozen.frozen, 1);
  failing.damage(RecordType::camera, camera_id);
  CameraRecord record;
  ASSERT_TRUE(get(failing, camera_id, record).is(StatusCode::record_damaged));
  ASSERT_TRUE(get_camera(failing, camera_id, record).ok());
  EXPECT_EQ(record.id, camera_id);
  EXPECT_EQ(record.fx, frozen.fx);
  EXPECT_EQ(record.frozen, 1);
  component = std::make_unique<CameraCalibrator>(failing, mission);
  EXPECT_TRUE(component->restore().ok());
  failing.damage(RecordType::camera, camera_copy_id);
  EXPECT_TRUE(get_camera(failing, camera_id, record).is(StatusCode::record_damaged));
}

TEST_F(CameraCalibratorTest, ACameraThatIsLostIsLookedForAgain) {
  fly(rugged_views(), 1.12, false);
  const auto nominal = read<CameraRecord>(camera_id);
  run_undisturbed();
  const auto found = read<CameraRecord>(camera_id);
  ASSERT_EQ(found.frozen, 1);
  // As a start does that finds neither the camera nor its copy.
  write(nominal);
  run_undisturbed();
  const auto again = read<CameraRecord>(camera_id);
  EXPECT_EQ(again.frozen, 1);
  EXPECT_NEAR(again.fx, true_camera().fx, 3 * again.sigma_focal_px);
  expect_all_posed();
}

TEST_F(CameraCalibratorTest, AFrozenFocalLengthThatIsWrongIsContradictedAndARightOneIsNot) {
  for (const double factor : {1.0, 1.2}) {
    SCOPED_TRACE(factor);
    mission.camera_known = 1;
    fly(rugged_views(), factor, true);
    run_undisturbed();
    EXPECT_GE(number_of<CalibrationCheckRecord>(), 1);
    EXPECT_EQ(events(StatusCode::camera_contradicted) > 0, factor != 1.0);
    EXPECT_EQ(read<CameraRecord>(camera_id).fx, factor * true_camera().fx) << "a contradiction changes nothing";
    renew_store();
  }
}

TEST_F(CameraCalibratorTest, WhatAnEarlierBootFoundStaysWhereThePointsAreGone) {
  mission.camera_known = 1;
  fly(rugged_views(), 1.2, true);
  run_undisturbed();
  const auto check = read<CalibrationCheckRecord>(1);
  ASSERT_EQ(check.verdict, CameraCheckVerdict::contradicts);
  test::erase_records<StructureRecord, CheckpointRecord>(store);
  component = std::make_unique<CameraCalibrator>(failing, mission);
  run_undisturbed();
  EXPECT_EQ(read<CalibrationCheckRecord>(1).verdict, check.verdict);
  EXPECT_EQ(read<CalibrationCheckRecord>(1).points, check.points);
}

}  // namespace
}  // namespace ilp
