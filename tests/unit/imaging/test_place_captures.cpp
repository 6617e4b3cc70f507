// Images at commanded places, over analytic tracks: metres are made longitude and latitude on the sphere of Mars here.
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "fsw/shared/local_plane.hpp"
#include "tests/unit/imaging/capture_fixture.hpp"

namespace ilp {
namespace {

// IAU 2015, and a place where a degree of longitude is shorter than one of latitude.
constexpr double mars_radius_m = 3396190, deg = 3.14159265358979323846 / 180;
constexpr double origin_longitude = 137.4, origin_latitude = -40;

using test::at_s;

double longitude_of(double x) {
  return origin_longitude + x / (mars_radius_m * std::cos(origin_latitude * deg)) / deg;
}
double latitude_of(double y) {
  return origin_latitude + y / mars_radius_m / deg;
}

/// A vehicle that goes straight on at 5 m/s to the east, 20 m north of the origin, which it passes at 100 s.
class PlaceCaptureTest : public test::CaptureFixture {
 protected:
  PlaceCaptureTest() {
    mission.capture_mode = CaptureMode::telecommanded;
    mission.capture_min_interval_s = 0.5;
    mission.body = Body::mars;
    mission.use_navigation = true;
    begin();
  }
  void begin() {
    planner = std::make_unique<CaptureClock>(store, camera, clock, mission);
    ASSERT_TRUE(restored(planner->restore()));
  }
  /// Steps in every minor frame from now until then, as the executive does.
  void fly_to(double seconds) {
    for (TimeNs now = clock.now(); now <= at_s(seconds); now += minor_frame_ns) {
      clock.set(now);
      for (const Status& fault : run(*planner)) faults.push_back(fault);
    }
  }
  KeyframeRecord keyframe_at(double seconds, std::int64_t strip) {
    KeyframeRecord keyframe;
    keyframe.id = ++keyframes;
    keyframe.frame_id = keyframe.id;
    keyframe.strip_id = strip;
    keyframe.time_ns = at_s(seconds);
    write(keyframe);
    return keyframe;
  }
  static double x_at(double seconds) { return 5 * (seconds - 100); }
  /// The vehicle measures where it is, with an error.
  void measure(double seconds, double x_off = 0, double y_off = 0, std::int64_t strip = 1, double sigma_m = 1) {
    const KeyframeRecord keyframe = keyframe_at(seconds, strip);
    NavigationRecord measured;
    measured.id = keyframe.id;
    measured.time_ns = keyframe.time_ns;
    measured.longitude_deg = longitude_of(x_at(seconds) + x_off);
    measured.latitude_deg = latitude_of(20 + y_off);
    measured.horizontal_sigma_m = sigma_m;
    write(measured);
  }
  std::int64_t command(double distance_m, double limit_s = 0, double x = 0, double y = 0) {
    CommandRecord command{.kind = CommandKind::capture_place, .at_ns = at_s(limit_s)};
    command.longitude_deg = longitude_of(x);
    command.latitude_deg = latitude_of(y);
    command.distance_m = distance_m;
    return send(command);
  }
  static double seconds(TimeNs time) { return 1e-9 * static_cast<double>(time); }
  std::string reason(std::int64_t command) {
    const CaptureRecord capture = of_command(command);
    return capture.state == CaptureState::rejected ? status_name(static_cast<StatusCode>(capture.reason)) : "";
  }
};

TEST_F(PlaceCaptureTest, TheImageIsWantedAtTheTimeOfTheClosestApproach) {
  const std::int64_t wanted = command(25);
  for (double t = 0; t <= 80; t += 8) {
    measure(t);
    fly_to(t + 1);
  }
  fly_to(99.4);
  EXPECT_EQ(number_of<CaptureRecord>(), 0) << "newer places may still move it";
  fly_to(99.6);
  const CaptureRecord capture = of_command(wanted);
  EXPECT_EQ(capture.source, CaptureSource::telecommand);
  EXPECT_EQ(capture.state, CaptureState::pending);
  EXPECT_NEAR(seconds(capture.requested_ns), 100, 1e-3);
  EXPECT_NEAR(capture.distance_m, 20, 0.02);
  EXPECT_NEAR(seconds(capture.issued_ns), 99.5, 0.1001);
  fly_to(120);
  EXPECT_EQ(number_of<CaptureRecord>(), 1) << "once";
  EXPECT_TRUE(faults.empty());
}

TEST_F(PlaceCaptureTest, ALineBesideTheAxesIsForecastToo) {
  // Places at 45 degrees: the nearest point to (100, 0) of the line y = x + 20 is (40, 60).
  PlaceTrack track;
  PlaceCaptures state;
  for (int i = 0; i < 4; ++i) {
    add_place(Body::mars, {at_s(2.0 * i), longitude_of(6.0 * i), latitude_of(6.0 * i + 20), 3}, 1, 7, state);
  }
  PlaceTarget target{.longitude_deg = longitude_of(100), .latitude_deg = latitude_of(0)};
  const TimeNs never = std::numeric_limits<TimeNs>::max();
  const Approach nearest = nearest_approach(Body::mars, state.track, target, at_s(7), never);
  ASSERT_TRUE(nearest.known);
  EXPECT_NEAR(seconds(nearest.time_ns), 40.0 / 3, 0.001);
  EXPECT_NEAR(nearest.distance_m, 60 * std::sqrt(2.0), 0.01);
  // Four places 2 s apart, 3 m each: sigma^2 = 9 (1 + (t - 3)^2 / 20).
  const double since = 40.0 / 3 - 3;
  EXPECT_NEAR(nearest.sigma_m, 3 * std::sqrt(1 + since * since / 20), 0.001);
  // Earlier and later than that time it is the end of the interval that is nearest.
  EXPECT_EQ(nearest_approach(Body::mars, state.track, target, at_s(7), at_s(8)).time_ns, at_s(8));
  EXPECT_EQ(nearest_approach(Body::mars, state.track, target, at_s(20), never).time_ns, at_s(20));
  // Over six seconds it reaches 24 s farther.
  EXPECT_TRUE(nearest_approach(Body::mars, state.track, target, at_s(29.9), never).known);
  EXPECT_FALSE(nearest_approach(Body::mars, state.track, target, at_s(30.1), never).known);
}

TEST_F(PlaceCaptureTest, NewerPlacesMoveTheTime) {
  const std::int64_t wanted = command(25);
  // By the first places the vehicle is 30 m ahead of its true track, and would be there at 94 s.
  for (double t = 40; t <= 72; t += 8) measure(t, 30, 0, 1);
  fly_to(73);
  for (double t = 74; t <= 92; t += 6) measure(t, 0, 0, 2);
  fly_to(99.6);
  EXPECT_NEAR(seconds(of_command(wanted).requested_ns), 100, 1e-3);
}

TEST_F(PlaceCaptureTest, TwoSigmaInDoubtCountAsWithinAndMoreDoesNot) {
  // The forecast at 100 s by places every 8 s from 0 s to 80 s (the latest eight), each 1 m:
  // sigma^2 = 1 + (100 - 52)^2 / sum of (t - 52)^2 = 1 + 2304 / 2688, so two sigma are 2.726 m.
  const std::int64_t near = command(20 - 2.6), far = command(20 - 2.8, 110);
  for (double t = 0; t <= 80; t += 8) measure(t);
  fly_to(101);
  EXPECT_EQ(of_command(near).state, CaptureState::pending);
  EXPECT_NEAR(seconds(of_command(near).requested_ns), 100, 1e-3);
  EXPECT_EQ(of_command(far).id, 0) << "it stays";
  EXPECT_TRUE(faults.empty());
}

TEST_F(PlaceCaptureTest, APlaceThatIsMissedStaysUntilItsTimeAndTheEventSaysHowNearItWas) {
  const std::int64_t missed = command(5, 150);
  for (double t = 64; t <= 144; t += 8) {
    measure(t);
    fly_to(t + 1);
  }
  fly_to(149.9);
  EXPECT_EQ(of_command(missed).id, 0);
  EXPECT_TRUE(faults.empty());
  fly_to(151);
  EXPECT_EQ(reason(missed), "place_missed");
  EXPECT_EQ(of_command(missed).distance_m, 20) << "between places 4 s before and after";
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_TRUE(faults[0].is(StatusCode::place_missed));
  EXPECT_EQ(faults[0].a, missed);
  EXPECT_EQ(faults[0].b, 20);
}

TEST_F(PlaceCaptureTest, WithoutATimeLimitItEndsWithTheFlight) {
  const std::int64_t missed = command(5);
  // The newest place lies 100 m before it; the forecast leads on from there.
  for (double t = 40; t <= 80; t += 8) measure(t);
  fly_to(90);
  CommandRecord end{
      .id = number_of<CommandRecord>() + 1, .kind = CommandKind::end_strip, .reason = StripEnd::end_of_flight};
  write(end);
  fly_to(90.5);
  EXPECT_EQ(reason(missed), "place_missed");
  EXPECT_NEAR(of_command(missed).distance_m, std::hypot(20, 50), 1) << "at 90 s, by the forecast";
}

TEST_F(PlaceCaptureTest, NobodyHasSeenAPlaceWhereNothingSaysWhereTheVehicleIs) {
  const std::int64_t unseen = command(25, 20);
  keyframe_at(3, 1);
  fly_to(21);
  EXPECT_EQ(reason(unseen), "place_unseen");
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].a, unseen);
}

