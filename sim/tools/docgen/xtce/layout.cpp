#include "sim/tools/docgen/xtce/layout.hpp"

#include <regex>
#include <stdexcept>

namespace ilp::docgen {
namespace {

constexpr Width widths[] = {
    {"failure code", &Tailoring::failure_code, ""},
    {"step", &Tailoring::step, ""},
    {"report count", &Tailoring::report_count, "one item, no N"},
    {"SID", &Tailoring::report_id, ""},
    {"event count", &Tailoring::event_count, "no list: every event; TM[5,8] has N in 2 octets"},
    {"event", &Tailoring::event_id, ""},
    {"reporter", &Tailoring::event_reporter, ""},
    {"event value", &Tailoring::event_value, ""},
    {"insert count", &Tailoring::insert_count, "one item, no N"},
    {"schedule count", &Tailoring::schedule_count, "one item, no N; in reports 2 octets"},
    {"sub-schedule", &Tailoring::sub_schedule, "not there"},
    {"group", &Tailoring::group, "not there"},
    {"request padding", &Tailoring::request_id_padding, "not there"},
    {"parameter count", &Tailoring::parameter_count, ""},
    {"parameter", &Tailoring::parameter_id, ""},
};

std::size_t width_of(const Tailoring& tailoring, const std::string& name) {
  for (const Width& width : widths) {
    if (name == width.name) return tailoring.*width.octets;
  }
  throw std::runtime_error("no width has the name " + name);
}

/// The parts between commas that are in no parentheses.
std::vector<std::string> parts_of(const std::string& text) {
  std::vector<std::string> parts;
  std::string part;
  int depth = 0;
  for (const char c : text + ",") {
    depth += c == '(' ? 1 : c == ')' ? -1 : 0;
    if (c != ',' || depth != 0) {
      if (c != ' ' || !part.empty()) part += c;
    } else if (!part.empty()) {
      parts.push_back(part);
      part.clear();
    }
  }
  return parts;
}

class Reader {
 public:
  explicit Reader(const Tailoring& tailoring) : tailoring_(tailoring) {}

  std::vector<LayoutItem> read(const std::string& text) const {
    std::vector<LayoutItem> items;
    for (const std::string& part : parts_of(text)) read_part(part, items);
    return items;
  }

 private:
  void read_part(const std::string& part, std::vector<LayoutItem>& items) const {
    static const std::regex repeated(R"((.*) x N)"), group(R"(\((.*)\))"), two(R"(two (?:values )?(.*))");
    std::smatch match;
    if (std::regex_match(part, match, repeated)) {
      std::string inner = match[1];
      if (std::regex_match(inner, match, group)) inner = match[1];
      items.push_back({.kind = ItemKind::list, .items = read(inner)});
    } else if (std::regex_match(part, match, two)) {
      const std::string owner = part.find("values") != std::string::npos ? "event_" : "failure_";
      for (const char* const name : {"a ", "b "}) {
        read_part(owner + name + match[1].str(), items);
        items.back().is_signed = true;
      }
    } else if (!read_word(part, items)) {
      read_number(part, items);
    }
  }

  static bool read_word(const std::string& part, std::vector<LayoutItem>& items) {
    static constexpr struct {
      const char* text;
      ItemKind kind;
      const char* name;
    } words[] = {{"TIME", ItemKind::time, "event_time"},
                 {"release TIME", ItemKind::time, "release_time"},
                 {"request", ItemKind::request, "request"},
                 {"telecommand", ItemKind::telecommand, "telecommand"},
                 {"text up to the end", ItemKind::text, "text"},
                 {"values", ItemKind::report, "values"},
                 {"value", ItemKind::value, "value"},
                 {"name 8 characters", ItemKind::function, "function"},
                 {"arguments", ItemKind::arguments, "arguments"}};
    for (const auto& word : words) {
      if (part != word.text) continue;
      items.push_back({.kind = word.kind, .name = word.name});
      return true;
    }
    return false;
  }

  void read_number(const std::string& part, std::vector<LayoutItem>& items) const {
    static const std::regex named(R"((.*) w\((.*)\))"), typed(R"((.*) ([ui])(8|16|32|64)(?: (ms))?(?: or f32 s)?)");
    std::smatch match;
    LayoutItem item;
    if (std::regex_match(part, match, named)) {
      item.width = match[2];
      item.octets = width_of(tailoring_, item.width);
    } else if (std::regex_match(part, match, typed)) {
      item.octets = std::stoul(match[3]) / 8;
      item.is_signed = match[2] == "i";
      item.unit = match[4];
      if (part.ends_with("or f32 s") && tailoring_.interval_in_seconds) {
        item.unit = "s";
        item.is_float = true;
      }
    } else {
      throw std::runtime_error("the layout '" + part + "' is not understood");
    }
    item.name = match[1];
    if (item.name == "N") item.kind = ItemKind::count;
    if (item.octets != 0 || item.kind == ItemKind::count) items.push_back(item);
  }

  const Tailoring& tailoring_;
};

}  // namespace

std::span<const Width> tailoring_widths() {
  return widths;
}

std::vector<LayoutItem> read_layout(const std::string& text, const Tailoring& tailoring) {
  return Reader(tailoring).read(text);
}

}  // namespace ilp::docgen
