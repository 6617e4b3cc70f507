#include "sim/tools/docgen/documents.hpp"

#include <algorithm>
#include <cstring>
#include <set>

#include "bsp/flight/status_text.hpp"
#include "cfg/mission.hpp"
#include "cfg/schedule.hpp"
#include "fsw/base/status.hpp"
#include "fsw/executive/event_log.hpp"
#include "fsw/records/records.hpp"
#include "sim/tools/docgen/interface_document.hpp"
#include "sim/tools/docgen/markdown.hpp"
#include "sim/tools/docgen/records_document.hpp"
#include "sim/tools/docgen/schedule_document.hpp"

namespace ilp::docgen {
namespace {

std::string made_from(const std::string& source) {
  return "<!-- Made by `build/host/bin/ilp-docgen docs` from " + source + ". Change it there. -->\n\n";
}

/// "u8", or "flag": its values are named above the table.
std::string type_cell(const ParameterInfo& info) {
  std::string text = code(info.key) + " ";
  text += info.choices.data() == boolean_values ? "flag" : field_type_name(info.type);
  if (info.unit[0] != 0) text += " " + cell(info.unit);
  return info.acts == Acts::next_start ? text + ", next start" : text;
}

std::string parameters_document() {
  std::string text = "# Mission parameters\n\n" + made_from("cfg/parameters.inc and cfg/choices.hpp");
  text +=
      "What a mission file may set (`sim/fly --mission FILE.ini`, `ilp-onboard --mission FILE.ini`, or a file from the "
      "ground). It has `[section]` lines and `key = value` lines; `;` and `#` begin comments at the start of a line or "
      "after a blank. A value is a decimal number, or the name of a choice: `capture_mode = forecast` and "
      "`capture_mode "
      "= 1` mean the same. An angle is in radians, or in degrees: `20deg`. A parameter that is not named keeps its "
      "default. An unknown name, a value out of range, a fraction where the type is a whole number, or values that "
      "contradict each other refuse the whole file.\n\n"
      "Service 20 names a parameter by its number, with a value of its type, big-endian; a flag is a u8, 0 `false` or "
      "1 `true` ([commanding](commanding.md)). Such a value survives a restart and overrides the file. It takes effect "
      "at once, or with the *next start*.\n\n"
      "A cue x of richness counts as x / (x + `x_half`), times its weight in the index, `x_weight`. A sigma is one "
      "standard deviation.\n";
  const MissionParameters defaults;
  std::string section;
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    const ParameterInfo& info = parameter_info(i);
    if (section != info.section) {
      section = info.section;
      text += "\n## " + section + "\n\n" + table_head({"number, key, type, unit", "range", "default", "meaning"});
    }
    text += table_row({std::to_string(info.number) + " " + type_cell(info), range_cell(info),
                       value_cell(info, parameter_value(defaults, i)), meaning_cell(info)});
  }
  return text;
}

/// "*depth* (pixels)": the name of a value and its type, where the name does not say it.
std::string named_value(const StatusValue& value) {
  const std::string name = value.name, type = info_of(value.type).name;
  const bool plain = name == type || value.type == ValueType::number || value.type == ValueType::id;
  return "*" + cell(name) + "*" + (plain ? "" : " (" + type + ")");
}

/// The text with the names of its values, which also stand for the same word beside them ("frame %a", "%a items").
/// Where b comes first, both say which value they are.
std::string named_text(StatusCode code) {
  std::string text = cell(status_text(code));
  const StatusValues values = status_values(code);
  const bool turned = text.find("%b") < text.find("%a");
  for (const bool second : {false, true}) {
    const std::string mark = second ? "%b" : "%a";
    const std::string name = named_value(second ? values.b : values.a) + (turned ? (second ? " [b]" : " [a]") : "");
    const std::size_t at = text.find(mark);
    if (at == std::string::npos) {
      if ((second ? values.b : values.a).type != ValueType::none) text += "; " + name;
      continue;
    }
    std::string word = second ? values.b.name : values.a.name;
    std::replace(word.begin(), word.end(), '_', ' ');
    const std::size_t from = at > word.size() ? at - word.size() - 1 : at;
    const std::size_t end = at + mark.size();
    const bool before = text.compare(from, end - from, word + " " + mark) == 0 &&
                        (from == 0 || text[from - 1] == ' ' || text[from - 1] == '(');
    const bool behind = text.compare(end, word.size() + 1, " " + word) == 0 &&
                        std::string(" ,:;)").find((text + " ")[end + 1 + word.size()]) != std::string::npos;
    const std::size_t begin = before ? from : at;
    text.replace(begin, (behind ? end + 1 + word.size() : end) - begin, name);
  }
  return text;
}

/// The numbers whose names say all.
std::string plain_names(EnumValues values) {
  std::string text;
  for (const EnumValue& value : values) {
    if (!says_more(value)) text += (text.empty() ? "" : ", ") + std::to_string(value.number) + " " + code(value.name);
  }
  return text;
}

bool same_values(EnumValues a, EnumValues b) {
  if (a.empty() || a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].number != b[i].number || std::strcmp(a[i].name, b[i].name) != 0) return false;
  }
  return true;
}

