#include "sim/ground/viewer/viewer_page.hpp"

#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sim/ground/viewer/resource.hpp"
#include "sim/ground/viewer/viewer_data.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::viewer {
namespace {

// What came down may be no text at all, and must not end the element that carries it.
std::string embedded(const nlohmann::json& data) {
  const std::string text = data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    if (c == '<') {
      safe += "\\u003c";
    } else {
      safe += c;
    }
  }
  return safe;
}

// The policy blocks all outside content, whatever the data contain.
void write_page(const std::string& title, const std::function<void(std::ostream&)>& write_data,
                const std::string& without_script, std::ostream& out) {
  out << "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
         "style-src 'unsafe-inline'; img-src data: blob:\">"
         "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>"
      << host::escaped(title) << " – viewer</title><link rel=\"icon\" href=\"data:,\"><style>" << style()
      << "</style></head>\n<body><div id=\"app\"><noscript><p>" << without_script << "</p></noscript></div>\n"
      << "<script type=\"application/json\" id=\"flight\">";
  write_data(out);
  out << "</script>\n<script type=\"text/plain\" id=\"licence\">" << licence() << "</script>\n<script>" << script()
      << "</script>\n</body></html>\n";
}

/// The object of viewer_data(), keyframe by keyframe.
void write_data(const report::Report& report, std::ostream& out) {
  out << "{\"keyframes\":[";
  const char* separator = "";
  for (const auto& [id, keyframe] : report.flight.keyframes) {
    out << separator << embedded(viewer_keyframe(report, keyframe));
    separator = ",";
  }
  out << "]," << embedded(viewer_data_but_keyframes(report)).substr(1);
}

}  // namespace

bool viewer_available() {
  return !script().empty();
}

void write_viewer_html(const report::Report& report, std::ostream& out) {
  write_page(
      report.title, [&](std::ostream& page) { write_data(report, page); },
      "This page draws with JavaScript, which is switched off here. The pictures are in report.html.", out);
}

std::string viewer_empty_html(const std::string& title, const std::string& reason) {
  std::ostringstream page;
  write_page(
      title,
      [&](std::ostream& out) {
        out << embedded({{"title", title}, {"nothing", reason}});
      },
      host::escaped(reason), page);
  return std::move(page).str();
}

}  // namespace ilp::viewer
