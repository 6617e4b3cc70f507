// Keyframes over terrain given by a formula to a camera: it waits with a reason, freezes once, is contradicted, and
// goes on after restarts and failing reads.
#include "fsw/motion/camera_calibrator.hpp"

#include <cmath>
#include <memory>
#include <set>

#include "fsw/motion/structure_and_motion.hpp"
#include "fsw/shared/body_figure.hpp"
#include "fsw/shared/camera_on_record.hpp"
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
  camera.k1 = camera.k2 = camera.p1 = camera.p2 = 0;
  camera.fy = camera.fx;
  camera.cx = 0.5 * (camera.width - 1);
  camera.cy = 0.5 * (camera.height - 1);
  return camera;
}

/// Swinging about both axes, as below a balloon.
RigidTransform pose_at(std::int64_t i) {
  const auto t = static_cast<double>(i);
  const Vec3 turn(0.11 * std::sin(1.9 * t), 0.10 * std::cos(1.3 * t), 0.12 * std::sin(0.7 * t));
  return test::looking_down(Vec3(11 * t, 3 * std::sin(t), height + 2 * std::cos(0.8 * t)), turn);
}

const std::vector<test::View>& views(const test::Terrain& terrain, std::vector<test::View>& rendered) {
  for (std::int64_t i = 0; rendered.size() < static_cast<std::size_t>(keyframes); ++i) {
    rendered.push_back(test::render_view(true_camera(), pose_at(i), terrain, 2, 1, static_cast<std::uint64_t>(i + 1)));
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

class CameraCalibratorTest : public test::ComponentTest {
 protected:
  CameraCalibratorTest() { mission.camera_known = 0; }

  /// The camera's focal length as the flight takes it to be, and whether that is frozen.
  void fly(const std::vector<test::View>& seen, double focal_factor, bool frozen) {
    CameraModel taken = true_camera();
    taken.fx *= focal_factor;
    taken.fy *= focal_factor;
    write(frozen ? camera_record(taken) : nominal_camera_record(taken));
    for (std::int64_t id = 1; id <= keyframes; ++id) {
      write_frame(id, seen[static_cast<std::size_t>(id - 1)].image);
      KeyframeRecord keyframe;
      keyframe.id = keyframe.frame_id = id;
      keyframe.strip_id = 1;
      keyframe.index = static_cast<std::int32_t>(id - 1);
      keyframe.time_ns = id * 60 * ns_per_s;
      if (id > 1) put_plane(seen, id, keyframe);
      write(keyframe);
    }
    StripRecord strip;
    strip.id = strip.first_keyframe_id = 1;
    strip.last_keyframe_id = keyframes;
    strip.end = StripEnd::end_of_flight;
    write(strip);
  }
  static void put_plane(const std::vector<test::View>& seen, std::int64_t id, KeyframeRecord& keyframe) {
    const CameraModel& camera = seen[0].camera;
    const RigidTransform& a = seen[static_cast<std::size_t>(id - 2)].cam_from_world;
    const RigidTransform b_from_a = compose(seen[static_cast<std::size_t>(id - 1)].cam_from_world, inverse(a));
    const Vec3 normal = a.rotation * Vec3(0, 0, -1);
    Mat3 k;
    k << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
    Mat3 plane =
        k * (b_from_a.rotation + b_from_a.translation * normal.transpose() / test::centre_of(a).z()) * k.inverse();
    plane /= plane(2, 2);
    for (int i = 0; i < 9; ++i) keyframe.plane_from_previous[i] = plane(i / 3, i % 3);
  }
  std::vector<std::vector<std::uint8_t>> run_undisturbed() {
    test::ExecutedComponent run(*component, store);
    EXPECT_TRUE(run.start().ok());
    EXPECT_TRUE(run.run());
    return found();
  }
  /// The camera, and everything that was said.
  std::vector<std::vector<std::uint8_t>> found() {
    std::vector<std::vector<std::uint8_t>> all = test::all_of<CameraRecord>(store);
    for (auto& record : test::all_of<CalibrationRecord>(store)) all.push_back(std::move(record));
    return all;
  }
  /// The true attitude, height and place at each keyframe, stated to be so uncertain.
  void measure(double height_sigma_m, double place_sigma_m, double attitude_sigma_rad = 0.005) {
    mission.use_navigation = true;
    mission.body = Body::mars;
    const DegreeLengths degree = degree_lengths(Body::mars, 0, 0);
    for (std::int64_t id = 1; id <= keyframes; ++id) {
      const RigidTransform pose = pose_at(id - 1);
      const Vec3 centre = test::centre_of(pose);
      NavigationRecord measured;
      measured.id = id;
      measured.height_m = centre.z();
      measured.height_sigma_m = height_sigma_m;
      quaternion_from_rotation(pose.rotation, measured.q_cam_from_level);
      measured.tilt_sigma_rad = measured.heading_sigma_rad = attitude_sigma_rad;
      measured.longitude_deg = centre.x() / degree.east_m;
      measured.latitude_deg = centre.y() / degree.north_m;
      measured.horizontal_sigma_m = place_sigma_m;
      write(measured);
    }
  }
  void renew_store() {
    store.~RamStore();
    new (&store) RamStore(region);
    component = std::make_unique<CameraCalibrator>(failing, mission, test::step_memory<CameraCalibrator>());
  }
  /// The camera as it was given, frozen, with the error of a focal length whose field of view is uncertain by 0.02 rad.
  void expect_nominal(const CameraRecord& given) {
    const auto camera = read<CameraRecord>(camera_id);
    EXPECT_EQ(camera.frozen, 1);
    EXPECT_EQ(camera.source, CameraSource::nominal);
    EXPECT_EQ(camera.fx, given.fx);
    EXPECT_EQ(camera.cx, given.cx);
    const double half_field = std::atan(0.5 * given.width / given.fx);
    EXPECT_NEAR(camera.sigma_focal_px, given.fx - 0.5 * given.width / std::tan(half_field + 0.01),
                0.05 * camera.sigma_focal_px);
    EXPECT_NEAR(camera.sigma_cx_px, 0.02 * given.width, 1e-9);
    EXPECT_EQ(events(StatusCode::camera_nominal), 1);
    EXPECT_EQ(events(StatusCode::camera_calibrated), 0);
    EventRecord event;
    while (next(store, event.id, event).ok()) {
      if (event.code != static_cast<std::uint16_t>(StatusCode::camera_nominal)) continue;
      EXPECT_EQ(event.b, static_cast<std::int64_t>(CalibrationVerdict::planar)) << "relief is missing";
    }
  }
  void expect_same_after_restarts(const std::vector<test::View>& seen) {
    fly(seen, 1.12, false);
    // The last keyframe takes some 200 steps, a slice of the work each.
    for (int life = 0; life < 150 && read<CameraRecord>(camera_id).frozen == 0; ++life) {
      component = std::make_unique<CameraCalibrator>(failing, mission, test::step_memory<CameraCalibrator>());
      ASSERT_TRUE(component->restore().ok());
      for (int step = 0; step < 3 + 2 * life && read<CameraRecord>(camera_id).frozen == 0; ++step) {
        ASSERT_NE(component->step().then, Then::restore);
      }
    }
    const auto disturbed = found();
    // The same flight in one life, in a store of its own.
    renew_store();
    fly(seen, 1.12, false);
    EXPECT_EQ(run_undisturbed(), disturbed);
  }
  std::int64_t events(StatusCode code) {
    std::int64_t count = 0;
    EventRecord event;
    while (next(store, event.id, event).ok()) count += event.code == static_cast<std::uint16_t>(code) ? 1 : 0;
    return count;
  }

  test::FailingStore failing{store};
  std::unique_ptr<CameraCalibrator> component =
      std::make_unique<CameraCalibrator>(failing, mission, test::step_memory<CameraCalibrator>());
};

TEST_F(CameraCalibratorTest, OverReliefTheCameraIsFoundAndFrozenOnce) {
  fly(rugged_views(), 1.12, false);
  run_undisturbed();
  const auto camera = read<CameraRecord>(camera_id);
  EXPECT_EQ(camera.frozen, 1);
  EXPECT_NEAR(camera.fx / true_camera().fx, 1, 0.05);
  EXPECT_EQ(events(StatusCode::camera_calibrated), 1);
  std::int64_t ok = 0;
  CalibrationRecord said;
  while (next(store, said.id, said).ok()) ok += said.verdict == CalibrationVerdict::ok ? 1 : 0;
  EXPECT_EQ(ok, 1);
}

TEST_F(CameraCalibratorTest, OverAPlaneItWaitsAndSaysWhyOnce) {
  fly(flat_views(), 1.12, false);
  run_undisturbed();
  EXPECT_EQ(read<CameraRecord>(camera_id).frozen, 0);
  EXPECT_EQ(number_of<CalibrationRecord>(), keyframes) << "each keyframe has its verdict";
  EXPECT_EQ(events(StatusCode::camera_calibrated), 0);
  EXPECT_GE(events(StatusCode::calibration_waiting), 1);
  EXPECT_LE(events(StatusCode::calibration_waiting), 3) << "told when the reason changes";
}

TEST_F(CameraCalibratorTest, TheModelOfEachPairIsOnRecord) {
  fly(flat_views(), 1.12, false);
  run_undisturbed();
  EXPECT_EQ(read<CalibrationRecord>(1).pair_model, PairModel::none) << "the first keyframe has no pair";
  for (std::int64_t id = 2; id <= keyframes; ++id) {
    EXPECT_EQ(read<CalibrationRecord>(id).pair_model, PairModel::homography) << id;
  }
  renew_store();
  fly(rugged_views(), 1.12, false);
  run_undisturbed();
  CalibrationRecord said;
  while (next(store, said.id, said).ok()) {
    EXPECT_EQ(said.pair_model, said.id == 1 ? PairModel::none : PairModel::fundamental) << said.id;
  }
}

TEST_F(CameraCalibratorTest, WhenThePatienceEndsTheNominalCameraFliesOnIfTheMissionSaysSo) {
  mission.calibration_fallback = CalibrationFallback::nominal;
  mission.calibration_patience_keyframes = 6;
  mission.field_of_view_sigma_rad = 0.02;
  fly(flat_views(), 1.12, false);
  const auto nominal = read<CameraRecord>(camera_id);
  run_undisturbed();
  expect_nominal(nominal);
  EXPECT_EQ(number_of<CalibrationRecord>(), 7) << "keyframe 7 is the first that finds keyframe 1 waiting for six";
  EXPECT_EQ(events(StatusCode::calibration_overdue), 0);
}

TEST_F(CameraCalibratorTest, WhenTheFlightEndsTheNominalCameraServesThoseThatWait) {
  mission.calibration_fallback = CalibrationFallback::nominal;
  mission.field_of_view_sigma_rad = 0.02;
  fly(flat_views(), 1.12, false);
  const auto nominal = read<CameraRecord>(camera_id);
  run_undisturbed();
  expect_nominal(nominal);
  EXPECT_EQ(number_of<CalibrationRecord>(), keyframes);
}

TEST_F(CameraCalibratorTest, OverAPlaneHeightsPlacesAndAttitudesGiveTheFocalLength) {
  fly(flat_views(), 1.12, false);
  measure(0.3, 0.2);
  run_undisturbed();
  const auto camera = read<CameraRecord>(camera_id);
  EXPECT_EQ(camera.frozen, 1);
  EXPECT_EQ(camera.source, CameraSource::measured);
  EXPECT_LE(camera.sigma_focal_px, 0.015 * camera.fx);
  EXPECT_NEAR(camera.fx, true_camera().fx, 3 * camera.sigma_focal_px);
  EXPECT_EQ(events(StatusCode::camera_calibrated), 1);
  CalibrationRecord said;
  ASSERT_TRUE(last(store, said).ok());
  EXPECT_EQ(said.measured_focal_px, camera.fx);
  EXPECT_EQ(said.measured_sigma_px, camera.sigma_focal_px);
  EXPECT_NE(said.verdict, CalibrationVerdict::ok);
}

TEST_F(CameraCalibratorTest, UncertainMeasurementsServeInPlaceOfTheNominalCameraOnly) {
  for (const auto fallback : {CalibrationFallback::wait, CalibrationFallback::nominal}) {
    mission.calibration_fallback = fallback;
    fly(flat_views(), 1.12, false);
    measure(2, 3, 0.03);
    run_undisturbed();
    const auto camera = read<CameraRecord>(camera_id);
    EXPECT_EQ(camera.frozen, fallback == CalibrationFallback::nominal);
    EXPECT_EQ(camera.source, camera.frozen ? CameraSource::measured : CameraSource::nominal);
    if (camera.frozen) {
      EXPECT_NEAR(camera.fx, true_camera().fx, 3 * camera.sigma_focal_px);
    }
    EXPECT_EQ(number_of<CalibrationRecord>(), keyframes);
    renew_store();
  }
}

TEST_F(CameraCalibratorTest, KeyframesWaitForTheirMeasurements) {
  mission.use_navigation = true;
  fly(flat_views(), 1.12, false);
  run_undisturbed();
  EXPECT_EQ(number_of<CalibrationRecord>(), 0);
}

TEST_F(CameraCalibratorTest, ACameraThatIsFoundInTimeIsNotTheNominalOne) {
  fly(rugged_views(), 1.12, false);
  const auto wanted = run_undisturbed();
  EXPECT_EQ(read<CameraRecord>(camera_id).source, CameraSource::calibrated);
  renew_store();
  mission.calibration_fallback = CalibrationFallback::nominal;
  fly(rugged_views(), 1.12, false);
  EXPECT_EQ(run_undisturbed(), wanted);
}

TEST_F(CameraCalibratorTest, RestartedInTheMiddleOfEveryKeyframeItFindsTheSameCamera) {
  expect_same_after_restarts(rugged_views());
}

TEST_F(CameraCalibratorTest, RestartedInTheMiddleOfEveryKeyframeItGoesOnWithTheNominalCameraAtTheSameKeyframe) {
  mission.calibration_fallback = CalibrationFallback::nominal;
  mission.calibration_patience_keyframes = 6;
  expect_same_after_restarts(flat_views());
}

TEST_F(CameraCalibratorTest, EveryReadOfAnImageMayFailOnce) {
  fly(rugged_views(), 1.12, false);
  std::set<std::int64_t> failed;
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool image = call.type == RecordType::frame && call.kind == test::StoreCall::read_blob;
    return image && failed.insert(call.id).second ? Status{StatusCode::store_error, 10} : Status{};
  });
  const auto disturbed = run_undisturbed();
  EXPECT_GE(failed.size(), 3U);
  failing.recover();
  renew_store();
  fly(rugged_views(), 1.12, false);
  EXPECT_EQ(run_undisturbed(), disturbed);
}

