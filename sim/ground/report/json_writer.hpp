// Writes a JSON object value by value, and lists element by element, so that memory does not grow with the object.
#pragma once

#include <nlohmann/json.hpp>
#include <ostream>
#include <string>

#include "sim/ground/report/report.hpp"

namespace ilp::report {

using Json = nlohmann::ordered_json;

/// Writes one object. It escapes `<`, so that no text can end the HTML element that contains the object.
class JsonWriter {
 public:
  JsonWriter(std::ostream& out, JsonStyle style) : out_(out), indented_(style == JsonStyle::indented) { out_ << "{"; }

  void put(const std::string& key, const Json& value) {
    begin(key);
    write(value);
  }
  void begin_list(const char* key) { open(key, "["); }
  void add(const Json& element) {
    next();
    write(element);
  }
  void end_list() { close("]"); }
  /// Begins an object as a member. Until end_object(), put() adds members to it.
  void begin_object(const char* key) { open(key, "{"); }
  void end_object() { close("}"); }
  void end() {
    depth_ = 0;
    out_ << line_break() << "}\n";
  }

 private:
  void next() {
    out_ << (first_ ? "" : ",") << line_break();
    first_ = false;
  }
  void begin(const std::string& key) {
    next();
    out_ << '"' << key << (indented_ ? "\": " : "\":");
  }
  void open(const char* key, const char* bracket) {
    begin(key);
    out_ << bracket;
    first_ = true;
    ++depth_;
  }
  void close(const char* bracket) {
    --depth_;
    out_ << (first_ ? "" : line_break()) << bracket;
    first_ = false;
  }
  [[nodiscard]] std::string line_break() const { return indented_ ? "\n" + std::string(depth_, ' ') : ""; }
  /// Indents every line: JSON strings contain no raw line breaks, so that each break is one of the layout.
  void write(const Json& value) {
    // Names from hostile files need not be UTF-8.
    const std::string text = value.dump(indented_ ? 1 : -1, ' ', false, Json::error_handler_t::replace);
    const std::string indentation = line_break();
    for (const char c : text) {
      if (c == '\n') {
        out_ << indentation;
      } else if (c == '<') {
        out_ << "\\u003c";
      } else {
        out_.put(c);
      }
    }
  }

  std::ostream& out_;
  bool indented_;
  bool first_ = true;
  std::size_t depth_ = 1;
};

}  // namespace ilp::report
