#include "sim/tools/docgen/markdown.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace ilp::docgen {

std::string cell(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string code(const std::string& text) {
  return "`" + cell(text) + "`";
}

std::string table_row(const Cells& cells) {
  std::string row = "|";
  for (const std::string& content : cells) row += content.empty() ? " |" : " " + content + " |";
  return row + "\n";
}

std::string table_head(const Cells& titles) {
  return table_row(titles) + table_row(Cells(titles.size(), "---"));
}

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.10g", value);
  return text.data();
}

bool says_more(const EnumValue& value) {
  std::string words = value.name;
  std::replace(words.begin(), words.end(), '_', ' ');
  return value.meaning[0] != 0 && words != value.meaning;
}

std::string values_text(EnumValues values) {
  std::string text;
  for (const EnumValue& value : values) {
    text += (text.empty() ? "" : ", ") + std::to_string(value.number) + " " + code(value.name);
    if (says_more(value)) text += " (" + cell(value.meaning) + ")";
  }
  return text;
}

std::string range_cell(const ParameterInfo& info) {
  return info.choices.empty() ? number(info.minimum) + " to " + number(info.maximum) : "";
}

std::string value_cell(const ParameterInfo& info, double value) {
  const EnumValue* const choice = find_value(info.choices, static_cast<std::uint64_t>(value));
  return choice != nullptr ? code(choice->name) : number(value);
}

std::string meaning_cell(const ParameterInfo& info) {
  const std::string text = cell(info.description);
  const bool choice = !info.choices.empty() && info.choices.data() != boolean_values;
  return choice ? text + ": " + values_text(info.choices) : text;
}

std::string meaning_cell(const FieldInfo& field) {
  std::string text = cell(field.description), words = field.name;
  std::replace(words.begin(), words.end(), '_', ' ');
  if (words == text || words == text + " id" || words == text + " " + field.unit) text.clear();
  if (text.empty() && !field.values.empty()) return values_text(field.values);
  return field.values.empty() ? text : text + ": " + values_text(field.values);
}

}  // namespace ilp::docgen