TEST_F(CameraCalibratorTest, BehindADamagedCheckpointAFrozenCameraStaysAsItIs) {
  fly(rugged_views(), 1.12, false);
  const auto wanted = run_undisturbed();
  for (const bool newer_only : {true, false}) {
    damage_checkpoints(newer_only);
    component = std::make_unique<CameraCalibrator>(failing, mission, test::step_memory<CameraCalibrator>());
    EXPECT_TRUE(restored(component->restore()));
    EXPECT_TRUE(run(*component).empty());
    EXPECT_EQ(found(), wanted);
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
  component = std::make_unique<CameraCalibrator>(failing, mission, test::step_memory<CameraCalibrator>());
  EXPECT_TRUE(component->restore().ok());
  failing.damage(RecordType::camera, camera_copy_id);
  EXPECT_TRUE(get_camera(failing, camera_id, record).is(StatusCode::record_damaged));
}

TEST_F(CameraCalibratorTest, ACameraThatIsLostIsLookedForAgain) {
  fly(rugged_views(), 1.12, false);
  const auto nominal = read<CameraRecord>(camera_id);
  run_undisturbed();
  ASSERT_EQ(read<CameraRecord>(camera_id).frozen, 1);
  // As a start does that finds neither the camera nor its copy.
  write(nominal);
  component = std::make_unique<CameraCalibrator>(failing, mission, test::step_memory<CameraCalibrator>());
  EXPECT_TRUE(component->restore().is(StatusCode::checkpoint_lost));
  // Behind what had been looked at; none of it is a fault.
  for (const Status& said : run(*component)) {
    EXPECT_TRUE(said.is(StatusCode::calibration_waiting) || said.is(StatusCode::camera_calibrated))
        << status_name(said.code);
  }
  EXPECT_TRUE(component->restore().ok());
}

TEST_F(CameraCalibratorTest, AFrozenFocalLengthThatIsWrongIsContradictedAndARightOneIsNot) {
  for (const double factor : {1.0, 1.2}) {
    SCOPED_TRACE(factor);
    mission.camera_known = 1;
    fly(rugged_views(), factor, true);
    const auto motion = std::make_unique<StructureAndMotion>(store, mission, test::step_memory<StructureAndMotion>());
    ASSERT_TRUE(motion->restore().ok());
    run(*motion, 100'000);
    test::ExecutedComponent check(*component, store);
    ASSERT_TRUE(check.start().ok());
    ASSERT_TRUE(check.run());
    EXPECT_GE(number_of<CalibrationCheckRecord>(), 1);
    EXPECT_EQ(events(StatusCode::camera_contradicted) > 0, factor != 1.0);
    EXPECT_EQ(read<CameraRecord>(camera_id).fx, factor * true_camera().fx) << "a contradiction changes nothing";
    renew_store();
  }
}

TEST_F(CameraCalibratorTest, WhatAnEarlierLifeFoundStaysWhereThePointsAreGone) {
  mission.camera_known = 1;
  fly(rugged_views(), 1.2, true);
  const auto motion = std::make_unique<StructureAndMotion>(store, mission, test::step_memory<StructureAndMotion>());
  ASSERT_TRUE(motion->restore().ok());
  run(*motion, 100'000);
  run_undisturbed();
  const auto said = read<CalibrationCheckRecord>(1);
  ASSERT_EQ(said.verdict, CameraCheckVerdict::contradicts);
  Transaction transaction(store);
  ASSERT_TRUE(transaction.begin().ok());
  for (std::int64_t id = 1; id <= keyframes; ++id) static_cast<void>(store.erase(record_info<StructureRecord>(), id));
  for (CheckpointRecord lost; next(store, 0, lost).ok();) {
    ASSERT_TRUE(store.erase(record_info<CheckpointRecord>(), lost.id).ok());
  }
  ASSERT_TRUE(transaction.commit().ok());
  component = std::make_unique<CameraCalibrator>(failing, mission, test::step_memory<CameraCalibrator>());
  run_undisturbed();
  EXPECT_EQ(read<CalibrationCheckRecord>(1).verdict, said.verdict);
  EXPECT_EQ(read<CalibrationCheckRecord>(1).points, said.points);
}

}  // namespace
}  // namespace ilp
