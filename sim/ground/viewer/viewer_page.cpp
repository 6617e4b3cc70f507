#include "sim/ground/viewer/viewer_page.hpp"

#include <nlohmann/json.hpp>

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
std::string page(const std::string& title, const nlohmann::json& data, const std::string& without_script) {
  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
      "style-src 'unsafe-inline'; img-src data: blob:\">"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>" +
      host::escaped(title) + " – viewer</title><link rel=\"icon\" href=\"data:,\"><style>";
  html += style();
  html += "</style></head>\n<body><div id=\"app\"><noscript><p>" + without_script + "</p></noscript></div>\n";
  html += "<script type=\"application/json\" id=\"flight\">" + embedded(data) + "</script>\n";
  html += "<script type=\"text/plain\" id=\"licence\">";
  html += licence();
  html += "</script>\n<script>";
  html += script();
  html += "</script>\n</body></html>\n";
  return html;
}

}  // namespace

bool viewer_available() {
  return !script().empty();
}

std::string viewer_html(const report::Report& report) {
  return page(report.title, viewer_data(report),
              "This page draws with JavaScript, which is switched off here. The pictures are in report.html.");
}

std::string viewer_empty_html(const std::string& title, const std::string& reason) {
  return page(title, {{"title", title}, {"nothing", reason}}, host::escaped(reason));
}

}  // namespace ilp::viewer