TEST_F(PlaceCaptureTest, ATrackIsOfOneStrip) {
  const std::int64_t wanted = command(25, 110);
  for (double t = 0; t <= 72; t += 8) measure(t, 0, 0, 1);
  measure(80, 0, 0, 2);
  fly_to(105);
  EXPECT_EQ(of_command(wanted).id, 0) << "the new strip has one place only";
}

TEST_F(PlaceCaptureTest, TheForecastGoesByTheMapWhereThereIsOne) {
  mission.use_map = true;
  const std::int64_t wanted = command(25);
  for (double t = 40; t <= 88; t += 8) {
    // The vehicle's own position is 300 m off.
    measure(t, 0, 300);
    FixRecord fix;
    fix.id = keyframes;
    fix.strip_id = 1;
    fix.map_id = 99;
    fix.body = Body::mars;
    fix.map_longitude_deg = longitude_of(-1000);
    fix.map_latitude_deg = origin_latitude;
    fix.place_m[0] = x_at(t) + 1000;
    fix.place_m[1] = 20;
    fix.place_m[2] = 800;
    fix.place_sigma_m = t == 64 ? 0 : 1;  // one that is not known
    if (t == 64) fix.place_m[1] = 5000;
    write(fix);
  }
  fly_to(101);
  const CaptureRecord capture = of_command(wanted);
  EXPECT_NEAR(seconds(capture.requested_ns), 100, 0.05);
  EXPECT_NEAR(capture.distance_m, 20, 0.2);
}

