// What the flight sends, or an attacker in its place: packets, reports of all services in all tailorings, and what the
// operator's console shows of them.
#include <cmath>
#include <string>

#include "fsw/packets/service_events.hpp"
#include "fsw/packets/service_housekeeping.hpp"
#include "fsw/packets/service_parameters.hpp"
#include "fsw/packets/service_schedule.hpp"
#include "fsw/packets/service_verification.hpp"
#include "sim/ground/console/flight_view.hpp"
#include "sim/ground/console/report_values.hpp"
#include "sim/ground/console/terminal.hpp"
#include "sim/ground/console/utc_text.hpp"
#include "tests/fuzz/targets.hpp"

namespace ilp::fuzz {
namespace {

using console::FlightView;
using console::Report;
using Bytes = std::vector<std::uint8_t>;

class Station {
 public:
  explicit Station(const Tailoring& tailoring) : tailoring_(tailoring) {}

  void receive(Octets octets) {
    console::take_packets(
        octets, 239, tailoring_, [this](const Report& report) { look_at(report); },
        [](Octets pdu) { require(!pdu.empty(), "a PDU of nothing"); });
  }
  void look_at(const Report& report) {
    look(console::event_words(tailoring_, report));
    look(console::schedule_words(tailoring_, report, [](std::uint32_t) { return std::string("ours"); }));
    look(console::parameter_words(tailoring_, report, [this](std::size_t index, double value) {
      static_cast<void>(set_parameter(view_.mission, index, value));
    }));
    VerificationReport reported;
    if (decode_verification(tailoring_, report.header.subtype, report.data, reported).ok()) {
      look(console::failure_words(reported.code, reported.failure_data));
    }
    if (const ReportInfo* info = view_.reports.take(tailoring_, report.data)) look(view_.reports.lines(info->name));
    look(console::utc_text(report.header.time));
    look(console::clock_text(report.header.time));
  }
  void show(Choices& choices) {
    view_.parameters_known = true;
    view_.since_status = static_cast<TimeNs>(choices.u32()) * ns_per_ms;
    if ((choices.byte() & 1U) != 0) view_.received_s = choices.u16();
    look(console::panel(view_));
    look(console::pass_words(view_));
    look(console::pass_plan(view_, 5));
    look({console::status_line(view_)});
  }

 private:
  static void look(const std::string& line) {
    for (const char c : console::fit(line, line.size()))
      require(c >= ' ' && c <= '~', "a character that does something");
  }
  static void look(const std::vector<std::string>& lines) {
    require(lines.size() < 70000, "a report as long as a packet");
    for (const std::string& line : lines) look(line);
  }

  const Tailoring& tailoring_;
  FlightView view_;
};

/// A report of the console's services whose data the input gives.
Report choose_report(Choices& choices) {
  static constexpr std::uint8_t kinds[][2] = {{1, 1}, {1, 2}, {1, 7},  {1, 8},  {3, 25},
                                              {5, 1}, {5, 4}, {20, 2}, {11, 13}};
  const std::uint8_t* kind = kinds[choices.byte() % std::size(kinds)];
  Report report;
  report.header.service = kind[0];
  report.header.subtype = kind[1];
  const std::uint8_t how = choices.byte();
  report.header.time = (how & 1U) != 0 ? static_cast<UtcNs>(choices.number(8)) : static_cast<UtcNs>(choices.u32());
  if ((how & 2U) == 0) {
    const Octets data = choices.bytes();
    report.data.assign(data.begin(), data.end());
    return report;
  }
  // A housekeeping report of the length that it has, its octets from the input as far as they go.
  const std::uint8_t which = choices.byte();
  const ReportInfo& info = report_table()[which % report_table().size()];
  const Octets data = choices.take(report_bytes(info));
  report.data = {0, static_cast<std::uint8_t>(info.id)};
  report.data.insert(report.data.end(), data.begin(), data.end());
  report.data.resize(2 + report_bytes(info), choices.byte());
  return report;
}

}  // namespace

void ground_telemetry(Octets input) {
  Choices choices(input);
  const std::uint8_t tailored = choices.byte();
  const Tailoring tailoring = tailoring_of(static_cast<GroundSystem>(tailored % tailoring_count), (tailored & 64U) != 0,
                                           MissionParameters{}.agency_epoch_s);
  Station station(tailoring);
  for (int i = 0; i < 30 && !choices.empty(); ++i) {
    const std::uint8_t operation = choices.byte();
    if (operation % 4 == 0) {
      station.receive(choices.bytes());
    } else {
      station.look_at(choose_report(choices));
    }
  }
  station.show(choices);
}

}  // namespace ilp::fuzz
