#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>

#include "hal/store/sqlite/sqlite_store.hpp"
#include "hal/store/store.hpp"
#include "sim/ground/ground_run.hpp"
#include "sim/ground/report/capture_summary.hpp"
#include "tests/support/page_text.hpp"
#include "tests/support/said.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::report {
namespace {
namespace fs = std::filesystem;

constexpr TimeNs second = 1000000000;

void add_frame(intake::Flight& flight, std::int64_t id, TimeNs time) {
  FrameRecord frame{.id = id, .time_ns = time};
  flight.frames[id] = frame;
}

void add_overlap(intake::Flight& flight, std::int64_t id, std::int64_t keyframe, OverlapDecision decision,
                 double value) {
  OverlapRecord overlap{.id = id, .keyframe_id = keyframe, .decision = decision, .overlap = value};
  flight.overlaps[id] = overlap;
}

void add_keyframe(intake::Flight& flight, std::int64_t id, std::int64_t frame, std::int32_t index, double overlap) {
  KeyframeRecord record{.id = id, .frame_id = frame, .index = index, .overlap = overlap};
  flight.keyframes[id].id = id;
  flight.keyframes[id].record = record;
}

CaptureRecord& add_capture(intake::Flight& flight, std::int64_t id, CaptureSource source, CaptureState state) {
  CaptureRecord capture{.id = id, .source = source, .state = state};
  return flight.captures[id] = capture;
}

void add_forecast(intake::Flight& flight, std::int64_t id, CaptureSource source, std::int64_t frame, double overlap,
                  double sigma) {
  CaptureRecord& capture = add_capture(flight, id, source, CaptureState::exposed);
  capture.frame_id = frame;
  capture.issued_ns = (frame - 1) * 10 * second + second;
  capture.requested_ns = capture.exposed_ns = frame * 10 * second;
  capture.overlap = overlap;
  capture.overlap_sigma = sigma;
}

// Frame n at 10 n s. Frames 1, 3, 5 are keyframes 1, 2, 3; frames 2 and 4 are on the way.
intake::Flight flight_with_forecasts() {
  intake::Flight flight;
  for (std::int64_t id = 1; id <= 5; ++id) add_frame(flight, id, id * 10 * second);
  add_overlap(flight, 1, 0, OverlapDecision::new_strip, 0);
  add_overlap(flight, 2, 1, OverlapDecision::skipped, 0.90);
  add_overlap(flight, 3, 1, OverlapDecision::selected, 0.84);
  add_overlap(flight, 4, 2, OverlapDecision::skipped, 0.91);
  add_overlap(flight, 5, 2, OverlapDecision::selected, 0.80);
  add_keyframe(flight, 1, 1, 0, 0);
  add_keyframe(flight, 2, 3, 1, 0.84);
  add_keyframe(flight, 3, 5, 2, 0.80);
  add_forecast(flight, 1, CaptureSource::safe, 1, unknown, unknown);
  add_forecast(flight, 2, CaptureSource::on_the_way, 2, 0.93, 0.04);  // error +0.03: inside 1 sigma
  add_forecast(flight, 3, CaptureSource::forecast, 3, 0.82, 0.01);    // -0.02: at 2 sigma
  add_forecast(flight, 4, CaptureSource::on_the_way, 4, 0.90, 0.02);  // -0.01: inside 1 sigma
  add_forecast(flight, 5, CaptureSource::forecast, 5, 0.84, 0.01);    // +0.04: outside 2 sigma
  flight.captures[3].overlap_sigma = 0.0101;                          // clear of rounding
  return flight;
}

TEST(CaptureSummary, CountsAndForecastErrorsAreThoseFoundByHand) {
  const CaptureSummary s = summarise_captures(flight_with_forecasts(), 0.8);
  const auto count = [&s](CaptureSource source, CaptureState state) {
    return s.counts[static_cast<std::size_t>(source)][static_cast<std::size_t>(state)];
  };
  EXPECT_EQ(count(CaptureSource::safe, CaptureState::exposed), 1U);
  EXPECT_EQ(count(CaptureSource::forecast, CaptureState::exposed), 2U);
  EXPECT_EQ(count(CaptureSource::on_the_way, CaptureState::exposed), 2U);
  EXPECT_EQ(count(CaptureSource::telecommand, CaptureState::exposed), 0U);
  EXPECT_NEAR(s.frames_per_keyframe, 5.0 / 3, 1e-12);
  // +0.04 and 0 against the target
  EXPECT_EQ(s.achieved.count, 2U);
  EXPECT_NEAR(s.achieved.mean, 0.02, 1e-12);
  EXPECT_NEAR(s.achieved.deviation, std::sqrt(2 * 0.02 * 0.02), 1e-12);
  // +0.03, -0.02, -0.01, +0.04: mean 0.01, squares about it 4 + 9 + 4 + 9 in 1e-4
  ASSERT_EQ(s.forecasts.size(), 4U);
  EXPECT_NEAR(s.forecast_error.mean, 0.01, 1e-12);
  EXPECT_NEAR(s.forecast_error.deviation, std::sqrt(26e-4 / 3), 1e-12);
  EXPECT_EQ(s.within_1_sigma, 0.5);
  EXPECT_EQ(s.within_2_sigma, 0.75);
  EXPECT_EQ(s.forecasts_unchecked, 0U);
  EXPECT_EQ(s.forecasts[0].keyframe_id, 0);
  EXPECT_EQ(s.forecasts[1].keyframe_id, 2);
}

TEST(CaptureSummary, ForecastsThatWereNotMeasuredAreNotCompared) {
  intake::Flight flight = flight_with_forecasts();
  flight.overlaps.erase(2);                                      // no record of the frame
  flight.overlaps[3].verdict = OverlapVerdict::overlap_unknown;  // its overlap was not found
  add_overlap(flight, 4, 1, OverlapDecision::skipped, 0.4);      // against the keyframe before the one forecast
  flight.captures[5].overlap = unknown;
  const CaptureSummary s = summarise_captures(flight, 0.8);
  EXPECT_TRUE(s.forecasts.empty());
  EXPECT_EQ(s.forecasts_unchecked, 3U) << "a capture without a forecast has nothing to check";
  EXPECT_TRUE(std::isnan(s.forecast_error.mean));
  EXPECT_TRUE(std::isnan(s.within_1_sigma));
}

TEST(CaptureSummary, TheForecastIsOfTheKeyframeThatWasLatestWhenItWasIssued) {
  intake::Flight flight = flight_with_forecasts();
  // A telecommanded frame came between the plan for frame 5 and frame 5, and became the keyframe.
  flight.captures[5].issued_ns = 35 * second;
  add_overlap(flight, 4, 2, OverlapDecision::selected, 0.83);
  add_keyframe(flight, 4, 4, 2, 0.83);
  add_overlap(flight, 5, 4, OverlapDecision::skipped, 0.95);
  const CaptureSummary s = summarise_captures(flight, 0.8);
  EXPECT_EQ(s.forecasts.size(), 3U);
  EXPECT_EQ(s.forecasts_unchecked, 1U);
}

TEST(CaptureSummary, AForecastWithoutSigmaCountsInTheErrorsAlone) {
  intake::Flight flight = flight_with_forecasts();
  flight.captures[5].overlap_sigma = unknown;
  const CaptureSummary s = summarise_captures(flight, 0.8);
  EXPECT_EQ(s.forecast_error.count, 4U);
  EXPECT_EQ(s.with_sigma, 3U);
  EXPECT_NEAR(s.within_2_sigma, 1.0, 1e-12);
}

TEST(CaptureSummary, SaysWhyThereIsNoFrame) {
  intake::Flight flight;
  CaptureRecord& past = add_capture(flight, 1, CaptureSource::telecommand, CaptureState::rejected);
  past.requested_ns = 5 * second;
  past.issued_ns = 10 * second;
  CaptureRecord& near = add_capture(flight, 2, CaptureSource::telecommand, CaptureState::rejected);
  near.requested_ns = 20 * second;
  near.command_id = 7;
  add_capture(flight, 3, CaptureSource::forecast, CaptureState::no_frame);
  CaptureRecord& exposed = add_capture(flight, 4, CaptureSource::telecommand, CaptureState::exposed);
  exposed.requested_ns = 30 * second;
  exposed.exposed_ns = 30 * second - 12500000;
  exposed.frame_id = 1;
  add_frame(flight, 1, exposed.exposed_ns);
  const auto event = [&flight](StatusCode code, std::int64_t a, std::int64_t b) {
    EventRecord e{.code = static_cast<std::uint16_t>(code), .a = a, .b = b};
    flight.events.push_back(e);
  };
  event(StatusCode::capture_too_soon, 7, 500000);
  event(StatusCode::capture_missed, 3, 3000);
  EXPECT_NE(capture_reason(flight, past).find("in the past by 5.0 s"), std::string::npos);
  EXPECT_NE(capture_reason(flight, near).find("least interval of 500 ms"), std::string::npos);
  EXPECT_NE(capture_reason(flight, flight.captures[3]).find("within 3000 ms"), std::string::npos);
  EXPECT_EQ(capture_reason(flight, exposed), "");
  EXPECT_NEAR(exposure_delay_ms(exposed), -12.5, 1e-9);
  EXPECT_TRUE(std::isnan(exposure_delay_ms(past)));
  flight.frames[1].time_doubt = TimeDoubt::off_command;
  EXPECT_NE(capture_reason(flight, exposed).find("commanded time stands"), std::string::npos);
}

std::string page_of(const Report& report) {
  const test::TemporaryFolder folder;
  std::ofstream file(folder / "report.html");
  write_report_html(report, file);
  file.close();
  return test::page_text(folder / "report.html");
}

TEST(CapturesPage, HundredsOfTelecommandsAreCutAndThoseWithoutAFrameStay) {
  ILP_NEED_TOOL("node");
  Report report;
  for (std::int64_t id = 1; id <= 300; ++id) {
    add_capture(report.flight, id, CaptureSource::telecommand,
                id == 298 ? CaptureState::no_frame : CaptureState::exposed);
  }
  const std::string page = page_of(report);
  EXPECT_NE(page.find("60 of 300 shown"), std::string::npos);
  EXPECT_NE(page.find("<td data-title=\"capture\">298</td>"), std::string::npos) << "the one without a frame is shown";
  EXPECT_EQ(page.find("<td data-title=\"capture\">297</td>"), std::string::npos);
}

TEST(CapturesPage, UnknownValuesOfOtherVersionsAreNamedSo) {
  ILP_NEED_TOOL("node");
  Report report;
  add_capture(report.flight, 1, static_cast<CaptureSource>(200), static_cast<CaptureState>(77));
  const std::string page = page_of(report);
  EXPECT_NE(page.find("unknown source"), std::string::npos);
  EXPECT_NE(page.find("unknown state"), std::string::npos);
}

TEST(CapturesPage, TheSectionIsThereOnlyWhenTheDatabaseHasCaptures) {
  ILP_NEED_TOOL("node");
  const test::TemporaryFolder folder;
  test::write_outbox(test::make_flight(false), folder.path() / "outbox");
  ground::GroundOptions options{.outbox = folder.path() / "outbox", .out = folder.path() / "out"};
  std::ostringstream messages;
  (void)ground::run_ground(options, messages);
  EXPECT_EQ(test::page_text(options.out / "report.html").find("When the images were taken"), std::string::npos);
  EXPECT_TRUE(nlohmann::json::parse(test::text_of(options.out / "report.json")).at("captures").is_null());

  options.flight_db = folder.path() / "flight.db";
  const auto store = std::make_unique<SqliteStore>();
  ASSERT_TRUE(store->open(options.flight_db.c_str()).ok());
  CaptureRecord capture;
  capture.id = 1;
  capture.source = CaptureSource::telecommand;
  capture.state = CaptureState::exposed;
  capture.command_id = 9;
  capture.requested_ns = 12 * second;
  capture.exposed_ns = 12 * second + 4000000;
  capture.frame_id = 3;
  ASSERT_TRUE(store->begin().ok());
  ASSERT_TRUE(put(*store, capture).ok());
  ASSERT_TRUE(store->commit().ok());
  store->close();
  (void)ground::run_ground(options, messages);
  EXPECT_NE(test::page_text(options.out / "report.html").find("When the images were taken"), std::string::npos);
  const auto json = nlohmann::json::parse(test::text_of(options.out / "report.json")).at("captures");
  EXPECT_EQ(json.at("by_source_and_state").at("telecommand").at("exposed"), 1);
  EXPECT_EQ(json.at("list").at(0).at("exposed_minus_requested_ms"), 4.0);
  EXPECT_EQ(json.at("list").at(0).at("command"), 9);
  EXPECT_TRUE(json.at("share_within_1_sigma").is_null());
}

}  // namespace
}  // namespace ilp::report