TEST_F(PlaceCaptureTest, WhereNoMapCanBeUsedTheVehicleSaysWhereItIs) {
  mission.use_map = true;
  const std::int64_t wanted = command(25);
  for (double t = 40; t <= 88; t += 8) {
    measure(t);
    FixRecord fix{.id = keyframes};
    write(fix);
  }
  fly_to(101);
  EXPECT_NEAR(seconds(of_command(wanted).requested_ns), 100, 1e-3);
}

TEST_F(PlaceCaptureTest, PlacesAndTrackOutliveARestart) {
  const std::int64_t wanted = command(25);
  for (double t = 40; t <= 80; t += 8) measure(t);
  fly_to(90);
  begin();
  fly_to(99.6);
  EXPECT_NEAR(seconds(of_command(wanted).requested_ns), 100, 1e-3);
  begin();
  fly_to(110);
  EXPECT_EQ(number_of<CaptureRecord>(), 1);
}

TEST_F(PlaceCaptureTest, BehindALostCheckpointTheTrackBeginsWithTheLatestKeyframes) {
  for (double t = 0; t <= 80; t += 8) measure(t);
  fly_to(81);
  damage_checkpoints();
  begin();
  const std::int64_t wanted = command(25);
  fly_to(99.6);
  EXPECT_NEAR(seconds(of_command(wanted).requested_ns), 100, 1e-3);
}

