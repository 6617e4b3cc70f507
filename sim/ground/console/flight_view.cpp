#include "sim/ground/console/flight_view.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "cfg/schedule.hpp"
#include "fsw/packets/pass_schedule.hpp"
#include "fsw/packets/service_functions.hpp"
#include "sim/ground/console/utc_text.hpp"

namespace ilp::console {
namespace {

// The difference of two such values still fits. A damaged report may state any value.
constexpr double largest_whole = 4e18;

// A value as a whole number, "-" if it is not known.
std::string whole(const FlightView& view, const char* report, const char* field) {
  const std::optional<double> value = view.reports.value(report, field);
  if (!value || !(std::fabs(*value) < largest_whole)) return "-";
  return std::to_string(std::llround(*value));
}

std::string decimal(std::optional<double> value, const char* format) {
  if (!value || std::isnan(*value)) return "-";
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), format, *value);
  return text.data();
}

std::string mebibytes(const FlightView& view, std::initializer_list<const char*> fields) {
  double sum = 0;
  for (const char* field : fields) {
    const std::optional<double> bytes = view.reports.value("storage", field);
    if (!bytes) return "-";
    sum += *bytes / (1 << 20);
  }
  return decimal(sum, "%.1f");
}

std::string strip_words(const FlightView& view) {
  const std::optional<double> end = view.reports.value("strip", "end");
  const std::string id = whole(view, "strip", "id");
  if (!end || id == "0") return "no strip yet";
  return "strip " + id + (*end == 0 ? " open" : " ended");
}

std::string received_words(const FlightView& view) {
  return "last report " +
         (view.received_s ? decimal(*view.received_s, "%.0f s ago") : std::string("nothing yet: is it in contact?"));
}

std::string time_line(const FlightView& view) {
  const std::string clock = view.reports.of("status") ? duration_clock(view.mission_time()) : "-";
  return "time      mission " + clock + ", " + pass_words(view) + "; " + received_words(view);
}

std::string image_line(const FlightView& view) {
  return "images    " + whole(view, "frame", "id") + " frames, " + whole(view, "keyframe", "id") + " keyframes, " +
         strip_words(view) + ", overlap " + decimal(view.reports.value("overlap", "overlap"), "%.2f") + ", richness " +
         decimal(view.reports.value("richness", "richness"), "%.2f") + " of keyframe " + whole(view, "richness", "id");
}

std::string storage_line(const FlightView& view) {
  const bool full = view.reports.value("storage", "full").value_or(0) != 0;
  return "storage   " + mebibytes(view, {"frame_bytes", "depth_bytes", "structure_bytes", "product_bytes"}) + " of " +
         mebibytes(view, {"budget_bytes"}) + " MiB" + (full ? " FULL" : "") +
         ", products: " + whole(view, "storage", "products_held") + " on board, " +
         whole(view, "storage", "products_acknowledged") + " confirmed, " + whole(view, "storage", "products_dropped") +
         " dropped";
}

std::string link_line(const FlightView& view) {
  return "link      reports " + whole(view, "link", "reports_sent") + " sent, " + whole(view, "link", "reports_lost") +
         " lost, " + whole(view, "link", "reports_waiting") + " waiting; files " +
         whole(view, "link", "files_delivered") + " delivered; telecommands " + whole(view, "commanding", "completed") +
         " done, " + whole(view, "commanding", "failed") + " failed, " + whole(view, "commanding", "rejected") +
         " rejected";
}

const char* transfer_state(double state) {
  constexpr std::array<const char*, 4> words = {"waiting", "on its way", "sent, not confirmed", "delivered"};
  return state >= 0 && state < words.size() ? words[static_cast<std::size_t>(state)] : "in an unknown state";
}

std::string queue_line(const FlightView& view) {
  std::string transfer = "no file";
  const std::optional<double> id = view.reports.value("transfer", "id");
  if (id && *id > 0) {
    transfer = "newest file: transfer " + whole(view, "transfer", "sequence") + ", " +
               whole(view, "transfer", "progress") + " of " + whole(view, "transfer", "bytes") + " bytes, " +
               (view.reports.value("transfer", "suspended").value_or(0) != 0
                    ? "held"
                    : transfer_state(view.reports.value("transfer", "state").value_or(-1)));
  }
  return "queue     " + transfer + "; telecommands: " + whole(view, "commanding", "open") + " open, " +
         whole(view, "commanding", "scheduled") + " scheduled";
}

std::string health_line(const FlightView& view) {
  std::string trouble;
  for (const Stage& stage : schedule) {
    const auto repeat = static_cast<std::size_t>(stage.component) - 1;
    const double faults = view.reports.value("components", "faults", 0, repeat).value_or(0);
    const double restarts = view.reports.value("components", "restarts", 0, repeat).value_or(0);
    if (faults + restarts == 0) continue;
    trouble += std::string(trouble.empty() ? "" : "; ") + stage.name + " " + decimal(faults, "%.0f") + " faults, " +
               decimal(restarts, "%.0f") + " restarts";
  }
  if (trouble.empty()) trouble = view.reports.of("components") ? "no fault" : "-";
  return "health    " + trouble + "; minor frames late: " + whole(view, "status", "frame_overruns") + " of " +
         whole(view, "status", "frames_run") + ", level of reduced work " + whole(view, "timing", "degraded");
}

