// What the console shows of reports as the flight makes them, and the files that it keeps.
#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "cfg/schedule.hpp"
#include "fsw/base/status.hpp"
#include "fsw/packets/report_table.hpp"
#include "fsw/packets/service_events.hpp"
#include "fsw/packets/service_housekeeping.hpp"
#include "fsw/packets/service_schedule.hpp"
#include "fsw/records/records.hpp"
#include "sim/ground/console/flight_view.hpp"
#include "sim/ground/console/operator_command.hpp"
#include "sim/ground/console/received_file.hpp"
#include "sim/ground/console/report_values.hpp"
#include "sim/ground/console/telecommand_data.hpp"
#include "sim/ground/console/terminal.hpp"
#include "tests/support/said.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::console {
namespace {

const Tailoring tailoring = tailoring_of(GroundSystem::standard, false, 0);

const ReportInfo& report_named(std::string_view name) {
  for (const ReportInfo& report : report_table()) {
    if (name == report.name) return report;
  }
  throw std::logic_error(std::string(name));
}

template <typename Struct>
std::vector<std::uint8_t> housekeeping_of(const char* name, const Struct& values, std::size_t repeats = 1) {
  const ReportInfo& report = report_named(name);
  return data_of([&](ByteWriter& out) {
    encode_report_id(tailoring, report.id, out);
    for (std::size_t i = 0; i < repeats; ++i) write_report_values(report, &values, out);
  });
}

FlightView view_at(TimeNs mission_time) {
  FlightView view;
  PackageStatus status;
  status.mission_time_ns = mission_time;
  EXPECT_NE(view.reports.take(tailoring, housekeeping_of("status", status)), nullptr);
  view.parameters_known = true;
  view.received_s = 3;
  return view;
}

std::string all(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

TEST(FlightViewTest, ProcessesThatShareTheFlightAreShownAndSilentOnesStandOut) {
  FlightView view = view_at(65 * ns_per_s);
  EXPECT_EQ(all(panel(view)).find("nodes"), std::string::npos) << "a flight in one process has none";
  NodeHealth head, matcher;
  for (const Stage& stage : schedule) {
    if (stage.runs_on == RunsOn::primary) head.stages |= 1U << (static_cast<unsigned>(stage.component) - 1);
  }
  matcher.stages = 1U << (static_cast<unsigned>(ComponentId::dense_matcher) - 1);
  matcher.silent_ns = 42 * ns_per_s;
  const NodeHealth nodes[most_nodes] = {head, matcher};
  const ReportInfo& report = report_named("nodes");
  const std::vector<std::uint8_t> data = data_of([&](ByteWriter& out) {
    encode_report_id(tailoring, report.id, out);
    for (const NodeHealth& node : nodes) write_report_values(report, &node, out);
  });
  ASSERT_NE(view.reports.take(tailoring, data), nullptr);
  EXPECT_NE(all(panel(view)).find("nodes     head; dense_matcher SILENT for 42 s\n"), std::string::npos)
      << all(panel(view));
}

TEST(FlightViewTest, AnEndOfContactIsFollowedThoughTheSilentFlightCannotReportIt) {
  FlightView view = view_at(65 * ns_per_s);
  EXPECT_EQ(pass_words(view), "always in contact");
  EXPECT_EQ(apply_contact_command(parse_operator_command("ping", tailoring, 0), view), "");
  EXPECT_EQ(apply_contact_command(parse_operator_command("downlink end", tailoring, 0), view),
            "the flight neither sends nor listens until mission time 02:00, for 00:55");
  EXPECT_TRUE(out_of_contact(view));
  EXPECT_EQ(pass_words(view), "no contact for 00:55, because a telecommand ended it");
  view.since_status = 56 * ns_per_s;
  EXPECT_EQ(pass_words(view), "always in contact") << "the window is over";
  EXPECT_FALSE(out_of_contact(view));
  view.since_status = 0;
  EXPECT_EQ(apply_contact_command(parse_operator_command("downlink 20", tailoring, 0), view), "");
  EXPECT_EQ(pass_words(view), "always in contact") << "what begins contact ends the silence";
}

TEST(FlightViewTest, AfterTheLastPassTheSilenceHasNoEnd) {
  FlightView view = view_at(65 * ns_per_s);
  view.mission.pass_period_s = 100;
  view.mission.pass_length_s = 80;
  view.mission.pass_count = 1;
  EXPECT_EQ(apply_contact_command(parse_operator_command("call PASSEND", tailoring, 0), view),
            "the flight neither sends nor listens from now on: its last pass is over");
}

TEST(FlightViewTest, ValuesAreThoseOfTheRecord) {
  FlightView view = view_at(65 * ns_per_s);
  StorageRecord storage{
      .product_bytes = 3 << 20, .products_held = 23, .budget_bytes = 256LL << 20, .products_acknowledged = 12};
  ASSERT_NE(view.reports.take(tailoring, housekeeping_of("storage", storage)), nullptr);
  EXPECT_EQ(view.reports.value("storage", "products_held"), 23);
  EXPECT_EQ(view.reports.value("storage", "no_such_field"), std::nullopt);
  EXPECT_EQ(view.reports.value("link", "sent"), std::nullopt) << "has not come";
  const std::string text = all(panel(view));
  EXPECT_NE(text.find("3.0 of 256.0 MiB, products: 23 on board, 12 confirmed"), std::string::npos) << text;
  EXPECT_NE(text.find("mission 01:05"), std::string::npos) << text;
  EXPECT_NE(text.find("last report 3 s ago"), std::string::npos) << text;
  EXPECT_NE(status_line(view).find("last report 3 s ago"), std::string::npos) << status_line(view);
}

TEST(FlightViewTest, ComponentsInTroubleAreNamed) {
  FlightView view = view_at(0);
  const ReportInfo& report = report_named("components");
  ComponentHealth health;
  ASSERT_NE(view.reports.take(tailoring, housekeeping_of("components", health, report.repeats)), nullptr);
  EXPECT_NE(all(panel(view)).find("health    no fault"), std::string::npos);
  const std::vector<std::uint8_t> data = data_of([&](ByteWriter& out) {
    encode_report_id(tailoring, report.id, out);
    for (std::size_t i = 0; i < report.repeats; ++i) {
      health.faults = i == 3 ? 5 : 0;
      write_report_values(report, &health, out);
    }
  });
  ASSERT_NE(view.reports.take(tailoring, data), nullptr);
  EXPECT_NE(all(panel(view)).find("overlap_checker 5 faults, 0 restarts"), std::string::npos) << all(panel(view));
}

TEST(FlightViewTest, ReportsOfAnotherLengthOrNumberAreLeftOut) {
  FlightView view;
  std::vector<std::uint8_t> data = housekeeping_of("status", PackageStatus{});
  data.pop_back();
  EXPECT_EQ(view.reports.take(tailoring, data), nullptr);
  EXPECT_EQ(view.reports.take(tailoring, std::vector<std::uint8_t>{99, 0, 0}), nullptr);
  EXPECT_EQ(view.reports.take(tailoring, {}), nullptr);
  EXPECT_NE(all(panel(view)).find("nothing yet"), std::string::npos);
}

TEST(FlightViewTest, ThePassPlanIsTheFlights) {
  FlightView view = view_at(130 * ns_per_s);
  EXPECT_EQ(pass_words(view), "always in contact");
  view.mission.pass_period_s = 100;
  view.mission.pass_length_s = 20;
  EXPECT_EQ(pass_words(view), "no contact; the next pass begins in 01:10 and lasts 00:20");
  view.since_status = 75 * ns_per_s;
  EXPECT_EQ(pass_words(view), "in contact for 00:15 more") << "time goes on without reports";
  const std::vector<std::string> plan = pass_plan(view, 2);
  ASSERT_EQ(plan.size(), 3U);
  EXPECT_EQ(plan[1], "  pass 2 from mission time 03:20 to 03:40, now");
  EXPECT_EQ(plan[2], "  pass 3 from mission time 05:00 to 05:20, in 01:35");
  view.mission.pass_count = 2;
  EXPECT_EQ(pass_words(view), "no contact: the last pass is over");
  view.parameters_known = false;
  EXPECT_EQ(pass_words(view), "pass plan not known yet");
}

TEST(ReportWords, AnEventHasItsMeaningAndWhatToDo) {
  Report report;
  report.header.service = event_reporting::service;
  report.header.subtype = event_reporting::informative + static_cast<std::uint8_t>(Severity::medium);
  const std::vector<std::uint8_t> auxiliary = data_of([](ByteWriter& out) {
    out.u8(4);
    out.number(17, 8);
    out.number(static_cast<std::uint64_t>(StripEnd::overlap_lost), 8);
    out.u32(9);
    ASSERT_TRUE(encode_time(tailoring.time, 3600 * ns_per_s, out).ok());
  });
  report.data = data_of([&](ByteWriter& out) {
    encode_event(tailoring, static_cast<std::uint32_t>(StatusCode::strip_broken), auxiliary, out);
  });
  EXPECT_EQ(event_words(tailoring, report),
            "event 9 medium at 01:00:00 overlap_checker strip_broken: strip 17 ended: overlap lost. To do: " +
                std::string(status_advice(StatusCode::strip_broken)));
  report.data.resize(report.data.size() - 3);
  EXPECT_EQ(event_words(tailoring, report), "an event report that is cut short");
}

TEST(ReportWords, TheScheduleNamesOurOwnRequests) {
  Report report;
  report.data = data_of([](ByteWriter& out) {
    encode_report_head(tailoring, 1, out);
    ScheduleItem item{.release = 24837 * seconds_per_day * ns_per_s, .id = {1, 239, 23}};
    ASSERT_TRUE(encode_summary_item(tailoring, item, out).ok());
  });
  const auto lines = schedule_words(tailoring, report, [](std::uint32_t request) {
    return request == 0x18EFC017 ? std::string("capture +10") : std::string("unknown");
  });
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[1], "  2026-01-01T00:00:00.000Z capture +10 (source 1, count 23)");
}

TEST(ReportWords, AFailureSaysWhyAndWhatToDo) {
  const std::vector<std::uint8_t> values = data_of([](ByteWriter& out) {
    out.number(0, 8);
    out.number(0, 8);
  });
  const std::string words = failure_words(static_cast<std::uint32_t>(StatusCode::capture_in_past), values);
  EXPECT_EQ(words.rfind("capture_in_past: ", 0), 0U) << words;
  EXPECT_EQ(failure_words(60000, values), "code 60000, unknown to this program");
}

TEST(ReceivedFile, IsHeldWholeOrNotAtAll) {
  const test::TemporaryFolder folder;
  const std::filesystem::path path = folder / "in";
  make_folder(path);
  const std::vector<std::uint8_t> first = {'a', 'b'}, other = {'x'};
  EXPECT_EQ(keep_file(path, "records-000001.ilp", first), "");
  EXPECT_EQ(keep_file(path, "records-000001.ilp", first), "") << "again";
  EXPECT_NE(keep_file(path, "records-000001.ilp", other).find("other content"), std::string::npos);
  EXPECT_EQ(test::text_of(path / "records-000001.ilp"), "ab");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path), std::filesystem::directory_iterator()), 1);
}

TEST(ReceivedFile, NamesThatLeaveTheFolderAreRefused) {
  const test::TemporaryFolder folder;
  const std::filesystem::path path = folder / "in";
  make_folder(path);
  for (const char* name : {"", "..", "../up", "a/b", ".hidden", "two words", "line\nbreak"}) {
    EXPECT_NE(keep_file(path, name, std::vector<std::uint8_t>{1}), "") << name;
  }
  EXPECT_TRUE(std::filesystem::is_empty(path));
}

TEST(TerminalText, IsCutAndHoldsNoControlCharacter) {
  EXPECT_EQ(fit("abcdef", 3), "abc");
  EXPECT_EQ(fit("a\x1b[2Jb\n", 10), "a?[2Jb?");
}

}  // namespace
}  // namespace ilp::console