TEST_F(PlaceCaptureTest, OnePlaceMoreThanFitIsRejected) {
  std::int64_t latest = 0;
  for (std::size_t i = 0; i <= limits::max_place_captures; ++i) latest = command(25, 0, 1000.0 * double(i));
  fly_to(1);
  EXPECT_EQ(number_of<CaptureRecord>(), 1);
  EXPECT_EQ(reason(latest), "places_full");
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].a, latest);
  EXPECT_EQ(faults[0].b, static_cast<std::int64_t>(limits::max_place_captures));
}

TEST_F(PlaceCaptureTest, WhatNothingCanEverReachIsRejected) {
  mission.body = Body::none;
  const std::int64_t bodiless = command(25);
  fly_to(0.1);
  EXPECT_EQ(reason(bodiless), "places_unknown");
  mission.body = Body::mars;
  mission.use_navigation = false;
  const std::int64_t blind = command(25);
  fly_to(0.2);
  EXPECT_EQ(reason(blind), "places_unknown");
  mission.use_navigation = true;
  const std::int64_t nowhere = command(25, 0, std::numeric_limits<double>::quiet_NaN());
  const std::int64_t beyond = command(25, 0, 0, 1e8), none = command(std::numeric_limits<double>::infinity());
  fly_to(0.3);
  for (const std::int64_t id : {nowhere, beyond, none}) EXPECT_EQ(reason(id), "invalid_argument") << id;
  clock.set(at_s(10));
  const std::int64_t late = command(25, 9);
  fly_to(10);
  EXPECT_EQ(reason(late), "capture_in_past");
}

TEST_F(PlaceCaptureTest, AnImageOfTheModeGivesWay) {
  mission.capture_mode = CaptureMode::regular;
  mission.capture_interval_s = 100.2;
  fly_to(0);
  CaptureRecord first = read<CaptureRecord>(1);
  FrameRecord frame{.id = 1};
  write(frame);
  first.state = CaptureState::exposed;
  write(first);
  const std::int64_t wanted = command(25);
  for (double t = 40; t <= 80; t += 8) measure(t);
  fly_to(99.3);
  EXPECT_EQ(read<CaptureRecord>(2).requested_ns, at_s(100.2));
  fly_to(99.6);
  EXPECT_EQ(read<CaptureRecord>(2).state, CaptureState::superseded);
  EXPECT_NEAR(seconds(of_command(wanted).requested_ns), 100, 1e-3);
}

TEST_F(PlaceCaptureTest, ItGivesWayToTheTimeOfAnotherTelecommand) {
  const std::int64_t wanted = command(30);
  CommandRecord timed{.id = number_of<CommandRecord>() + 1, .kind = CommandKind::capture, .at_ns = at_s(99.8)};
  write(timed);
  for (double t = 40; t <= 80; t += 8) measure(t);
  fly_to(101);
  EXPECT_EQ(of_command(timed.id).requested_ns, at_s(99.8));
  EXPECT_EQ(of_command(timed.id).state, CaptureState::pending);
  // Half a second after the other one, still within 30 m.
  EXPECT_EQ(of_command(wanted).requested_ns, at_s(100.3));
}

}  // namespace
}  // namespace ilp