/// The field of a record whose page has these names already.
std::string field_with(EnumValues values) {
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    const RecordInfo& record = record_info(static_cast<RecordType>(t));
    for (std::size_t f = 0; f < record.field_count; ++f) {
      const FieldInfo& field = record.fields[f];
      if (field.values.data() == boolean_values || !same_values(field.values, values)) continue;
      return "as " + code(field.name) + " of [" + record.name + "](records.md#" + record.name + ")";
    }
  }
  return "";
}

/// The types of values, and the names of their numbers.
std::string value_types() {
  std::string text =
      "\n## Types of values\n\nThe programs write a value with the unit of its type, or by the name of its number; a "
      "number without a name as it is. The numbers of a type follow it.\n\n" +
      table_head({"type, or number and name", "unit or meaning"});
  for (std::size_t i = 1; i < static_cast<std::size_t>(ValueType::count); ++i) {
    const auto type = static_cast<ValueType>(i);
    const ValueTypeInfo& info = info_of(type);
    std::string meaning = info.per_unit > 1 ? "1/" + std::to_string(info.per_unit) : "";
    if (info.unit[0] != 0) meaning += (meaning.empty() ? "" : " ") + cell(info.unit);
    const std::string elsewhere = field_with(named_values(type));
    for (const std::string& part :
         {cell(info.meaning), elsewhere.empty() ? plain_names(named_values(type)) : elsewhere}) {
      meaning += (meaning.empty() || part.empty() ? "" : ": ") + part;
    }
    text += table_row({std::string("**") + info.name + "**", meaning});
    for (const EnumValue& value : elsewhere.empty() ? named_values(type) : EnumValues{}) {
      if (says_more(value)) {
        text += table_row({std::to_string(value.number) + " " + code(value.name), cell(value.meaning)});
      }
    }
  }
  return text;
}

std::string events_document() {
  std::string text = "# Events\n\n" + made_from("fsw/base/status_list.inc");
  text +=
      "Every code of a `Status` or an event report. Names of its values a and b (columns of the table `event`) are in "
      "*italics*, in this order or marked, with their [types](#types-of-values) behind them. A value without a type is "
      "a plain number, or the id of the record that it names. "
      "Severities are those of ECSS-E-ST-70-41C, service 5. An empty last column: nothing is to be done. The programs "
      "print the same texts.\n\n"
      "Of each code of each component " +
      std::to_string(EventLog::burst) + " events are written at once, and then one every " +
      std::to_string(EventLog::interval_ns / ns_per_s) + " s of mission time; `events_repeated` counts the others.\n\n";
  text += table_head({"code, name, severity", "text", "what to do"});
  for (std::size_t i = 0; i < status_code_limit; ++i) {
    if (!is_status_code(i)) continue;
    const auto status = static_cast<StatusCode>(i);
    text += table_row({std::to_string(i) + " " + code(status_name(status)) + " " + name_of(status_severity(status)),
                       named_text(status),
                       cell(status_advice(status) == std::string("nothing") ? "" : status_advice(status))});
  }
  return text + value_types();
}

}  // namespace

std::string placed(const Document& document, const std::string& page) {
  if (!document.part) return document.text;
  const std::size_t begin = page.find('\n', page.find(part_begins));
  const std::size_t end = page.find(part_ends);
  if (begin == std::string::npos || end == std::string::npos || begin > end) return page;
  return page.substr(0, begin + 1) + "\n" + document.text + "\n" + page.substr(end);
}

std::vector<Document> generated_documents() {
  std::vector<Document> documents = {
      {"parameters.md", parameters_document()},
      {"events.md", events_document()},
      {"records.md", "# Records\n\n" + made_from("fsw/records/records.inc") + records_document()},
      {"schedule.md", "# Schedule\n\n" + made_from("cfg/schedule.hpp") + schedule_document()},
      {"interface-control-document.md",
       "# Interface control document\n\n" +
           made_from("fsw/packets/message_table.cpp, fsw/packets/tailoring.cpp, fsw/commanding/functions.inc, "
                     "fsw/packets/reports.inc, cfg/parameters.inc and fsw/base/status_list.inc") +
           interface_document()},
      {"design.md", schedule_picture(), true}};
  std::set<std::string> folders;
  for (const Stage& stage : schedule) folders.insert(stage.page);
  for (const std::string& folder : folders)
    documents.push_back({"../fsw/" + folder + "/design.md", stages_of(folder), true});
  return documents;
}

}  // namespace ilp::docgen
