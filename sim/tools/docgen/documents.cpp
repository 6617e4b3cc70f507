#include "sim/tools/docgen/documents.hpp"

#include <algorithm>

#include "cfg/mission.hpp"
#include "cfg/schedule.hpp"
#include "fsw/base/status.hpp"
#include "fsw/records/records.hpp"
#include "sim/tools/docgen/interface_document.hpp"
#include "sim/tools/docgen/markdown.hpp"
#include "sim/tools/docgen/records_document.hpp"
#include "sim/tools/docgen/value_cells.hpp"

namespace ilp::sim {
namespace {

std::string made_from(const std::string& source) {
  return "<!-- Made by `build/host/bin/ilp-docgen docs` from " + source + ". Change it there. -->\n\n";
}

std::string parameters_document() {
  std::string text = "# Mission parameters\n\n" + made_from("cfg/parameters.inc and cfg/choices.hpp");
  text +=
      "What a mission file may set (`sim/fly --mission FILE.ini`, `ilp-onboard --mission FILE.ini`, or a file from the "
      "ground). A file holds `[section]` lines and\n`key = value` lines; `;` and `#` begin comments at the start of a "
      "line or after a blank. A value is a decimal number, or the name of a choice:\n`capture_mode = forecast` and "
      "`capture_mode = 1` say the same. What is not named keeps its default. An unknown name, a value out of range, a "
      "fraction where the type is\na whole number, or values that contradict each other ([commanding](commanding.md)) "
      "refuse the whole file.\n\n"
      "Service 20 names a parameter by its number, with a value of its type, big-endian ([commanding](commanding.md)). "
      "A value set\nthat way stays over a restart and goes before the file; it takes effect at once, or where the "
      "type says so with the next\nstart.\n\n";
  text += table_head({"no.", "section", "key", "type", "unit", "range", "default", "meaning"});
  const MissionParameters defaults;
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    const ParameterInfo& info = parameter_info(i);
    text += table_row({std::to_string(info.number), cell(info.section), code(info.key),
                       std::string(field_type_name(info.type)) + (info.acts == Acts::next_start ? ", next start" : ""),
                       cell(info.unit), range_cell(info), value_cell(info, parameter_value(defaults, i)),
                       meaning_cell(info)});
  }
  return text;
}

const char* severity_name(Severity severity) {
  switch (severity) {
    case Severity::info:
      return "info";
    case Severity::low:
      return "low";
    case Severity::medium:
      return "medium";
    case Severity::high:
      return "high";
  }
  return "?";
}

std::string events_document() {
  std::string text = "# Events\n\n" + made_from("fsw/base/status_list.inc");
  text +=
      "Every code that a `Status` or an event report can carry. `%a` and `%b` in the text stand for the two values of "
      "the report\n(columns `a` and `b` of the table `event`, whose column `code` holds the number). Severities are "
      "those of ECSS-E-ST-70-41C,\nservice 5. The programs print the same texts.\n\n";
  text += table_head({"code", "name", "severity", "text", "what to do"});
  for (std::size_t i = 0; i < status_code_limit; ++i) {
    if (!is_status_code(i)) continue;
    const auto status = static_cast<StatusCode>(i);
    text += table_row({std::to_string(i), code(status_name(status)), severity_name(status_severity(status)),
                       cell(status_text(status)), cell(status_advice(status))});
  }
  return text;
}

std::string names_of(RecordMask mask) {
  std::string names;
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    const auto type = static_cast<RecordType>(t);
    if ((mask & mask_of(type)) == 0) continue;
    names += (names.empty() ? "" : ", ") + code(record_info(type).name);
  }
  return names;
}

std::string milliseconds(TimeNs time) {
  return number(static_cast<double>(time) / static_cast<double>(ns_per_ms)) + " ms";
}

std::string schedule_document() {
  std::string text = "# Schedule\n\n" + made_from("cfg/schedule.hpp");
  text += "The executive runs in minor frames of " + milliseconds(minor_frame_ns) +
          ". In each it calls, in the order of the table, every component that is due or\nwas woken by a change of a "
          "record it watches; what is left of the frame goes to whoever has work pending. A step\nthat takes more "
          "processor time than its budget is counted as an overrun; nothing is cut "
          "off. "
          "A frame that ends late is reported.\nAt most " +
          std::to_string(max_steps_per_frame) + " steps run in one frame. A component that reports " +
          std::to_string(max_faults_in_a_row) +
          " faults without a good step between them waits for\nthe next frame. Besides the records named here, every "
          "component writes its `checkpoint`; the executive writes\n`event` and `component`.\n\n";
  text += table_head({"", "component", "woken by", "writes", "runs", "budget of a step"});
  for (const Stage& stage : schedule) {
    std::string runs = "when woken";
    if (stage.period == 1) runs = "every frame";
    if (stage.period > 1) runs = "when woken, and every " + std::to_string(stage.period) + " frames";
    text += table_row({std::to_string(static_cast<unsigned>(stage.component) + 1), code(stage.name),
                       names_of(stage.reads), names_of(stage.writes), runs, milliseconds(stage.budget_ns)});
  }
  text += "\nThe number is the id of the component's rows in the tables `component` and `checkpoint`.\n";
  return text;
}

}  // namespace

std::vector<Document> generated_documents() {
  return {{"parameters.md", parameters_document()},
          {"events.md", events_document()},
          {"records.md", "# Records\n\n" + made_from("fsw/records/records.cpp") + records_document()},
          {"schedule.md", schedule_document()},
          {"interface-control-document.md",
           "# Interface control document\n\n" +
               made_from("fsw/link/message_table.cpp, fsw/link/tailoring.cpp, fsw/commanding/function_table.cpp, "
                         "fsw/telemetry/telemetry_reports.cpp, cfg/parameters.inc and fsw/base/status_list.inc") +
               interface_document()}};
}

}  // namespace ilp::sim
