#include "sim/ground/console/operator_console.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "cfg/limits.hpp"
#include "fsw/packets/service_events.hpp"
#include "fsw/packets/service_housekeeping.hpp"
#include "fsw/packets/service_parameters.hpp"
#include "fsw/packets/service_schedule.hpp"
#include "fsw/packets/service_verification.hpp"
#include "fsw/records/records.hpp"
#include "hal/clock/utc.hpp"
#include "sim/ground/console/received_file.hpp"
#include "sim/ground/console/report_values.hpp"
#include "sim/ground/console/telecommand_data.hpp"

namespace ilp::console {
namespace {

/// The housekeeping reports that the view shows.
constexpr const char* watched[] = {"status", "components", "link",     "commanding", "storage", "frame", "overlap",
                                   "strip",  "keyframe",   "richness", "transfer",   "timing",  "nodes"};
/// Housekeeping that has not come by then is requested again: the flight may have been out of contact.
constexpr double report_patience_s = 10, first_patience_s = 3;
constexpr double answer_s = 15;
/// After this time without any report the operator is told what may be wrong.
constexpr double silence_s = 5;

ConsoleSettings link_of(const OperatorSettings& settings, ground_cfdp::CfdpReceiver::Keep keep) {
  ConsoleSettings link = settings.link;
  link.take_files = !settings.out.empty();
  link.remember_files = false;
  link.seal_files = settings.seal_files == SealFiles::yes;
  link.keep = std::move(keep);
  return link;
}

OperatorCommand own_command(std::uint8_t service, std::uint8_t subtype, Console::Bytes data, const char* words) {
  OperatorCommand command;
  command.kind = OperatorCommand::Kind::telecommand;
  command.words = words;
  command.service = service;
  command.subtype = subtype;
  command.data = std::move(data);
  return command;
}

}  // namespace

OperatorConsole::OperatorConsole(OperatorSettings settings, Say say)
    : settings_(std::move(settings)),
      say_(std::move(say)),
      console_(
          link_of(settings_, [this](const std::string& name, const Console::Bytes& file) { return keep(name, file); })),
      parameters_reported_(parameter_count()) {
  if (!settings_.out.empty()) make_folder(settings_.out);
  subscribe();
  ask_for_parameters();
}

void OperatorConsole::subscribe() {
  const Tailoring& tailoring = settings_.link.tailoring;
  // A tailoring without lists takes one report at a time.
  for (const char* name : watched) {
    const auto report = std::find_if(report_table().begin(), report_table().end(),
                                     [&](const ReportInfo& info) { return std::string(info.name) == name; });
    ReportList list;
    IntervalList intervals;
    if (!list.push_back(report->id) || !intervals.push_back({report->id, settings_.interval})) continue;
    send(own_command(housekeeping::service, housekeeping::set_interval,
                     data_of([&](ByteWriter& out) { encode_interval_list(tailoring, intervals, out); }),
                     "interval of housekeeping"),
         true);
    send(own_command(housekeeping::service, housekeeping::enable,
                     data_of([&](ByteWriter& out) { encode_report_list(tailoring, list, out); }), "housekeeping"),
         true);
  }
  asked_s_ = now_s();
}

void OperatorConsole::ask_for_parameters() {
  const Tailoring& tailoring = settings_.link.tailoring;
  // This many parameters fit into one answer, whatever their types are.
  constexpr std::size_t in_a_request = 50;
  for (std::size_t begin = 0; begin < parameter_count(); begin += in_a_request) {
    const std::size_t end = std::min(begin + in_a_request, parameter_count());
    send(own_command(parameter_management::service, parameter_management::report, data_of([&](ByteWriter& out) {
                       write_count(tailoring.parameter_count, end - begin, out);
                       for (std::size_t i = begin; i < end; ++i)
                         out.number(parameter_info(i).number, tailoring.parameter_id);
                     }),
                     "parameters"),
         true);
  }
}

void OperatorConsole::send(const OperatorCommand& command, bool own) {
  const std::uint32_t request = console_.command(command.service, command.subtype, command.data);
  requests_[request] = {command.words, command, now_s(), own, false};
  if (own) return;
  say_("sent: " + command.words);
  if (out_of_contact(view_)) say_("the flight does not listen now: " + pass_words(view_));
  ParameterList list;
  if (command.service == parameter_management::service && command.subtype == parameter_management::report &&
      decode_parameter_list(settings_.link.tailoring, command.data, list).ok()) {
    std::vector<std::size_t>& wanted = parameters_wanted_.emplace_back();
    for (const std::uint32_t id : list) wanted.push_back(find_parameter(id));
  }
}

void OperatorConsole::watch_receiver() {
  const std::uint64_t forgotten = console_.cfdp().counts().forgotten;
  if (forgotten == forgotten_reported_) return;
  say_(std::to_string(forgotten - forgotten_reported_) +
       " incomplete file transfers were dropped for newer ones: a flight does not send this many at a time, so another "
       "sender may use the link");
  forgotten_reported_ = forgotten;
}

void OperatorConsole::follow_authentication() {
  if (settings_.seal_files != SealFiles::as_reported) return;
  const bool wanted = view_.mission.authentication == Authentication::telecommands_and_files;
  if (wanted == sealing_) return;
  try {
    console_.seal_files(wanted);
    sealing_ = wanted;
    seal_fault_reported_ = false;
    say_(wanted ? "file transfers are authenticated, as the flight requires" : "file transfers are not authenticated");
  } catch (const std::runtime_error& error) {
    if (!seal_fault_reported_) say_(std::string("no file can be confirmed or sent: ") + error.what());
    seal_fault_reported_ = true;
  }
}

UtcNs OperatorConsole::flight_time(double now) const {
  // A damaged report may state any time.
  constexpr UtcNs latest = std::int64_t{1} << 62U;
  if (received_utc_ <= 0 || received_utc_ >= latest) return utc_now();
  return received_utc_ + static_cast<TimeNs>((now - received_s_) * 1e9);
}

OperatorCommand OperatorConsole::parse(const std::string& line) const {
  return parse_operator_command(line, settings_.link.tailoring, flight_time(now_s()));
}

void OperatorConsole::execute(const OperatorCommand& command) {
  switch (command.kind) {
    case OperatorCommand::Kind::nothing:
      return;
    case OperatorCommand::Kind::telecommand:
      return send(command, false);
    case OperatorCommand::Kind::show:
      for (const std::string& text : view_.reports.lines(command.report)) say_("  " + text);
      return;
    case OperatorCommand::Kind::uplink:
      return uplinks_.send(command.path, command.words);
    case OperatorCommand::Kind::passes:
      for (const std::string& text : pass_plan(view_, 5)) say_(text);
      return;
    case OperatorCommand::Kind::help:
      for (const std::string& text : operator_help()) say_("  " + text);
      return;
    case OperatorCommand::Kind::wait:
      pause_s_ = command.seconds;
      return;
    case OperatorCommand::Kind::quit:
      quit_ = true;
      return;
  }
}

void OperatorConsole::enter(const std::string& line) {
  pause_s_ = 0;
  try {
    execute(parse(line));
  } catch (const std::runtime_error& error) {
    ++failures_;
    say_("not sent: " + line + ": " + error.what());
  }
}

void OperatorConsole::step(double seconds) {
  console_.listen(seconds);
  const double now = now_s();
  for (const Report& report : console_.take_reports()) receive(report, now);
  if (view_.received_s) view_.received_s = now - received_s_;
  view_.since_status = static_cast<TimeNs>((now - status_s_) * 1e9);
  uplinks_.watch();
  watch_receiver();
  keep_subscribed(now);
  suspect_silent_requests(now);
  suspect_silent_address(now);
}

void OperatorConsole::keep_subscribed(double now) {
  const bool begun = view_.reports.of("status") != nullptr;
  const double patience = begun ? report_patience_s + 2e-9 * static_cast<double>(settings_.interval) : first_patience_s;
  if ((begun && now - status_s_ < patience) || now - asked_s_ < patience) return;
  std::erase_if(requests_, [](const auto& request) { return request.second.own; });
  subscribe();
  ask_for_parameters();
}

void OperatorConsole::suspect_silent_requests(double now) {
  for (auto& [id, request] : requests_) {
    if (request.own || request.received || now - request.sent_s < answer_s) continue;
    request.received = true;
    say_("no answer yet: " + request.words + "; is the flight in contact?");
  }
}

std::string OperatorConsole::silence_words() const {
  if (console_.refused())
    return "no program listens there: start the flight with this address (--link-udp), or correct the address";
  return "check the address, that the flight runs with it (--link-udp, --link-tcp), its key (--key), and that it is in "
         "contact";
}

void OperatorConsole::suspect_silent_address(double now) {
  if (silence_reported_ || view_.received_s || now - begun_s_ < silence_s) return;
  silence_reported_ = true;
  say_("nothing has come from the flight: " + silence_words() + "; the console goes on asking");
}

std::vector<std::string> OperatorConsole::waiting() const {
  std::vector<std::string> words;
  for (const auto& [id, request] : requests_) {
    if (!request.own) words.push_back(request.words);
  }
  for (std::string& uplink : uplinks_.waiting()) words.push_back(std::move(uplink));
  return words;
}

std::string OperatorConsole::name_of(std::uint32_t request) const {
  const auto found = requests_.find(request);
  return found == requests_.end() ? "a telecommand of another station" : found->second.words;
}

void OperatorConsole::receive(const Report& report, double now) {
  received_s_ = now;
  received_utc_ = report.header.time;
  view_.received_s = 0;
  const Tailoring& tailoring = settings_.link.tailoring;
  const std::uint8_t service = report.header.service, subtype = report.header.subtype;
  if (service == verification::service) return receive_verification(report);
  if (service == housekeeping::service && subtype == housekeeping::report) return receive_housekeeping(report, now);
  if (service == parameter_management::service) return receive_parameters(report);
  if (service == event_reporting::service && subtype < event_reporting::enable) say_(event_words(tailoring, report));
  if (service == test_service::service && subtype == test_service::alive) say_("the flight is alive");
  if (service == scheduling::service && subtype == scheduling::summary_report) {
    for (const std::string& line : schedule_words(tailoring, report, [this](std::uint32_t r) { return name_of(r); })) {
      say_(line);
    }
  }
}

void OperatorConsole::receive_verification(const Report& report) {
  VerificationReport reported;
  if (!decode_verification(settings_.link.tailoring, report.header.subtype, report.data, reported).ok()) return;
  const auto found = requests_.find(reported.request);
  if (found == requests_.end() || report.header.destination != settings_.link.source) return;
  found->second.received = true;
  const Request request = found->second;
  const bool failed = reported.subtype % 2 == 0;
  const bool last = failed || reported.subtype == verification::completion;
  if (last) requests_.erase(found);
  if (failed) {
    if (!request.own) ++failures_;
    const bool missing = reported.code == static_cast<std::uint32_t>(StatusCode::not_found);
    const std::string missed = missing ? missing_words(request.command) : "";
    say_((reported.subtype == verification::acceptance_failed ? "refused: " : "failed: ") + request.words + ": " +
         (missed.empty() ? failure_words(reported.code, reported.failure_data) : missed));
  } else if (!request.own) {
    const std::string step =
        reported.subtype == verification::progress ? ", step " + std::to_string(reported.step) : "";
    const char* what = reported.subtype == verification::acceptance ? "accepted: "
                       : reported.subtype == verification::start    ? "started: "
                       : reported.subtype == verification::progress ? "in progress: "
                                                                    : "done: ";
    say_(what + request.words + step);
    if (last) follow_contact(request.command);
  }
}

void OperatorConsole::follow_contact(const OperatorCommand& command) {
  if (!view_.parameters_known || !view_.reports.of("status")) return;
  const std::string reported = apply_contact_command(command, view_);
  if (!reported.empty()) say_(reported);
}

void OperatorConsole::receive_housekeeping(const Report& report, double now) {
  const ReportInfo* info = view_.reports.take(settings_.link.tailoring, report.data);
  if (!info || std::string(info->name) != "status") return;
  status_s_ = now;
  const std::optional<double> crc = view_.reports.value("status", "parameters_crc32");
  if (parameters_crc_ && crc != parameters_crc_) ask_for_parameters();
  parameters_crc_ = crc;
}

void OperatorConsole::receive_parameters(const Report& report) {
  std::vector<std::size_t> reported;
  const std::vector<std::string> lines =
      parameter_words(settings_.link.tailoring, report, [&](std::size_t index, double value) {
        static_cast<void>(set_parameter(view_.mission, index, value));
        parameters_reported_[index] = true;
        reported.push_back(index);
      });
  static const std::size_t authentication = find_parameter("link", "authentication");
  if (parameters_reported_[authentication]) follow_authentication();
  view_.parameters_known =
      std::find(parameters_reported_.begin(), parameters_reported_.end(), false) == parameters_reported_.end();
  const auto wanted = std::find(parameters_wanted_.begin(), parameters_wanted_.end(), reported);
  if (wanted == parameters_wanted_.end()) return;
  parameters_wanted_.erase(wanted);
  for (const std::string& line : lines) say_("  " + line);
}

bool OperatorConsole::keep(const std::string& name, const Console::Bytes& file) {
  const std::string fault = keep_file(settings_.out, name, file);
  if (fault.empty()) {
    say_("file: " + name + ", " + std::to_string(file.size()) + " bytes");
  } else {
    ++failures_;
    say_("file not taken: " + fault);
  }
  return fault.empty();
}

}  // namespace ilp::console