std::string stages_of(std::uint32_t bits) {
  std::string names;
  for (const Stage& stage : schedule) {
    if ((bits >> (static_cast<unsigned>(stage.component) - 1) & 1U) == 0) continue;
    // Those of the primary go together.
    const std::string name = stage.runs_on == RunsOn::primary ? "head" : stage.name;
    if (name != "head" || names.empty()) names += (names.empty() ? "" : ",") + name;
  }
  return names;
}

/// The processes that share the flight, by the stages that each runs; empty for a flight in one process.
std::string nodes_line(const FlightView& view) {
  std::string nodes;
  for (std::size_t i = 0; i < most_nodes; ++i) {
    const auto stages = static_cast<std::uint32_t>(view.reports.value("nodes", "stages", 0, i).value_or(0));
    if (stages == 0) continue;
    nodes += (nodes.empty() ? "" : "; ") + stages_of(stages);
    const double silent_s = view.reports.value("nodes", "silent_ns", 0, i).value_or(0) / 1e9;
    if (silent_s > 10) nodes += " SILENT for " + decimal(silent_s, "%.0f") + " s";
  }
  return nodes.empty() ? nodes : "nodes     " + nodes;
}

std::string in(TimeNs duration) {
  return duration_clock(duration < 0 ? 0 : duration);
}

// The pass at `time`, otherwise the next one; none after the last pass.
std::optional<Contact> pass_from(const MissionParameters& mission, TimeNs time) {
  const Contact contact = contact_at(mission, time);
  if (contact.over) return std::nullopt;
  return contact;
}

}  // namespace

TimeNs FlightView::mission_time() const {
  const std::optional<double> reported = reports.value("status", "mission_time_ns");
  return reported && std::fabs(*reported) < largest_whole ? static_cast<TimeNs>(*reported) + since_status : 0;
}

std::string pass_words(const FlightView& view) {
  if (!view.parameters_known || !view.reports.of("status")) return "pass plan not known yet";
  const TimeNs now = view.mission_time();
  const std::optional<Contact> contact = pass_from(view.mission, now);
  if (!contact) return "no contact: the last pass is over";
  if (contact->open && view.mission.pass_period_s == 0) return "always in contact";
  if (contact->open) return "in contact for " + in(contact->end_ns - now) + " more";
  if (view.mission.pass_period_s == 0)
    return "no contact for " + in(contact->begin_ns - now) + ", because a telecommand ended it";
  return "no contact; the next pass begins in " + in(contact->begin_ns - now) + " and lasts " +
         in(contact->end_ns - contact->begin_ns);
}

std::vector<std::string> pass_plan(const FlightView& view, std::size_t passes) {
  std::vector<std::string> lines = {pass_words(view)};
  if (!view.parameters_known || !view.reports.of("status") || view.mission.pass_period_s == 0) return lines;
  const TimeNs now = view.mission_time();
  TimeNs time = now;
  for (std::size_t i = 0; i < passes; ++i) {
    const std::optional<Contact> contact = pass_from(view.mission, time);
    if (!contact) break;
    lines.push_back("  pass " + std::to_string(contact->pass) + " from mission time " + in(contact->begin_ns) + " to " +
                    in(contact->end_ns) + (contact->open && i == 0 ? ", now" : ", in " + in(contact->begin_ns - now)));
    time = contact->end_ns;
  }
  return lines;
}

std::string apply_contact_command(const OperatorCommand& command, FlightView& view) {
  FunctionCall call;
  if (command.service != function_management::service || !decode_function(command.data, call).ok()) return "";
  const std::string name(call.name, strnlen(call.name, function_name_bytes));
  const TimeNs now = view.mission_time();
  if (name == "PASSBEG") {
    open_contact(now, ByteReader(call.arguments).u32(), view.mission);
    return "";
  }
  if (name != "PASSEND") return "";
  close_contact(now, view.mission);
  const std::optional<Contact> next = pass_from(view.mission, now);
  if (!next) return "the flight neither sends nor listens from now on: its last pass is over";
  return "the flight neither sends nor listens until mission time " + in(next->begin_ns) + ", for " +
         in(next->begin_ns - now);
}

bool out_of_contact(const FlightView& view) {
  return view.parameters_known && view.reports.of("status") && !contact_at(view.mission, view.mission_time()).open;
}

std::vector<std::string> panel(const FlightView& view) {
  std::vector<std::string> lines = {time_line(view), image_line(view), storage_line(view),
                                    link_line(view), queue_line(view), health_line(view)};
  const std::string nodes = nodes_line(view);
  if (!nodes.empty()) lines.push_back(nodes);
  return lines;
}

std::string status_line(const FlightView& view) {
  return "mission " + duration_clock(view.mission_time()) + ", " + pass_words(view) + "; " + received_words(view) +
         "; " + whole(view, "frame", "id") + " frames, " + whole(view, "keyframe", "id") + " keyframes, " +
         whole(view, "storage", "products_held") + " products on board, " +
         whole(view, "storage", "products_acknowledged") + " confirmed, " + whole(view, "commanding", "open") +
         " telecommands open, events to " + whole(view, "status", "events");
}

}  // namespace ilp::console
